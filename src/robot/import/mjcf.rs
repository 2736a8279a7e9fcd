//! The description as a MuJoCo model of our own.

use std::{collections::BTreeMap, fmt::Write as _};

use nalgebra::UnitQuaternion;
use urdf_rs::{Geometry, Joint, JointType, Pose, Robot, Visual};

use super::{description::moves, meshes::Mesh, tree::Tree};
use crate::{geometry::Side, robot::FINGERS};

/// Meshes smaller than this are left out: the description marks its fingertips with specks of dust. Metres.
const SPECK: f32 = 1e-3;

struct Writer<'a> {
    robot: &'a Robot,
    tree: &'a Tree,
    meshes: &'a BTreeMap<String, Mesh>,
    out: String,
    scaled: BTreeMap<String, (String, [f64; 3])>,
    notes: &'a mut Vec<String>,
}

/// The model: bodies, hinges with limits and velocities (`user`), equalities for coupled joints, a site at every
/// fingertip. It is for kinematics and pictures; masses are nominal and nothing collides.
pub(super) fn write(
    robot: &Robot,
    tree: &Tree,
    meshes: &BTreeMap<String, Mesh>,
    notes: &mut Vec<String>,
) -> String {
    let mut writer = Writer { robot, tree, meshes, out: String::new(), scaled: BTreeMap::new(), notes };
    writer.bodies();
    let bodies = std::mem::take(&mut writer.out);
    writer.equalities();
    let equalities = std::mem::take(&mut writer.out);
    let mut assets = String::new();
    for (asset, (file, [x, y, z])) in &writer.scaled {
        let _ = writeln!(
            assets,
            "    <mesh name=\"{asset}\" file=\"{file}\" scale=\"{x} {y} {z}\" inertia=\"shell\"/>"
        );
    }
    format!(
        "<mujoco model=\"imported\">\n  <compiler angle=\"radian\" autolimits=\"true\" fusestatic=\"false\" \
         inertiafromgeom=\"false\"/>\n  <option gravity=\"0 0 0\"/>\n  <size nuser_jnt=\"1\"/>\n  <visual>\n    \
         <quality shadowsize=\"0\"/>\n  </visual>\n  <asset>\n{assets}  </asset>\n  <worldbody>\n{bodies}  \
         </worldbody>\n  <equality>\n{equalities}  </equality>\n</mujoco>\n"
    )
}

impl Writer<'_> {
    /// All bodies, without recursion: a description may be a very long chain.
    fn bodies(&mut self) {
        enum Step {
            Open(Option<usize>, usize),
            Close,
        }
        let mut steps = vec![Step::Open(None, self.tree.root)];
        while let Some(step) = steps.pop() {
            match step {
                Step::Open(joint, link) => {
                    self.open_body(joint, link);
                    steps.push(Step::Close);
                    let children = self.tree.children[link].iter().rev();
                    steps.extend(children.map(|(joint, child)| Step::Open(Some(*joint), *child)));
                }
                Step::Close => self.out.push_str("</body>\n"),
            }
        }
    }

    fn open_body(&mut self, joint: Option<usize>, link: usize) {
        let joint = joint.map(|joint| &self.robot.joints[joint]);
        let link = &self.robot.links[link];
        let place = joint.map_or_else(String::new, |joint| placement(&joint.origin));
        let _ = writeln!(self.out, "<body name=\"{}\"{place}>", escape(&link.name));
        self.out.push_str("<inertial pos=\"0 0 0\" mass=\"0.1\" diaginertia=\"1e-3 1e-3 1e-3\"/>\n");
        if let Some(joint) = joint {
            self.joint(joint);
        }
        for visual in &link.visual {
            self.visual(&link.name, visual);
        }
        if let Some(site) = tip_site(&link.name) {
            let _ = writeln!(self.out, "<site name=\"{site}\" size=\"0.003\" group=\"5\"/>");
        }
    }

    fn joint(&mut self, joint: &Joint) {
        if !moves(joint) {
            if joint.joint_type != JointType::Fixed {
                let at = joint.limit.lower;
                self.notes.push(format!(
                    "joint `{}` has no room between its limits ({at}): fixed at 0",
                    joint.name
                ));
            }
            return;
        }
        let kind = if joint.joint_type == JointType::Prismatic { "slide" } else { "hinge" };
        let [x, y, z] = joint.axis.xyz.0;
        let range = match joint.joint_type {
            JointType::Continuous => String::new(),
            _ => format!(" range=\"{} {}\"", joint.limit.lower, joint.limit.upper),
        };
        let (name, velocity) = (escape(&joint.name), joint.limit.velocity);
        let _ = writeln!(
            self.out,
            "<joint name=\"{name}\" type=\"{kind}\" axis=\"{x} {y} {z}\"{range} user=\"{velocity}\"/>"
        );
    }

    fn visual(&mut self, link: &str, visual: &Visual) {
        let Some(shape) = self.shape(link, &visual.geometry) else { return };
        let group = if matches!(link, "head_link" | "logo_link") { 1 } else { 2 };
        let [r, g, b, a] = self.colour(visual);
        let place = placement(&visual.origin);
        let _ = writeln!(
            self.out,
            "<geom {shape}{place} rgba=\"{r} {g} {b} {a}\" group=\"{group}\" contype=\"0\" conaffinity=\"0\"/>"
        );
    }

    fn shape(&mut self, link: &str, geometry: &Geometry) -> Option<String> {
        let positive = |values: &[f64]| values.iter().all(|value| *value > 1e-6);
        match geometry {
            Geometry::Box { size } => {
                let [x, y, z] = size.0.map(|side| 0.5 * side);
                positive(&[x, y, z]).then(|| format!("type=\"box\" size=\"{x} {y} {z}\""))
            }
            Geometry::Cylinder { radius, length } => positive(&[*radius, *length])
                .then(|| format!("type=\"cylinder\" size=\"{radius} {}\"", 0.5 * length)),
            Geometry::Capsule { radius, length } => positive(&[*radius, *length])
                .then(|| format!("type=\"capsule\" size=\"{radius} {}\"", 0.5 * length)),
            Geometry::Sphere { radius } => {
                positive(&[*radius]).then(|| format!("type=\"sphere\" size=\"{radius}\""))
            }
            Geometry::Mesh { filename, scale } => {
                let mesh = self.meshes.get(filename)?;
                let scale = scale.map_or([1.0; 3], |scale| scale.0);
                if extent(mesh, scale) < SPECK || mesh.triangles.len() < 4 {
                    self.notes
                        .push(format!("link `{link}`: mesh `{filename}` is too small to be seen: left out"));
                    return None;
                }
                let bits = scale.map(f64::to_bits);
                let asset = format!("{}_{:x}_{:x}_{:x}", mesh.name, bits[0], bits[1], bits[2]);
                self.scaled.insert(asset.clone(), (mesh.file(), scale));
                Some(format!("type=\"mesh\" mesh=\"{asset}\""))
            }
        }
    }

    /// The visual's colour, or that of the robot's material of its name, or light grey.
    fn colour(&self, visual: &Visual) -> [f64; 4] {
        let Some(material) = &visual.material else { return [0.7, 0.7, 0.7, 1.0] };
        let shared = self.robot.materials.iter().find(|shared| shared.name == material.name);
        let colour = material.color.as_ref().or_else(|| shared.and_then(|shared| shared.color.as_ref()));
        let rgba = colour.map_or([0.7, 0.7, 0.7, 1.0], |colour| colour.rgba.0);
        rgba.map(|value| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 })
    }

    fn equalities(&mut self) {
        for joint in self.robot.joints.iter().filter(|joint| moves(joint)) {
            let Some(mimic) = &joint.mimic else { continue };
            let (offset, gain) = (mimic.offset.unwrap_or(0.0), mimic.multiplier.unwrap_or(1.0));
            let (follower, leader) = (escape(&joint.name), escape(&mimic.joint));
            let _ = writeln!(
                self.out,
                "<joint joint1=\"{follower}\" joint2=\"{leader}\" polycoef=\"{offset} {gain} 0 0 0\"/>"
            );
        }
    }
}

fn extent(mesh: &Mesh, scale: [f64; 3]) -> f32 {
    let along = |axis: usize| {
        let values = mesh.triangles.iter().flatten().map(|corner| corner[axis]);
        let (low, high) = values.fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v), high.max(v)));
        (high - low) * scale[axis].abs() as f32
    };
    along(0).max(along(1)).max(along(2))
}

/// ` pos="…" quat="…"` of a URDF origin (roll, pitch, yaw about fixed axes).
fn placement(origin: &Pose) -> String {
    let [x, y, z] = origin.xyz.0;
    let [roll, pitch, yaw] = origin.rpy.0;
    let q = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    format!(" pos=\"{x} {y} {z}\" quat=\"{} {} {} {}\"", q.w, q.i, q.j, q.k)
}

/// The site our model has at a fingertip, where the link is one: `left_thumb_tip_Link`, `right_index_tip`, …
fn tip_site(link: &str) -> Option<String> {
    Side::BOTH
        .iter()
        .flat_map(|side| FINGERS.iter().map(move |finger| format!("{}_{finger}_tip", side.name())))
        .find_map(|stem| {
            let rest = link.strip_prefix(&stem)?.to_ascii_lowercase();
            (rest.is_empty() || rest == "_link").then(|| format!("{stem}_site"))
        })
}

fn escape(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
