//! From what a regressor says of a crop to a hand in the camera frame.

use nalgebra::{UnitQuaternion, Vector3};

use super::{crop::Crop, rotation::of_side};
use crate::{
    geometry::{Camera, Pinhole, Pixel, Position, Side},
    hands::ManoHand,
    landmarks::KEYPOINT_COUNT,
};

/// Focal length that the networks were trained with, in sides of their crop: 5000 pixels at 256.
const TRAINED_FOCAL: f64 = 5000.0 / 256.0;
/// Farther away than this, metres, there is no hand.
const FARTHEST: f64 = 10.0;

/// What a regressor says of a crop: of a right hand, the crops of left ones being mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct HandPrediction {
    /// Scale and shift (s, tx, ty) of the hand in its crop.
    pub camera: [f64; 3],
    /// The joints relative to the hand, metres, in our order.
    pub joints: [Vector3<f64>; KEYPOINT_COUNT],
    /// Orientation of the whole hand and rotations of the 15 finger joints, where the graph gives them.
    pub rotations: Option<(UnitQuaternion<f64>, [UnitQuaternion<f64>; 15])>,
    /// MANO's shape, where the graph gives it.
    pub shape: Option<[f64; 10]>,
}

/// A hand in the camera frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedHand {
    /// Joints, metres.
    pub joints: [Position<Camera>; KEYPOINT_COUNT],
    /// Where the network sees them, pixels of the clip.
    pub keypoints: [Pixel; KEYPOINT_COUNT],
    /// MANO's rotations and shape, where the graph gives them.
    pub mano: Option<ManoHand>,
}

/// Where a hand of scale and shift (s, tx, ty) in `crop` is for a camera of focal lengths `focal` and principal point
/// `centre`, metres: `Tz = 2f / (bs)`, `Tx = 2(x − cx) / (bs) + tx` and `Ty` likewise, with b the crop's side and (x, y)
/// its centre. The shift is that of the hand as it is: a left hand's is mirrored back before.
///
/// With the networks' own focal length the projection looks as right and the hand is tens of times too far away.
pub fn camera_translation(
    [s, tx, ty]: [f64; 3],
    crop: &Crop,
    focal: [f64; 2],
    centre: Pixel,
) -> Vector3<f64> {
    let z = 2.0 * focal[0] / (crop.side * s + 1e-9);
    let aside = |at: f64, centre: f64, focal: f64| z * (at - centre) / focal;
    Vector3::new(
        aside(crop.centre.x, centre.x, focal[0]) + tx,
        aside(crop.centre.y, centre.y, focal[1]) + ty,
        z,
    )
}

/// From the axes of a crop to those of the camera. A network knows nothing of where in the picture its crop was: it says how
/// the hand is turned towards whoever looks straight at it, and a camera sees the crop along a ray of its own. Its own focal
/// length is so long that all rays are parallel; the camera's is not.
fn viewing_turn(crop: &Crop, camera: &Pinhole) -> UnitQuaternion<f64> {
    let ray =
        Vector3::new((crop.centre.x - camera.cx) / camera.fx, (crop.centre.y - camera.cy) / camera.fy, 1.0);
    // A ray into the picture never points back along the axis.
    UnitQuaternion::rotation_between(&Vector3::z(), &ray).unwrap_or_default()
}

impl HandPrediction {
    /// The hand in the frame of `camera`; `None` where the numbers are not finite or mean no hand before the camera.
    pub fn placed(&self, crop: &Crop, camera: &Pinhole) -> Option<PlacedHand> {
        let mirror = if crop.hand == Side::Left { -1.0 } else { 1.0 };
        let [s, tx, ty] = self.camera;
        let shift = [s, mirror * tx, ty];
        let joints = self.joints.map(|joint| Vector3::new(mirror * joint.x, joint.y, joint.z));
        let at = camera_translation(shift, crop, [camera.fx, camera.fy], Pixel::new(camera.cx, camera.cy));
        let turn = viewing_turn(crop, camera);
        let metric = joints.map(|joint| Position::<Camera>::new(turn * joint + at));
        let is_there =
            |joint: &Position<Camera>| joint.is_finite() && joint.xyz.z > 0.01 && joint.xyz.norm() < FARTHEST;
        if !metric.iter().all(is_there) {
            return None;
        }
        // What the network means in the picture is what its own camera sees.
        let (width, height) = (f64::from(camera.size.width), f64::from(camera.size.height));
        let (focal, middle) = (TRAINED_FOCAL * width.max(height), Pixel::new(0.5 * width, 0.5 * height));
        let own = camera_translation(shift, crop, [focal; 2], middle);
        let keypoints = joints.map(|joint| {
            let p = joint + own;
            Pixel::new(focal * p.x / p.z + middle.x, focal * p.y / p.z + middle.y)
        });
        let finite = keypoints.iter().all(|pixel| pixel.x.is_finite() && pixel.y.is_finite());
        let mano = self.rotations.map(|(orientation, fingers)| ManoHand {
            orientation: turn * of_side(orientation, crop.hand),
            fingers: fingers.map(|finger| of_side(finger, crop.hand)),
            shape: self.shape,
        });
        finite.then_some(PlacedHand { joints: metric, keypoints, mano })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    const CROP: Crop = Crop { centre: Pixel { x: 1200.0, y: 700.0 }, side: 300.0, hand: Side::Right };
    const SAID: [f64; 3] = [0.9, 0.05, -0.02];

    fn camera() -> Pinhole {
        Pinhole { fx: 1050.0, fy: 1050.0, cx: 960.0, cy: 540.0, size: Size::new(1920, 1080) }
    }

    fn hand(camera: [f64; 3]) -> HandPrediction {
        let joints = std::array::from_fn(|k| Vector3::new(0.01 + 0.001 * k as f64, -0.02, 0.005));
        HandPrediction { camera, joints, rotations: None, shape: None }
    }

    #[test]
    fn the_translation_is_the_published_one_for_the_trained_focal_length() {
        let own = camera_translation(SAID, &CROP, [37_500.0; 2], Pixel::new(960.0, 540.0));
        assert!((own - Vector3::new(1.827_777_78, 1.165_185_19, 277.777_777_78)).norm() < 1e-6, "{own}");
        let p = Vector3::new(0.01, -0.02, 0.005) + own;
        let seen = (37_500.0 * p.x / p.z + 960.0, 37_500.0 * p.y / p.z + 540.0);
        assert!(
            (seen.0 - 1_208.095_534_28).abs() < 1e-4 && (seen.1 - 694.597_217_25).abs() < 1e-4,
            "{seen:?}"
        );
        let near = camera_translation(SAID, &CROP, [1050.0; 2], Pixel::new(960.0, 540.0));
        assert!((near.z - 7.777_777_778).abs() < 1e-6 && (near.x - own.x).abs() < 1e-6);
    }

    #[test]
    fn a_hand_at_a_usual_scale_is_at_arms_length_and_seen_where_its_crop_is() {
        let crop = Crop { side: 700.0, ..CROP };
        let placed = hand([5.5, 0.0, 0.0]).placed(&crop, &camera()).unwrap();
        let first = placed.joints[0].xyz;
        assert!((first.z - 0.005 - 2.0 * 1050.0 / 3850.0).abs() < 0.01);
        // The principal point's place decides where in space the same picture of a hand is.
        let off = Pinhole { cx: 900.0, cy: 500.0, ..camera() };
        let moved = hand([5.5, 0.0, 0.0]).placed(&crop, &off).unwrap();
        let aside = moved.joints[0].xyz - first;
        let expected = first.z - 0.005;
        assert!((aside.x - 60.0 / 1050.0 * expected).abs() < 2e-3 && aside.z.abs() < 2e-3);
        assert_eq!(moved.keypoints, placed.keypoints);
        assert!(off.project(&moved.joints[0]).unwrap().distance(placed.keypoints[0]) < 1.0);
    }

    #[test]
    fn a_hand_beside_the_middle_is_turned_with_the_ray_that_sees_it() {
        // Fingers towards the camera, in the picture's corner: 30 degrees beside the axis.
        let crop = Crop { centre: Pixel::new(1500.0, 800.0), side: 700.0, hand: Side::Right };
        let joints = std::array::from_fn(|k| Vector3::new(0.0, 0.0, -0.008 * k as f64));
        let said = HandPrediction { joints, ..hand([5.5, 0.0, 0.0]) };
        let placed = said.placed(&crop, &camera()).unwrap();
        for (joint, keypoint) in placed.joints.iter().zip(&placed.keypoints) {
            // The network sees them all but behind each other, and so does the camera.
            assert!(camera().project(joint).unwrap().distance(*keypoint) < 6.0);
        }
        let pointing = placed.joints[20].xyz - placed.joints[0].xyz;
        assert!(pointing.angle(&-placed.joints[0].xyz) < 1e-6);
    }

    #[test]
    fn a_left_hand_is_the_mirror_image_of_the_right_one() {
        // The middle of a picture 1920 wide lies half a pixel beside the middle of its columns.
        let centred = Crop { centre: Pixel::new(960.0, 600.0), side: 600.0, hand: Side::Right };
        let said = hand([5.0, 0.03, 0.01]);
        let right = said.placed(&centred, &camera()).unwrap();
        let left = said.placed(&Crop { hand: Side::Left, ..centred }, &camera()).unwrap();
        for (a, b) in right.joints.iter().zip(&left.joints) {
            assert!((a.xyz.x + b.xyz.x).abs() < 1e-12 && (a.xyz.y - b.xyz.y).abs() < 1e-12);
        }
    }

    #[test]
    fn numbers_that_mean_no_hand_give_none() {
        for camera_said in
            [[f64::NAN, 0.0, 0.0], [-5.0, 0.0, 0.0], [0.0, 0.0, 0.0], [5.0, f64::INFINITY, 0.0]]
        {
            assert_eq!(hand(camera_said).placed(&CROP, &camera()), None, "{camera_said:?}");
        }
    }
}
