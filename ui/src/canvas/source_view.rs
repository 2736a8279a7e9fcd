//! The frame as filmed.

use std::sync::Arc;

use agenticfocus::image::Rgb8;
use egui::{Color32, ColorImage, Pos2, Rect, pos2};

use super::{scene::Scene, texture::Texture};
use crate::state::Context;

/// Seconds after which a picture that is not the right one is dimmed: any sooner it would flicker while
/// playing.
const PATIENCE: f64 = 0.15;
/// How much is left of its brightness then.
const DIMMED: f32 = 0.45;

/// A wait for something, so that short ones are not shown.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patience {
    since: Option<f64>,
}

impl Patience {
    /// How bright to draw what is here: 1 when it is the right thing or the wait is short. While the clip
    /// plays, pictures are always about to come.
    pub fn strength(&mut self, right: bool, playing: bool, scene: &Scene<'_>) -> f32 {
        if right || playing {
            self.since = None;
            return 1.0;
        }
        let now = scene.painter.ctx().input(|input| input.time);
        let waited = now - *self.since.get_or_insert(now);
        if waited >= PATIENCE {
            return DIMMED;
        }
        let rest = std::time::Duration::from_secs_f64((PATIENCE - waited).max(0.0));
        scene.painter.ctx().request_repaint_after(rest);
        1.0
    }
}

/// The source picture on screen.
#[derive(Debug, Default)]
pub(super) struct SourceView {
    texture: Texture,
    shown: Option<Arc<Rgb8>>,
    patience: Patience,
    opaque: bool,
}

impl SourceView {
    /// Draws the frame, or the nearest one there is while it is awaited; false when there is none at all.
    pub fn draw(&mut self, nearest: bool, scene: &Scene<'_>, cx: &mut Context<'_>) -> bool {
        let right = cx.pictures.source(scene.frame);
        let strength = self.patience.strength(right.is_some(), cx.options.playing, scene);
        self.opaque = false;
        if let Some(picture) = right.or_else(|| cx.pictures.nearest_source(scene.frame)) {
            let same = self.shown.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, &picture));
            if !same || self.texture.is_nearest() != nearest {
                let size = [picture.size().width as usize, picture.size().height as usize];
                let image = ColorImage::from_rgb(size, picture.data());
                self.texture.write(scene.painter.ctx(), "source", image, nearest);
                self.shown = Some(picture);
            }
        }
        // What was shown last stays until something else is here.
        let Some(id) = self.texture.id().filter(|_| self.shown.is_some()) else { return false };
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        let tint = Color32::WHITE.gamma_multiply(strength);
        scene.painter.image(id, scene.projection.picture_rect(), whole, tint);
        self.opaque = strength >= 1.0;
        true
    }

    /// Whether it was drawn last so that nothing under it is to be seen.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// Forgets the picture: another clip is open.
    pub fn clear(&mut self) {
        self.shown = None;
    }
}
