//! Palette pictures, one a frame, named by its number.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use super::{LayerLabels, Masks, number_in};
use crate::{export::read_indexed, image::Mask, pipeline::ClipFailure, segment::RleMask, session::MaskLayer};

pub(super) fn read(
    folder: &Path,
    labels: &LayerLabels,
    others: &mut BTreeMap<u32, u64>,
) -> Result<Masks, ClipFailure> {
    let mut pictures: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
            pictures.push(path);
        }
    }
    pictures.sort();
    let mut masks = Masks::new();
    for path in pictures {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let number = number_in(&name).ok_or_else(|| {
            ClipFailure::bad_input(format_args!("{}: no frame number in its name", path.display()))
        })?;
        let (size, indices) = read_indexed(&path)
            .map_err(|error| ClipFailure::bad_input(format_args!("{error}; expected DAVIS annotations")))?;
        for layer in [MaskLayer::Object, MaskLayer::Arms] {
            let inside: Vec<u8> = indices
                .iter()
                .map(|index| u8::from(labels.layers(u32::from(*index)).contains(&layer)))
                .collect();
            // As many bytes as pixels: checked when it was read.
            let mask = Mask::from_bytes(size, inside).unwrap_or_else(|| Mask::new(size));
            if masks.insert((number, layer), RleMask::encode(&mask)).is_some() {
                let path = path.display();
                return Err(ClipFailure::bad_input(format_args!(
                    "{path}: a second picture of frame {number}"
                )));
            }
        }
        for index in indices.into_iter().map(u32::from).filter(|index| *index != 0) {
            if labels.layers(index).is_empty() {
                *others.entry(index).or_default() += 1;
            }
        }
    }
    Ok(masks)
}
