//! The stages, their order and their share of the work.

use serde::{Deserialize, Serialize};

/// A step of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Decode and standardise.
    Clip,
    /// Hand landmarks: what segmentation and the hand fit both read.
    Landmarks,
    /// Arm masks.
    Arms,
    /// Which object.
    Select,
    /// Object masks.
    Object,
    /// Clean frame, template, placements.
    Template,
    /// Background.
    Inpaint,
    /// Metric hands.
    Hands,
    /// Robot motion.
    Retarget,
    /// Robot pictures, layers, files.
    Export,
}

impl Stage {
    /// All stages in order, each with its share of a clip's work, for progress and ETA.
    pub const SHARES: [(Self, f64); 10] = [
        (Self::Clip, 0.04),
        (Self::Landmarks, 0.16),
        (Self::Arms, 0.14),
        (Self::Select, 0.02),
        (Self::Object, 0.18),
        (Self::Template, 0.10),
        (Self::Inpaint, 0.16),
        (Self::Hands, 0.03),
        (Self::Retarget, 0.02),
        (Self::Export, 0.15),
    ];

    /// The name in logs and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clip => "clip",
            Self::Landmarks => "landmarks",
            Self::Arms => "arms",
            Self::Select => "select",
            Self::Object => "object",
            Self::Template => "template",
            Self::Inpaint => "inpaint",
            Self::Hands => "hands",
            Self::Retarget => "retarget",
            Self::Export => "export",
        }
    }

    /// Whether one stage may be at work before the other is done: the background is made beside template, hands
    /// and motion.
    pub fn runs_beside(self, other: Self) -> bool {
        let beside = Self::Template..=Self::Retarget;
        beside.contains(&self) && beside.contains(&other)
    }
}

#[cfg(test)]
mod tests {
    use super::Stage;

    #[test]
    fn shares_add_up_to_the_whole_clip() {
        assert!((Stage::SHARES.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(Stage::SHARES.is_sorted_by_key(|(stage, _)| *stage));
    }
}
