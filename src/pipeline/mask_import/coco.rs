//! COCO annotations whose segmentations are run lengths, as text or as numbers.

use std::{collections::BTreeMap, fs, path::Path};

use serde::Deserialize;

use super::{LayerLabels, Masks, number_in};
use crate::{
    geometry::Size,
    pipeline::ClipFailure,
    segment::{RleMask, counts_from_text},
};

/// Largest file that is read.
const LARGEST: u64 = 2 << 30;

#[derive(Deserialize)]
struct Dataset {
    images: Vec<Image>,
    annotations: Vec<Annotation>,
}

#[derive(Deserialize)]
struct Image {
    id: u64,
    #[serde(default)]
    file_name: String,
    /// Of our own exports.
    frame_index: Option<u32>,
}

#[derive(Deserialize)]
struct Annotation {
    id: u64,
    image_id: u64,
    category_id: u32,
    segmentation: Segmentation,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Segmentation {
    Runs { size: [u32; 2], counts: Counts },
    Polygons(serde::de::IgnoredAny),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Counts {
    Text(String),
    Numbers(Vec<u32>),
}

pub(super) fn read(
    path: &Path,
    labels: &LayerLabels,
    others: &mut BTreeMap<u32, u64>,
) -> Result<Masks, ClipFailure> {
    let wrong = |what: String| ClipFailure::bad_input(format_args!("{}: {what}", path.display()));
    if fs::metadata(path)?.len() > LARGEST {
        return Err(wrong(format!("is larger than {} MiB", LARGEST >> 20)));
    }
    let dataset: Dataset =
        serde_json::from_slice(&fs::read(path)?).map_err(|error| wrong(format!("no COCO file: {error}")))?;
    let mut numbers = BTreeMap::new();
    for image in &dataset.images {
        let number = image.frame_index.or_else(|| number_in(&image.file_name));
        let number = number
            .ok_or_else(|| wrong(format!("image {}: no frame number in {:?}", image.id, image.file_name)))?;
        numbers.insert(image.id, number);
    }
    let mut masks = Masks::new();
    for annotation in &dataset.annotations {
        let layers = labels.layers(annotation.category_id);
        if layers.is_empty() {
            *others.entry(annotation.category_id).or_default() += 1;
            continue;
        }
        let id = annotation.id;
        let number = numbers.get(&annotation.image_id);
        let number =
            *number.ok_or_else(|| wrong(format!("annotation {id}: no image {}", annotation.image_id)))?;
        let mask =
            mask(&annotation.segmentation).map_err(|what| wrong(format!("annotation {id}: {what}")))?;
        for layer in layers {
            // Several annotations of one thing on one picture are its parts.
            let whole = match masks.get(&(number, *layer)) {
                Some(part) if part.size() == mask.size() => {
                    RleMask::encode(&part.decode().union(&mask.decode()))
                }
                Some(part) => {
                    return Err(wrong(format!(
                        "annotation {id}: {}, another part {}",
                        mask.size(),
                        part.size()
                    )));
                }
                None => mask.clone(),
            };
            masks.insert((number, *layer), whole);
        }
    }
    Ok(masks)
}

fn mask(segmentation: &Segmentation) -> Result<RleMask, String> {
    let Segmentation::Runs { size: [height, width], counts } = segmentation else {
        return Err("a polygon, expected run lengths {\"size\", \"counts\"}".to_owned());
    };
    let counts = match counts {
        Counts::Text(text) => counts_from_text(text).map_err(|error| error.to_string())?,
        Counts::Numbers(numbers) => numbers.clone(),
    };
    if *width == 0 || *height == 0 || *width > 16_384 || *height > 16_384 {
        return Err(format!("a picture of {width} by {height} pixels"));
    }
    RleMask::from_counts(Size::new(*width, *height), counts).map_err(|error| error.to_string())
}
