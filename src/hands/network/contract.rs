//! The contract `hand-pose/1`: a detector of hands, and a regressor of one hand's pose.

use serde::{Deserialize, Serialize};

use super::crop::CROP_SIDE;
use crate::onnx::{Contract, Dim, GraphSpec, TensorSpec};

const SIDE: Dim = Dim::Exactly(CROP_SIDE as i64);
const ONE: Dim = Dim::Exactly(1);
const THREE: Dim = Dim::Exactly(3);
const JOINTS: Dim = Dim::Exactly(21);
const FINGER_JOINTS: Dim = Dim::Exactly(15);

/// The detector sees a letterboxed square picture, RGB from 0 to 1; the regressor one hand's crop, right hands as they
/// are and left hands mirrored.
pub const HAND_POSE: Contract = Contract {
    id: "hand-pose/1",
    graphs: &[
        GraphSpec {
            name: "hand_detector",
            inputs: &[TensorSpec::floats("images", &[&[ONE, THREE, Dim::Of("N"), Dim::Of("N")]])],
            outputs: &[TensorSpec::floats(
                "output0",
                &[
                    // A box, two sides and 21 keypoints of x, y and trust.
                    &[ONE, Dim::Exactly(69), Dim::Any("A")],
                    &[ONE, Dim::Exactly(6), Dim::Any("A")],
                    &[ONE, Dim::Any("K"), Dim::Exactly(6)],
                ],
            )],
            optional: false,
        },
        GraphSpec {
            name: "hand_regressor",
            inputs: &[TensorSpec::floats("img", &[&[ONE, THREE, SIDE, SIDE], &[ONE, SIDE, SIDE, THREE]])],
            outputs: &[
                TensorSpec::floats("pred_cam", &[&[ONE, THREE]]),
                TensorSpec::floats("pred_keypoints_3d", &[&[ONE, JOINTS, THREE]]),
                TensorSpec::floats(
                    "global_orient",
                    &[&[ONE, ONE, THREE, THREE], &[ONE, THREE, THREE], &[ONE, ONE, THREE], &[ONE, THREE]],
                )
                .if_there(),
                TensorSpec::floats(
                    "hand_pose",
                    &[
                        &[ONE, FINGER_JOINTS, THREE, THREE],
                        &[ONE, FINGER_JOINTS, THREE],
                        &[ONE, Dim::Exactly(45)],
                    ],
                )
                .if_there(),
                TensorSpec::floats("betas", &[&[ONE, Dim::Exactly(10)]]).if_there(),
            ],
            optional: false,
        },
    ],
};

/// How large the square around a hand's box is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum BoxRule {
    /// As high as the box widened to 3:4 (default): the loaders of WiLoR and HaMeR.
    #[default]
    #[serde(rename = "aspect_3_4")]
    Aspect,
    /// As the box's longer side: WiLoR-mini.
    #[serde(rename = "square")]
    Square,
}

impl BoxRule {
    /// The factor that its authors enlarge boxes by.
    pub const fn usual_rescale(self) -> f64 {
        match self {
            Self::Aspect => 2.0,
            Self::Square => 2.5,
        }
    }
}

/// How a regressor gives rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotations {
    /// 3×3 matrices.
    Matrix,
    /// Axes times angles, radians.
    AxisAngle,
}

/// In which order a regressor gives its 21 joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointOrder {
    /// Wrist, then thumb to pinky from base to tip (default).
    #[default]
    Openpose,
    /// MANO's 16 joints (wrist, index, middle, pinky, ring, thumb), then the five tips.
    Mano,
}

impl JointOrder {
    /// Where each of our keypoints stands in this order. MANO's: WiLoR-mini, `mano_wrapper.py`.
    pub const fn places(self) -> [usize; 21] {
        match self {
            Self::Openpose => [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20],
            Self::Mano => [0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20],
        }
    }
}

/// What the contract lets a model choose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HandParameters {
    /// How large the square around a box is (default: `aspect_3_4`).
    pub box_rule: BoxRule,
    /// By what the box is enlarged (default: 2 for `aspect_3_4`, 2.5 for `square`).
    pub rescale: Option<f64>,
    /// How rotations are given (default: by their shapes).
    pub rotations: Option<Rotations>,
    /// Order of the joints (default: `openpose`).
    pub joints: JointOrder,
    /// Least trust of a detection (default 0.3).
    pub confidence: f64,
    /// Overlap (intersection over union) above which two boxes of one side are one hand (default 0.5).
    pub overlap: f64,
}

impl Default for HandParameters {
    fn default() -> Self {
        Self {
            box_rule: BoxRule::Aspect,
            rescale: None,
            rotations: None,
            joints: JointOrder::Openpose,
            confidence: 0.3,
            overlap: 0.5,
        }
    }
}

impl HandParameters {
    /// By what boxes are enlarged.
    pub fn rescale(&self) -> f64 {
        self.rescale.unwrap_or(self.box_rule.usual_rescale())
    }

    /// What is out of bounds, in words.
    pub(super) fn fault(&self) -> Option<String> {
        let bounds = [
            ("rescale", self.rescale(), 0.5..=10.0),
            ("confidence", self.confidence, 0.0..=1.0),
            ("overlap", self.overlap, 0.0..=1.0),
        ];
        let wrong = bounds.into_iter().find(|(_, value, bounds)| !bounds.contains(value));
        wrong.map(|(name, value, bounds)| {
            format!("[parameters] {name} = {value}: {} to {} expected", bounds.start(), bounds.end())
        })
    }
}
