//! Placements that a person set, and those between two of them.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::{Placement, TemplateTrack};
use crate::{clip::FrameIndex, session::TemplateEdits};

/// Where a person put the template on a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedByHand {
    /// Takes template pixels to frame pixels.
    pub transform: Matrix3<f64>,
    /// The keyframes that it lies between; `None` on a keyframe itself.
    pub between: Option<(FrameIndex, FrameIndex)>,
}

impl TemplateTrack {
    /// What a person said about `frame`; `None` where it is the machine's.
    pub fn by_hand(&self, edits: &TemplateEdits, frame: FrameIndex) -> Option<PlacedByHand> {
        if let Some(transform) = edits.placements.get(&frame) {
            return Some(PlacedByHand { transform: *transform, between: None });
        }
        let [(first, from), (last, to)] = edits.keyframes_around(frame)?;
        if !edits.interpolated.contains(&first) {
            return None;
        }
        let share = f64::from(frame.0 - first.0) / f64::from(last.0 - first.0);
        let transform = between(from, to, share, self.middle());
        Some(PlacedByHand { transform, between: Some((first, last)) })
    }

    /// The track with everything that a person said about placements.
    #[must_use]
    pub fn with_edits(mut self, edits: &TemplateEdits) -> Self {
        for frame in FrameIndex::all(self.placements.len()) {
            if let Some(PlacedByHand { transform, .. }) = self.by_hand(edits, frame) {
                let slot = &mut self.placements[frame.as_usize()];
                let visible = slot.as_ref().map_or(1.0, |placement| placement.visible);
                *slot = Some(Placement { transform, confidence: 1.0, visible });
            }
        }
        self
    }

    /// The middle of the template, pixels of it.
    fn middle(&self) -> Vector2<f64> {
        let size = self.picture.size();
        0.5 * Vector2::new(f64::from(size.width) - 1.0, f64::from(size.height) - 1.0)
    }
}

/// The placement at `share` (0 to 1) of the way from `from` to `to`: `middle` of the template moves on a straight line,
/// its size changes by equal factors, it turns the shorter way. What neither is (perspective) is mixed linearly.
fn between(from: &Matrix3<f64>, to: &Matrix3<f64>, share: f64, middle: Vector2<f64>) -> Matrix3<f64> {
    let (start, end) = (Similarity::of(from, middle), Similarity::of(to, middle));
    let turn = (end.angle - start.angle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
        - std::f64::consts::PI;
    let here = Similarity {
        scale: start.scale * (end.scale / start.scale).powf(share),
        angle: start.angle + share * turn,
        shift: start.shift + share * (end.shift - start.shift),
    };
    let rest = |similarity: &Similarity, whole: &Matrix3<f64>| similarity.inverse_matrix(middle) * whole;
    let (first, last) = (rest(&start, from), rest(&end, to));
    let (first, last) = (normalised(first, middle), normalised(last, middle));
    here.matrix(middle) * (first + share * (last - first))
}

/// A homography with a third coordinate of 1 at `middle`.
fn normalised(matrix: Matrix3<f64>, middle: Vector2<f64>) -> Matrix3<f64> {
    matrix / matrix.row(2).dot(&middle.push(1.0).transpose())
}

/// A scaling and turn about a point, and where that point goes.
#[derive(Clone, Copy, Debug)]
struct Similarity {
    scale: f64,
    angle: f64,
    /// Where the point goes, pixels of the frame.
    shift: Vector2<f64>,
}

impl Similarity {
    /// The similarity that `transform` is nearest to at `middle`.
    fn of(transform: &Matrix3<f64>, middle: Vector2<f64>) -> Self {
        let seen: Vector3<f64> = transform * middle.push(1.0);
        let shift = seen.xy() / seen.z;
        // The derivative of the homography there.
        let slope = |row: usize, column: usize| {
            (transform[(row, column)] - shift[row] * transform[(2, column)]) / seen.z
        };
        let (a, b, c, d) = (slope(0, 0), slope(0, 1), slope(1, 0), slope(1, 1));
        Self { scale: (a * d - b * c).abs().sqrt().max(1e-9), angle: (c - b).atan2(a + d), shift }
    }

    /// As a matrix that turns about `middle` and takes it to the shift.
    fn matrix(&self, middle: Vector2<f64>) -> Matrix3<f64> {
        let (sin, cos) = self.angle.sin_cos();
        let (s, c) = (self.scale * sin, self.scale * cos);
        let x = self.shift.x - c * middle.x + s * middle.y;
        let y = self.shift.y - s * middle.x - c * middle.y;
        Matrix3::new(c, -s, x, s, c, y, 0.0, 0.0, 1.0)
    }

    fn inverse_matrix(&self, middle: Vector2<f64>) -> Matrix3<f64> {
        let (sin, cos) = self.angle.sin_cos();
        let (s, c) = (sin / self.scale, cos / self.scale);
        let x = middle.x - c * self.shift.x - s * self.shift.y;
        let y = middle.y + s * self.shift.x - c * self.shift.y;
        Matrix3::new(c, s, x, -s, c, y, 0.0, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{geometry::Size, image::Rgba8};

    const MIDDLE: Vector2<f64> = Vector2::new(19.5, 9.5);

    fn track(count: usize) -> TemplateTrack {
        let seen = Placement { transform: Matrix3::identity(), confidence: 0.4, visible: 0.7 };
        TemplateTrack {
            picture: Rgba8::new(Size::new(40, 20)),
            origin: (0, 0),
            frame: FrameIndex(0),
            placements: vec![Some(seen); count],
            scores: vec![0.0; count],
        }
    }

    fn placed(scale: f64, angle: f64, x: f64, y: f64) -> Matrix3<f64> {
        Similarity { scale, angle, shift: Vector2::new(x, y) }.matrix(MIDDLE)
    }

    fn near(one: &Matrix3<f64>, other: &Matrix3<f64>) -> bool {
        (one / one[(2, 2)] - other / other[(2, 2)]).amax() < 1e-9
    }

    #[test]
    fn half_way_the_middle_is_half_way_the_size_is_the_geometric_mean_and_the_turn_the_shorter_one() {
        let (from, to) = (placed(0.5, 3.0, 10.0, 50.0), placed(2.0, -3.0, 30.0, 20.0));
        let half = between(&from, &to, 0.5, MIDDLE);
        assert!(near(&half, &placed(1.0, std::f64::consts::PI, 20.0, 35.0)), "{half}");
    }

    #[test]
    fn only_frames_between_keyframes_that_were_joined_change() {
        let mut edits = TemplateEdits::default();
        for (frame, x) in [(2, 0.0), (6, 40.0), (9, 0.0)] {
            edits.placements.insert(FrameIndex(frame), placed(1.0, 0.0, x, 0.0));
        }
        edits.interpolated.insert(FrameIndex(2));
        // The last keyframe has no next one to run to.
        edits.interpolated.insert(FrameIndex(9));
        let track = track(12).with_edits(&edits);
        let x = |frame: usize| {
            let placement = track.placements[frame].as_ref().unwrap();
            let seen = placement.transform * MIDDLE.push(1.0);
            (placement.confidence == 1.0).then_some(seen.x / seen.z)
        };
        let seen: Vec<Option<f64>> = (0..12).map(|frame| x(frame).map(|x| x.round())).collect();
        let no = None;
        let wanted =
            [no, no, Some(0.0), Some(10.0), Some(20.0), Some(30.0), Some(40.0), no, no, Some(0.0), no, no];
        assert_eq!(seen, wanted);
        assert_eq!(track.placements[4].as_ref().unwrap().visible, 0.7);
    }

    proptest! {
        #[test]
        fn the_ends_are_the_keyframes_whatever_their_perspective(
            (scale, angle, x, y) in (0.2..5.0_f64, -3.1..3.1_f64, -500.0..500.0_f64, -500.0..500.0_f64),
            (slant, tilt) in (-1e-3..1e-3_f64, -1e-3..1e-3_f64),
        ) {
            let perspective = Matrix3::new(1.1, 0.02, 3.0, -0.01, 0.95, 1.0, slant, tilt, 1.0);
            let (from, to) = (placed(1.0, 0.0, 5.0, 5.0), placed(scale, angle, x, y) * perspective);
            prop_assert!(near(&between(&from, &to, 0.0, MIDDLE), &from));
            let end = between(&from, &to, 1.0, MIDDLE);
            prop_assert!((end / end[(2, 2)] - to / to[(2, 2)]).amax() < 1e-7, "{end} {to}");
            let on_the_way = between(&from, &to, 0.3, MIDDLE);
            prop_assert!(on_the_way.iter().all(|value| value.is_finite()));
        }
    }
}
