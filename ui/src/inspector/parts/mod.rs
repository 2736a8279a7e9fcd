//! Small pieces that all inspectors are made of.

mod back_end;
mod button;
mod fact;
mod layout;
mod parameter;
mod texture;
mod time_plot;

pub(super) use back_end::{backend_in_words, made_by, model_fault};
pub(super) use button::{
    choice_button, frame_with_cross, go_to_frame, primary_button, small_button, tool_button, unavailable,
};
pub(super) use fact::{Share, bar_of_shares, fact, mark, sign};
pub(super) use layout::{draft, empty, folded_section, hint, section};
pub(super) use parameter::{Edit, Parameter};
pub(super) use texture::{TextureKey, Textures, picture_of_rgb, picture_of_rgba};
pub(super) use time_plot::{Trace, TraceStyle, legend, time_plot};
