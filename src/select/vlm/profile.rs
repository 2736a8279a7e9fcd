//! How a family of models writes coordinates.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use crate::geometry::{Pixel, Size};

/// How a model writes coordinates on the picture it was sent. Nothing in an answer tells one from the other, so it is
/// chosen beforehand and said in the log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// 0 to 1000 of width and height, x first (default; Qwen2-VL, Qwen3-VL and most others when asked to).
    #[default]
    #[serde(rename = "rel1000-xyxy")]
    Rel1000Xyxy,
    /// Pixels of the picture sent, x first (Qwen2.5-VL).
    AbsXyxy,
    /// 0 to 1000 of height and width, y first in lists (Gemini).
    #[serde(rename = "rel1000-yxyx")]
    Rel1000Yxyx,
    /// A point alone, in percent of width and height (Molmo).
    PctPoint,
}

impl Profile {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Rel1000Xyxy, Self::AbsXyxy, Self::Rel1000Yxyx, Self::PctPoint];

    /// Its name on the command line, in manifests and sessions.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rel1000Xyxy => "rel1000-xyxy",
            Self::AbsXyxy => "abs-xyxy",
            Self::Rel1000Yxyx => "rel1000-yxyx",
            Self::PctPoint => "pct-point",
        }
    }

    /// What is known of the model with this id; `None` where its name says nothing.
    pub fn suggested(model: &str) -> Option<Self> {
        let plain: String =
            model.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect();
        // Separators and the dot are dropped: `Qwen/Qwen2.5-VL-7B-Instruct`, `qwen2.5vl:7b`, `qwen2_5_vl`.
        let has = |part: &str| plain.contains(part);
        if has("qwen25vl") {
            Some(Self::AbsXyxy)
        } else if has("qwen2vl") || has("qwen3vl") || has("qwenvl") {
            Some(Self::Rel1000Xyxy)
        } else if has("gemini") {
            Some(Self::Rel1000Yxyx)
        } else if has("molmo") {
            Some(Self::PctPoint)
        } else {
            None
        }
    }

    /// Whether lists of numbers put y before x.
    pub(super) const fn is_y_first(self) -> bool {
        matches!(self, Self::Rel1000Yxyx)
    }

    /// Whether the model points instead of drawing boxes. Such models look at one picture.
    pub(super) const fn is_point(self) -> bool {
        matches!(self, Self::PctPoint)
    }

    /// What 1.0 of the picture is in the model's numbers, along x and y.
    pub(super) fn unit(self, sent: Size) -> (f64, f64) {
        match self {
            Self::Rel1000Xyxy | Self::Rel1000Yxyx => (1000.0, 1000.0),
            Self::AbsXyxy => (f64::from(sent.width), f64::from(sent.height)),
            Self::PctPoint => (100.0, 100.0),
        }
    }

    /// Pixels of the picture sent where the model says (`x`, `y`).
    pub(super) fn to_sent(self, at: Pixel, sent: Size) -> Pixel {
        let (x, y) = self.unit(sent);
        Pixel::new(at.x / x * f64::from(sent.width), at.y / y * f64::from(sent.height))
    }

    /// The convention as the model is told.
    pub(super) fn convention(self, sent: Size) -> String {
        match self {
            Self::Rel1000Xyxy | Self::Rel1000Yxyx => {
                "integers 0..1000 relative to the image, origin top-left, x right, y down".to_owned()
            }
            Self::AbsXyxy => format!(
                "integer pixels of the image as sent ({} wide, {} high), origin top-left, x right, y down",
                sent.width, sent.height
            ),
            Self::PctPoint => "percent of the image (0..100), origin top-left, x right, y down".to_owned(),
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Profile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|profile| profile.name() == text.trim()).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("unknown coordinate profile {text:?}: expected one of {names}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_families_are_told_by_their_names() {
        for (model, profile) in [
            ("Qwen/Qwen2.5-VL-7B-Instruct", Some(Profile::AbsXyxy)),
            ("qwen2.5vl:7b", Some(Profile::AbsXyxy)),
            ("Qwen/Qwen3-VL-8B-Instruct", Some(Profile::Rel1000Xyxy)),
            ("qwen2-vl-72b", Some(Profile::Rel1000Xyxy)),
            ("google/gemini-2.5-pro", Some(Profile::Rel1000Yxyx)),
            ("allenai/Molmo-7B-D-0924", Some(Profile::PctPoint)),
            ("llava:13b", None),
        ] {
            assert_eq!(Profile::suggested(model), profile, "{model}");
        }
    }

    #[test]
    fn names_are_the_same_on_the_command_line_and_in_files() {
        for profile in Profile::ALL {
            assert_eq!(profile.name().parse(), Ok(profile));
            assert_eq!(serde_json::to_value(profile).unwrap(), profile.name());
        }
        assert!("xyxy".parse::<Profile>().is_err());
    }

    #[test]
    fn the_picture_s_corner_is_its_corner_in_every_convention() {
        let sent = Size::new(896, 672);
        for profile in Profile::ALL {
            let (x, y) = profile.unit(sent);
            assert_eq!(profile.to_sent(Pixel::new(x, y), sent), Pixel::new(896.0, 672.0), "{profile}");
        }
    }
}
