//! The skin of a posed hand and forearm: flesh around the bones, coloured for a small palette.

use nalgebra::{UnitQuaternion, Vector3};

use super::{
    hand_shape::{Bone, HandShape, PosedHand},
    implicit::{Cone, Flesh, Surface},
};

/// Triangles without shared vertices, as a fixed-topology mesh wants them.
#[derive(Clone, Debug, Default)]
pub struct TriangleSoup {
    /// Three positions a triangle, metres.
    pub positions: Vec<[f32; 3]>,
    /// Normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates.
    pub uv: Vec<[f32; 2]>,
}

/// What covers the forearm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forearm {
    /// Unit vector from the wrist to the elbow, canonical frame.
    pub direction: Vector3<f64>,
    /// Back of the forearm, canonical frame.
    pub back: Vector3<f64>,
    /// Length to draw, metres.
    pub length: f64,
    /// Where the sleeve begins, metres from the wrist; none for bare arms.
    pub sleeve: Option<f64>,
}

/// Cone tags: 3 bones for each of 5 fingers, then these.
const TAG_PALM: usize = 15;
const TAG_FOREARM: usize = 16;
const TAG_SLEEVE: usize = 17;

/// Flesh radius at the joints in millimetres: base, first, second joint, tip.
const FINGER_RADII_MM: [[f64; 4]; 5] = [
    [15.0, 12.0, 10.3, 7.6],
    [11.0, 9.3, 8.1, 6.6],
    [11.2, 9.5, 8.3, 6.8],
    [10.4, 8.9, 7.8, 6.4],
    [9.4, 7.8, 6.8, 5.7],
];

/// Flesh radius at both ends of a finger's bone, metres.
pub fn bone_radii(shape: &HandShape, finger: usize, bone: usize) -> [f64; 2] {
    let unit = shape.scale() * 1e-3;
    [FINGER_RADII_MM[finger][bone] * unit, FINGER_RADII_MM[finger][bone + 1] * unit]
}

/// The cones of fingers and palm, canonical frame.
pub fn hand_cones(shape: &HandShape, hand: &PosedHand) -> Vec<Cone> {
    let unit = shape.scale() * 1e-3;
    let mut cones = Vec::with_capacity(40);
    for (finger, chain) in hand.bones.iter().enumerate() {
        for (index, bone) in chain.iter().enumerate() {
            let [ra, rb] = bone_radii(shape, finger, index);
            // The metacarpal of the thumb belongs to the palm it grows out of.
            let group = if finger == 0 && index == 0 { 0 } else { finger + 1 };
            let mut cone = Cone { a: bone.start, b: bone.end, ra, rb, group, tag: finger * 3 + index };
            if index == 2 {
                cone.b -= (bone.end - bone.start).normalize() * rb;
            }
            cones.push(cone);
        }
    }
    palm_cones(hand, unit, &mut cones);
    cones
}

fn palm_cones(hand: &PosedHand, unit: f64, cones: &mut Vec<Cone>) {
    let at = |x: f64, y: f64, z: f64| Vector3::new(x, y, z) * unit;
    let mut add = |a: Vector3<f64>, ra: f64, b: Vector3<f64>, rb: f64| {
        cones.push(Cone { a, b, ra: ra * unit, rb: rb * unit, group: 0, tag: TAG_PALM });
    };
    let carpals = [at(10.0, 0.0, 13.0), at(10.0, 1.0, 5.0), at(10.0, 0.5, -5.0), at(12.0, -1.5, -13.0)];
    for (finger, carpal) in carpals.iter().enumerate() {
        let mcp = hand.joints[5 + 4 * finger];
        let sink = [1.8, 1.5, 2.0, 2.5][finger];
        add(*carpal, 15.5, mcp - at(3.0, sink, 0.0), [12.2, 12.3, 11.8, 11.0][finger]);
        // The pad under the finger's root.
        add(mcp - at(6.0, 7.0, 0.0), 9.5, mcp - at(16.0, 7.5, 0.0), 9.5);
    }
    let thumb = &hand.bones[0][0];
    let middle = (thumb.start + thumb.end) * 0.5;
    add(at(24.0, -12.0, 14.0), 14.0, middle + at(2.0, -2.0, -6.0), 14.0);
    add(at(18.0, -9.0, -16.0), 13.5, at(60.0, -10.0, -28.0), 12.0);
    // The web between thumb and index finger.
    add(middle.lerp(&hand.joints[5], 0.30), 9.0, middle.lerp(&hand.joints[5], 0.72), 9.0);
}

fn forearm_cones(shape: &HandShape, arm: &Forearm) -> Vec<Cone> {
    let unit = shape.scale();
    let side = arm.direction.cross(&arm.back).normalize();
    let mut cones = Vec::new();
    for sign in [-1.0, 1.0] {
        let wrist = side * (sign * 0.0105 * unit);
        let middle = arm.direction * 0.13 + side * (sign * 0.013 * unit);
        let elbow = arm.direction * arm.length + side * (sign * 0.014 * unit);
        let mut add = |a, ra: f64, b, rb: f64| {
            cones.push(Cone { a, b, ra: ra * unit, rb: rb * unit, group: 0, tag: TAG_FOREARM });
        };
        add(wrist, 0.0195, middle, 0.0285);
        add(middle, 0.0285, elbow, 0.040);
    }
    cones
}

fn sleeve_flesh(shape: &HandShape, arm: &Forearm, begin: f64) -> Flesh {
    let unit = shape.scale();
    let mut cones = Vec::new();
    let mut ring = |t: f64, radius: f64, length: f64| {
        cones.push(Cone {
            a: arm.direction * t,
            b: arm.direction * (t + length),
            ra: radius * unit,
            rb: (radius + 0.004) * unit,
            group: 0,
            tag: TAG_SLEEVE,
        });
    };
    ring(begin + 0.02, 0.044, 0.02);
    let mut t = begin + 0.045;
    let mut fold = 0;
    while t < arm.length {
        let grow = 0.007 * (t - begin) / 0.2;
        ring(t, 0.044 + grow + 0.0025 * f64::from(fold % 3), 0.018);
        t += 0.034 + 0.006 * f64::from(fold % 2);
        fold += 1;
    }
    Flesh { cones, body_blend: 0.018, limb_blend: 0.01, join_blend: 0.01 }
}

/// The skin of a hand with its forearm in the canonical frame, and the cloth of its sleeve.
///
/// `cell` is the size of the sampling grid in metres. Texture coordinates of the skin address the
/// palette of [`super::texture::skin_palette`]; those of the sleeve run around and along it.
pub fn cover(shape: &HandShape, hand: &PosedHand, arm: &Forearm, cell: f64) -> (TriangleSoup, TriangleSoup) {
    let unit = shape.scale();
    let mut cones = hand_cones(shape, hand);
    let mut bare = *arm;
    if let Some(begin) = arm.sleeve {
        bare.length = (begin + 0.06).min(arm.length);
    }
    cones.extend(forearm_cones(shape, &bare));
    let flesh = Flesh { cones, body_blend: 0.011 * unit, limb_blend: 0.003 * unit, join_blend: 0.008 * unit };
    let surface = flesh.triangulate(cell);
    let uv: Vec<_> = surface
        .vertices
        .iter()
        .zip(&surface.normals)
        .map(|(p, n)| skin_uv(hand, arm, unit, flesh.nearest_tag(p), p, n))
        .collect();
    let skin = soup(&surface, &uv);
    let sleeve = arm.sleeve.map(|begin| {
        let surface = sleeve_flesh(shape, arm, begin).triangulate(cell * 1.8);
        let uv: Vec<_> = surface.vertices.iter().map(|p| cloth_uv(arm, p)).collect();
        soup(&surface, &uv)
    });
    (skin, sleeve.unwrap_or_default())
}

fn soup(surface: &Surface, uv: &[[f32; 2]]) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    for index in surface.triangles.iter().flatten() {
        let index = *index as usize;
        soup.positions.push(surface.vertices[index].cast::<f32>().into());
        soup.normals.push(surface.normals[index].cast::<f32>().into());
        soup.uv.push(uv[index]);
    }
    soup
}

fn cloth_uv(arm: &Forearm, p: &Vector3<f64>) -> [f32; 2] {
    let side = arm.direction.cross(&arm.back).normalize();
    // Both coordinates are continuous all around, so that no seam shows.
    let (along, across, up) = (p.dot(&arm.direction), p.dot(&side), p.dot(&arm.back));
    [(8.0 * along) as f32, (6.0 * across + 4.0 * up) as f32]
}

/// Palette coordinates: u from palm (0.05) over back (0.35) and knuckle (0.55) to nail (0.95), v mottling.
fn skin_uv(
    hand: &PosedHand,
    arm: &Forearm,
    unit: f64,
    tag: usize,
    p: &Vector3<f64>,
    n: &Vector3<f64>,
) -> [f32; 2] {
    let (frame, origin) = match tag {
        tag if tag < 15 => {
            let bone = &hand.bones[tag / 3][tag % 3];
            (bone.rotation, bone.start)
        }
        TAG_FOREARM => (super::hand_shape::axes(arm.direction, arm.back), Vector3::zeros()),
        _ => (UnitQuaternion::identity(), Vector3::zeros()),
    };
    let local = frame.inverse() * (p - origin) / unit * 1e3;
    let back = (frame.inverse() * n).y;
    let mut u = 0.05 + 0.30 * smoothstep(-0.5, 0.25, back);
    if tag < 15 {
        let bone = &hand.bones[tag / 3][tag % 3];
        u += finger_tint(bone, tag, unit, &local, back);
    } else if tag == TAG_PALM {
        for joint in [5, 9, 13, 17] {
            let near = (p - hand.joints[joint]).norm() / unit * 1e3;
            u += 0.13 * (1.0 - smoothstep(9.0, 17.0, near)) * smoothstep(0.3, 0.9, back);
        }
    }
    let seed = tag as f64 * 17.3;
    let mottle = 0.5
        + 0.32 * super::texture::noise3(local.x / 9.0 + seed, local.y / 9.0, local.z / 9.0)
        + 0.22 * super::texture::noise3(local.x / 3.2 + seed, local.y / 3.2 + 5.0, local.z / 3.2);
    [u.clamp(0.02, 0.98) as f32, mottle.clamp(0.02, 0.98) as f32]
}

fn finger_tint(bone: &Bone, tag: usize, unit: f64, local: &Vector3<f64>, back: f64) -> f64 {
    let length = (bone.end - bone.start).norm() / unit * 1e3;
    let on_back = smoothstep(0.2, 0.8, back);
    if tag % 3 == 2 {
        let from_tip = length - local.x;
        let width = if tag == 2 { 6.2 } else { 4.6 };
        let inside = smoothstep(0.4, 2.0, from_tip)
            * (1.0 - smoothstep(11.0, 13.0, from_tip))
            * (1.0 - smoothstep(width - 1.0, width + 1.0, local.z.abs()));
        return inside * on_back * 0.62;
    }
    let to_joint = (length - local.x).abs().min(if tag.is_multiple_of(3) { f64::MAX } else { local.x.abs() });
    let crease = 0.5 + 0.5 * (local.x * 1.9).cos();
    on_back * (1.0 - smoothstep(2.5, 7.0, to_joint)) * (0.10 + 0.12 * crease)
}

/// Hermite step from 0 at `low` to 1 at `high`.
pub fn smoothstep(low: f64, high: f64, value: f64) -> f64 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
