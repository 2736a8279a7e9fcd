//! How the operator looks at things: remembered between starts, no part of the session.

use agenticfocus::{
    clip::FrameIndex,
    engine::OrbitCamera,
    geometry::Side,
    session::{MaskLayer, Step},
};

use serde::{Deserialize, Serialize};

use crate::theme::ThemeChoice;

/// What the pointer does on the canvas in the step of masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Adds under the brush (default).
    #[default]
    Brush,
    /// Takes away under the brush.
    Eraser,
    /// Adds (with Shift takes away) a polygon, corner by corner.
    Polygon,
    /// Adds (with Shift takes away) what a line drawn by hand encloses.
    Lasso,
    /// Adds (with Shift takes away) a box.
    Box,
    /// + and − points from which the engine makes a mask.
    Points,
}

/// A layer of the composite as it is previewed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerEye {
    /// Whether it is drawn.
    pub shown: bool,
    /// 0 to 1.
    pub opacity: f32,
}

impl Default for LayerEye {
    fn default() -> Self {
        Self { shown: true, opacity: 1.0 }
    }
}

/// The eyes of all layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerEyes {
    /// The frame without the human.
    pub background: LayerEye,
    /// The whole robot.
    pub robot: LayerEye,
    /// The object.
    pub object: LayerEye,
    /// The part of the robot over the object.
    pub front: LayerEye,
}

/// How source and composite are compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BeforeAfter {
    /// The composite alone (default).
    #[default]
    After,
    /// The source alone.
    Before,
    /// The source left of this share of the width, the composite right of it.
    Wipe(f32),
}

/// How fast a clip plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlaySpeed {
    /// ¼×.
    Quarter,
    /// ½×.
    Half,
    /// 1× (default).
    #[default]
    Normal,
    /// 2×.
    Double,
}

impl PlaySpeed {
    /// All, slowest first.
    pub const ALL: [Self; 4] = [Self::Quarter, Self::Half, Self::Normal, Self::Double];

    /// Frames a second of the clip.
    pub const fn factor(self) -> f64 {
        match self {
            Self::Quarter => 0.25,
            Self::Half => 0.5,
            Self::Normal => 1.0,
            Self::Double => 2.0,
        }
    }

    /// As it is written on its button.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Quarter => "¼×",
            Self::Half => "½×",
            Self::Normal => "1×",
            Self::Double => "2×",
        }
    }
}

/// Options of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Dark, light, or the system's.
    pub theme: ThemeChoice,
    /// Scale of everything, 1 is normal.
    pub zoom: f32,
    /// Whether the queue is unfolded.
    pub queue_open: bool,
    /// Whether the inspector is unfolded.
    pub inspector_open: bool,
    /// Which layer the mask tools edit.
    pub mask_layer: MaskLayer,
    /// The mask tool.
    pub tool: Tool,
    /// Radius of brush and eraser, picture pixels.
    pub brush_radius: f32,
    /// Opacity of a mask's fill, 0 to 1.
    pub mask_opacity: f32,
    /// Masks are hidden (while a key is held).
    pub masks_hidden: bool,
    /// Outlines of the frames before and after.
    pub onion_skin: bool,
    /// Outline of the hole in which the background is restored.
    pub hole_outline: bool,
    /// How far the hole is widened while somebody moves its slider, as a share of the picture's width.
    pub hole_moving: Option<f64>,
    /// Pixels that grow and shrink move the border by.
    pub grow_by: u32,
    /// The hand that single-hand commands mean, and the arm whose mask is edited.
    pub side: Side,
    /// Whether the clip plays.
    pub playing: bool,
    /// How fast.
    pub speed: PlaySpeed,
    /// Frames selected on the timeline, first and last inclusive.
    pub selection: Option<(FrameIndex, FrameIndex)>,
    /// Source against composite.
    pub before_after: BeforeAfter,
    /// Eyes of the composite's layers.
    pub eyes: LayerEyes,
    /// Where the 3-D view looks from.
    pub orbit: OrbitCamera,
    /// Which plot is on top in the step of retargeting.
    pub plot: usize,
    /// Whether the command palette is open.
    pub palette_open: bool,
    /// Whether the key sheet is open.
    pub keys_open: bool,
    /// The step on screen.
    pub step: Step,
}

impl Options {
    /// The arm whose mask is edited; `None` where the object's is.
    pub fn arm(&self) -> Option<Side> {
        (self.mask_layer == MaskLayer::Arms).then_some(self.side)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            theme: ThemeChoice::default(),
            zoom: 1.0,
            queue_open: true,
            inspector_open: true,
            mask_layer: MaskLayer::Object,
            tool: Tool::default(),
            brush_radius: 12.0,
            mask_opacity: 0.35,
            masks_hidden: false,
            onion_skin: false,
            hole_outline: false,
            hole_moving: None,
            grow_by: 2,
            side: Side::Right,
            playing: false,
            speed: PlaySpeed::default(),
            selection: None,
            before_after: BeforeAfter::default(),
            eyes: LayerEyes::default(),
            orbit: OrbitCamera::default(),
            plot: 0,
            palette_open: false,
            keys_open: false,
            step: Step::default(),
        }
    }
}
