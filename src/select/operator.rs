//! The operator's or the manifest's word: it trumps every guess.

use super::{ObjectSelector, Proposal, SelectError, SelectInput};
use crate::{clip::FrameIndex, geometry::PixelBox, progress::Watch};

/// A box that a person gave.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorSelector {
    /// The frame the box is on.
    pub frame: FrameIndex,
    /// The object's box, pixels of the clip.
    pub bounds: PixelBox,
    /// The object's name.
    pub label: String,
}

impl ObjectSelector for OperatorSelector {
    fn select(&self, input: SelectInput<'_>, _watch: &dyn Watch) -> Result<Vec<Proposal>, SelectError> {
        let (frames, size) = (input.frames.frame_count(), input.frames.size());
        let refused = SelectError::Prompt { frame: self.frame, bounds: self.bounds, frames, size };
        if self.frame.as_usize() >= frames {
            return Err(refused);
        }
        let bounds = self.bounds.clipped(size).ok_or(refused)?;
        Ok(vec![Proposal {
            frame: self.frame,
            bounds,
            point: None,
            label: self.label.clone(),
            confidence: 1.0,
            reason: "given by the operator".to_owned(),
            backend: "operator".to_owned(),
        }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        clip::FramesInMemory, geometry::Size, image::Rgb8, landmarks::LandmarkTrack, progress::Unwatched,
        segment::MaskTrack,
    };

    fn select(bounds: PixelBox) -> Result<Vec<Proposal>, SelectError> {
        let size = Size::new(20, 10);
        let frames = FramesInMemory::new(vec![Rgb8::new(size)]).unwrap();
        let arms = MaskTrack { size, frames: Vec::new(), backend: String::new() };
        let input = SelectInput { frames: &frames, landmarks: &LandmarkTrack::new(), arms: &arms };
        let selector = OperatorSelector { frame: FrameIndex(0), bounds, label: "cup".to_owned() };
        selector.select(input, &Unwatched)
    }

    #[test]
    fn a_box_is_clipped_to_the_picture_and_trusted() {
        let best = select(PixelBox { x0: 5.0, y0: 5.0, x1: 50.0, y1: 50.0 }).unwrap().remove(0);
        assert_eq!(best.bounds, PixelBox { x0: 5.0, y0: 5.0, x1: 20.0, y1: 10.0 });
        assert_eq!(best.confidence, 1.0);
    }

    #[test]
    fn a_box_outside_the_picture_is_refused() {
        let refused = select(PixelBox { x0: 25.0, y0: 5.0, x1: 50.0, y1: 50.0 });
        assert!(matches!(refused, Err(SelectError::Prompt { .. })));
    }
}
