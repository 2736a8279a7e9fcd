//! The embedded Unitree G1 + BrainCo model: kinematics and shapes joined into one MJCF.

use super::{
    RobotError,
    loft::{Loft, attribute},
};

const KINEMATICS: &str = include_str!("../../assets/robots/g1_brainco/kinematics.xml");
const VISUALS: &str = include_str!("../../assets/robots/g1_brainco/visuals.xml");

/// The embedded model as one MJCF document.
///
/// # Errors
/// When a shape names a body that the kinematics do not have.
pub fn embedded_mjcf() -> Result<String, RobotError> {
    join(KINEMATICS, VISUALS)
}

/// Puts the shapes of every `<link name="B">` of `visuals` into body `B` of `kinematics` (and mirrored into the body
/// `mirror`), the meshes of their lofts and the content of `<shared>` in front of the world. Both are our own
/// files: one element a line, `<body` with its name first.
fn join(kinematics: &str, visuals: &str) -> Result<String, RobotError> {
    let broken = |what: &str| RobotError::Embedded(what.to_owned());
    // The heading comment speaks of the elements by name.
    let visuals = visuals.split_once("-->").map_or(visuals, |(_, after)| after);
    let shared =
        between(visuals, "<shared>", "</shared>").ok_or_else(|| broken("no <shared> in visuals.xml"))?;
    let (head, world) =
        kinematics.split_once("<worldbody>").ok_or_else(|| broken("no <worldbody> in kinematics.xml"))?;
    let mut mjcf = format!("<worldbody>{world}");
    let mut meshes = String::new();
    let mut rest = visuals;
    while let Some((_, after)) = rest.split_once("<link ") {
        let (opening, after) =
            after.split_once('>').ok_or_else(|| broken("unfinished <link> in visuals.xml"))?;
        let (shapes, after) =
            after.split_once("</link>").ok_or_else(|| broken("unfinished <link> in visuals.xml"))?;
        let opening = format!(" {opening}");
        let name = attribute(&opening, "name").ok_or_else(|| broken("<link> without a name"))?;
        let own = expand_lofts(shapes.trim_end(), name, [false; 3], &mut meshes)?;
        mjcf = insert_into_body(&mjcf, name, &own)?;
        if let Some(mirror) = attribute(&opening, "mirror") {
            let flip = attribute(&opening, "flip").unwrap_or("");
            let flip = ['x', 'y', 'z'].map(|axis| flip.contains(axis));
            let other = expand_lofts(shapes.trim_end(), mirror, flip, &mut meshes)?;
            mjcf = insert_into_body(&mjcf, mirror, &other)?;
        }
        rest = after;
    }
    let meshes = if meshes.is_empty() { meshes } else { format!("<asset>\n{meshes}</asset>\n") };
    Ok(format!("{head}{shared}{meshes}{mjcf}"))
}

/// Replaces every `<loft …/>` by a mesh geom and adds its mesh to `meshes`.
fn expand_lofts(
    shapes: &str,
    body: &str,
    flip: [bool; 3],
    meshes: &mut String,
) -> Result<String, RobotError> {
    let mut expanded = String::new();
    let mut rest = shapes;
    for number in 0.. {
        let Some((before, after)) = rest.split_once("<loft") else { break };
        let (element, after) = after
            .split_once("/>")
            .ok_or_else(|| RobotError::Embedded(format!("unfinished <loft> in the shapes of {body}")))?;
        let class = attribute(element, "class").unwrap_or("shell");
        let name = format!("{body}_{number}");
        meshes.push_str(&Loft::parse(&format!("<loft{element}/>"))?.mesh(flip).to_mjcf(&name));
        expanded.push_str(before);
        expanded.push_str(&format!("<geom class=\"{class}\" type=\"mesh\" mesh=\"{name}\"/>"));
        rest = after;
    }
    expanded.push_str(rest);
    Ok(expanded)
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    Some(text.split_once(start)?.1.split_once(end)?.0)
}

fn insert_into_body(mjcf: &str, name: &str, shapes: &str) -> Result<String, RobotError> {
    let missing = || RobotError::Missing { kind: "body", name: name.to_owned() };
    let start = mjcf.find(&format!("<body name=\"{name}\"")).ok_or_else(missing)?;
    let end = start + mjcf[start..].find('>').ok_or_else(missing)?;
    let (before, after) = (&mjcf[..end], &mjcf[end + 1..]);
    Ok(match before.strip_suffix('/') {
        Some(open) => format!("{open}>{shapes}\n</body>{after}"),
        None => format!("{before}>{shapes}{after}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_land_inside_their_bodies() {
        let kinematics = "<m><worldbody><body name=\"a\" pos=\"0\"><body name=\"b\"/></body></worldbody></m>";
        let visuals = "<v><shared>S</shared><link name=\"a\">A</link><link name=\"b\">B</link></v>";
        let joined = join(kinematics, visuals).unwrap();
        assert_eq!(
            joined,
            "<m>S<worldbody><body name=\"a\" pos=\"0\">A<body name=\"b\">B\n</body></body></worldbody></m>"
        );
    }

    #[test]
    fn a_shape_for_an_unknown_body_is_an_error() {
        let result = join("<worldbody></worldbody>", "<shared></shared><link name=\"ghost\">A</link>");
        assert!(result.unwrap_err().to_string().contains("ghost"));
    }
}
