//! RGB and RGBA pictures.

use crate::geometry::Size;

/// An 8-bit sRGB picture, rows top to bottom, `[r, g, b]` a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8 {
    size: Size,
    data: Vec<u8>,
}

/// An 8-bit sRGB picture with straight (not premultiplied) alpha, `[r, g, b, a]` a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgba8 {
    size: Size,
    data: Vec<u8>,
}

macro_rules! picture {
    ($name:ident, $channels:literal) => {
        impl $name {
            /// Bytes a pixel.
            pub const CHANNELS: usize = $channels;

            /// All zero.
            pub fn new(size: Size) -> Self {
                Self { size, data: vec![0; size.area() * $channels] }
            }

            /// Takes over `data`; `None` when its length is not `width * height * channels`.
            pub fn from_data(size: Size, data: Vec<u8>) -> Option<Self> {
                (data.len() == size.area() * $channels).then_some(Self { size, data })
            }

            /// Width and height.
            pub fn size(&self) -> Size {
                self.size
            }

            /// All bytes, row after row.
            pub fn data(&self) -> &[u8] {
                &self.data
            }

            /// All bytes, for writing.
            pub fn data_mut(&mut self) -> &mut [u8] {
                &mut self.data
            }

            /// The bytes themselves.
            pub fn into_data(self) -> Vec<u8> {
                self.data
            }

            /// The pixel in column `x`, row `y`.
            pub fn pixel(&self, x: u32, y: u32) -> [u8; $channels] {
                let start = (y as usize * self.size.width as usize + x as usize) * $channels;
                let mut pixel = [0; $channels];
                pixel.copy_from_slice(&self.data[start..start + $channels]);
                pixel
            }

            /// Sets the pixel in column `x`, row `y`.
            pub fn set_pixel(&mut self, x: u32, y: u32, pixel: [u8; $channels]) {
                let start = (y as usize * self.size.width as usize + x as usize) * $channels;
                self.data[start..start + $channels].copy_from_slice(&pixel);
            }

            /// All pixels in row order.
            pub fn pixels(&self) -> impl Iterator<Item = &[u8; $channels]> {
                self.data.as_chunks::<$channels>().0.iter()
            }
        }
    };
}

picture!(Rgb8, 3);
picture!(Rgba8, 4);
