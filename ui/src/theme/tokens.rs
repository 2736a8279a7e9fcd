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
    /// What is raised, under the pointer.
    pub hovered: Color32,
    /// What is chosen among several.
    pub selected: Color32,
    /// Lines between things.
    pub line: Color32,
    /// Text.
    pub text: Color32,
    /// Text of less weight.
    pub muted: Color32,
    /// The one accent, as a fill, a line or a glyph.
    pub accent: Color32,
    /// The accent as text.
    pub accent_text: Color32,
    /// Text on a fill of the accent.
    pub on_accent: Color32,
    /// Text about something that is wrong or wants a look.
    pub alarm: Color32,
    /// Text on a fill of [`Self::alarm`].
    pub on_alarm: Color32,
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

/// A colour from its hexadecimal digits, as designers write it.
const fn rgb(digits: u32) -> Color32 {
    let [_, red, green, blue] = digits.to_be_bytes();
    Color32::from_rgb(red, green, blue)
}

impl Tokens {
    /// The step that all distances are multiples of, points.
    pub const STEP: f32 = 4.0;
    /// Height of a row and of a button, points.
    pub const ROW: f32 = 24.0;
    /// Radius of corners, points.
    pub const RADIUS: u8 = 4;
    /// Size of text, points.
    pub const TEXT: f32 = 13.0;
    /// Size of small text, points.
    pub const SMALL: f32 = 11.0;
    /// Size of headings, points.
    pub const HEADING: f32 = 15.0;

    /// The dark theme.
    pub const fn dark() -> Self {
        Self {
            dark: true,
            ground: rgb(0x15_171B),
            panel: rgb(0x1C_1F24),
            raised: rgb(0x25_2930),
            hovered: rgb(0x2F_343C),
            selected: rgb(0x2A_384C),
            line: rgb(0x34_3A43),
            text: rgb(0xE6_E8EB),
            muted: rgb(0x9A_A3AE),
            accent: rgb(0x6A_A9FF),
            accent_text: rgb(0x6A_A9FF),
            on_accent: rgb(0x10_141A),
            alarm: rgb(0xFF_9A55),
            on_alarm: rgb(0x1A_1006),
            object: rgb(0xE6_9F00),
            left: rgb(0x56_B4E9),
            right: rgb(0xCC_79A7),
            template: rgb(0x00_9E73),
            hole: rgb(0xD5_5E00),
            robot: rgb(0xB8_C0CA),
        }
    }

    /// The light theme.
    pub const fn light() -> Self {
        Self {
            dark: false,
            ground: rgb(0xF5_F6F8),
            panel: rgb(0xFF_FFFF),
            raised: rgb(0xEE_F0F3),
            hovered: rgb(0xE2_E6EB),
            selected: rgb(0xDE_EAFC),
            line: rgb(0xD5_DAE1),
            text: rgb(0x1B_1F24),
            muted: rgb(0x5C_6672),
            accent: rgb(0x1F_6FEB),
            accent_text: rgb(0x0F_4FB8),
            on_accent: rgb(0xFF_FFFF),
            alarm: rgb(0xA8_4300),
            on_alarm: rgb(0xFF_FFFF),
            robot: rgb(0x6B_7480),
            ..Self::dark()
        }
    }

    /// The colour of a side's hand and arm.
    pub const fn side(&self, side: agenticfocus::geometry::Side) -> Color32 {
        match side {
            agenticfocus::geometry::Side::Left => self.left,
            agenticfocus::geometry::Side::Right => self.right,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(colour: Color32) -> f64 {
        let linear = |byte: u8| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    }

    fn contrast(one: Color32, other: Color32) -> f64 {
        let (one, other) = (luminance(one), luminance(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    #[test]
    fn text_stands_out_from_every_ground_it_stands_on() {
        for tokens in [Tokens::dark(), Tokens::light()] {
            let Tokens { ground, panel, raised, hovered, selected, .. } = tokens;
            for ground in [ground, panel, raised, hovered, selected] {
                for text in [tokens.text, tokens.muted, tokens.accent_text, tokens.alarm] {
                    let found = contrast(text, ground);
                    assert!(found >= 4.5, "{text:?} on {ground:?}: {found:.2} (dark: {})", tokens.dark);
                }
            }
            assert!(contrast(tokens.on_accent, tokens.accent) >= 4.5);
            assert!(contrast(tokens.on_alarm, tokens.alarm) >= 4.5);
        }
    }

    #[test]
    fn data_colours_are_the_same_in_both_themes() {
        let (dark, light) = (Tokens::dark(), Tokens::light());
        let of = |t: &Tokens| [t.object, t.left, t.right, t.template, t.hole];
        assert_eq!(of(&dark), of(&light), "what a colour means must not depend on the theme");
    }
}
