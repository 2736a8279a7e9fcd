//! What colours arms have, by the arm masks.

use opencv::core::{MatTraitConstManual, Vec3b};

use super::scene::{Sample, Scene, to_lab};
use crate::vision::{LabHistogram, binary};

/// Colours of arms and of all else on every sample.
pub(super) struct ArmColours {
    samples: Vec<(LabHistogram, LabHistogram)>,
}

/// Arm pixels from which on their colours are known.
const ENOUGH: f64 = 150.0;

impl ArmColours {
    /// From the arm masks of all samples.
    pub fn learn(scene: &Scene<'_>) -> opencv::Result<Self> {
        let counts = |sample: &Sample| {
            let lab = to_lab(&sample.view.colour)?;
            let core = binary::eroded(&sample.arm, 2)?;
            let (mut arms, mut others) = (LabHistogram::default(), LabHistogram::default());
            let pixels = lab.data_typed::<Vec3b>()?.iter().zip(core.data_bytes()?);
            for ((lab, core), arm) in pixels.zip(sample.arm.data_bytes()?).step_by(5) {
                if *core != 0 {
                    arms.add(lab.0);
                } else if *arm == 0 {
                    others.add(lab.0);
                }
            }
            Ok((arms, others))
        };
        Ok(Self { samples: scene.samples.iter().map(counts).collect::<opencv::Result<_>>()? })
    }

    /// Share of `colours` that rather are an arm's, by the arms before (`taken`) or after a change: while
    /// the object lies there it is in no arm's mask by mistake.
    pub fn share_then(&self, colours: &[[u8; 3]], taken: bool, when: (usize, usize)) -> f64 {
        let (first, last) = (when.0.min(when.1), when.0.max(when.1));
        let span = if taken { &self.samples[..=first] } else { &self.samples[last..] };
        let mut all = merged(span);
        if all.0.total() < ENOUGH {
            all = merged(&self.samples);
        }
        share(&all, colours)
    }

    /// Share of `colours` that rather are an arm's, by all samples.
    pub fn share_of_all(&self, colours: &[[u8; 3]]) -> f64 {
        share(&merged(&self.samples), colours)
    }
}

fn merged(span: &[(LabHistogram, LabHistogram)]) -> (LabHistogram, LabHistogram) {
    let mut all = (LabHistogram::default(), LabHistogram::default());
    for (arms, others) in span {
        all.0.merge(arms);
        all.1.merge(others);
    }
    all
}

/// Share of `colours` that fit the first histogram better than the second.
fn share((arms, others): &(LabHistogram, LabHistogram), colours: &[[u8; 3]]) -> f64 {
    if arms.total() < ENOUGH {
        return 0.0;
    }
    let table = arms.smoothed(1).posterior_table(&others.smoothed(1));
    let like = colours.iter().filter(|lab| LabHistogram::look_up(&table, **lab) > 186).count();
    like as f64 / colours.len().max(1) as f64
}
