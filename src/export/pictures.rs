//! PNG files: masks, crops, the template.

use std::{fs::File, io::BufWriter, path::Path};

use png::{BitDepth, ColorType, Compression, Encoder};

use super::ExportError;
use crate::{
    geometry::{PixelBox, Size},
    image::{Mask, Rgb8, Rgba8},
};

/// Writes a mask as 8-bit grey, 0 outside and 255 inside.
///
/// # Errors
/// When the file cannot be written.
pub fn write_mask(path: &Path, mask: &Mask) -> Result<(), ExportError> {
    write_png(path, mask.size(), ColorType::Grayscale, mask.data())
}

/// Writes an RGB picture.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rgb(path: &Path, picture: &Rgb8) -> Result<(), ExportError> {
    write_png(path, picture.size(), ColorType::Rgb, picture.data())
}

/// Writes an RGBA picture with straight alpha.
///
/// # Errors
/// When the file cannot be written.
pub fn write_rgba(path: &Path, picture: &Rgba8) -> Result<(), ExportError> {
    write_png(path, picture.size(), ColorType::Rgba, picture.data())
}

fn write_png(path: &Path, size: Size, colour: ColorType, data: &[u8]) -> Result<(), ExportError> {
    let write = || -> std::io::Result<()> {
        let mut encoder = Encoder::new(BufWriter::new(File::create(path)?), size.width, size.height);
        encoder.set_color(colour);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(data)?;
        writer.finish()?;
        Ok(())
    };
    write().map_err(|source| ExportError::io(path, "write the picture", source))
}

/// The part of `frame` inside `mask`, cropped to the mask's box grown by `margin` pixels; `None`
/// when the mask is empty. Alpha is the mask.
pub fn object_crop(frame: &Rgb8, mask: &Mask, margin: f64) -> Option<Rgba8> {
    let crop: PixelBox = mask.bounding_box()?.grown(margin).clipped(frame.size())?;
    let (x0, y0) = (crop.x0 as u32, crop.y0 as u32);
    let size = Size::new(crop.x1 as u32 - x0, crop.y1 as u32 - y0);
    let mut picture = Rgba8::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            let [r, g, b] = frame.pixel(x0 + x, y0 + y);
            let alpha = if mask.get(x0 + x, y0 + y) { 255 } else { 0 };
            picture.set_pixel(x, y, [r, g, b, alpha]);
        }
    }
    Some(picture)
}
