//! An object followed by a network with a memory, run by the real ONNX Runtime on graphs whose answer is known.
#![allow(clippy::unwrap_used, reason = "a failing unwrap fails the test")]

#[path = "support/graph_writer.rs"]
mod graph_writer;
#[path = "support/onnx_runtime.rs"]
mod onnx_runtime;
#[path = "support/tiny_models.rs"]
mod tiny_models;

use agenticfocus::{
    clip::{FrameIndex, FramesInMemory},
    geometry::{Pixel, PixelBox, Size},
    image::{Mask, Rgb8},
    onnx::{CheckedModel, Contract, ModelFolder, OnnxError, Registry, Runtime, Trust},
    progress::Unwatched,
    segment::{
        MaskAuthor, MaskFlag, MaskTrack, RleMask, SegmentError,
        object::{ObjectPrompt, PromptKind},
        sam2::{ImageSegmenter, SAM2_IMAGE, SAM2_VIDEO, VideoSegmenter, segment_frame, track_object},
    },
};
use onnx_runtime::runtime;
use tiny_models::{red_picture, red_things, write_model};

const SIZE: Size = Size { width: 64, height: 64 };
const COUNT: usize = 24;

/// The model of those graphs, loaded by `open`.
fn loaded<T>(
    contract: &Contract,
    graphs: &[(&str, Vec<u8>)],
    open: impl FnOnce(&Runtime, &CheckedModel) -> Result<T, OnnxError>,
) -> Option<T> {
    let runtime = runtime()?;
    let root = tempfile::tempdir().unwrap();
    let description = format!("contract = \"{}\"\nname = \"Red\"\nlicence = \"MIT\"\n", contract.id);
    write_model(root.path(), "red", &description, graphs);
    let found = ModelFolder::find(&[root.path().to_owned()]).remove(0).unwrap();
    let registry = Registry::default();
    let checked = found.checked(contract.graphs, Trust { registry: &registry, unlisted: true }).unwrap();
    Some(open(&runtime, &checked).unwrap())
}

fn network() -> Option<VideoSegmenter> {
    loaded(&SAM2_VIDEO, &red_things(), VideoSegmenter::open)
}

/// A red square that moves four pixels every other frame; hidden for a while; another one far away that stays.
fn square(frame: usize) -> Option<PixelBox> {
    let left = (4 * (frame / 2)) as f64;
    let hidden = (10..14).contains(&frame);
    (!hidden).then_some(PixelBox { x0: left, y0: 8.0, x1: left + 16.0, y1: 24.0 })
}

fn mask(frame: usize) -> Mask {
    let Some(b) = square(frame) else { return Mask::new(SIZE) };
    Mask::from_fn(SIZE, |x, y| (b.x0..b.x1).contains(&f64::from(x)) && (b.y0..b.y1).contains(&f64::from(y)))
}

fn clip(other: bool) -> FramesInMemory {
    let frame = |at: usize| {
        let mask = mask(at);
        let mut picture = Rgb8::new(SIZE);
        for y in 0..64 {
            for x in 0..64 {
                let red = mask.get(x, y) || (other && (0..16).contains(&x) && (48..64).contains(&y));
                picture.set_pixel(x, y, if red { [255, 0, 0] } else { [128, 128, 128] });
            }
        }
        picture
    };
    FramesInMemory::new((0..COUNT).map(frame).collect()).unwrap()
}

fn track(clip: &FramesInMemory, prompts: &[ObjectPrompt]) -> Option<Result<MaskTrack, SegmentError>> {
    let mut network = network()?;
    let mut by_hand = |prompt: &ObjectPrompt| Ok(RleMask::encode(&mask(prompt.frame.as_usize())));
    Some(track_object(clip, prompts, &mut network, &mut by_hand, None, &Unwatched))
}

/// The square to the pixel, but for its four corners, which enlarging logits rounds.
fn is_square(found: &RleMask, at: usize) -> bool {
    let (found, truth) = (found.decode(), mask(at));
    found.bounding_box() == truth.bounding_box() && truth.minus(&found).area() <= 4
}

fn assert_exact(track: &MaskTrack) {
    for (at, frame) in track.frames.iter().enumerate() {
        assert!(is_square(&frame.mask, at), "frame {at}: {:?}", frame.mask.decode().bounding_box());
        assert_eq!(frame.flags.contains(&MaskFlag::Lost), square(at).is_none(), "frame {at}");
    }
}

#[test]
fn a_moving_square_is_followed_exactly_onwards_back_and_through_being_hidden() {
    for at in [0, 7, 23] {
        let clip = clip(false);
        let prompt = ObjectPrompt::new(FrameIndex(at as u32), PromptKind::Box(square(at).unwrap()));
        let Some(found) = track(&clip, &[prompt]) else { return };
        let found = found.unwrap();
        assert_exact(&found);
        assert_eq!((found.backend.as_str(), found.frames[at].author), ("Red", MaskAuthor::Seeded));
    }
}

#[test]
fn memories_tell_the_object_from_another_that_looks_the_same() {
    // A memory laid out in another order would be found at other places.
    let human = PromptKind::Mask { mask: RleMask::encode(&mask(4)), human: true };
    let Some(found) = track(&clip(true), &[ObjectPrompt::new(FrameIndex(4), human)]) else { return };
    let found = found.unwrap();
    assert_exact(&found);
    assert_eq!(found.frames[4].author, MaskAuthor::Human);
}

#[test]
fn a_persons_masks_come_back_as_given_even_where_the_network_sees_something_else() {
    let drawn = Mask::from_fn(SIZE, |x, y| (20..31).contains(&x) && (10..21).contains(&y));
    let prompts = [
        ObjectPrompt::new(FrameIndex(2), PromptKind::Mask { mask: RleMask::encode(&drawn), human: true }),
        ObjectPrompt::new(
            FrameIndex(9),
            PromptKind::Mask { mask: RleMask::encode(&Mask::new(SIZE)), human: true },
        ),
    ];
    let Some(found) = track(&clip(false), &prompts) else { return };
    let found = found.unwrap();
    assert!(found.frames[2].mask.decode() == drawn);
    assert!(found.frames[9].mask.is_empty() && found.frames[9].author == MaskAuthor::Human);
}

#[test]
fn what_a_prompt_is_not_spread_to_stays_empty() {
    let kind = PromptKind::Box(square(6).unwrap());
    let prompt = ObjectPrompt { frame: FrameIndex(6), kind, reach: (false, true) };
    let Some(found) = track(&clip(false), &[prompt]) else { return };
    let found = found.unwrap();
    assert!(found.frames[..6].iter().all(|frame| frame.mask.is_empty()));
    assert!(found.frames[6..].iter().enumerate().all(|(at, frame)| is_square(&frame.mask, at + 6)));
}

#[test]
fn clicks_that_two_points_cannot_say_become_a_mask_first() {
    let pixels = |xs: &[f64]| xs.iter().map(|x| Pixel::new(*x, 12.0)).collect::<Vec<_>>();
    for (positive, negative, asked) in [(vec![4.0], vec![], false), (vec![4.0, 9.0, 12.0], vec![40.0], true)]
    {
        let Some(mut network) = network() else { return };
        let kind = PromptKind::Points { positive: pixels(&positive), negative: pixels(&negative) };
        let mut was_asked = false;
        let mut by_hand = |prompt: &ObjectPrompt| {
            was_asked = true;
            Ok(RleMask::encode(&mask(prompt.frame.as_usize())))
        };
        let prompt = ObjectPrompt::new(FrameIndex(0), kind);
        let found = track_object(&clip(false), &[prompt], &mut network, &mut by_hand, None, &Unwatched);
        assert_exact(&found.unwrap());
        assert_eq!(was_asked, asked);
    }
}

#[test]
fn a_prompt_beyond_the_clip_and_none_at_all_are_refused() {
    let kind = PromptKind::Box(square(0).unwrap());
    let Some(beyond) = track(&clip(false), &[ObjectPrompt::new(FrameIndex(99), kind)]) else { return };
    assert!(matches!(beyond, Err(SegmentError::Prompt { .. })));
    assert!(matches!(track(&clip(false), &[]).unwrap(), Err(SegmentError::NoPrompt)));
    let failed: SegmentError = OnnxError::Run { graph: "mask_decoder", reason: "no".to_owned() }.into();
    assert!(failed.to_string().contains("mask_decoder"));
}

#[test]
fn a_click_or_a_box_gives_a_mask_at_once_with_the_graphs_of_either_exporter() {
    for hugging_face in [false, true] {
        let graphs = red_picture(hugging_face);
        let Some(mut network) = loaded(&SAM2_IMAGE, &graphs, ImageSegmenter::open) else { return };
        let clip = clip(false);
        let many = PromptKind::Points {
            positive: vec![Pixel::new(4.0, 12.0), Pixel::new(9.0, 12.0), Pixel::new(9.0, 20.0)],
            negative: vec![Pixel::new(40.0, 40.0)],
        };
        for kind in [PromptKind::Box(square(2).unwrap()), many] {
            let prompt = ObjectPrompt::new(FrameIndex(2), kind);
            let mask = segment_frame(&clip, &prompt, &mut network).unwrap();
            assert!(is_square(&mask, 2), "{:?}", mask.decode().bounding_box());
        }
        let nothing = PromptKind::Points { positive: Vec::new(), negative: Vec::new() };
        let refused = segment_frame(&clip, &ObjectPrompt::new(FrameIndex(2), nothing), &mut network);
        assert!(matches!(refused, Err(SegmentError::Prompt { .. })));
    }
}
