//! Masks, crops, template and the debug videos.

use std::sync::{Arc, mpsc::Receiver};

use super::{export::Parts, frame::FramePixels, pixels::next_frame};
use crate::{
    clip::{FrameIndex, FrameSource as _},
    composite::Composite,
    export::{
        ClipFolder, VideoQuality, VideoWriter, object_crop, overlay::masks_picture, write_mask, write_rgba,
    },
    geometry::Size,
    image::Rgb8,
    pipeline::{ClipFailure, ExitCode},
    progress::Watch,
    render::RobotLayers,
};

/// Share of the object's box that a crop shows around it.
const CROP_MARGIN: f64 = 0.1;

fn failed(error: &(dyn std::error::Error + 'static)) -> ClipFailure {
    ClipFailure::from_error(error, ExitCode::Internal)
}

/// Writes masks, crops, the template and the mask and inpaint debug videos.
pub(super) fn write(
    folder: &ClipFolder,
    parts: &Parts<'_>,
    pixels: Receiver<Arc<FramePixels>>,
    watch: &dyn Watch,
) -> Result<(), ClipFailure> {
    let size = parts.clip.size();
    let mut masks = VideoWriter::create(&folder.file("debug/masks.mp4"), size, VideoQuality::Debug)?;
    let mut inpaint = VideoWriter::create(&folder.file("debug/inpaint.mp4"), size, VideoQuality::Debug)?;
    if let Some(template) = &parts.template {
        write_rgba(&folder.file("template.png"), &template.picture)?;
    }
    for index in FrameIndex::all(parts.clip.frame_count()) {
        watch.check().map_err(|error| failed(&error))?;
        let at = index.as_usize();
        let frame = next_frame(&pixels)?;
        let object = parts.object.frame(index).mask.decode();
        let arms = parts.arms.union.frame(index).mask.decode();
        write_mask(&folder.mask_file("object", index), &object)?;
        write_mask(&folder.mask_file("hand", index), &arms)?;
        if let Some(crop) = object_crop(&frame.source, &object, CROP_MARGIN) {
            write_rgba(&folder.crop_file(index), &crop)?;
        }
        let sides = &parts.arms.sides;
        let (left, right) = (sides.left[at].decode(), sides.right[at].decode());
        masks.push(&masks_picture(&frame.source, Some(&object), Some(&left), Some(&right)))?;
        inpaint.push(&frame.background)?;
    }
    masks.finish()?;
    inpaint.finish()?;
    Ok(())
}

/// Size of the layer video: four pictures at half size, even.
pub(super) fn layers_size(size: Size) -> Size {
    let half = half(size);
    Size::new(2 * half.width, 2 * half.height)
}

fn half(size: Size) -> Size {
    Size::new((size.width / 2).max(1), (size.height / 2).max(1))
}

/// Background, robot, object and composite of one frame, at half size.
pub(super) fn layers_picture(
    background: &Rgb8,
    robot: &RobotLayers,
    composed: &Composite,
) -> Result<Rgb8, ClipFailure> {
    let size = background.size();
    let mut robot_picture = checkerboard(size);
    robot.full.draw_over(&mut robot_picture);
    let mut object_picture = checkerboard(size);
    if let Some(object) = &composed.object {
        object.draw_over(&mut object_picture);
    }
    let half = half(size);
    let mut sheet = Rgb8::new(layers_size(size));
    let tiles = [background, &robot_picture, &object_picture, &composed.picture];
    for (tile, (column, row)) in tiles.into_iter().zip([(0, 0), (1, 0), (0, 1), (1, 1)]) {
        let small = tile.resized(half).map_err(|error| failed(&error))?;
        paste(&small, (column * half.width, row * half.height), &mut sheet);
    }
    Ok(sheet)
}

fn paste(tile: &Rgb8, (left, top): (u32, u32), sheet: &mut Rgb8) {
    let (columns, width) = (sheet.size().width as usize * 3, tile.size().width as usize * 3);
    for (y, row) in tile.data().chunks_exact(width).enumerate() {
        let start = (top as usize + y) * columns + left as usize * 3;
        sheet.data_mut()[start..start + width].copy_from_slice(row);
    }
}

fn checkerboard(size: Size) -> Rgb8 {
    let mut picture = Rgb8::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            let value = if (x / 16 + y / 16) % 2 == 0 { 150 } else { 105 };
            picture.set_pixel(x, y, [value; 3]);
        }
    }
    picture
}
