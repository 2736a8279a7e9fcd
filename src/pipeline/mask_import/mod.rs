//! A user's own masks as a person's edits of a session.

mod coco;
mod davis;

use std::{collections::BTreeMap, path::Path};

use super::{ClipFailure, ExitCode, run::clip_request};
use crate::{
    clip::{self, ClipInfo, FrameIndex},
    progress::Watch,
    segment::RleMask,
    session::{Author, Command, MaskEdit, MaskLayer, Session},
};

/// What the numbers of the masks count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameNumbering {
    /// Frames of the 30 FPS timeline, as our own exports do.
    Timeline,
    /// Frames of the source video; one that the timeline shows twice gives both their mask.
    Source,
}

/// Which label or category is which layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerLabels {
    /// The object.
    pub object: u32,
    /// Hands and arms.
    pub arms: u32,
    /// Pixels of both, where a picture can say only one thing (DAVIS); our own exports take 3.
    pub both: Option<u32>,
}

impl LayerLabels {
    fn layers(&self, label: u32) -> &'static [MaskLayer] {
        if label == self.object {
            &[MaskLayer::Object]
        } else if label == self.arms {
            &[MaskLayer::Arms]
        } else if Some(label) == self.both {
            &[MaskLayer::Object, MaskLayer::Arms]
        } else {
            &[]
        }
    }
}

/// What was imported.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskImportReport {
    /// Frames whose object mask a person says now.
    pub object: usize,
    /// Frames whose arm mask a person says now.
    pub arms: usize,
    /// Labels that were found and belong to no layer, with how often.
    pub others: BTreeMap<u32, u64>,
    /// Numbers of masks that lie outside the part of the clip in use.
    pub outside: Vec<u32>,
}

/// Masks by number and layer.
type Masks = BTreeMap<(u32, MaskLayer), RleMask>;

/// Makes the masks at `path` (a COCO file with run lengths, or a folder of DAVIS palette pictures) a person's edits
/// of `session`, one command each, so that every one can be undone.
///
/// # Errors
/// When the clip cannot be decoded, a file is damaged, a mask is not of the clip's size, none lies in the clip, or
/// the session cannot be written. Nothing is changed unless all masks are sound.
pub fn import_masks(
    session: &mut Session,
    path: &Path,
    numbering: FrameNumbering,
    labels: &LayerLabels,
    watch: &dyn Watch,
) -> Result<MaskImportReport, ClipFailure> {
    let mut report = MaskImportReport::default();
    let masks = if path.is_dir() {
        davis::read(path, labels, &mut report.others)?
    } else {
        coco::read(path, labels, &mut report.others)?
    };
    let scratch = tempfile::tempdir()?;
    let clip = clip::open(&clip_request(session.document()), scratch.path(), watch)?;
    let mut edits = Vec::new();
    for ((number, layer), mask) in &masks {
        if mask.size() != clip.info.size {
            return Err(ClipFailure::bad_input(format_args!(
                "{}: the mask of frame {number} is {}, the clip is {}",
                path.display(),
                mask.size(),
                clip.info.size
            )));
        }
        let frames = frames_of(&clip.info, *number, numbering);
        if frames.is_empty() && report.outside.last() != Some(number) {
            report.outside.push(*number);
        }
        edits.extend(frames.into_iter().map(|frame| (frame, *layer, mask)));
    }
    if edits.is_empty() {
        return Err(ClipFailure::bad_input(format_args!(
            "{}: no mask of the object (label {}) or of arms (label {}) on the clip's {} frames",
            path.display(),
            labels.object,
            labels.arms,
            clip.info.frame_count()
        )));
    }
    let store = session.masks();
    for (frame, layer, mask) in edits {
        watch.check().map_err(|error| ClipFailure::from_error(&error, ExitCode::Cancelled))?;
        let edit = if mask.is_empty() { MaskEdit::Absent } else { MaskEdit::Mask(store.put(mask)?) };
        session.apply(Author::Human, Command::SetMask { layer, frame, edit: Some(edit) })?;
        match layer {
            MaskLayer::Object => report.object += 1,
            MaskLayer::Arms => report.arms += 1,
        }
    }
    Ok(report)
}

fn frames_of(info: &ClipInfo, number: u32, numbering: FrameNumbering) -> Vec<FrameIndex> {
    let shows = |row: &&clip::FrameRow| match numbering {
        FrameNumbering::Timeline => row.index.0 == number,
        FrameNumbering::Source => row.source_frame == number,
    };
    info.frame_table.iter().filter(shows).map(|row| row.index).collect()
}

/// The number at the end of a file's name, without its ending.
fn number_in(name: &str) -> Option<u32> {
    let stem = Path::new(name).file_stem()?.to_str()?;
    let digits = stem.rfind(|c: char| !c.is_ascii_digit()).map_or(stem, |at| &stem[at + 1..]);
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_at_the_end_of_a_name_is_the_frames() {
        assert_eq!(number_in("put/000017.jpg"), Some(17));
        assert_eq!(number_in("frame_12.png"), Some(12));
        assert_eq!((number_in("mask.png"), number_in("99999999999.png")), (None, None));
    }
}
