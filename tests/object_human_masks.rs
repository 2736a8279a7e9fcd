//! Propagation never touches what a person drew, and a propagation that was stopped leaves nothing half-made.
#![cfg(feature = "engine")]
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

use std::{
    collections::BTreeMap,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use agenticfocus::{
    clip::{FrameIndex, FrameSource as _, FramesInMemory},
    geometry::Size,
    image::{Mask, Rgb8},
    landmarks::LandmarkTrack,
    progress::{Unwatched, Watch},
    segment::{
        MaskAuthor, MaskFrame, MaskTrack, RleMask, SegmentError,
        object::{MaskSink, ObjectParams, ObjectPrompt, PromptKind, track_object},
    },
};
use proptest::prelude::*;

const SIZE: Size = Size::new(96, 72);
const FRAMES: u32 = 7;
const SIDE: u32 = 22;

fn left(frame: u32) -> u32 {
    14 + 4 * frame
}

fn square(frame: u32, grown: u32) -> Mask {
    let columns = left(frame) - grown..left(frame) + SIDE + grown;
    Mask::from_fn(SIZE, |x, y| columns.contains(&x) && (24 - grown..24 + SIDE + grown).contains(&y))
}

fn speckle(x: u32, y: u32, seed: u32) -> i32 {
    let hash = (x / 3).wrapping_mul(73_856_093) ^ (y / 3).wrapping_mul(19_349_663) ^ seed;
    (hash.wrapping_mul(2_654_435_761) >> 24) as i32 % 40 - 20
}

fn picture(frame: u32) -> Rgb8 {
    let (mut picture, object) = (Rgb8::new(SIZE), square(frame, 0));
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let (base, grain) = if object.get(x, y) {
                ([60, 90, 190], speckle(x - left(frame), y, 7))
            } else {
                ([120, 130, 110], speckle(x, y, 3))
            };
            picture.set_pixel(x, y, base.map(|value: i32| (value + grain).clamp(0, 255) as u8));
        }
    }
    picture
}

/// What a person says on one frame: nothing of it here, or the object roughly or exactly.
fn drawn(frame: u32, said: u32) -> RleMask {
    match said {
        0 => RleMask::empty(SIZE),
        grown => RleMask::encode(&square(frame, grown - 1)),
    }
}

/// Frames with what was said there; on at least one the object is to be seen.
fn said() -> impl Strategy<Value = BTreeMap<u32, u32>> {
    (prop::collection::btree_map(0..FRAMES, 0_u32..4, 0..4), 0..FRAMES, 1_u32..4).prop_map(
        |(mut said, frame, seen)| {
            said.insert(frame, seen);
            said
        },
    )
}

fn prompts(said: &BTreeMap<u32, u32>) -> Vec<ObjectPrompt> {
    let prompt = |(frame, said): (&u32, &u32)| {
        let kind = PromptKind::Mask { mask: drawn(*frame, *said), human: true };
        ObjectPrompt::new(FrameIndex(*frame), kind)
    };
    said.iter().map(prompt).collect()
}

/// Every frame that was told, with its mask, in any order.
type Told = Vec<(FrameIndex, MaskFrame)>;

fn track(said: &BTreeMap<u32, u32>, watch: &dyn Watch) -> (Result<MaskTrack, SegmentError>, Told) {
    let frames = FramesInMemory::new((0..FRAMES).map(picture).collect()).unwrap();
    let no_arm = MaskFrame {
        mask: RleMask::empty(SIZE),
        author: MaskAuthor::Propagated,
        score: 0.0,
        flags: Vec::new(),
    };
    let arms =
        MaskTrack { size: SIZE, frames: vec![no_arm; frames.frame_count()], backend: "test".to_owned() };
    let told = Mutex::new(Told::new());
    let tell = |index: FrameIndex, frame: &MaskFrame| told.lock().unwrap().push((index, frame.clone()));
    let sink: &MaskSink<'_> = &tell;
    let (params, landmarks) = (ObjectParams::default(), LandmarkTrack::new());
    let track = track_object(&frames, &prompts(said), &arms, &landmarks, &params, Some(sink), watch);
    (track, told.into_inner().unwrap())
}

/// Cancels when it was asked `after` times.
struct Impatient {
    asked: AtomicUsize,
    after: usize,
}

impl Impatient {
    fn new(after: usize) -> Self {
        Self { asked: AtomicUsize::new(0), after }
    }
}

impl Watch for Impatient {
    fn advance(&self, _done: usize, _total: usize) {}

    fn is_cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.after
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn what_a_person_drew_comes_back_as_given_and_is_never_told_anew(said in said()) {
        let (track, told) = track(&said, &Unwatched);
        let track = track.unwrap();
        for (frame, what) in &said {
            let kept = track.frame(FrameIndex(*frame));
            prop_assert_eq!(&kept.mask, &drawn(*frame, *what), "frame {}", frame);
            prop_assert_eq!(kept.author, MaskAuthor::Human);
        }
        for frame in 0..FRAMES {
            let heard = told.iter().any(|(index, _)| index.0 == frame);
            prop_assert_eq!(heard, !said.contains_key(&frame), "frame {}", frame);
        }
        for (index, frame) in &told {
            prop_assert_eq!(frame.author, MaskAuthor::Propagated, "frame {}", index);
        }
    }

    #[test]
    fn a_stopped_propagation_gives_no_track_and_told_only_whole_frames(said in said(), share in 0.0..1.0_f64) {
        let patient = Impatient::new(usize::MAX);
        let (_, whole) = track(&said, &patient);
        let checks = patient.asked.into_inner();
        prop_assert!(checks > 0);
        let (track, told) = track(&said, &Impatient::new((share * checks as f64) as usize));
        prop_assert!(matches!(track, Err(SegmentError::Cancelled(_))), "{:?}", track.map(|track| track.backend));
        for frame in &told {
            prop_assert!(whole.contains(frame), "frame {} was told half", frame.0);
        }
    }
}
