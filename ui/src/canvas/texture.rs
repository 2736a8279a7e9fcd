//! A picture on the graphics card that is written anew in place.

use egui::{ColorImage, Context, TextureFilter, TextureHandle, TextureId, TextureOptions};

/// One texture; allocated once for all pictures of one size.
#[derive(Default)]
pub(super) struct Texture {
    handle: Option<TextureHandle>,
    nearest: bool,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Texture").field("size", &self.handle.as_ref().map(TextureHandle::size)).finish()
    }
}

/// Soft when made smaller; square pixels when made larger, if `nearest`.
fn options(nearest: bool) -> TextureOptions {
    let magnification = if nearest { TextureFilter::Nearest } else { TextureFilter::Linear };
    TextureOptions { magnification, minification: TextureFilter::Linear, ..TextureOptions::LINEAR }
}

impl Texture {
    /// The texture, if anything was written to it.
    pub fn id(&self) -> Option<TextureId> {
        self.handle.as_ref().map(TextureHandle::id)
    }

    /// Whether a picture of this size would be written in place.
    pub fn fits(&self, size: [usize; 2]) -> bool {
        self.handle.as_ref().is_some_and(|handle| handle.size() == size)
    }

    /// Whether pixels are drawn as squares when made larger.
    pub fn is_nearest(&self) -> bool {
        self.nearest
    }

    /// Writes a whole picture.
    pub fn write(&mut self, context: &Context, name: &str, image: ColorImage, nearest: bool) {
        self.nearest = nearest;
        match &mut self.handle {
            // A write to a part, even to all of it, keeps the allocation.
            Some(handle) if handle.size() == image.size => {
                handle.set_partial([0, 0], image, options(nearest));
            }
            _ => self.handle = Some(context.load_texture(name, image, options(nearest))),
        }
    }

    /// Writes a part of the picture, from column and row `at` on; nothing before a whole one was written.
    pub fn write_part(&mut self, at: [usize; 2], image: ColorImage) {
        if let Some(handle) = &mut self.handle {
            handle.set_partial(at, image, options(self.nearest));
        }
    }
}
