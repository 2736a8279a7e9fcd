//! Colours and sizes, named by what they are for. Nothing else in the window names a colour.

use egui::Color32;

/// All tokens of one theme.
#[derive(Clone, Debug, PartialEq)]
pub struct Tokens {
    /// Whether this is the dark theme.
    pub dark: bool,
    /// Behind everything, the canvas.
    pub ground: Color32,
    /// Panels.
    pub panel: Color32,
    /// Buttons, cards.
    pub raised: Color32,
    /// Lines between things.
    pub line: Color32,
    /// Text.
    pub text: Color32,
    /// Text of less weight.
    pub muted: Color32,
    /// The one accent.
    pub accent: Color32,
    /// The manipulated object.
    pub object: Color32,
    /// The left hand and arm.
    pub left: Color32,
    /// The right hand and arm.
    pub right: Color32,
    /// The template.
    pub template: Color32,
    /// The hole, and whatever is wrong.
    pub hole: Color32,
    /// The robot.
    pub robot: Color32,
}
