//! First guesses of an object's shape inside a box.

use super::{
    motion::{LocalFlow, fit_similarity},
    view::{Roi, Scene, View, arm},
};
use crate::{clip::FrameIndex, segment::SegmentError};

/// The whole box, the ellipse in it, and a slim shape along either diagonal; 0 or 1 a pixel of `roi`.
pub(super) fn inside_box(roi: &Roi, bounds: (f64, f64, f64, f64)) -> Vec<Vec<u8>> {
    let (x0, y0, x1, y1) = bounds;
    let make = |inside: &dyn Fn(f64, f64) -> bool| {
        let pixel = |at: usize| {
            let u = 2.0 * ((at % roi.width) as f64 + 0.5 - x0) / (x1 - x0).max(1.0) - 1.0;
            let v = 2.0 * ((at / roi.width) as f64 + 0.5 - y0) / (y1 - y0).max(1.0) - 1.0;
            u8::from(u.abs() <= 1.0 && v.abs() <= 1.0 && inside(u, v))
        };
        (0..roi.area()).map(pixel).collect::<Vec<u8>>()
    };
    vec![
        make(&|_, _| true),
        make(&|u, v| u * u + v * v < 0.95),
        make(&|u, v| (u - v).abs() < 0.42),
        make(&|u, v| (u + v).abs() < 0.42),
    ]
}

/// Frames ahead or behind that motion is looked for in.
const LOOK: i64 = 3;

/// Pixels in the box that move otherwise than the background around it does, when those are a fair
/// part of the box: an object already in the hand. `None` where nothing, or everything, moves.
pub(super) fn moving(
    scene: &Scene<'_>,
    view: &View,
    frame: FrameIndex,
    roi: &Roi,
    bounds: (f64, f64, f64, f64),
) -> Result<Option<Vec<u8>>, SegmentError> {
    let count = scene.frames.frame_count() as i64;
    let here = i64::from(frame.0);
    let Some(other) = [here + LOOK, here - LOOK].into_iter().find(|at| (0..count).contains(at)) else {
        return Ok(None);
    };
    let other = scene.view(FrameIndex(other as u32))?;
    let wide = Roi::around(
        (roi.x as f64, roi.y as f64, (roi.x + roi.width) as f64, (roi.y + roi.height) as f64),
        40.0,
        view.width,
        view.height,
    );
    let flow = LocalFlow::between(view, &other, wide)?;
    let classes = wide.crop(&view.arms, view.width);
    let position = |at: usize| ((at % wide.width + wide.x) as f64, (at / wide.width + wide.y) as f64);
    let in_box = |at: usize| {
        let (x, y) = position(at);
        let (x, y) = (x - roi.x as f64, y - roi.y as f64);
        x >= bounds.0 && x < bounds.2 && y >= bounds.1 && y < bounds.3
    };
    let around = flow.matches(|at| !in_box(at) && classes[at] == arm::NONE, 2000);
    let Some(background) = fit_similarity(&around).filter(|fit| fit.agreement > 0.5) else { return Ok(None) };
    let mut moving = vec![0; roi.area()];
    let (mut inside, mut moved) = (0_u32, 0_u32);
    for (at, class) in classes.iter().enumerate() {
        if !in_box(at) {
            continue;
        }
        inside += 1;
        let (x, y) = position(at);
        let w = flow.forward.vectors()[at];
        let still = super::keyframe::apply(&background.transform, x, y);
        let off = (x + f64::from(w[0]) - still.0).hypot(y + f64::from(w[1]) - still.1);
        if off > 2.0 && *class < arm::MASK {
            moved += 1;
            moving[(y as usize - roi.y) * roi.width + x as usize - roi.x] = 1;
        }
    }
    let share = f64::from(moved) / f64::from(inside.max(1));
    Ok((0.08..0.8).contains(&share).then_some(moving))
}
