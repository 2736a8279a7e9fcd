//! Where the background is restored behind the arms.

use std::sync::Arc;

use agenticfocus::{clip::FrameIndex, inpaint::InpaintParams, segment::RleMask, session::MaskLayer};

use super::super::{
    scene::Scene,
    shapes::{LineStyle, outlines},
};
use crate::{
    paint::{self, Outline},
    state::Context,
};

/// What an outline was made from.
#[derive(Debug, PartialEq)]
struct Made {
    frame: FrameIndex,
    reach: u32,
    arms: Arc<RleMask>,
    object: Option<Arc<RleMask>>,
}

/// The outline of the hole, kept until anything it is made from changes.
#[derive(Debug, Default)]
pub(super) struct HoleOutline {
    made: Option<Made>,
    lines: Vec<Outline>,
}

impl HoleOutline {
    /// Draws it where it is asked for, and while its slider moves.
    pub fn show(&mut self, scene: &Scene<'_>, cx: &Context<'_>) {
        let moving = cx.options.hole_moving;
        if !(cx.options.hole_outline || moving.is_some()) {
            return;
        }
        let share = moving.unwrap_or_else(|| scene.workspace.hole_dilation());
        self.make(scene, &InpaintParams::with_hole_dilation(share));
        let style = LineStyle { width: 2.0, colour: cx.tokens.hole, dashed: true };
        outlines(&scene.painter, &scene.projection, self.lines.iter().map(|line| (line, style)));
    }

    fn make(&mut self, scene: &Scene<'_>, params: &InpaintParams) {
        let width = scene.size().width;
        let fits = |mask: Arc<RleMask>| (mask.size() == scene.size()).then_some(mask);
        let mask = |layer| fits(scene.workspace.mask(layer, scene.frame)?.mask);
        let Some(arms) = mask(MaskLayer::Arms) else {
            *self = Self::default();
            return;
        };
        let (frame, reach) = (scene.frame, params.hole_reach(width));
        let made = Made { frame, reach, arms, object: mask(MaskLayer::Object) };
        if self.made.as_ref() == Some(&made) {
            return;
        }
        let wide = paint::grow(&made.arms.decode(), reach);
        let core =
            made.object.as_ref().map(|object| paint::shrink(&object.decode(), params.object_inset(width)));
        let hole = core.map_or_else(|| wide.clone(), |core| wide.minus(&core));
        self.lines = paint::outline(&hole);
        self.made = Some(made);
    }
}
