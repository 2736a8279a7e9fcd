//! Writes synthetic episodes: `make_episodes OUT FIRST_SEED COUNT [FRAMES]`.

use std::{path::PathBuf, process::ExitCode};

use agenticfocus::{
    progress::Unwatched,
    synth::{EpisodeSpec, generate},
};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize, default: u64| arguments.get(index).map_or(Some(default), |a| a.parse().ok());
    let (Some(out), Some(first), Some(count), Some(frames)) =
        (arguments.first(), number(1, 1), number(2, 1), number(3, 135))
    else {
        eprintln!("usage: make_episodes OUT [FIRST_SEED] [COUNT] [FRAMES]");
        return ExitCode::from(2);
    };
    for seed in first..first + count {
        let dir = PathBuf::from(out).join(format!("seed{seed:04}"));
        let spec = EpisodeSpec { seed, frames: frames as u32, ..EpisodeSpec::default() };
        match generate(&spec, &dir, &Unwatched) {
            Ok(truth) => {
                println!("{} {:?} {:?} {:?}", dir.display(), truth.object, truth.grasp, truth.moving_side)
            }
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
