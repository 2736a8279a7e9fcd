//! Which frames show the object whole, and why.

use agenticfocus::{
    clip::FrameIndex, image::Mask, segment::RleMask, session::MaskLayer, template::TemplateTrack,
};

use crate::state::Workspace;

/// A clean frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ranked {
    /// Which.
    pub frame: FrameIndex,
    /// 0 to 1.
    pub score: f64,
    /// What speaks for it and against it.
    pub why: String,
}

/// The best frames; neighbours look alike, so of every stretch only the best is offered. The frame in use is
/// always among them.
pub(super) fn ranked(workspace: &Workspace, track: &TemplateTrack, count: usize) -> Vec<Ranked> {
    let apart = (track.scores.len() as u32 / 30).max(5);
    let mut frames = apart_from_each_other(&track.scores, apart, count);
    if !frames.contains(&track.frame) {
        frames.truncate(count.saturating_sub(1));
        frames.push(track.frame);
    }
    let usual = usual_area(workspace);
    let rank = |frame: FrameIndex| Ranked {
        frame,
        score: track.scores.get(frame.as_usize()).copied().unwrap_or(0.0),
        why: why(workspace, frame, usual),
    };
    frames.into_iter().map(rank).collect()
}

fn apart_from_each_other(scores: &[f64], apart: u32, count: usize) -> Vec<FrameIndex> {
    let mut order: Vec<FrameIndex> = FrameIndex::all(scores.len()).collect();
    order.sort_by(|a, b| scores[b.as_usize()].total_cmp(&scores[a.as_usize()]).then(a.cmp(b)));
    let mut taken: Vec<FrameIndex> = Vec::new();
    for frame in order {
        if taken.len() == count || scores[frame.as_usize()] <= 0.0 {
            break;
        }
        if taken.iter().all(|other| other.0.abs_diff(frame.0) >= apart) {
            taken.push(frame);
        }
    }
    taken
}

/// The area of the object where it is seen well: nine tenths of the frames show less.
fn usual_area(workspace: &Workspace) -> u64 {
    let mask = |frame| workspace.mask(MaskLayer::Object, frame).map_or(0, |on| on.mask.area());
    let mut areas: Vec<u64> =
        FrameIndex::all(workspace.frame_count()).map(mask).filter(|area| *area > 0).collect();
    areas.sort_unstable();
    areas.get(areas.len() * 9 / 10).copied().unwrap_or(0)
}

fn why(workspace: &Workspace, frame: FrameIndex, usual: u64) -> String {
    let Some(object) = workspace.mask(MaskLayer::Object, frame) else { return "no mask yet".to_owned() };
    let mut words = Vec::new();
    let size = object.mask.area() as f64 / usual.max(1) as f64;
    words.push(if size >= 0.9 { "whole".to_owned() } else { format!("{:.0} % of it seen", 100.0 * size) });
    if let Some(arms) = workspace.mask(MaskLayer::Arms, frame) {
        let touched = touched_share(&object.mask, &arms.mask);
        words.push(match touched {
            share if share < 0.01 => "hand away".to_owned(),
            share => format!("hand at {:.0} % of edge", 100.0 * share),
        });
    }
    if object.author == agenticfocus::segment::MaskAuthor::Human {
        words.push("mask by you".to_owned());
    }
    words.join(", ")
}

/// Share of the object's outline that has arm within 4 pixels.
fn touched_share(object: &RleMask, arms: &RleMask) -> f64 {
    if object.size() != arms.size() || arms.is_empty() {
        return 0.0;
    }
    let (object, arms) = (object.decode(), arms.decode());
    let Some(bounds) = object.bounding_box() else { return 0.0 };
    let (mut edge, mut touched) = (0_u32, 0_u32);
    for y in bounds.y0 as i64..bounds.y1 as i64 {
        for x in bounds.x0 as i64..bounds.x1 as i64 {
            let around = |step: i64| [(x - step, y), (x + step, y), (x, y - step), (x, y + step)];
            if inside(&object, x, y) && around(1).iter().any(|(x, y)| !inside(&object, *x, *y)) {
                edge += 1;
                let near = |step: i64| around(step).iter().any(|(x, y)| inside(&arms, *x, *y));
                touched += u32::from((1..=4).any(near));
            }
        }
    }
    f64::from(touched) / f64::from(edge.max(1))
}

fn inside(mask: &Mask, x: i64, y: i64) -> bool {
    let size = mask.size();
    let on = (0..i64::from(size.width)).contains(&x) && (0..i64::from(size.height)).contains(&y);
    on && mask.get(x as u32, y as u32)
}

#[cfg(test)]
mod tests {
    use agenticfocus::geometry::Size;

    use super::*;

    #[test]
    fn neighbours_of_a_good_frame_are_not_offered() {
        let scores = [0.1, 0.8, 0.9, 0.85, 0.2, 0.0, 0.5];
        assert_eq!(apart_from_each_other(&scores, 3, 5), [FrameIndex(2), FrameIndex(6)]);
    }

    #[test]
    fn a_hand_along_one_side_touches_a_quarter_of_a_square() {
        let size = Size::new(40, 40);
        let square = Mask::from_fn(size, |x, y| (10..30).contains(&x) && (10..30).contains(&y));
        let hand = Mask::from_fn(size, |x, _| x >= 31);
        let share = touched_share(&RleMask::encode(&square), &RleMask::encode(&hand));
        assert!((0.2..0.4).contains(&share), "{share}");
        assert_eq!(touched_share(&RleMask::encode(&square), &RleMask::empty(size)), 0.0);
    }
}
