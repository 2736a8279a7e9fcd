//! Which frames the network sees together.

use std::ops::Range;

/// How a network takes its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowSize {
    /// Any number of frames: neighbours as far as the clip goes, every reference frame (E2FGVI's own `test.py`).
    Open,
    /// A graph frozen at so many local and reference frames.
    Fixed {
        /// Local frames, consecutive.
        local: usize,
        /// Reference frames.
        references: usize,
    },
}

/// Distances between windows and between reference frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowSteps {
    /// Frames from one window's centre to the next (E2FGVI: 5).
    pub stride: usize,
    /// Reference frames are the multiples of this (E2FGVI: 10).
    pub reference: usize,
}

/// Frames that are fed together: the local ones first, then the references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// The frame in its middle.
    pub centre: usize,
    /// The clip's frames it restores.
    pub local: Range<usize>,
    /// Frames fed in the local places; longer than `local` where a short clip's last frame is repeated.
    pub fed: Vec<usize>,
    /// Frames fed beside them.
    pub references: Vec<usize>,
}

/// The windows of a clip of `count` frames, in the order of their centres; together they cover every frame.
pub fn windows(count: usize, size: WindowSize, steps: WindowSteps) -> Vec<Window> {
    let stride = steps.stride.max(1);
    (0..count).step_by(stride).map(|centre| window(centre, count, size, steps)).collect()
}

fn window(centre: usize, count: usize, size: WindowSize, steps: WindowSteps) -> Window {
    let stride = steps.stride.max(1);
    let local = match size {
        WindowSize::Open => centre.saturating_sub(stride)..(centre + stride + 1).min(count),
        WindowSize::Fixed { local, .. } => {
            let start = centre.saturating_sub(local / 2).min(count.saturating_sub(local));
            start..(start + local).min(count)
        }
    };
    let outside: Vec<usize> =
        (0..count).step_by(steps.reference.max(1)).filter(|frame| !local.contains(frame)).collect();
    let mut fed: Vec<usize> = local.clone().collect();
    let references = match size {
        WindowSize::Open => outside,
        WindowSize::Fixed { local: wanted, references } => {
            fed.resize(wanted, count - 1);
            evenly(&outside, references, centre)
        }
    };
    Window { centre, local, fed, references }
}

/// `wanted` of `frames`, evenly spaced by their place in the list; the one nearest to `centre` repeated where there
/// are too few, `centre` itself where there are none.
fn evenly(frames: &[usize], wanted: usize, centre: usize) -> Vec<usize> {
    if frames.len() > wanted {
        let last = (frames.len() - 1) as f64;
        let step = if wanted > 1 { last / (wanted - 1) as f64 } else { 0.0 };
        return (0..wanted).map(|at| frames[(at as f64 * step).round() as usize]).collect();
    }
    let nearest = frames.iter().copied().min_by_key(|frame| frame.abs_diff(centre)).unwrap_or(centre);
    let mut chosen = frames.to_vec();
    chosen.resize(wanted, nearest);
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: WindowSteps = WindowSteps { stride: 5, reference: 10 };

    #[test]
    fn open_windows_are_those_of_the_published_procedure() {
        let found: Vec<_> = windows(23, WindowSize::Open, STEPS)
            .into_iter()
            .map(|window| (window.centre, window.local, window.references))
            .collect();
        let expected = [
            (0, 0..6, vec![10, 20]),
            (5, 0..11, vec![20]),
            (10, 5..16, vec![0, 20]),
            (15, 10..21, vec![0]),
            (20, 15..23, vec![0, 10]),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn fixed_windows_feed_the_graphs_own_number_of_frames_and_cover_the_clip() {
        let size = WindowSize::Fixed { local: 11, references: 6 };
        for count in [1, 3, 10, 11, 12, 23, 135] {
            let all = windows(count, size, STEPS);
            let mut covered = vec![false; count];
            for window in &all {
                assert_eq!((window.fed.len(), window.references.len()), (11, 6), "{count} frames");
                assert_eq!(window.fed[..window.local.len()], window.local.clone().collect::<Vec<_>>());
                assert!(window.fed.iter().chain(&window.references).all(|frame| *frame < count));
                covered[window.local.clone()].fill(true);
            }
            assert!(covered.iter().all(|covered| *covered), "{count} frames");
        }
    }

    #[test]
    fn references_are_spread_over_the_clip_and_repeat_the_nearest_where_they_are_few() {
        assert_eq!(evenly(&[0, 10, 20, 30, 40], 3, 5), [0, 20, 40]);
        assert_eq!(evenly(&[20, 30], 4, 5), [20, 30, 20, 20]);
        assert_eq!(evenly(&[], 2, 7), [7, 7]);
    }
}
