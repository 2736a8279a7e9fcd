//! The proportions of a synthetic hand and its forward kinematics.
//!
//! Bone lengths follow Buryanov & Kotiuk 2010 (Int. J. Morphol. 28(3):755, X-rays of 66 adults),
//! with a carpal height of 0.54 times the middle metacarpal below it (Youm's ratio). The canonical
//! hand frame has its origin in the wrist, x to the middle MCP, y out of the back of the hand and
//! z to the thumb's side, metres. It is right-handed for a left hand; a right hand is its mirror
//! image in z.

use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::landmarks::KEYPOINT_COUNT;

/// Hand length of the published table, wrist to middle fingertip, straight, metres.
pub const TABLE_HAND_LENGTH: f64 = 0.1918;

/// One finger: flexion of MCP, PIP, DIP and abduction to the thumb's side, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FingerPose {
    /// Flexion of MCP, PIP, DIP.
    pub flexion: [f64; 3],
    /// Turn to the thumb's side at the MCP.
    pub abduction: f64,
}

/// The thumb: how far it opposes the palm (0 beside the palm, 1 across it), flexion of MCP and IP in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ThumbPose {
    /// 0 beside the palm, 1 across it.
    pub opposition: f64,
    /// Flexion of MCP and IP.
    pub flexion: [f64; 2],
}

/// All joint angles of a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandPose {
    /// The thumb.
    pub thumb: ThumbPose,
    /// Index, middle, ring, little.
    pub fingers: [FingerPose; 4],
}

impl HandPose {
    /// The pose a share `t` of the way to `other`.
    #[must_use]
    pub fn lerp(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let mut pose = *self;
        pose.thumb.opposition = mix(pose.thumb.opposition, other.thumb.opposition);
        for (a, b) in pose.thumb.flexion.iter_mut().zip(other.thumb.flexion) {
            *a = mix(*a, b);
        }
        for (finger, target) in pose.fingers.iter_mut().zip(&other.fingers) {
            finger.abduction = mix(finger.abduction, target.abduction);
            for (a, b) in finger.flexion.iter_mut().zip(target.flexion) {
                *a = mix(*a, b);
            }
        }
        pose
    }
}

/// One bone as posed: where it starts and ends and how its back is turned, canonical frame.
#[derive(Clone, Copy, Debug)]
pub struct Bone {
    /// Joint it starts from.
    pub start: Vector3<f64>,
    /// Joint it ends in.
    pub end: Vector3<f64>,
    /// x along the bone, y out of its back.
    pub rotation: UnitQuaternion<f64>,
}

/// A posed hand in the canonical frame.
#[derive(Clone, Debug)]
pub struct PosedHand {
    /// 21 joints in the keypoint order.
    pub joints: [Vector3<f64>; KEYPOINT_COUNT],
    /// Thumb to little finger, three bones each, from base to tip (the thumb's first is its metacarpal).
    pub bones: [[Bone; 3]; 5],
}

/// A hand's size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HandShape {
    /// Wrist to middle fingertip, straight, metres.
    pub hand_length: f64,
}

/// MCP joints of index to little finger at the table's size, millimetres.
const MCP_MM: [[f64; 3]; 4] = [[94.2, 0.0, 23.0], [99.5, 0.0, 0.0], [91.0, -1.5, -19.0], [80.2, -4.0, -37.5]];
/// Proximal, middle and distal phalanx with pulp, index to little finger, millimetres.
const PHALANGES_MM: [[f64; 3]; 4] =
    [[39.8, 22.4, 19.6], [44.6, 26.3, 21.4], [41.4, 25.7, 21.3], [32.7, 18.1, 19.7]];
/// Direction of the straight fingers to the thumb's side, degrees.
const FAN_DEG: [f64; 4] = [5.0, 0.0, -5.0, -12.0];
/// Thumb CMC joint, millimetres.
const CMC_MM: [f64; 3] = [22.0, -9.0, 24.0];
/// Thumb metacarpal, proximal and distal phalanx with pulp, millimetres.
const THUMB_MM: [f64; 3] = [46.2, 31.6, 27.4];

impl HandShape {
    /// Size relative to the published table.
    pub fn scale(&self) -> f64 {
        self.hand_length / TABLE_HAND_LENGTH
    }

    /// Poses the hand in the canonical frame.
    pub fn pose(&self, pose: &HandPose) -> PosedHand {
        let unit = self.scale() * 1e-3;
        let mut joints = [Vector3::zeros(); KEYPOINT_COUNT];
        let thumb = self.thumb(&pose.thumb, unit);
        let mut bones = [thumb; 5];
        for (finger, angles) in pose.fingers.iter().enumerate() {
            bones[finger + 1] = finger_chain(finger, angles, unit);
        }
        for (finger, chain) in bones.iter().enumerate() {
            let first = 1 + 4 * finger;
            joints[first] = chain[0].start;
            for (bone, joint) in chain.iter().zip(&mut joints[first + 1..]) {
                *joint = bone.end;
            }
        }
        PosedHand { joints, bones }
    }

    fn thumb(&self, pose: &ThumbPose, unit: f64) -> [Bone; 3] {
        let cmc = Vector3::from(CMC_MM) * unit;
        let beside = Vector3::new(0.66, -0.20, 0.72).normalize();
        let across = Vector3::new(0.70, -0.68, 0.22).normalize();
        let direction = beside.lerp(&across, pose.opposition).normalize();
        // Flexion bends the tip towards a point over the palm's middle.
        let over_palm = Vector3::new(105.0, -62.0, -12.0) * unit;
        let axis = Unit::new_normalize(direction.cross(&(over_palm - cmc)));
        let turn = |angle: f64| Rotation3::from_axis_angle(&axis, angle);
        let directions = [
            direction,
            turn(pose.flexion[0]) * direction,
            turn(pose.flexion[0] + pose.flexion[1]) * direction,
        ];
        let mut start = cmc;
        std::array::from_fn(|index| {
            let end = start + directions[index] * THUMB_MM[index] * unit;
            let back = -axis.cross(&directions[index]);
            let bone = Bone { start, end, rotation: axes(directions[index], back) };
            start = end;
            bone
        })
    }
}

fn finger_chain(finger: usize, pose: &FingerPose, unit: f64) -> [Bone; 3] {
    let fan =
        Rotation3::from_axis_angle(&Vector3::y_axis(), -(FAN_DEG[finger].to_radians() + pose.abduction));
    let mut start = Vector3::from(MCP_MM[finger]) * unit;
    let mut angle = 0.0;
    std::array::from_fn(|index| {
        angle += pose.flexion[index];
        let rotation = fan * Rotation3::from_axis_angle(&Vector3::z_axis(), -angle);
        let end = start + rotation * Vector3::x() * PHALANGES_MM[finger][index] * unit;
        let bone = Bone { start, end, rotation: UnitQuaternion::from_rotation_matrix(&rotation) };
        start = end;
        bone
    })
}

/// The rotation whose x axis is `along` and whose y axis is nearest to `back`.
pub fn axes(along: Vector3<f64>, back: Vector3<f64>) -> UnitQuaternion<f64> {
    let x = along.normalize();
    let y = (back - x * back.dot(&x)).normalize();
    let matrix = nalgebra::Matrix3::from_columns(&[x, y, x.cross(&y)]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_middle_finger_has_the_stated_hand_length() {
        let shape = HandShape { hand_length: 0.18 };
        let hand = shape.pose(&HandPose::default());
        assert!((hand.joints[12].norm() - 0.18).abs() < 1e-9, "{}", hand.joints[12].norm());
    }

    #[test]
    fn bones_keep_their_length_in_every_pose() {
        let shape = HandShape { hand_length: 0.19 };
        let mut pose = HandPose::default();
        pose.fingers[2] = FingerPose { flexion: [1.0, 1.2, 0.7], abduction: 0.1 };
        pose.thumb = ThumbPose { opposition: 0.8, flexion: [0.6, 0.9] };
        let (open, bent) = (shape.pose(&HandPose::default()), shape.pose(&pose));
        for (a, b) in open.bones.iter().flatten().zip(bent.bones.iter().flatten()) {
            assert!(((a.end - a.start).norm() - (b.end - b.start).norm()).abs() < 1e-12);
        }
    }
}
