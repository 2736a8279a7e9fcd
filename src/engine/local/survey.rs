//! What a folder's clips look like from outside: review, results, a small picture.

use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::Arc,
};

use super::scene::Shared;
use crate::{
    clip::Rotation,
    engine::{Event, QueueItem},
    geometry::Size,
    image::Rgb8,
    pipeline::{
        ClipJob,
        batch::{ClipState, read_outcome},
    },
    session::{ReviewState, Session},
};

/// Thumbnails of the queue, pixels.
const THUMBNAIL: Size = Size::new(96, 54);

/// What is opened for `job`.
pub(super) fn path_of(job: &ClipJob) -> PathBuf {
    job.session.clone().unwrap_or_else(|| PathBuf::from(&job.document.clip.path))
}

/// Tells the clips at once and again as their pictures are read, on a thread of its own.
pub(super) fn start(shared: &Arc<Shared>, path: PathBuf, jobs: Vec<ClipJob>) {
    let here = Arc::clone(shared);
    let started = std::thread::Builder::new().name("survey".to_owned()).spawn(move || {
        let mut items: Vec<QueueItem> = jobs.iter().map(|job| item(&here, job)).collect();
        here.tell(Event::Queue { path: path.clone(), items: items.clone() });
        for at in 0..items.len() {
            if here.is_stopping() {
                return;
            }
            let clip = match session_of(&here, &jobs[at]) {
                Some(session) => session.document().clip.clone(),
                None => jobs[at].document.clip.clone(),
            };
            items[at].thumbnail = thumbnail(Path::new(&clip.path), clip.rotate).map(Arc::new);
            here.tell(Event::Queue { path: path.clone(), items: items.clone() });
        }
    });
    if let Err(error) = started {
        shared.outbox.note(&format!("the folder could not be read: {error}"));
    }
}

fn session_of(shared: &Shared, job: &ClipJob) -> Option<Session> {
    let folder = job.session.clone().unwrap_or_else(|| shared.out.join(format!("{}.afs", job.id)));
    Session::open_read_only(&folder).ok().map(|(session, _)| session)
}

fn item(shared: &Shared, job: &ClipJob) -> QueueItem {
    let session = session_of(shared, job);
    let out = job.session.as_deref().and_then(Path::parent).unwrap_or(&shared.out);
    let (exported, flags) = match read_outcome(&out.join(&job.id)) {
        Ok(ClipState::Done(outcome)) => (true, outcome.flags),
        _ => (false, Vec::new()),
    };
    let clip_path = session.as_ref().map_or(&job.document.clip.path, |session| &session.document().clip.path);
    let fault = if job.session.is_some() && session.is_none() {
        Some("the session cannot be read".to_owned())
    } else if !Path::new(clip_path).is_file() {
        Some(format!("the video {clip_path} is not there"))
    } else {
        None
    };
    QueueItem {
        id: job.id.clone(),
        path: path_of(job),
        review: session.map_or(ReviewState::Unreviewed, |session| session.document().review.clone()),
        flags,
        exported,
        thumbnail: None,
        fault,
    }
}

/// The clip's first frame, small; `None` where it cannot be read.
fn thumbnail(path: &Path, rotate: Rotation) -> Option<Rgb8> {
    let turn = match rotate {
        Rotation::Deg0 => "",
        Rotation::Deg90 => "transpose=1,",
        Rotation::Deg180 => "hflip,vflip,",
        Rotation::Deg270 => "transpose=2,",
    };
    let Size { width, height } = THUMBNAIL;
    let filter =
        format!("{turn}scale={width}:{height}:force_original_aspect_ratio=increase,crop={width}:{height}");
    let output = Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-protocol_whitelist", "file,pipe", "-i"])
        .arg(path)
        .args(["-frames:v", "1", "-vf", &filter, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    Rgb8::from_data(THUMBNAIL, output.stdout)
}
