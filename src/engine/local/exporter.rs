//! The export of the open session: the batch's own run of one clip.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

use super::{listener::seconds_left, panic_text, scene::Shared, worker::told};
use crate::{
    engine::{Event, WorkFailure},
    pipeline::{ClipFailure, ClipJob, ExitCode, Listener, RunOptions, Stage, run_clip},
    session::Session,
};

struct ExportListener<'a> {
    shared: &'a Shared,
    began: Instant,
}

impl Listener for ExportListener<'_> {
    fn progress(&self, _stage: Stage, _done: usize, _total: usize, share: f64) {
        let left = seconds_left(self.began.elapsed().as_secs_f64(), 0.0, share);
        self.shared.tell(Event::ExportProgress { share, left });
    }

    fn note(&self, text: &str) {
        self.shared.outbox.note(text);
    }
}

/// Exports the session in `folder` on a thread of its own; one at a time.
pub(super) fn start(shared: &Arc<Shared>, job: ClipJob, folder: PathBuf) {
    if shared.exporting.swap(true, Ordering::Relaxed) {
        shared.outbox.note("the export is running already");
        return;
    }
    shared.export_cancel.store(false, Ordering::Relaxed);
    let here = Arc::clone(shared);
    let started = std::thread::Builder::new().name("export".to_owned()).spawn(move || {
        let result = export(&here, &job, &folder);
        here.exporting.store(false, Ordering::Relaxed);
        here.tell(Event::Exported(result));
    });
    if let Err(error) = started {
        shared.exporting.store(false, Ordering::Relaxed);
        let message = format!("the export could not be started: {error}; close other programs and try again");
        shared.tell(Event::Exported(Err(Some(WorkFailure { stage: None, message }))));
    }
}

fn export(shared: &Shared, job: &ClipJob, folder: &Path) -> Result<PathBuf, Option<WorkFailure>> {
    // What a manifest said about the object stands in the session once it was worked on.
    let known = Session::open_read_only(folder).is_ok_and(|(session, _)| session.document().object.is_some());
    let object = job.object.clone().filter(|_| !known);
    let job = ClipJob { session: Some(folder.to_owned()), object, ..job.clone() };
    let out = folder.parent().map_or_else(|| shared.out.clone(), Path::to_owned);
    let listener = ExportListener { shared, began: Instant::now() };
    let cancel: &AtomicBool = &shared.export_cancel;
    // The window goes on with this session: what was decoded stays.
    let options = RunOptions { keep_frames: true, ..RunOptions::default() };
    let run = catch_unwind(AssertUnwindSafe(|| {
        run_clip(&job, &out, &shared.installation, options, &listener, cancel)
    }));
    let run = run.unwrap_or_else(|panic| {
        Err(ClipFailure { stage: None, exit: ExitCode::Internal, message: panic_text(&*panic) })
    });
    match run {
        Ok(_) => Ok(out.join(&job.id)),
        Err(failure) if failure.exit == ExitCode::Cancelled => Err(None),
        Err(failure) => Err(Some(told(&failure))),
    }
}
