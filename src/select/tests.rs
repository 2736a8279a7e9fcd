//! Little scenes: a hand of plain skin carries a square over textured ground.

use proptest::prelude::*;

use super::{Proposal, SelectParams, propose};
use crate::{
    clip::FramesInMemory,
    geometry::{PerSide, Pixel, PixelBox, Side, Size},
    image::{Mask, Rgb8},
    landmarks::{HandLandmarks, LandmarkTrack},
    progress::Unwatched,
    segment::{MaskAuthor, MaskFrame, MaskTrack, RleMask},
};

const SIZE: Size = Size::new(176, 132);
const FRAMES: usize = 36;
const SIDE: i32 = 18;

/// A scene: how far the camera pans a frame, and whether the square goes with the hand.
#[derive(Clone, Copy)]
struct Play {
    pan: f64,
    carries: bool,
    /// Top left corner of the square before and after.
    from: (i32, i32),
    to: (i32, i32),
}

const CARRY: Play = Play { pan: 0.0, carries: true, from: (40, 40), to: (100, 62) };

/// Smooth noise from a lattice of hashes, 0 to 1.
fn noise(x: f64, y: f64) -> f64 {
    let hash = |i: i64, j: i64| {
        let mut h = (i.wrapping_mul(0x9E37_79B9) ^ j.wrapping_mul(0x85EB_CA6B)) as u64;
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D_9E37_79B9);
        ((h >> 40) & 0xFFFF) as f64 / 65535.0
    };
    let (x, y) = (x / 5.0, y / 5.0);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (u, v) = (x - x.floor(), y - y.floor());
    let top = hash(i, j) * (1.0 - u) + hash(i + 1, j) * u;
    let low = hash(i, j + 1) * (1.0 - u) + hash(i + 1, j + 1) * u;
    top * (1.0 - v) + low * v
}

impl Play {
    /// How much of the way the hand has carried, 0 to 1.
    fn carried(frame: usize) -> f64 {
        ((frame as f64 - 12.0) / 11.0).clamp(0.0, 1.0)
    }

    fn pan_at(&self, frame: usize) -> f64 {
        self.pan * frame as f64
    }

    /// The square's corner on the picture.
    fn corner(&self, frame: usize) -> (i32, i32) {
        let way = if self.carries { Self::carried(frame) } else { 0.0 };
        let at = |a: i32, b: i32| f64::from(a) + way * f64::from(b - a);
        (
            (at(self.from.0, self.to.0) + self.pan_at(frame)).round() as i32,
            at(self.from.1, self.to.1).round() as i32,
        )
    }

    fn bounds(&self, frame: usize) -> PixelBox {
        let (x, y) = self.corner(frame);
        PixelBox { x0: x.into(), y0: y.into(), x1: (x + SIDE).into(), y1: (y + SIDE).into() }
    }

    /// The middle of the hand: it comes from below, stays by the square's lower edge, and leaves again.
    fn hand(&self, frame: usize) -> Pixel {
        let way = Self::carried(frame);
        let away = ((9.0 - frame as f64).max(frame as f64 - 26.0) / 9.0).clamp(0.0, 1.0);
        let at = |a: i32, b: i32| f64::from(a) + way * f64::from(b - a);
        let (x, y) = (at(self.from.0, self.to.0), at(self.from.1, self.to.1));
        Pixel::new(x + 9.0 + self.pan_at(frame), y + f64::from(SIDE) + 8.0 + 55.0 * away)
    }

    fn is_arm(&self, frame: usize, x: u32, y: u32) -> bool {
        let hand = self.hand(frame);
        let (dx, dy) = (f64::from(x) - hand.x, f64::from(y) - hand.y);
        dx.hypot(dy) < 10.0 || (dx.abs() < 6.0 && dy > 0.0)
    }

    fn picture(&self, frame: usize) -> Rgb8 {
        let mut picture = Rgb8::new(SIZE);
        let (left, top) = self.corner(frame);
        for (x, y) in (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y))) {
            let ground = 90.0 + 110.0 * noise(f64::from(x) - self.pan_at(frame), f64::from(y));
            let (dx, dy) = (x as i32 - left, y as i32 - top);
            let colour = if self.is_arm(frame, x, y) {
                [205.0, 150.0, 125.0]
            } else if (0..SIDE).contains(&dx) && (0..SIDE).contains(&dy) {
                let stripe = if (dx / 5) % 2 == 0 { 30.0 } else { 0.0 };
                [40.0 + stripe, 70.0, 170.0 + stripe]
            } else {
                [ground, 0.95 * ground, 0.7 * ground]
            };
            picture.set_pixel(x, y, colour.map(|c| c as u8));
        }
        picture
    }

    fn landmarks(&self, frame: usize) -> PerSide<Option<HandLandmarks>> {
        let hand = self.hand(frame);
        let mut keypoints = [Pixel::new(hand.x, hand.y + 10.0); 21];
        for finger in 0..5 {
            for joint in 0..4 {
                let (x, y) = (hand.x - 8.0 + 4.0 * finger as f64, hand.y + 1.0 - 3.0 * joint as f64);
                keypoints[1 + 4 * finger + joint] = Pixel::new(x, y);
            }
        }
        let seen = HandLandmarks { keypoints, world: None, confidence: 1.0 };
        PerSide::from_fn(|side| (side == Side::Right).then(|| seen.clone()))
    }

    fn proposals(&self) -> Vec<Proposal> {
        let frames = FramesInMemory::new((0..FRAMES).map(|frame| self.picture(frame)).collect()).unwrap();
        let landmarks: LandmarkTrack = (0..FRAMES).map(|frame| self.landmarks(frame)).collect();
        let arm = |frame: usize| MaskFrame {
            mask: RleMask::encode(&Mask::from_fn(SIZE, |x, y| self.is_arm(frame, x, y))),
            author: MaskAuthor::Propagated,
            score: 1.0,
            flags: Vec::new(),
        };
        let arms =
            MaskTrack { size: SIZE, frames: (0..FRAMES).map(arm).collect(), backend: "test".to_owned() };
        propose(&frames, &landmarks, &arms, &SelectParams::default(), &Unwatched).unwrap()
    }

    /// IoU of the best proposal with the square on its own frame.
    fn score(&self) -> f64 {
        let proposals = self.proposals();
        let best = proposals.first().expect("something is proposed");
        super::propose::overlap(&best.bounds, &self.bounds(best.frame.as_usize()))
    }
}

#[test]
fn a_carried_square_is_found_under_a_still_camera() {
    assert!(CARRY.score() > 0.8, "{:?}", CARRY.proposals());
}

#[test]
fn a_carried_square_is_found_under_a_moving_camera() {
    let play = Play { pan: 0.6, ..CARRY };
    assert!(play.score() > 0.8, "{:?}", play.proposals());
}

#[test]
fn a_square_that_is_moved_by_less_than_its_size_is_found() {
    let play = Play { to: (52, 46), ..CARRY };
    assert!(play.score() > 0.7, "{:?}", play.proposals());
}

#[test]
fn an_arm_that_moves_nothing_is_not_proposed_nor_anything_else() {
    for pan in [0.0, 0.6] {
        let found = Play { carries: false, pan, ..CARRY }.proposals();
        assert!(found.is_empty(), "{found:?}");
    }
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| CARRY.proposals())
    };
    assert_eq!(by(1), by(3));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3, ..ProptestConfig::default() })]
    #[test]
    fn every_proposal_lies_within_the_clip(
        from in (0_i32..150, 0_i32..100),
        to in (0_i32..150, 0_i32..100),
        pan in -1.0_f64..1.0,
    ) {
        for proposal in (Play { pan, carries: true, from, to }).proposals() {
            prop_assert!(proposal.frame.as_usize() < FRAMES);
            prop_assert!(proposal.bounds.clipped(SIZE) == Some(proposal.bounds));
            prop_assert!((0.0..=1.0).contains(&proposal.confidence));
        }
    }
}
