//! Textures of small pictures, made once.

use std::{any::Any, collections::HashMap, sync::Arc};

use agenticfocus::{
    clip::FrameIndex,
    image::{Rgb8, Rgba8},
};
use egui::{ColorImage, TextureHandle, TextureOptions, Ui};

/// What a texture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::inspector) enum TextureKey {
    /// A part of a source frame: frame, left, top, width, height.
    Crop(FrameIndex, [u32; 4]),
    /// A small picture of a frame.
    Thumbnail(FrameIndex),
    /// The template.
    Template,
    /// The robot from outside.
    Orbit,
    /// A layer of the composite, from the front.
    Layer(usize),
}

/// Textures by what they show; one is made anew when its picture is another one.
#[derive(Default)]
pub(in crate::inspector) struct Textures {
    // The picture is kept with its texture: a freed address may come again with another picture in it.
    kept: HashMap<TextureKey, (Arc<dyn Any + Send + Sync>, TextureHandle)>,
}

impl std::fmt::Debug for Textures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Textures").field("kept", &self.kept.len()).finish()
    }
}

impl Textures {
    /// The texture for `key`, where there is one.
    pub fn get(&self, key: TextureKey) -> Option<&TextureHandle> {
        self.kept.get(&key).map(|(_, texture)| texture)
    }

    /// The texture for `key` of the picture `source`, made by `make` when it is not the one that is kept.
    pub fn of<T: Any + Send + Sync>(
        &mut self,
        ui: &Ui,
        key: TextureKey,
        source: &Arc<T>,
        make: impl FnOnce(&T) -> ColorImage,
    ) -> TextureHandle {
        let address = Arc::as_ptr(source).cast::<()>();
        if let Some((kept, texture)) = self.kept.get(&key)
            && Arc::as_ptr(kept).cast::<()>() == address
        {
            return texture.clone();
        }
        let texture = ui.ctx().load_texture(format!("{key:?}"), make(source), TextureOptions::LINEAR);
        let source: Arc<dyn Any + Send + Sync> = Arc::<T>::clone(source);
        self.kept.insert(key, (source, texture.clone()));
        texture
    }

    /// Keeps a texture that needs no source any more.
    pub fn keep(&mut self, ui: &Ui, key: TextureKey, image: ColorImage) {
        let texture = ui.ctx().load_texture(format!("{key:?}"), image, TextureOptions::LINEAR);
        self.kept.insert(key, (Arc::new(()), texture));
    }
}

/// Columns and rows of a picture.
fn side_lengths(size: agenticfocus::geometry::Size) -> [usize; 2] {
    [size.width as usize, size.height as usize]
}

/// A picture as egui wants it.
pub(in crate::inspector) fn picture_of_rgb(picture: &Rgb8) -> ColorImage {
    ColorImage::from_rgb(side_lengths(picture.size()), picture.data())
}

/// A picture with alpha as egui wants it.
pub(in crate::inspector) fn picture_of_rgba(picture: &Rgba8) -> ColorImage {
    ColorImage::from_rgba_unmultiplied(side_lengths(picture.size()), picture.data())
}
