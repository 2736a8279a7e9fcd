//! Scores of every stage and of the whole on synthetic episodes.

use std::{
    error::Error,
    io,
    path::{Path, PathBuf},
    process::Command,
    sync::atomic::AtomicBool,
    time::Instant,
};

use super::{
    ClipFailure, ClipJob, ExitCode, Installation, Listener, RawObjectPrompt, Understood,
    batch::{BatchEvent, BatchOptions, WorkerMessage, run_batch},
    understand_clip,
};
use crate::{
    clip::{self, CameraSpec, ClipRequest, FrameIndex},
    evaluate::bench::{self, Figures},
    hands::{self, FitParams},
    progress::{Unwatched, Watch},
    render::{LayerRequest, RobotRenderParams, RobotRenderer},
    retarget::score_ik,
    robot::RobotModel,
    select::vlm::VlmWish,
    session::{ClipReference, Document, RetargetSettings},
    synth::{Episode, EpisodeSpec, generate},
};

/// Spread of the keypoint noise on which the hand fit is scored, pixels.
const KEYPOINT_NOISE: f64 = 1.0;
/// Frames of the clips between which memory may grow: 10 s and 60 s.
const MEMORY_FRAMES: [usize; 2] = [300, 1800];

/// What is measured.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Seed of the first episode.
    pub seed: u64,
    /// Episodes.
    pub episodes: u32,
    /// Whether peak memory is compared between a 10 s and a 60 s clip, which takes a while.
    pub memory_growth: bool,
    /// Folder for episodes and results.
    pub out: PathBuf,
    /// The worker program and its arguments, as in [`BatchOptions`].
    pub worker: (PathBuf, Vec<String>),
}

/// Runs the bench.
///
/// # Errors
/// When an episode cannot be made, the pipeline fails on one, or a score cannot be computed.
pub fn run_bench(
    options: &BenchOptions,
    installation: &Installation,
    listener: &dyn Listener,
    watch: &dyn Watch,
    cancel: &AtomicBool,
) -> Result<Figures, ClipFailure> {
    let mut figures = Figures::default();
    score_solver(options.seed, &mut figures)?;
    for number in 0..u64::from(options.episodes) {
        let seed = options.seed + number;
        listener.note(&format!("episode {} of {} (seed {seed})", number + 1, options.episodes));
        let spec = EpisodeSpec { seed, ..EpisodeSpec::default() };
        let episode = episode(&spec, &options.out.join(format!("episodes/seed{seed:04}")), watch)?;
        let job = episode_job(&episode, &format!("seed{seed:04}")).map_err(|error| failed(&error))?;
        let run = run_worker(&job, options, cancel)?;
        let mut scores = Figures::default();
        scores.add("pipeline_fps", episode.frame_count() as f64 / run.seconds);
        scores.add_some("peak_memory_mib", run.peak_memory_mib);
        let found = understand_clip(&job, &options.out, installation, listener, cancel)?;
        score_episode(&episode, &found, &options.out.join(&job.id), seed, &mut scores)?;
        listener.note(&scores.to_line());
        figures.add_episode(seed, scores);
    }
    if options.memory_growth {
        let growth = memory_growth(options, cancel, listener, watch)?;
        figures.add_some("memory_growth_pct", growth);
    }
    Ok(figures)
}

fn failed(error: &(dyn Error + 'static)) -> ClipFailure {
    ClipFailure::from_error(error, ExitCode::Internal)
}

/// The episode in `folder`, made unless it is there.
fn episode(spec: &EpisodeSpec, folder: &Path, watch: &dyn Watch) -> Result<Episode, ClipFailure> {
    if let Ok(episode) = Episode::load(folder)
        && episode.truth.spec == *spec
    {
        return Ok(episode);
    }
    generate(spec, folder, watch).map_err(|error| failed(&error))?;
    Episode::load(folder).map_err(|error| failed(&error))
}

/// A job as a manifest would state it: the camera, the hand's length, and the object by one box.
///
/// # Errors
/// When the truth cannot be read.
pub fn episode_job(episode: &Episode, id: &str) -> Result<ClipJob, bench::BenchError> {
    let path = episode.clip_path();
    let path = std::path::absolute(&path).unwrap_or(path);
    let camera = episode.truth.pinhole;
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
    let object = bench::first_object_box(episode)?.map(|(frame, b)| RawObjectPrompt {
        label: "object".to_owned(),
        source_frame: frame.0,
        bounds: Some([b.x0, b.y0, b.x1, b.y1]),
        points: Vec::new(),
        negative: Vec::new(),
    });
    Ok(ClipJob { id: id.to_owned(), session: None, document, object, vlm: VlmWish::default(), method: None })
}

struct WorkerRun {
    seconds: f64,
    peak_memory_mib: Option<f64>,
}

/// The job in a worker of its own, so that time and memory are the pipeline's alone.
fn run_worker(job: &ClipJob, options: &BenchOptions, cancel: &AtomicBool) -> Result<WorkerRun, ClipFailure> {
    // An earlier run's result would be taken as done.
    for path in [options.out.join(&job.id), options.out.join(format!("{}.afs", job.id))] {
        match std::fs::remove_dir_all(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
    }
    let mut arguments = options.worker.1.clone();
    arguments.push("--keep-frames".to_owned());
    let batch = BatchOptions {
        out: options.out.clone(),
        jobs: 1,
        worker: options.worker.0.clone(),
        worker_arguments: arguments,
    };
    let peak = std::sync::Mutex::new(None);
    let start = Instant::now();
    let summary = run_batch(std::slice::from_ref(job), &batch, cancel, &|event| {
        if let BatchEvent::Said(_, WorkerMessage::Finished { peak_memory_mib, .. }) = event {
            *peak.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = *peak_memory_mib;
        }
    })?;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(outcome) = summary.clips.first().filter(|outcome| outcome.exit != ExitCode::Done) {
        let message = format!("{}: {}", job.id, outcome.message.clone().unwrap_or_default());
        return Err(ClipFailure { stage: None, exit: outcome.exit, message });
    }
    let peak_memory_mib = peak.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    Ok(WorkerRun { seconds, peak_memory_mib })
}

fn score_solver(seed: u64, figures: &mut Figures) -> Result<(), ClipFailure> {
    let robot = RobotModel::embedded().map_err(|error| failed(&error))?;
    let score = score_ik(&robot, seed);
    figures.add("ik_position_error_mm", score.position_error_mm);
    figures.add("limit_violations", score.limit_violations as f64);
    figures.add("ik_time_ms", score.time_ms);
    Ok(())
}

fn score_episode(
    episode: &Episode,
    found: &Understood,
    result: &Path,
    seed: u64,
    figures: &mut Figures,
) -> Result<(), ClipFailure> {
    let bad = |error: bench::BenchError| failed(&error);
    figures.add_some("object_mask_j", bench::object_mask_j(episode, &found.object).map_err(bad)?);
    figures.add_some("arm_mask_j", bench::arm_mask_j(episode, &found.arms.union).map_err(bad)?);
    if let Some(template) = &found.template {
        let score = bench::template_iou_occluded(episode, template).map_err(bad)?;
        figures.add_some("template_iou_occluded", score);
    }
    let score = bench::inpaint_psnr_db(episode, &found.background.frames).map_err(bad)?;
    figures.add_some("inpaint_psnr_db", score);
    let camera = &found.clip.info.intrinsics;
    let score = bench::wrist_reprojection_px(&found.motion, &found.hands, camera).map_err(bad)?;
    figures.add_some("wrist_reprojection_px", score);
    let tolerance = 1e-9;
    let limits = found.robot.limits();
    let beyond: usize =
        found.motion.angles.iter().map(|angles| limits.position_violations(angles, tolerance)).sum();
    let pairs = found.motion.angles.windows(2);
    let fast: usize = pairs.map(|pair| limits.velocity_violations(&pair[0], &pair[1], tolerance)).sum();
    figures.add("limit_violations", (beyond + fast) as f64);
    score_hand_fit(episode, seed, figures)?;
    figures.add_some("composite_psnr_db", composite_score(episode, found, result)?);
    Ok(())
}

/// The 3-D fit alone: true keypoints with noise in, wrist depth and joints out.
fn score_hand_fit(episode: &Episode, seed: u64, figures: &mut Figures) -> Result<(), ClipFailure> {
    let landmarks = bench::noisy_landmarks(episode, KEYPOINT_NOISE, seed);
    let params = FitParams { hand_length_mm: episode.truth.hand_length * 1000.0, ..FitParams::default() };
    let track = hands::fit(&landmarks, "truth", &episode.truth.pinhole, &params, &Unwatched)
        .map_err(|error| failed(&error))?;
    if let Some(errors) = bench::hand_errors(episode, &track).map_err(|error| failed(&error))? {
        figures.add("hand_depth_error_pct", errors.depth_pct);
        figures.add("hand_joint_error_mm", errors.joint_mm);
    }
    Ok(())
}

/// The exported video against the ideal composite of the same robot pictures.
fn composite_score(episode: &Episode, found: &Understood, result: &Path) -> Result<Option<f64>, ClipFailure> {
    let scratch = result.join(".score");
    std::fs::create_dir_all(&scratch)?;
    let finished = clip::open(&ClipRequest::new(result.join("composite.mp4")), &scratch, &Unwatched)?;
    let params = RobotRenderParams::default();
    let mut renderer = RobotRenderer::new(&found.robot, found.clip.info.intrinsics, params)
        .map_err(|error| failed(&error))?;
    let shown = super::shown_arms(&found.motion);
    let mut robot = |index: FrameIndex| {
        let at = index.as_usize();
        let request = LayerRequest { shown: shown[at], ..LayerRequest::default() };
        let layers = renderer.render(&found.motion.angles[at], &found.motion.map, &request);
        layers.map(Some).map_err(|error| ScoreError(error.to_string()))
    };
    let score = bench::composite_psnr_db(episode, &finished, &mut robot);
    drop(finished);
    std::fs::remove_dir_all(&scratch)?;
    score.map_err(|error| failed(&error))
}

/// Why a composite could not be scored.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct ScoreError(String);

impl From<bench::BenchError> for ScoreError {
    fn from(error: bench::BenchError) -> Self {
        Self(error.to_string())
    }
}

/// Growth of the peak from 10 s to 60 s in percent; the clips are one episode, looped.
fn memory_growth(
    options: &BenchOptions,
    cancel: &AtomicBool,
    listener: &dyn Listener,
    watch: &dyn Watch,
) -> Result<Option<f64>, ClipFailure> {
    let spec = EpisodeSpec { seed: options.seed, ..EpisodeSpec::default() };
    let episode = episode(&spec, &options.out.join(format!("episodes/seed{:04}", options.seed)), watch)?;
    let mut peaks = Vec::new();
    for frames in MEMORY_FRAMES {
        listener.note(&format!("memory on {frames} frames"));
        let path = options.out.join(format!("episodes/loop{frames}.mp4"));
        loop_clip(&episode.clip_path(), &path, frames)?;
        let id = format!("loop{frames}");
        let mut job = episode_job(&episode, &id).map_err(|error| failed(&error))?;
        job.document.clip.path = std::path::absolute(&path).unwrap_or(path).to_string_lossy().into_owned();
        peaks.push(run_worker(&job, options, cancel)?.peak_memory_mib);
    }
    Ok(match peaks[..] {
        [Some(short), Some(long)] if short > 0.0 => Some(100.0 * (long / short - 1.0)),
        _ => None,
    })
}

fn loop_clip(from: &Path, to: &Path, frames: usize) -> Result<(), ClipFailure> {
    let status = Command::new("ffmpeg")
        .args(["-v", "error", "-nostdin", "-y", "-stream_loop", "-1", "-i"])
        .arg(from)
        .args(["-frames:v", &frames.to_string(), "-c:v", "libx264", "-crf", "14", "-preset", "veryfast"])
        .arg(to)
        .status()?;
    if status.success() {
        return Ok(());
    }
    let message = format!("ffmpeg could not loop {} ({status})", from.display());
    Err(ClipFailure { stage: None, exit: ExitCode::Internal, message })
}
