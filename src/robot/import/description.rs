//! Parsing, and the checks of every number.

use std::thread;

use urdf_rs::{Geometry, Joint, JointType, Link, Robot};

use super::ImportError;

/// Most links or joints; the official description has 72.
const MAX_PARTS: usize = 4096;
/// The parser recurses; this is far more than the allowed depth needs.
const STACK: usize = 64 << 20;

/// Parses a scanned document and checks its names, sizes and numbers.
pub(super) fn parse(text: String) -> Result<Robot, ImportError> {
    let parser = thread::Builder::new().stack_size(STACK).spawn(move || urdf_rs::read_from_string(&text));
    let outcome = parser.map_err(|error| ImportError::NotUrdf(error.to_string()))?.join();
    let robot = match outcome {
        Ok(Ok(robot)) => robot,
        Ok(Err(error)) => return Err(ImportError::NotUrdf(error.to_string())),
        Err(_) => return Err(ImportError::NotUrdf("the parser gave up on it".to_owned())),
    };
    for (what, count) in [("links", robot.links.len()), ("joints", robot.joints.len())] {
        if count > MAX_PARTS {
            let (found, limit) = (count.to_string(), MAX_PARTS.to_string());
            return Err(ImportError::TooLarge { what: format!("the number of {what}"), found, limit });
        }
    }
    if robot.links.is_empty() {
        return Err(ImportError::NotUrdf("it has no links".to_owned()));
    }
    unique("link", robot.links.iter().map(|link| &link.name))?;
    unique("joint", robot.joints.iter().map(|joint| &joint.name))?;
    robot.links.iter().try_for_each(check_link)?;
    robot.joints.iter().try_for_each(|joint| check_joint(&robot, joint))?;
    Ok(robot)
}

/// Whether a joint has an angle: the fingertips of the official description are revolute between equal limits.
pub(super) fn moves(joint: &Joint) -> bool {
    match joint.joint_type {
        JointType::Continuous => true,
        JointType::Revolute | JointType::Prismatic => joint.limit.lower < joint.limit.upper,
        _ => false,
    }
}

fn unique<'a>(kind: &'static str, names: impl Iterator<Item = &'a String>) -> Result<(), ImportError> {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(ImportError::Duplicate { kind, name: name.clone() });
        }
    }
    Ok(())
}

fn finite(of: &str, what: &'static str, values: &[f64]) -> Result<(), ImportError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(ImportError::NotFinite { of: of.to_owned(), what, value: *value }),
        None => Ok(()),
    }
}

fn check_link(link: &Link) -> Result<(), ImportError> {
    let of = format!("link `{}`", link.name);
    for visual in &link.visual {
        finite(&of, "the origin of a visual", &visual.origin.xyz.0)?;
        finite(&of, "the rotation of a visual", &visual.origin.rpy.0)?;
        match &visual.geometry {
            Geometry::Box { size } => finite(&of, "the size of a box", &size.0)?,
            Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
                finite(&of, "the size of a cylinder", &[*radius, *length])?;
            }
            Geometry::Sphere { radius } => finite(&of, "the radius of a sphere", &[*radius])?,
            Geometry::Mesh { scale, .. } => {
                let scale = scale.map_or([1.0; 3], |scale| scale.0);
                finite(&of, "the scale of a mesh", &scale)?;
            }
        }
        if let Some(colour) = visual.material.as_ref().and_then(|material| material.color.as_ref()) {
            finite(&of, "a colour", &colour.rgba.0)?;
        }
    }
    Ok(())
}

fn check_joint(robot: &Robot, joint: &Joint) -> Result<(), ImportError> {
    let of = format!("joint `{}`", joint.name);
    finite(&of, "the origin", &joint.origin.xyz.0)?;
    finite(&of, "the rotation", &joint.origin.rpy.0)?;
    finite(&of, "the axis", &joint.axis.xyz.0)?;
    match joint.joint_type {
        JointType::Fixed => return Ok(()),
        JointType::Revolute | JointType::Prismatic => {
            finite(&of, "a limit", &[joint.limit.lower, joint.limit.upper])?;
            if joint.limit.lower > joint.limit.upper {
                let (lower, upper) = (joint.limit.lower, joint.limit.upper);
                return Err(ImportError::Limits { joint: joint.name.clone(), lower, upper });
            }
        }
        JointType::Continuous => {}
        _ => {
            let kind = format!("{:?}", joint.joint_type).to_lowercase();
            return Err(ImportError::JointKind { joint: joint.name.clone(), kind });
        }
    }
    finite(&of, "the velocity limit", &[joint.limit.velocity])?;
    if joint.axis.xyz.0.iter().map(|v| v * v).sum::<f64>().sqrt() < 1e-9 {
        return Err(ImportError::Axis { joint: joint.name.clone() });
    }
    check_mimic(robot, joint)
}

fn check_mimic(robot: &Robot, joint: &Joint) -> Result<(), ImportError> {
    let Some(mimic) = &joint.mimic else { return Ok(()) };
    let numbers = [mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0)];
    finite(&format!("joint `{}`", joint.name), "the coupling", &numbers)?;
    let leads = |other: &&Joint| other.name == mimic.joint && other.mimic.is_none() && moves(other);
    match robot.joints.iter().find(leads) {
        Some(_) => Ok(()),
        None => Err(ImportError::Mimic { joint: joint.name.clone(), target: mimic.joint.clone() }),
    }
}
