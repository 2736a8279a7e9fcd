//! Design tokens and the egui style made from them.

mod tokens;

pub use tokens::Tokens;

/// Which colours the operator wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThemeChoice {
    /// As the system says (default).
    #[default]
    System,
    /// Dark.
    Dark,
    /// Light.
    Light,
}
