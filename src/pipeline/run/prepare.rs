//! The session of a job: opened where there is one, created where there is none.

use std::{fs, path::Path};

use crate::{
    pipeline::{ClipFailure, ClipJob, Listener},
    session::{Author, Command, Session, SessionError},
};

/// Opens or creates the job's session and brings it up to what the manifest says now.
pub(crate) fn open_session(
    job: &ClipJob,
    out: &Path,
    listener: &dyn Listener,
) -> Result<Session, ClipFailure> {
    if let Some(folder) = &job.session {
        return open(folder, listener);
    }
    let folder = out.join(format!("{}.afs", job.id));
    if !folder.join("journal.jsonl").exists() {
        return Ok(Session::create(&folder, job.document.clone())?);
    }
    let mut session = open(&folder, listener)?;
    let (old, new) = (&session.initial_document().clip, &job.document.clip);
    let same_clip =
        (&old.path, old.rotate, old.start, old.end) == (&new.path, new.rotate, new.start, new.end);
    if !same_clip {
        if session.human_edits() > 0 {
            return Err(ClipFailure::bad_input(format_args!(
                "{} holds a person's edits of {}: move it away, or give this clip another id",
                folder.display(),
                old.path
            )));
        }
        drop(session);
        fs::remove_dir_all(&folder)?;
        return Ok(Session::create(&folder, job.document.clone())?);
    }
    follow_manifest(&mut session, job)?;
    Ok(session)
}

/// Opens `folder` for writing, or for reading while somebody else writes to it.
fn open(folder: &Path, listener: &dyn Listener) -> Result<Session, ClipFailure> {
    let (session, report) = match Session::open(folder) {
        Err(SessionError::Locked(holder)) => {
            listener.note(&format!("the session is open in {holder}: it is only read here"));
            Session::open_read_only(folder)?
        }
        other => other?,
    };
    if report.torn_bytes > 0 {
        listener.note("the session's last command was torn and never acknowledged: dropped");
    }
    Ok(session)
}

/// Settings that the manifest changed since it made the session, except where a person set them.
fn follow_manifest(session: &mut Session, job: &ClipJob) -> Result<(), ClipFailure> {
    let (initial, wanted) = (session.initial_document().clone(), &job.document);
    let now = session.document().clone();
    let untouched = session.human_edits() == 0;
    let mut commands = Vec::new();
    if wanted.task != now.task && (untouched || now.task == initial.task) {
        commands.push(Command::SetTask(wanted.task.clone()));
    }
    if wanted.camera != now.camera && (untouched || now.camera == initial.camera) {
        commands.push(Command::SetCamera(wanted.camera));
    }
    if wanted.hand_track != now.hand_track && (untouched || now.hand_track == initial.hand_track) {
        commands.push(Command::SetHandTrack(wanted.hand_track.clone()));
    }
    if wanted.hole_dilation != now.hole_dilation && (untouched || now.hole_dilation == initial.hole_dilation)
    {
        commands.push(Command::SetHoleDilation(wanted.hole_dilation));
    }
    if wanted.retarget != now.retarget && (untouched || now.retarget == initial.retarget) {
        commands.push(Command::SetRetarget(wanted.retarget));
    }
    if !commands.is_empty() && session.is_writable() {
        session.apply(Author::Manifest, Command::Together(commands))?;
    }
    Ok(())
}
