//! A vision-language model behind the OpenAI-compatible chat API (vLLM, Ollama, llama.cpp, hosted ones) as a selector.
//!
//! It is shown a few frames and answers with a box (or a point) on one of them: a proposal like any other. How models write
//! coordinates is configured ([`Profile`]), never guessed. The key comes from the environment and is shown nowhere.

mod base_url;
mod config;
mod error;
mod frames;
mod json_scan;
mod letterbox;
mod parse;
mod picture;
mod points;
mod profile;
mod prompt;
mod reply;
mod request;
mod retry;
mod secret;
mod selector;
mod transport;
mod validate;

pub use base_url::{BaseUrl, UrlError};
pub use config::{
    CONNECT_TIMEOUT, FIRST_WAIT, KEY_VARIABLE, ProfileOrigin, TOTAL_TIMEOUT, VlmConfigError, VlmMode,
    VlmPlan, VlmServer, VlmSettings, VlmWish,
};
pub use error::VlmError;
pub use profile::Profile;
pub use secret::Secret;
pub use selector::{VlmSelector, answers};
