//! `agenticfocus synth`: synthetic episodes with truth.

use std::path::Path;

use super::{Failure, Outcome, batch::cancel_on_signals, progress::SimpleProgress};
use crate::{
    pipeline::ExitCode,
    synth::{EpisodeSpec, generate},
};

pub(super) fn run(out: &Path, episodes: u32, seed: u64, frames: Option<u32>) -> Outcome {
    let cancel = cancel_on_signals()?;
    for number in 0..u64::from(episodes) {
        let seed = seed + number;
        let mut spec = EpisodeSpec { seed, ..EpisodeSpec::default() };
        spec.frames = frames.unwrap_or(spec.frames);
        let folder = out.join(format!("seed{seed:04}"));
        let progress = SimpleProgress::new(&format!("seed {seed}"), &cancel);
        generate(&spec, &folder, &progress).map_err(|error| Failure::from_error(&error))?;
        drop(progress);
        println!("{}", folder.display());
    }
    Ok(ExitCode::Done)
}
