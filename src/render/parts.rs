//! Which part of the robot a geom belongs to.

use mujoco_rs::wrappers::mj_model::{MjModel, MjtObjBase};

use crate::geometry::Side;

/// The kind of object that `id_to_name` looks among.
pub(super) const BODY: MjtObjBase = MjtObjBase::mjOBJ_BODY;

/// A part of the robot as the layers tell them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Torso, head, legs: not seen by the robot's own camera.
    Body,
    /// Arm from the shoulder to the palm.
    Arm(Side),
    /// Thumb.
    Thumb(Side),
    /// One of the other four fingers.
    Finger(Side),
}

impl Part {
    pub(super) fn side(self) -> Option<Side> {
        match self {
            Self::Body => None,
            Self::Arm(side) | Self::Thumb(side) | Self::Finger(side) => Some(side),
        }
    }
}

/// The part of every geom, by the names of the bodies above it, which the embedded and the official description share.
pub(super) fn parts_of_geoms(model: &MjModel) -> Vec<Part> {
    let bodies: Vec<Part> = (0..model.body_parentid().len()).map(|body| part_of_body(model, body)).collect();
    model.geom_bodyid().iter().map(|body| bodies.get(*body as usize).copied().unwrap_or(Part::Body)).collect()
}

fn part_of_body(model: &MjModel, mut body: usize) -> Part {
    let parents = model.body_parentid();
    while body != 0 {
        let name = model.id_to_name(BODY, body).unwrap_or("");
        if let Some(part) = part_by_name(name) {
            return part;
        }
        body = parents[body] as usize;
    }
    Part::Body
}

fn part_by_name(name: &str) -> Option<Part> {
    for side in Side::BOTH {
        let Some(rest) = name.strip_prefix(side.name()).and_then(|rest| rest.strip_prefix('_')) else {
            continue;
        };
        let starts = |words: &[&str]| words.iter().any(|word| rest.starts_with(word));
        if starts(&["thumb"]) {
            return Some(Part::Thumb(side));
        }
        if starts(&["index", "middle", "ring", "pinky"]) {
            return Some(Part::Finger(side));
        }
        if starts(&["shoulder", "elbow", "wrist", "base"]) {
            return Some(Part::Arm(side));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_descriptions_tell_the_part() {
        assert_eq!(part_by_name("left_thumb_metacarpal_Link"), Some(Part::Thumb(Side::Left)));
        assert_eq!(part_by_name("right_pinky_tip"), Some(Part::Finger(Side::Right)));
        assert_eq!(part_by_name("right_wrist_yaw_link"), Some(Part::Arm(Side::Right)));
        assert_eq!(part_by_name("left_hip_roll_link"), None);
        assert_eq!(part_by_name("torso_link"), None);
    }
}
