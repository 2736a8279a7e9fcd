//! `agenticfocus demo`: a synthetic episode through the whole pipeline.

use std::path::Path;

use super::{
    Failure, Outcome,
    batch::{cancel_on_signals, run_jobs},
    progress::SimpleProgress,
};
use crate::{
    clip::{CameraSpec, FrameIndex},
    pipeline::{ClipJob, ExitCode, RawObjectPrompt},
    session::{ClipReference, Document, RetargetSettings},
    synth::{Episode, EpisodeSpec, generate},
};

pub(super) fn run(out: &Path, seed: u64, frames: Option<u32>) -> Outcome {
    let cancel = cancel_on_signals()?;
    let mut spec = EpisodeSpec { seed, ..EpisodeSpec::default() };
    spec.frames = frames.unwrap_or(spec.frames);
    let folder = out.join("synthetic");
    if !is_there(&folder, &spec) {
        println!("making a synthetic episode (seed {seed}, {} frames) in {}", spec.frames, folder.display());
        let progress = SimpleProgress::new("episode", &cancel);
        generate(&spec, &folder, &progress).map_err(|error| Failure::from_error(&error))?;
    }
    let episode = Episode::load(&folder).map_err(|error| Failure::from_error(&error))?;
    let job = episode_job(&episode, "episode").map_err(|error| Failure::from_error(&error))?;
    println!("running the pipeline on it");
    let summary = run_jobs(&[job], out.to_owned(), 1)?;
    if summary.exit == ExitCode::Done {
        let result = out.join("episode");
        println!("\nthe demonstration is in {}:", result.display());
        println!("  composite.mp4     the robot in the person's place");
        println!("  record.npz        joint angles, commands, wrists, fingertips, 30 rows a second");
        println!("  report.json       quality, frame by frame");
        println!("  debug/            masks, background and layers as videos");
        println!("the session is {}; run it again with:", out.join("episode.afs").display());
        println!("  agenticfocus --batch {} --out DIR", out.join("episode.afs").display());
        println!("{:.0} s in all", summary.seconds);
    }
    Ok(summary.exit)
}

/// Whether the very episode is in `folder` already.
fn is_there(folder: &Path, spec: &EpisodeSpec) -> bool {
    Episode::load(folder).is_ok_and(|episode| episode.truth.spec == *spec)
}

/// A job as a manifest would state it: the camera, the hand's length, and the object by a box.
pub(super) fn episode_job(episode: &Episode, id: &str) -> Result<ClipJob, crate::synth::SynthError> {
    let path = std::path::absolute(episode.clip_path()).unwrap_or_else(|_| episode.clip_path());
    let camera = episode.truth.pinhole;
    let bounds = episode.object_visible(FrameIndex(0))?.bounding_box();
    let document = Document {
        clip: ClipReference {
            id: id.to_owned(),
            path: path.to_string_lossy().into_owned(),
            ..ClipReference::default()
        },
        task: Some("move the object".to_owned()),
        camera: CameraSpec::Intrinsics { fx: camera.fx, fy: camera.fy, cx: camera.cx, cy: camera.cy },
        retarget: RetargetSettings {
            hand_length: Some(episode.truth.hand_length),
            ..RetargetSettings::default()
        },
        ..Document::default()
    };
    let object = bounds.map(|b| RawObjectPrompt {
        label: "object".to_owned(),
        source_frame: 0,
        bounds: Some([b.x0, b.y0, b.x1, b.y1]),
        points: Vec::new(),
        negative: Vec::new(),
    });
    Ok(ClipJob { id: id.to_owned(), session: None, document, object })
}
