//! A textured square slides over a speckled table, passes behind a bar, and is followed from one box.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use agenticfocus::{
    clip::{FrameIndex, FrameSource, FramesInMemory},
    geometry::{PixelBox, Size},
    image::{Mask, Rgb8},
    landmarks::LandmarkTrack,
    progress::Unwatched,
    segment::{
        MaskAuthor, MaskFrame, MaskTrack, RleMask,
        object::{ObjectParams, ObjectPrompt, PromptKind, track_object},
    },
    template::{self, TemplateParams},
};

const SIZE: Size = Size::new(240, 180);
const SIDE: u32 = 44;

fn left(frame: u32) -> u32 {
    40 + 3 * frame
}

fn speckle(x: u32, y: u32, seed: u32) -> i32 {
    let hash = (x / 3).wrapping_mul(73_856_093) ^ (y / 3).wrapping_mul(19_349_663) ^ seed;
    (hash.wrapping_mul(2_654_435_761) >> 24) as i32 % 40 - 20
}

fn in_bar(x: u32) -> bool {
    (112..130).contains(&x)
}

fn full(frame: u32) -> Mask {
    let x0 = left(frame);
    Mask::from_fn(SIZE, |x, y| (x0..x0 + SIDE).contains(&x) && (60..60 + SIDE).contains(&y))
}

fn bar() -> Mask {
    Mask::from_fn(SIZE, |x, _| in_bar(x))
}

fn picture(frame: u32) -> Rgb8 {
    let mut picture = Rgb8::new(SIZE);
    let (object, x0) = (full(frame), left(frame));
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let (base, grain) = if in_bar(x) {
                ([205, 150, 125], 0)
            } else if object.get(x, y) {
                ([60, 90, 190], speckle(x - x0, y, 7))
            } else {
                ([120, 130, 110], speckle(x, y, 3))
            };
            picture.set_pixel(x, y, base.map(|value: i32| (value + grain).clamp(0, 255) as u8));
        }
    }
    picture
}

fn clip(count: u32) -> (FramesInMemory, MaskTrack) {
    let frames = FramesInMemory::new((0..count).map(picture).collect()).unwrap();
    let arm = MaskFrame {
        mask: RleMask::encode(&bar()),
        author: MaskAuthor::Seeded,
        score: 1.0,
        flags: Vec::new(),
    };
    let arms = MaskTrack { size: SIZE, frames: vec![arm; count as usize], backend: "test".to_owned() };
    (frames, arms)
}

#[test]
fn one_box_follows_the_object_behind_an_arm_and_the_template_stays_whole() {
    let (frames, arms) = clip(26);
    let bounds = PixelBox { x0: 40.0, y0: 60.0, x1: 84.0, y1: 104.0 };
    let prompt = ObjectPrompt::new(FrameIndex(0), PromptKind::Box(bounds));
    let landmarks = LandmarkTrack::new();
    let track =
        track_object(&frames, &[prompt], &arms, &landmarks, &ObjectParams::default(), None, &Unwatched)
            .unwrap();
    for index in FrameIndex::all(frames.frame_count()) {
        let truth = full(index.0).minus(&bar());
        let j = track.frame(index).mask.decode().iou(&truth);
        assert!(j > 0.85, "{index}: J = {j}");
    }
    let params = TemplateParams::default();
    let template =
        template::build(&frames, &track, &arms, None, &landmarks, &params, &Unwatched).unwrap().unwrap();
    for (at, placement) in template.placements.iter().enumerate() {
        let placement = placement.as_ref().unwrap();
        let (column, row) = (f64::from(template.origin.0), f64::from(template.origin.1));
        let middle =
            nalgebra::Vector3::new(f64::from(left(template.frame.0)) + 21.5 - column, 81.5 - row, 1.0);
        let there = placement.transform * middle;
        let truth = (f64::from(left(at as u32)) + 21.5, 81.5);
        let error = (there.x / there.z - truth.0).hypot(there.y / there.z - truth.1);
        assert!(error < 2.0, "frame {at}: centre off by {error} px");
    }
}

#[test]
fn a_human_mask_comes_back_untouched() {
    let (frames, arms) = clip(6);
    let drawn = RleMask::encode(&full(3));
    let prompt = ObjectPrompt::new(FrameIndex(3), PromptKind::Mask { mask: drawn.clone(), human: true });
    let landmarks = LandmarkTrack::new();
    let track =
        track_object(&frames, &[prompt], &arms, &landmarks, &ObjectParams::default(), None, &Unwatched)
            .unwrap();
    assert_eq!(track.frames[3].mask, drawn);
    assert_eq!(track.frames[3].author, MaskAuthor::Human);
    assert!(track.frames[0].mask.decode().iou(&full(0).minus(&bar())) > 0.85);
}

#[test]
fn a_mask_that_is_spread_forward_alone_leaves_earlier_frames_alone() {
    let (frames, arms) = clip(6);
    let drawn = RleMask::encode(&full(3));
    let kind = PromptKind::Mask { mask: drawn, human: true };
    let prompt = ObjectPrompt { reach: (false, true), ..ObjectPrompt::new(FrameIndex(3), kind) };
    let landmarks = LandmarkTrack::new();
    let track =
        track_object(&frames, &[prompt], &arms, &landmarks, &ObjectParams::default(), None, &Unwatched)
            .unwrap();
    assert!(track.frames[..3].iter().all(|frame| frame.mask.is_empty()));
    assert!(track.frames[5].mask.decode().iou(&full(5).minus(&bar())) > 0.8);
}
