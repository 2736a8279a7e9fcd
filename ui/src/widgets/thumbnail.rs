//! Small pictures as textures, each uploaded once.

use std::{collections::BTreeMap, sync::Arc};

use agenticfocus::image::Rgb8;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};

/// Textures kept before those not shown lately are dropped.
const KEPT: usize = 256;

/// Textures of small pictures by any key.
#[derive(Default)]
pub struct Thumbnails<K: Ord> {
    known: BTreeMap<K, Known>,
    clock: u64,
}

struct Known {
    picture: Arc<Rgb8>,
    texture: TextureHandle,
    shown: u64,
}

impl<K: Ord> std::fmt::Debug for Thumbnails<K> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Thumbnails").field("count", &self.known.len()).finish_non_exhaustive()
    }
}

impl<K: Ord + Clone> Thumbnails<K> {
    /// The texture of `picture`, which stands for `key`.
    pub fn texture(&mut self, ctx: &Context, key: K, picture: &Arc<Rgb8>) -> egui::TextureId {
        self.clock += 1;
        if let Some(known) = self.known.get_mut(&key)
            && Arc::ptr_eq(&known.picture, picture)
        {
            known.shown = self.clock;
            return known.texture.id();
        }
        let size = picture.size();
        let image = ColorImage::from_rgb([size.width as usize, size.height as usize], picture.data());
        let texture = ctx.load_texture("thumbnail", image, TextureOptions::LINEAR);
        let id = texture.id();
        self.known.insert(key, Known { picture: Arc::clone(picture), texture, shown: self.clock });
        self.tidy();
        id
    }

    fn tidy(&mut self) {
        if self.known.len() > KEPT {
            let mut ages: Vec<u64> = self.known.values().map(|known| known.shown).collect();
            let (_, middle, _) = ages.select_nth_unstable(KEPT / 2);
            let oldest = *middle;
            self.known.retain(|_, known| known.shown >= oldest);
        }
    }
}
