//! What every place of one view showed over a stretch of time, with the arms taken out.

use opencv::{
    core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Scalar, Vec3b},
    imgproc,
};

use super::{
    SelectError,
    scene::{Scene, to_lab},
};
use crate::vision::{Registration, Warp};

/// Samples of a stretch drawn on the grid of one of them.
pub(super) struct Timeline {
    pub columns: usize,
    /// Position in the scene's samples whose grid it is.
    pub reference: usize,
    pub shown: Vec<Shown>,
}

/// A sample as the reference's camera would have seen it.
pub(super) struct Shown {
    /// Position in the scene's samples.
    pub sample: usize,
    pub lab: Vec<[u8; 3]>,
    /// Where the background or something lying on it is seen: not an arm, not outside.
    pub known: Vec<bool>,
}

impl Timeline {
    /// Registers the samples at `range` with the one at `reference`; those that do not fit are left out.
    pub fn new(scene: &Scene<'_>, samples: &[usize], reference: usize) -> Result<Self, SelectError> {
        let mut shown = Vec::new();
        for sample in samples {
            if let Some(drawn) = drawn(scene, *sample, reference)? {
                shown.push(drawn);
            }
        }
        Ok(Self { columns: scene.scale.work.width as usize, reference, shown })
    }

    pub fn area(&self) -> usize {
        self.shown.first().map_or(0, |shown| shown.lab.len())
    }

    /// The colours of every place as first seen and as last seen, medians of up to three sights without a gap
    /// between them; `None` where it was not seen twice.
    pub fn ends(&self) -> Ends {
        let mut ends = Ends { first: Vec::new(), last: Vec::new() };
        let mut sights: Vec<(usize, [u8; 3])> = Vec::new();
        for place in 0..self.area() {
            sights.clear();
            let known = self.shown.iter().enumerate().filter(|(_, shown)| shown.known[place]);
            sights.extend(known.map(|(at, shown)| (at, shown.lab[place])));
            let few = (sights.len() / 2).min(3);
            let ends_here = (few > 0).then(|| {
                let run = |near: &mut dyn Iterator<Item = &(usize, [u8; 3])>| {
                    let mut run: Vec<(usize, [u8; 3])> = Vec::with_capacity(few);
                    for sight in near.take(few) {
                        if run.last().is_some_and(|last| last.0.abs_diff(sight.0) > 1) {
                            break;
                        }
                        run.push(*sight);
                    }
                    median(&run)
                };
                (run(&mut sights.iter()), run(&mut sights.iter().rev()))
            });
            ends.first.push(ends_here.map(|pair| pair.0));
            ends.last.push(ends_here.map(|pair| pair.1));
        }
        ends
    }
}

/// First and last colours of every place.
pub(super) struct Ends {
    pub first: Vec<Option<[u8; 3]>>,
    pub last: Vec<Option<[u8; 3]>>,
}

fn median(sights: &[(usize, [u8; 3])]) -> [u8; 3] {
    std::array::from_fn(|channel| {
        let mut values = [0_u8; 64];
        let count = sights.len().min(64);
        for (value, sight) in values.iter_mut().zip(sights) {
            *value = sight.1[channel];
        }
        values[..count].sort_unstable();
        values[count / 2]
    })
}

/// The warp that draws sample `source` on the grid of sample `target`.
pub(super) fn warp(scene: &Scene<'_>, target: usize, source: usize) -> Result<Option<Warp>, SelectError> {
    let (to, from) = (&scene.samples[target], &scene.samples[source]);
    let Some(guess) = scene.camera(to.index, from.index) else { return Ok(None) };
    if target == source {
        return Ok(Some(Warp::along(&guess, to.view.scale, from.view.scale)));
    }
    let registration = Registration { parallax: true };
    let found = registration.register(&to.view, &from.view, &guess, None)?;
    // Too few corners: what the chain of neighbours says.
    Ok(Some(found.unwrap_or_else(|| Warp::along(&guess, to.view.scale, from.view.scale))))
}

fn drawn(scene: &Scene<'_>, sample: usize, reference: usize) -> Result<Option<Shown>, SelectError> {
    let Some(warp) = warp(scene, reference, sample)? else { return Ok(None) };
    let view = &scene.samples[sample].view;
    let (colour, valid) = warp.draw_work(view)?;
    let target = &scene.samples[reference].view;
    let colour = alike(&colour, &valid, &target.colour, &target.valid)?;
    let lab = to_lab(&colour)?.data_typed::<Vec3b>()?.iter().map(|v| v.0).collect();
    let known = valid.data_bytes()?.iter().map(|v| *v != 0).collect();
    Ok(Some(Shown { sample, lab, known }))
}

/// `colour` with the exposure of `target`: one gain a channel, from the medians of what both show.
fn alike(colour: &Mat, valid: &Mat, target: &Mat, usable: &Mat) -> opencv::Result<Mat> {
    let mut both = Mat::default();
    opencv::core::bitwise_and_def(valid, usable, &mut both)?;
    let mut ratios: [Vec<f32>; 3] = Default::default();
    let pixels = colour.data_typed::<Vec3b>()?.iter().zip(target.data_typed::<Vec3b>()?);
    for ((mine, theirs), both) in pixels.zip(both.data_bytes()?).step_by(7) {
        if *both == 0 {
            continue;
        }
        for ((ratios, mine), theirs) in ratios.iter_mut().zip(mine.0).zip(theirs.0) {
            if mine > 24 && theirs > 24 && mine < 250 && theirs < 250 {
                ratios.push(f32::from(theirs) / f32::from(mine));
            }
        }
    }
    let mut gains = [1.0_f64; 3];
    for (gain, ratios) in gains.iter_mut().zip(&mut ratios) {
        if ratios.len() > 50 {
            let middle = ratios.len() / 2;
            *gain = f64::from(*ratios.select_nth_unstable_by(middle, f32::total_cmp).1).clamp(0.6, 1.6);
        }
    }
    let mut out = Mat::default();
    opencv::core::multiply_def(colour, &Scalar::new(gains[0], gains[1], gains[2], 1.0), &mut out)?;
    Ok(out)
}

/// `mask`, which is on the grid of sample `from`, on the grid of sample `to`.
pub(super) fn carried(
    scene: &Scene<'_>,
    mask: &Mat,
    from: usize,
    to: usize,
) -> Result<Option<Mat>, SelectError> {
    if from == to {
        return Ok(Some(mask.try_clone()?));
    }
    let Some(warp) = warp(scene, to, from)? else { return Ok(None) };
    let region = scene.samples[to].view.scale.whole();
    let mut out = warp.draw(mask, region, imgproc::INTER_LINEAR, Some(Scalar::all(0.0)))?;
    for value in out.data_bytes_mut()? {
        *value = if *value > 127 { 255 } else { 0 };
    }
    Ok(Some(out))
}
