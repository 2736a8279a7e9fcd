//! One mask layer on screen: a texture for its fill and lines for its border, both kept until the mask
//! changes.

use std::sync::Arc;

use agenticfocus::{
    clip::FrameIndex,
    geometry::{Side, Size},
    image::Mask,
    segment::RleMask,
};
use egui::{Color32, ColorImage, Context, Painter, Rect, pos2};

use super::{
    shapes::{LineStyle, outlines},
    texture::Texture,
    view::Projection,
};
use crate::paint::{Area, Outline, SideSplit, outline};

/// Which colour a mask's pixels have.
#[derive(Clone, Debug)]
pub(super) enum Colouring {
    /// The same everywhere.
    One(Color32),
    /// Left arm and right arm, told apart by the machine's split.
    Sides { left: Color32, right: Color32, split: Arc<SideSplit> },
}

impl PartialEq for Colouring {
    /// A split is compared by who it is: every frame of the window asks, and masks are large.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::One(one), Self::One(other)) => one == other,
            (
                Self::Sides { left, right, split },
                Self::Sides { left: other_left, right: other_right, split: other },
            ) => left == other_left && right == other_right && Arc::ptr_eq(split, other),
            _ => false,
        }
    }
}

impl Colouring {
    fn at(&self, x: u32, y: u32) -> Color32 {
        match self {
            Self::One(colour) => *colour,
            Self::Sides { left, right, split } => match split.side(x, y) {
                Side::Left => *left,
                Side::Right => *right,
            },
        }
    }

    /// The arm at a pixel, where that is known.
    fn side_at(&self, x: u32, y: u32) -> Option<Side> {
        match self {
            Self::One(_) => None,
            Self::Sides { split, .. } => Some(split.side(x, y)),
        }
    }
}

/// How a layer is drawn this time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Look {
    /// Opacity of the fill, 0 to 1.
    pub fill: f32,
    /// Width of the border, points.
    pub line: f32,
    /// Dashed: not to be trusted.
    pub dashed: bool,
    /// The arm that is worked on: the other one's border is thin.
    pub arm: Option<Side>,
}

/// A mask layer.
#[derive(Debug)]
pub(super) struct MaskView {
    name: &'static str,
    shown: Option<(FrameIndex, Arc<RleMask>)>,
    colouring: Colouring,
    pixels: Mask,
    texture: Texture,
    /// Where the texture is not clear.
    filled: Option<Area>,
    lines: Vec<Outline>,
    /// The operator works on it: what the session says comes later.
    held: bool,
}

impl MaskView {
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            shown: None,
            colouring: Colouring::One(Color32::TRANSPARENT),
            pixels: Mask::new(Size::new(0, 0)),
            texture: Texture::default(),
            filled: None,
            lines: Vec::new(),
            held: false,
        }
    }

    /// Shows `mask`, unless it is shown already or the operator works on the layer.
    pub fn sync(&mut self, context: &Context, frame: FrameIndex, mask: &Arc<RleMask>, colouring: Colouring) {
        if self.held {
            return;
        }
        let same = self.shown.as_ref().is_some_and(|(at, shown)| *at == frame && shown == mask);
        if same && self.colouring == colouring {
            return;
        }
        self.pixels = mask.decode();
        self.colouring = colouring;
        self.shown = Some((frame, Arc::clone(mask)));
        let area = Area::joined(self.filled, Area::of(&self.pixels));
        self.refresh(context, area);
    }

    /// The mask on screen.
    pub fn pixels(&self) -> &Mask {
        &self.pixels
    }

    /// Starts work of the operator's on the mask.
    pub fn hold(&mut self) {
        self.held = true;
    }

    /// Changes the mask on screen; `change` tells which rectangle it touched, and only that is worked on.
    pub fn change(&mut self, context: &Context, change: impl FnOnce(&mut Mask) -> Option<Area>) {
        if let Some(area) = change(&mut self.pixels) {
            self.refresh(context, Some(area));
        }
    }

    /// Changes the mask without showing it.
    pub fn change_unseen(&mut self, change: impl FnOnce(&mut Mask) -> Option<Area>) {
        if let Some(area) = change(&mut self.pixels) {
            self.filled = Area::joined(self.filled, Some(area));
        }
    }

    /// Ends work of the operator's: from now on the session's mask is shown again.
    pub fn release(&mut self) {
        self.held = false;
        self.shown = None;
    }

    fn refresh(&mut self, context: &Context, area: Option<Area>) {
        let size = self.pixels.size();
        let extent = [size.width as usize, size.height as usize];
        if !self.texture.fits(extent) {
            self.texture.write(context, self.name, ColorImage::filled(extent, Color32::TRANSPARENT), true);
            self.upload(Area::of(&self.pixels));
        } else {
            self.upload(area);
        }
        self.filled = Area::of(&self.pixels);
        self.lines = outline(&self.pixels);
    }

    fn upload(&mut self, area: Option<Area>) {
        let Some(area) = area else { return };
        let mut colours = Vec::with_capacity(area.width() * area.height());
        for y in area.y0..area.y1 {
            colours.extend(
                (area.x0..area.x1).map(|x| {
                    if self.pixels.get(x, y) { self.colouring.at(x, y) } else { Color32::TRANSPARENT }
                }),
            );
        }
        let image = ColorImage::new([area.width(), area.height()], colours);
        self.texture.write_part([area.x0 as usize, area.y0 as usize], image);
    }

    /// Draws the layer.
    pub fn draw(&self, painter: &Painter, projection: &Projection, look: Look) {
        if let Some(id) = self.texture.id()
            && look.fill > 0.0
            && let Some(area) = self.filled
        {
            // Only where there is anything: clear pixels cost as much as others. One more all round, since the
            // texture is softened at its edges.
            let (size, [x0, y0, x1, y1]) = (projection.size, [area.x0, area.y0, area.x1, area.y1]);
            let (x0, y0) = (x0.saturating_sub(1), y0.saturating_sub(1));
            let (x1, y1) = ((x1 + 1).min(size.width), (y1 + 1).min(size.height));
            let place = |x: u32, y: u32| projection.corner_to_screen(f64::from(x), f64::from(y));
            let share = |x: u32, y: u32| {
                pos2(x as f32 / size.width.max(1) as f32, y as f32 / size.height.max(1) as f32)
            };
            let part = Rect::from_min_max(share(x0, y0), share(x1, y1));
            let tint = Color32::WHITE.gamma_multiply(look.fill.clamp(0.0, 1.0));
            painter.image(id, Rect::from_min_max(place(x0, y0), place(x1, y1)), part, tint);
        }
        let styled = self.lines.iter().map(|line| {
            let [x, y] = line.inside;
            let other = look.arm.is_some_and(|arm| self.colouring.side_at(x, y).is_some_and(|at| at != arm));
            let width = if other { look.line.min(1.0) } else { look.line };
            (line, LineStyle { width, colour: self.colouring.at(x, y), dashed: look.dashed })
        });
        outlines(painter, projection, styled);
    }
}
