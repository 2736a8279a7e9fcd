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
    session::{ClipReference, ReviewState, Session},
};

/// Thumbnails of the queue, pixels.
const THUMBNAIL: Size = Size::new(96, 54);

/// What is opened for `job`.
pub(super) fn path_of(job: &ClipJob) -> PathBuf {
    job.session.clone().unwrap_or_else(|| PathBuf::from(&job.document.clip.path))
}

/// Tells the clips at once and their pictures as they are read, on a thread of its own.
pub(super) fn start(shared: &Arc<Shared>, path: PathBuf, jobs: Vec<ClipJob>) {
    let here = Arc::clone(shared);
    let started = std::thread::Builder::new().name("survey".to_owned()).spawn(move || {
        let (items, clips): (Vec<_>, Vec<_>) = jobs.iter().map(|job| item(&here, job)).unzip();
        let paths: Vec<PathBuf> = items.iter().map(|item: &QueueItem| item.path.clone()).collect();
        here.tell(Event::Queue { path: path.clone(), items });
        for (item, clip) in paths.into_iter().zip(clips) {
            if here.is_stopping() {
                return;
            }
            if let Some(picture) = thumbnail(Path::new(&clip.path), clip.rotate).map(Arc::new) {
                here.tell(Event::QueueThumbnail { path: path.clone(), item, picture });
            }
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

/// A row of the queue, without its picture, and the clip it is about.
fn item(shared: &Shared, job: &ClipJob) -> (QueueItem, ClipReference) {
    let session = session_of(shared, job);
    let document = session.as_ref().map_or(&job.document, Session::document);
    let out = job.session.as_deref().and_then(Path::parent).unwrap_or(&shared.out);
    let (exported, flags) = match read_outcome(&out.join(&job.id)) {
        Ok(ClipState::Done(outcome)) => (true, outcome.flags),
        _ => (false, Vec::new()),
    };
    let fault = if job.session.is_some() && session.is_none() {
        Some("the session cannot be read".to_owned())
    } else if !Path::new(&document.clip.path).is_file() {
        Some(format!("the video {} is not there", document.clip.path))
    } else {
        None
    };
    let review = if session.is_some() { document.review.clone() } else { ReviewState::Unreviewed };
    let item =
        QueueItem { id: job.id.clone(), path: path_of(job), review, flags, exported, thumbnail: None, fault };
    (item, document.clip.clone())
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
