//! Masks as COCO annotations, run lengths in COCO's text form: without loss, holes and all.

use std::path::Path;

use serde_json::{Value, json};

use super::{DatasetError, clip::FinishedClip, file};
use crate::{
    clip::FrameIndex,
    export::read_mask,
    geometry::Size,
    segment::{RleMask, text_from_counts},
};

/// The mask layers of a finished clip and their category ids, object first.
pub(super) const LAYERS: [(&str, u32); 2] = [("object", 1), ("hand", 2)];

/// Writes `annotations/{id}.json` for the clip: an image a frame, an annotation a frame and layer, empty ones too.
pub(super) fn write_clip(clip: &FinishedClip, path: &Path) -> Result<Size, DatasetError> {
    let mut size = None;
    let (mut images, mut annotations) = (Vec::new(), Vec::new());
    for frame in FrameIndex::all(clip.frames()) {
        for (layer, category) in LAYERS {
            let mask = mask(clip, layer, frame, &mut size)?;
            annotations.push(annotation(annotations.len() + 1, frame, category, &mask));
        }
        let Some(size) = size else { continue };
        images.push(image(clip, frame, size));
    }
    let size = size.ok_or_else(|| DatasetError::clip(&clip.folder, "has no frames"))?;
    let dataset = json!({
        "info": {
            "description": clip.task(),
            "agenticfocus": { "id": clip.id, "source_file": clip.description.clip.file,
                "source_hash": clip.description.clip.hash, "backends": clip.description.meta.backends },
        },
        "licenses": [],
        "categories": [
            { "id": 1, "name": "object", "supercategory": "" },
            { "id": 2, "name": "human arm", "supercategory": "" },
        ],
        "images": images,
        "annotations": annotations,
    });
    file::write_json(path, &dataset)?;
    Ok(size)
}

/// The mask of one layer on one frame; all of a clip have one size.
pub(super) fn mask(
    clip: &FinishedClip,
    layer: &str,
    frame: FrameIndex,
    size: &mut Option<Size>,
) -> Result<crate::image::Mask, DatasetError> {
    let path = clip.folder.join(format!("masks/{layer}/{:06}.png", frame.0));
    let mask = read_mask(&path)?;
    let expected = *size.get_or_insert(mask.size());
    if mask.size() == expected {
        return Ok(mask);
    }
    Err(DatasetError::clip(&path, format!("is {}, expected {expected} as before", mask.size())))
}

fn image(clip: &FinishedClip, frame: FrameIndex, size: Size) -> Value {
    let source = clip.description.clip.source_frame.get(frame.as_usize());
    json!({
        "id": frame.0 + 1,
        "file_name": format!("{}/{:06}.jpg", clip.id, frame.0),
        "width": size.width,
        "height": size.height,
        "frame_index": frame.0,
        "source_frame": source,
    })
}

fn annotation(id: usize, frame: FrameIndex, category: u32, mask: &crate::image::Mask) -> Value {
    let size = mask.size();
    let bbox = mask.bounding_box().map_or([0.0; 4], |b| [b.x0, b.y0, b.x1 - b.x0, b.y1 - b.y0]);
    json!({
        "id": id,
        "image_id": frame.0 + 1,
        "category_id": category,
        "segmentation": {
            "size": [size.height, size.width],
            "counts": text_from_counts(RleMask::encode(mask).counts()),
        },
        "area": mask.area(),
        "bbox": bbox,
        "iscrowd": 0,
    })
}
