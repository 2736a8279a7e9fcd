//! Masks as DAVIS stores them: a palette picture a frame, the index says what a pixel shows.

use std::{fs, path::Path};

use super::{DatasetError, clip::FinishedClip, coco};
use crate::{clip::FrameIndex, export::write_indexed, geometry::Size};

/// Colours of nothing, the object, arms, and pixels that both claim.
pub(super) const PALETTE: [[u8; 3]; 4] = [[0, 0, 0], [128, 0, 0], [0, 128, 0], [128, 128, 0]];

/// Fills `folder` with `00000.png`, …: 0 nothing, 1 the object, 2 arms and hands, 3 where both masks are.
pub(super) fn write_clip(clip: &FinishedClip, folder: &Path) -> Result<Size, DatasetError> {
    fs::create_dir_all(folder).map_err(DatasetError::io(folder, "create the folder"))?;
    let mut size = None;
    for frame in FrameIndex::all(clip.frames()) {
        let mut indices = Vec::new();
        for (bit, (layer, _)) in coco::LAYERS.into_iter().enumerate() {
            let mask = coco::mask(clip, layer, frame, &mut size)?;
            indices.resize(mask.data().len(), 0_u8);
            for (index, inside) in indices.iter_mut().zip(mask.data()) {
                *index |= u8::from(*inside != 0) << bit;
            }
        }
        if let Some(size) = size {
            write_indexed(&folder.join(format!("{:05}.png", frame.0)), size, &PALETTE, &indices)?;
        }
    }
    size.ok_or_else(|| DatasetError::clip(&clip.folder, "has no frames"))
}
