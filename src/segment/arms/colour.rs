//! The clip's own colours of arm, background and object, and how much a change says.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual};

use super::{
    plate::{NEUTRAL, UNKNOWN},
    shade::Shadows,
    work_frame::WorkFrame,
};
use crate::vision::{LabHistogram, binary};

/// Shadows that arms cast on the background: share of the light that is left, and how often.
const SHADOWS: [(f32, f32); 3] = [(0.55, 0.05), (0.68, 0.05), (0.82, 0.05)];
/// How far a change against the background may speak for or against an arm, log-odds: a hand that rests
/// throughout a clip has become part of the plate and does not change at all.
const CHANGE_ODDS: (f32, f32) = (-2.0, 2.5);

/// An 8-bit Lab colour in shadow: chroma falls with lightness.
fn shaded(lab: [u8; 3], ratio: f32) -> [u8; 3] {
    let chroma = |value: u8| (128.0 + ratio * (f32::from(value) - 128.0)).round() as u8;
    [(ratio * f32::from(lab[0])).round() as u8, chroma(lab[1]), chroma(lab[2])]
}

/// Histograms of what is arm and what is not.
#[derive(Clone, Debug)]
pub(super) struct ColourModel {
    pub arm: LabHistogram,
    pub background: LabHistogram,
    /// Changes against the plate inside and outside of arms.
    changes: [Vec<f32>; 2],
}

impl Default for ColourModel {
    fn default() -> Self {
        let empty = || vec![0.0; 256];
        Self {
            arm: LabHistogram::default(),
            background: LabHistogram::default(),
            changes: [empty(), empty()],
        }
    }
}

impl ColourModel {
    /// Counts the pixels of `frame` inside `arm` and inside `background`, these also in `shadows`.
    pub fn learn(
        &mut self,
        frame: &WorkFrame,
        arm: &Mat,
        background: &Mat,
        shadows: &Shadows,
    ) -> opencv::Result<()> {
        let possible = SHADOWS.into_iter().filter(|(ratio, _)| shadows.reach(*ratio));
        let masks = arm.data_bytes()?.iter().zip(background.data_bytes()?);
        for (lab, (arm, background)) in frame.pixels()?.iter().zip(masks) {
            if *arm != 0 {
                self.arm.add(*lab);
            } else if *background != 0 {
                self.background.add(*lab);
                for (ratio, weight) in possible.clone() {
                    self.background.add_weighted(shaded(*lab, ratio), weight);
                }
            }
        }
        Ok(())
    }

    /// Counts the changes inside `arm` and outside of it.
    pub fn learn_change(&mut self, change: &Mat, arm: &Mat) -> opencv::Result<()> {
        for (change, arm) in change.data_bytes()?.iter().zip(arm.data_bytes()?) {
            self.changes[usize::from(*arm == 0)][usize::from(*change)] += 1.0;
        }
        Ok(())
    }

    /// Adds what `other` has learned.
    pub fn merge(&mut self, other: &Self) {
        self.arm.merge(&other.arm);
        self.background.merge(&other.background);
        for (mine, theirs) in self.changes.iter_mut().flatten().zip(other.changes.iter().flatten()) {
            *mine += theirs;
        }
    }

    /// Whether both sides have seen enough to be compared.
    pub fn is_usable(&self) -> bool {
        self.arm.total() > 200.0 && self.background.total() > 200.0
    }

    /// What the counts say of colours and changes; `object` holds the colours of the object that is handled.
    pub fn tables(&self, object: Option<&LabHistogram>) -> Tables {
        let arm = self.arm.smoothed(1);
        let mut colour = arm.posterior_table(&self.background.smoothed(1));
        let object = object.map(|object| object.smoothed(1).fair_posterior_table(&arm));
        if let Some(object) = &object {
            for (arm, object) in colour.iter_mut().zip(object) {
                // Odds against the background and odds against the object add up; even odds say nothing.
                let against = |posterior: u8| f32::from(255 - posterior) / f32::from(posterior).max(0.5);
                let object_odds = (f32::from(*object) / f32::from(255 - object).max(0.5) - 1.0).max(0.0);
                *arm = (255.0 / (1.0 + against(*arm) + object_odds)).round() as u8;
            }
        }
        Tables { colour, object, change: self.change_odds() }
    }

    /// log P(change | arm) / P(change | background), smoothed over neighbouring values.
    fn change_odds(&self) -> Vec<f32> {
        let smooth = |counts: &[f32]| -> Vec<f32> {
            let known = &counts[..usize::from(UNKNOWN)];
            let total: f32 = known.iter().sum::<f32>() + 255.0;
            (0..known.len())
                .map(|at| {
                    let half = 1 + at / 8;
                    let near = &known[at.saturating_sub(half)..(at + half + 1).min(known.len())];
                    (near.iter().sum::<f32>() + near.len() as f32) / (near.len() as f32 * total)
                })
                .collect()
        };
        let (arm, background) = (smooth(&self.changes[0]), smooth(&self.changes[1]));
        let odds = arm.iter().zip(&background).map(|(a, b)| (a / b).ln().clamp(CHANGE_ODDS.0, CHANGE_ODDS.1));
        // Doubtful samples are drawn where arms are often: that is no evidence.
        let mut odds: Vec<f32> = odds.chain(std::iter::once(0.0)).collect();
        odds[usize::from(NEUTRAL)] = 0.0;
        odds
    }
}

/// Colours and changes looked up instead of computed.
#[derive(Clone, Debug)]
pub(super) struct Tables {
    /// P(arm | Lab cell) against background and object with even priors, 0 to 255.
    pub colour: Vec<u8>,
    /// P(object | Lab cell) against arm, 0 to 255.
    pub object: Option<Vec<u8>>,
    /// Log-odds of arm for every change against the plate.
    pub change: Vec<f32>,
}

impl Tables {
    /// P(arm), 0 to 255, from `colour` (P(arm | colour), CV_8UC1) and `change`.
    pub fn likely(&self, colour: &Mat, change: Option<&Mat>) -> opencv::Result<Mat> {
        let Some(change) = change else { return colour.try_clone() };
        let odds: Vec<f32> = (0..256)
            .map(|value| {
                let p = (value as f32 / 255.0).clamp(0.004, 0.996);
                (p / (1.0 - p)).ln()
            })
            .collect();
        let mut out = binary::empty(colour.rows(), colour.cols())?;
        let values = colour.data_bytes()?.iter().zip(change.data_bytes()?);
        for (out, (colour, change)) in out.data_bytes_mut()?.iter_mut().zip(values) {
            let sum = odds[usize::from(*colour)] + self.change[usize::from(*change)];
            *out = (255.0 / (1.0 + (-sum).exp())).round() as u8;
        }
        Ok(out)
    }
}
