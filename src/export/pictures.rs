//! PNG files: masks, crops, the template.

use std::{
    fs::File,
    io::{BufReader, BufWriter},
    path::Path,
};

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};

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

/// Writes a picture of indices into `palette` (at most 256 colours), 8 bits a pixel.
///
/// # Errors
/// When the file cannot be written.
pub fn write_indexed(
    path: &Path,
    size: Size,
    palette: &[[u8; 3]],
    indices: &[u8],
) -> Result<(), ExportError> {
    encode(path, size, ColorType::Indexed, Some(palette.as_flattened().to_vec()), indices)
}

/// Reads a mask as [`write_mask`] writes it.
///
/// # Errors
/// When the file cannot be read or is no 8-bit grey PNG.
pub fn read_mask(path: &Path) -> Result<Mask, ExportError> {
    let (size, colour, bytes) = decode(path)?;
    let mask = if colour == ColorType::Grayscale { Mask::from_bytes(size, bytes) } else { None };
    mask.ok_or_else(|| damaged(path, format!("a picture of type {colour:?}, expected 8-bit grey")))
}

/// Reads the indices of an 8-bit palette picture.
///
/// # Errors
/// When the file cannot be read or is no such picture.
pub fn read_indexed(path: &Path) -> Result<(Size, Vec<u8>), ExportError> {
    let (size, colour, bytes) = decode(path)?;
    if colour == ColorType::Indexed && bytes.len() == size.area() {
        return Ok((size, bytes));
    }
    Err(damaged(path, format!("a picture of type {colour:?}, expected 8-bit palette indices")))
}

/// Largest side of a picture that is read.
const LARGEST_SIDE: u32 = 16_384;

fn decode(path: &Path) -> Result<(Size, ColorType, Vec<u8>), ExportError> {
    let file = File::open(path).map_err(|source| ExportError::io(path, "read the picture", source))?;
    let broken = |error: png::DecodingError| damaged(path, error.to_string());
    let mut decoder = Decoder::new(BufReader::new(file));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    let size = Size::new(info.width, info.height);
    if size.width > LARGEST_SIDE || size.height > LARGEST_SIDE || info.bit_depth != BitDepth::Eight {
        let found = format!(
            "{size} with {:?} bits a channel, expected 8 and at most {LARGEST_SIDE} a side",
            info.bit_depth
        );
        return Err(damaged(path, found));
    }
    let mut bytes = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let frame = reader.next_frame(&mut bytes).map_err(broken)?;
    bytes.truncate(frame.buffer_size());
    Ok((size, frame.color_type, bytes))
}

fn damaged(path: &Path, reason: String) -> ExportError {
    let source = std::io::Error::new(std::io::ErrorKind::InvalidData, reason);
    ExportError::io(path, "read the picture", source)
}

fn write_png(path: &Path, size: Size, colour: ColorType, data: &[u8]) -> Result<(), ExportError> {
    encode(path, size, colour, None, data)
}

fn encode(
    path: &Path,
    size: Size,
    colour: ColorType,
    palette: Option<Vec<u8>>,
    data: &[u8],
) -> Result<(), ExportError> {
    let write = || -> std::io::Result<()> {
        let mut encoder = Encoder::new(BufWriter::new(File::create(path)?), size.width, size.height);
        encoder.set_color(colour);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        if let Some(palette) = palette {
            encoder.set_palette(palette);
        }
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
