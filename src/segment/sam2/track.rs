//! An object followed through a clip: from what somebody said of some frames, onwards and then back.

use std::collections::BTreeMap;

use super::{
    bank::{Bank, Heading},
    logits::{mask_of, sure, without_specks},
    network::{Decoded, Encoded, Memory, TwoPoints, VideoSegmenter},
};
use crate::{
    clip::{FrameIndex, FrameSource},
    geometry::{Pixel, Size},
    image::Mask,
    progress::Watch,
    segment::{
        MaskAuthor, MaskFlag, MaskFrame, MaskTrack, RleMask, SegmentError,
        object::{MaskSink, ObjectPrompt, PromptKind},
    },
    vision::single_threaded,
};

/// Makes a mask of a prompt that two points cannot say.
pub type MaskOfPrompt<'a> = dyn FnMut(&ObjectPrompt) -> Result<RleMask, SegmentError> + 'a;

/// The visible part of the object on every frame, by a network with a memory.
///
/// Prompts as [`crate::segment::object::track_object`] takes them: a person's masks come back as given. `mask_of_prompt`
/// makes a mask of what two points cannot say: three points and more. Every prompted frame is attended by all others.
///
/// Memory: six frames' memories beside the prompted ones, whatever the clip's length.
///
/// # Errors
/// Without a prompt, when one lies outside the clip, a frame cannot be read, the network fails, or when cancelled.
pub fn track_object(
    frames: &dyn FrameSource,
    prompts: &[ObjectPrompt],
    network: &mut VideoSegmenter,
    mask_of_prompt: &mut MaskOfPrompt<'_>,
    sink: Option<&MaskSink<'_>>,
    watch: &dyn Watch,
) -> Result<MaskTrack, SegmentError> {
    single_threaded();
    let (count, size) = (frames.frame_count(), frames.size());
    let prompts: BTreeMap<usize, &ObjectPrompt> = prompts.iter().map(|p| (p.frame.as_usize(), p)).collect();
    let (Some(first), Some(last)) = (prompts.keys().next().copied(), prompts.keys().last().copied()) else {
        return Err(SegmentError::NoPrompt);
    };
    if last >= count {
        let reason = format!("the clip has {count} frames");
        return Err(SegmentError::Prompt { frame: FrameIndex(last as u32), reason });
    }
    let mut follower = Follower { frames, network, bank: Bank::new(first), size };
    let mut found: Vec<Option<MaskFrame>> = vec![None; count];
    for (at, prompt) in &prompts {
        watch.check()?;
        found[*at] = Some(follower.condition(prompt, mask_of_prompt)?);
    }
    let onwards = (first..count).map(|at| (at, Heading::Forward));
    let back = (0..first).rev().map(|at| (at, Heading::Backward));
    for (done, (at, heading)) in onwards.chain(back).enumerate() {
        watch.check()?;
        if found[at].is_none() {
            let frame = if is_reached(&prompts, at) { follower.follow(at, heading)? } else { nothing(size) };
            if let Some(sink) = sink {
                sink(FrameIndex(at as u32), &frame);
            }
            found[at] = Some(frame);
        }
        watch.advance(done + 1, count);
    }
    let frames = found.into_iter().map(|frame| frame.unwrap_or_else(|| nothing(size))).collect();
    Ok(MaskTrack { size, frames, backend: follower.network.name().to_owned() })
}

/// Whether the prompt before or the one behind a frame is to be spread to it.
fn is_reached(prompts: &BTreeMap<usize, &ObjectPrompt>, at: usize) -> bool {
    let before = prompts.range(..at).next_back();
    let behind = prompts.range(at + 1..).next();
    before.is_some_and(|(_, prompt)| prompt.reach.1) || behind.is_some_and(|(_, prompt)| prompt.reach.0)
}

fn nothing(size: Size) -> MaskFrame {
    let flags = vec![MaskFlag::Lost];
    MaskFrame { mask: RleMask::empty(size), author: MaskAuthor::Propagated, score: 0.0, flags }
}

struct Follower<'a> {
    frames: &'a dyn FrameSource,
    network: &'a mut VideoSegmenter,
    bank: Bank<Memory>,
    size: Size,
}

impl Follower<'_> {
    fn encode(&mut self, at: usize) -> Result<Encoded, SegmentError> {
        let picture = self.frames.frame(FrameIndex(at as u32))?.to_mat()?;
        self.network.encode(&picture)
    }

    /// Takes in what somebody said of a frame.
    fn condition(
        &mut self,
        prompt: &ObjectPrompt,
        mask_of_prompt: &mut MaskOfPrompt<'_>,
    ) -> Result<MaskFrame, SegmentError> {
        let at = prompt.frame.as_usize();
        if let Some(points) = self.two_points(&prompt.kind) {
            let seen = self.encode(at)?;
            let decoded = self.network.decode_prompt(&seen, points)?;
            let memory = self.network.remember(&seen, &decoded, &decoded.logits, true)?;
            self.bank.condition(at, memory);
            return self.finish(&decoded, MaskAuthor::Seeded);
        }
        let (mask, author) = match &prompt.kind {
            PromptKind::Mask { mask, human: true } => (mask.clone(), MaskAuthor::Human),
            PromptKind::Mask { mask, human: false } => (mask.clone(), MaskAuthor::Seeded),
            _ => (mask_of_prompt(prompt)?, MaskAuthor::Seeded),
        };
        self.condition_by_mask(at, &mask)?;
        Ok(MaskFrame { flags: flags_of(&mask.decode()), mask, author, score: 1.0 })
    }

    /// A mask says more than points: the decoder only gives the object's pointer, from its box.
    fn condition_by_mask(&mut self, at: usize, mask: &RleMask) -> Result<(), SegmentError> {
        let drawn = mask.decode();
        // Where the object is said to be absent there is nothing to remember it by.
        let Some(bounds) = drawn.bounding_box() else { return Ok(()) };
        let seen = self.encode(at)?;
        let corners = [Pixel::new(bounds.x0, bounds.y0), Pixel::new(bounds.x1, bounds.y1)];
        let decoded = self.network.decode_prompt(&seen, self.points(corners, [2, 3]))?;
        let decoded = Decoded { presence: 10.0, ..decoded };
        let logits = sure(&drawn, self.network.side())?;
        let memory = self.network.remember(&seen, &decoded, &logits, false)?;
        self.bank.condition(at, memory);
        Ok(())
    }

    /// Finds the object on a frame by what is remembered of others.
    fn follow(&mut self, at: usize, heading: Heading) -> Result<MaskFrame, SegmentError> {
        let seen = self.encode(at)?;
        let masks = self.bank.masks(at, heading);
        let masks: Vec<(&Memory, usize)> =
            masks.iter().map(|(_, memory, row)| (memory.as_ref(), *row)).collect();
        let pointers = self.bank.pointers(at, heading);
        let pointers: Vec<(&Memory, usize)> =
            pointers.iter().map(|(memory, steps)| (memory.as_ref(), *steps)).collect();
        if masks.is_empty() {
            return Ok(nothing(self.size));
        }
        let decoded = self.network.decode_remembered(&seen, &masks, &pointers)?;
        let memory = self.network.remember(&seen, &decoded, &decoded.logits, false)?;
        self.bank.remember(at, memory);
        self.finish(&decoded, MaskAuthor::Propagated)
    }

    fn finish(&self, decoded: &Decoded, author: MaskAuthor) -> Result<MaskFrame, SegmentError> {
        if decoded.presence <= 0.0 {
            return Ok(nothing(self.size));
        }
        let mask = mask_of(&without_specks(&decoded.logits)?, self.size)?;
        let flags = flags_of(&mask);
        let empty = flags.contains(&MaskFlag::Lost);
        let score = if empty { 0.0 } else { f64::from(decoded.fit).clamp(0.0, 1.0) };
        Ok(MaskFrame { mask: RleMask::encode(&mask), author, score, flags })
    }

    /// What two points can say: a box, one click, two clicks.
    fn two_points(&self, kind: &PromptKind) -> Option<TwoPoints> {
        match kind {
            PromptKind::Box(bounds) => {
                let corners = [Pixel::new(bounds.x0, bounds.y0), Pixel::new(bounds.x1, bounds.y1)];
                Some(self.points(corners, [2, 3]))
            }
            PromptKind::Points { positive, negative } => match (positive.as_slice(), negative.as_slice()) {
                ([one], []) => {
                    let mut points = self.points([*one; 2], [1, -1]);
                    points.points[1] = [0.0; 2];
                    Some(points)
                }
                ([one, other], []) => Some(self.points([*one, *other], [1, 1])),
                ([on], [beside]) => Some(self.points([*on, *beside], [1, 0])),
                _ => None,
            },
            PromptKind::Mask { .. } => None,
        }
    }

    fn points(&self, pixels: [Pixel; 2], labels: [i64; 2]) -> TwoPoints {
        let side = self.network.side() as f64;
        let (x, y) = (side / f64::from(self.size.width), side / f64::from(self.size.height));
        TwoPoints { points: pixels.map(|pixel| [(pixel.x * x) as f32, (pixel.y * y) as f32]), labels }
    }
}

fn flags_of(mask: &Mask) -> Vec<MaskFlag> {
    let (right, low) = (f64::from(mask.size().width) - 1.0, f64::from(mask.size().height) - 1.0);
    match mask.bounding_box() {
        None => vec![MaskFlag::Lost],
        Some(b) if b.x0 < 1.0 || b.y0 < 1.0 || b.x1 > right || b.y1 > low => vec![MaskFlag::TouchesBorder],
        Some(_) => Vec::new(),
    }
}
