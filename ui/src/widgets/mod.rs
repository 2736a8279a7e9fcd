//! What panels are built from.

mod availability;
mod button;
mod card;
mod chip;
mod empty;
mod icon;
mod keys;
mod path_button;
mod state_glyph;
mod thumbnail;

pub use availability::{blocked, blocked_in_its_step};
pub use button::{
    IconButton, command_button, command_icon_button, command_menu_button, command_switch, command_toggle,
    icon_button,
};
pub use card::card;
pub use chip::Chip;
pub use empty::empty_state;
pub use icon::Icon;
pub(crate) use keys::small;
pub use keys::{key_caps, key_text, tooltip_with_key};
pub use path_button::path_button;
pub use state_glyph::{StateGlyph, review_glyph, review_words, step_glyph, step_name, step_words};
pub use thumbnail::Thumbnails;
