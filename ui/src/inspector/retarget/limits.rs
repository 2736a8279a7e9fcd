//! Limits of the robot's joints, read out of its description.

use std::sync::LazyLock;

use agenticfocus::{
    geometry::Side,
    robot::{ARM_DOF, ARM_JOINTS, HAND_ACTUATORS, actuated_joint_names},
};

const KINEMATICS: &str = include_str!("../../../../assets/robots/g1_brainco/kinematics.xml");

/// A joint as it is offered and drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Joint {
    /// In words, without its side.
    pub name: String,
    /// Whose.
    pub side: Side,
    /// Place in the record.
    pub index: usize,
    /// Lower and upper limit, degrees, where the description has them.
    pub limits: Option<[f64; 2]>,
}

static JOINTS: LazyLock<Vec<Joint>> = LazyLock::new(|| {
    actuated_joint_names().iter().enumerate().map(|(index, description)| joint(index, description)).collect()
});

/// All joints in the record's order.
pub(super) fn joints() -> &'static [Joint] {
    &JOINTS
}

fn joint(index: usize, description: &str) -> Joint {
    let hand = index >= ARM_DOF;
    let (within, names): (usize, &[&str]) =
        if hand { (index - ARM_DOF, &HAND_ACTUATORS) } else { (index, &ARM_JOINTS) };
    let side = if within < names.len() { Side::Left } else { Side::Right };
    let name = match names[within % names.len()] {
        "thumb_aux" => "thumb swing".to_owned(),
        name => name.replace('_', " "),
    };
    Joint { name, side, index, limits: range_of(description) }
}

/// `range` of the element named `name`, degrees.
fn range_of(name: &str) -> Option<[f64; 2]> {
    let (_, element) = KINEMATICS.split_once(&format!("<joint name=\"{name}\""))?;
    let (element, _) = element.split_once('>')?;
    let (_, range) = element.split_once("range=\"")?;
    let (range, _) = range.split_once('"')?;
    let mut numbers = range.split_whitespace().map(|number| number.parse::<f64>().map(f64::to_degrees));
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

#[cfg(test)]
mod tests {
    use agenticfocus::robot::ACTUATED_DOF;

    use super::*;

    #[test]
    fn every_joint_has_limits_around_a_range_and_sides_are_in_the_records_order() {
        let joints = joints();
        assert_eq!(joints.len(), ACTUATED_DOF);
        for joint in joints {
            let [lower, upper] = joint.limits.unwrap();
            assert!(lower < upper && upper <= 180.0, "{joint:?}");
        }
        assert_eq!(joints[3].name, "elbow");
        assert_eq!((joints[10].name.as_str(), joints[10].side), ("elbow", Side::Right));
        assert_eq!((joints[21].name.as_str(), joints[21].side), ("thumb swing", Side::Right));
    }
}
