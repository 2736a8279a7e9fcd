//! RGB and RGBA pictures.

use serde::{Deserialize, Serialize};

use crate::geometry::Size;

/// An 8-bit sRGB picture, rows top to bottom, `[r, g, b]` a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rgb8 {
    size: Size,
    data: Vec<u8>,
}

/// An 8-bit sRGB picture with straight (not premultiplied) alpha, `[r, g, b, a]` a pixel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedRgba8")]
pub struct Rgba8 {
    size: Size,
    data: Vec<u8>,
}

#[derive(Deserialize)]
struct UncheckedRgba8 {
    size: Size,
    data: Vec<u8>,
}

impl TryFrom<UncheckedRgba8> for Rgba8 {
    type Error = String;
    fn try_from(raw: UncheckedRgba8) -> Result<Self, String> {
        let found = raw.data.len();
        Self::from_data(raw.size, raw.data)
            .ok_or_else(|| format!("{found} bytes for a {} RGBA picture", raw.size))
    }
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

impl Rgba8 {
    /// Draws this picture over `ground`, which has the same size.
    ///
    /// # Panics
    /// When the sizes differ: callers layer pictures of one clip.
    pub fn draw_over(&self, ground: &mut Rgb8) {
        assert_eq!(self.size, ground.size, "pictures of one clip have one size");
        let pairs = ground.data.as_chunks_mut::<3>().0.iter_mut().zip(self.pixels());
        for (below, [r, g, b, alpha]) in pairs.filter(|(_, above)| above[3] > 0) {
            let alpha = u32::from(*alpha);
            for (under, over) in below.iter_mut().zip([r, g, b]) {
                let mixed = u32::from(*over) * alpha + u32::from(*under) * (255 - alpha);
                *under = ((mixed + 127) / 255) as u8;
            }
        }
    }
}
