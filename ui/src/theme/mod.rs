//! Design tokens and the egui style made from them.

mod style;
mod tokens;

pub use style::{apply, number_font, small_number_font};
pub use tokens::Tokens;

use serde::{Deserialize, Serialize};

/// Which colours the operator wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ThemeChoice {
    /// As the system says (default).
    #[default]
    System,
    /// Dark.
    Dark,
    /// Light.
    Light,
}

impl ThemeChoice {
    /// The tokens to draw with; dark where the system says nothing.
    pub fn tokens(self, ctx: &egui::Context) -> Tokens {
        let theme = match self {
            Self::System => ctx.system_theme().unwrap_or(egui::Theme::Dark),
            Self::Dark => egui::Theme::Dark,
            Self::Light => egui::Theme::Light,
        };
        match theme {
            egui::Theme::Dark => Tokens::dark(),
            egui::Theme::Light => Tokens::light(),
        }
    }
}
