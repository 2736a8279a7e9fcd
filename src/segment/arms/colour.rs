//! The clip's own colours of arm and background.

use opencv::core::{Mat, MatTraitConstManual};

use super::work_frame::WorkFrame;
use crate::vision::LabHistogram;

/// Shadows that arms cast on the background: share of the light that is left, and how often.
const SHADOWS: [(f32, f32); 3] = [(0.55, 0.05), (0.68, 0.05), (0.82, 0.05)];

/// An 8-bit Lab colour in shadow: chroma falls with lightness.
fn shaded(lab: [u8; 3], ratio: f32) -> [u8; 3] {
    let chroma = |value: u8| (128.0 + ratio * (f32::from(value) - 128.0)).round() as u8;
    [(ratio * f32::from(lab[0])).round() as u8, chroma(lab[1]), chroma(lab[2])]
}

/// Histograms of what is arm and what is not.
#[derive(Clone, Debug, Default)]
pub(super) struct ColourModel {
    pub arm: LabHistogram,
    pub background: LabHistogram,
}

impl ColourModel {
    /// Counts the pixels of `frame` inside `arm` and inside `background`.
    pub fn learn(&mut self, frame: &WorkFrame, arm: &Mat, background: &Mat) -> opencv::Result<()> {
        let masks = arm.data_bytes()?.iter().zip(background.data_bytes()?);
        for (lab, (arm, background)) in frame.pixels()?.iter().zip(masks) {
            if *arm != 0 {
                self.arm.add(*lab);
            } else if *background != 0 {
                self.background.add(*lab);
                for (ratio, weight) in SHADOWS {
                    self.background.add_weighted(shaded(*lab, ratio), weight);
                }
            }
        }
        Ok(())
    }

    /// Adds what `other` has learned.
    pub fn merge(&mut self, other: &Self) {
        self.arm.merge(&other.arm);
        self.background.merge(&other.background);
    }

    /// Whether both sides have seen enough to be compared.
    pub fn is_usable(&self) -> bool {
        self.arm.total() > 200.0 && self.background.total() > 200.0
    }

    /// P(arm | Lab cell) with even priors, 0 to 255.
    pub fn posterior_table(&self) -> Vec<u8> {
        self.arm.smoothed(1).posterior_table(&self.background.smoothed(1))
    }
}
