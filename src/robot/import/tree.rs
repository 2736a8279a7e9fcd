//! The links as a tree.

use std::collections::BTreeMap;

use urdf_rs::Robot;

use super::ImportError;

/// Children of every link, in the description's order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    /// Index of the one link without a parent.
    pub(super) root: usize,
    /// By link: the joints that hang below it and the links at their other ends.
    pub(super) children: Vec<Vec<(usize, usize)>>,
}

impl Tree {
    /// The tree of `robot`, whose names are unique.
    pub(super) fn new(robot: &Robot) -> Result<Self, ImportError> {
        let index: BTreeMap<&str, usize> =
            robot.links.iter().enumerate().map(|(index, link)| (link.name.as_str(), index)).collect();
        let mut children = vec![Vec::new(); robot.links.len()];
        let mut parent: Vec<Option<usize>> = vec![None; robot.links.len()];
        for (number, joint) in robot.joints.iter().enumerate() {
            let find = |link: &str| {
                let unknown =
                    || ImportError::UnknownLink { joint: joint.name.clone(), link: link.to_owned() };
                index.get(link).copied().ok_or_else(unknown)
            };
            let (above, below) = (find(&joint.parent.link)?, find(&joint.child.link)?);
            if let Some(first) = parent[below] {
                return Err(ImportError::TwoParents {
                    link: robot.links[below].name.clone(),
                    first: robot.joints[first].name.clone(),
                    second: joint.name.clone(),
                });
            }
            parent[below] = Some(number);
            children[above].push((number, below));
        }
        let roots: Vec<usize> = (0..robot.links.len()).filter(|link| parent[*link].is_none()).collect();
        let mut reached = vec![false; robot.links.len()];
        let mut open = roots.clone();
        while let Some(link) = open.pop() {
            reached[link] = true;
            open.extend(children[link].iter().map(|(_, child)| *child));
        }
        // Every link has one parent at most, so what no root reaches runs in circles.
        if let Some(link) = reached.iter().position(|reached| !reached) {
            let joint = parent[link].map(|joint| robot.joints[joint].name.clone()).unwrap_or_default();
            return Err(ImportError::Cycle { joint, link: robot.links[link].name.clone() });
        }
        match roots[..] {
            [root] => Ok(Self { root, children }),
            _ => Err(ImportError::Roots {
                found: roots.iter().take(8).map(|link| robot.links[*link].name.clone()).collect(),
            }),
        }
    }
}
