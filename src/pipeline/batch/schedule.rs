//! Runs jobs in worker processes, a few at a time.

use std::{
    collections::VecDeque,
    io::{self, BufRead as _, BufReader, Write as _},
    path::PathBuf,
    process::{Child, ChildStderr, Command, Stdio},
    sync::{Mutex, PoisonError, atomic::AtomicBool, atomic::Ordering},
    thread,
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};

use super::{ClipOutcome, ClipState, read_outcome, write_failure};
use crate::pipeline::{ClipJob, ExitCode};

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct BatchOptions {
    /// Where the clips' folders go.
    pub out: PathBuf,
    /// Clips at a time, at least 1 (default: 1; a clip uses several cores itself).
    pub jobs: usize,
    /// The program that does one clip: it reads a [`ClipJob`] as JSON from standard input and writes
    /// [`WorkerMessage`] lines.
    pub worker: PathBuf,
    /// Arguments of the worker before the output folder.
    pub worker_arguments: Vec<String>,
}

/// What a worker says while it works, one JSON object a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "message")]
pub enum WorkerMessage {
    /// A stage goes on.
    Progress {
        /// The stage.
        stage: String,
        /// Steps done.
        done: usize,
        /// Of these.
        total: usize,
        /// Share of the whole clip that is done, 0 to 1.
        share: f64,
    },
    /// Something worth a line.
    Note {
        /// The line.
        text: String,
    },
    /// It is over; the outcome is on disk.
    Finished {
        /// How.
        outcome: Box<ClipOutcome>,
        /// Whether the result was there already.
        skipped: bool,
        /// Largest resident size of the worker and its largest child together, where known.
        peak_memory_mib: Option<f64>,
    },
}

/// What the caller of a batch hears.
#[derive(Debug)]
pub enum BatchEvent<'a> {
    /// A clip begins.
    Started(&'a ClipJob),
    /// A clip's worker says something.
    Said(&'a ClipJob, &'a WorkerMessage),
    /// A clip is over.
    Ended(&'a ClipJob, &'a ClipOutcome),
}

/// How a batch ended.
#[derive(Clone, Debug, Serialize)]
pub struct BatchSummary {
    /// The worst of the clips.
    pub exit: ExitCode,
    /// Outcomes in the order of the jobs.
    pub clips: Vec<ClipOutcome>,
    /// Wall time in seconds.
    pub seconds: f64,
}

/// Runs all jobs. One clip's failure never stops the others; a raised `cancel` stops all.
///
/// # Errors
/// When the output folder cannot be made or an outcome cannot be written.
pub fn run_batch(
    jobs: &[ClipJob],
    options: &BatchOptions,
    cancel: &AtomicBool,
    listen: &(dyn Fn(BatchEvent<'_>) + Sync),
) -> io::Result<BatchSummary> {
    let start = Instant::now();
    std::fs::create_dir_all(&options.out)?;
    let queue: Mutex<VecDeque<usize>> = Mutex::new((0..jobs.len()).collect());
    let results: Mutex<Vec<Option<io::Result<ClipOutcome>>>> =
        Mutex::new(jobs.iter().map(|_| None).collect());
    thread::scope(|scope| {
        for _ in 0..options.jobs.clamp(1, jobs.len().max(1)) {
            scope.spawn(|| {
                while let Some(index) = lock(&queue).pop_front() {
                    let job = &jobs[index];
                    let outcome = run_one(job, options, cancel, listen);
                    if let Ok(outcome) = &outcome {
                        listen(BatchEvent::Ended(job, outcome));
                    }
                    lock(&results)[index] = Some(outcome);
                }
            });
        }
    });
    let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    let clips = results.into_iter().flatten().collect::<io::Result<Vec<_>>>()?;
    let exit = clips.iter().map(|clip| clip.exit).max().unwrap_or(ExitCode::Done);
    Ok(BatchSummary { exit, clips, seconds: start.elapsed().as_secs_f64() })
}

/// A panic in another thread leaves plain data behind: it stays usable.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn run_one(
    job: &ClipJob,
    options: &BatchOptions,
    cancel: &AtomicBool,
    listen: &(dyn Fn(BatchEvent<'_>) + Sync),
) -> io::Result<ClipOutcome> {
    if cancel.load(Ordering::Relaxed) {
        return Ok(failure(job, ExitCode::Cancelled, "cancelled before it began".to_owned()));
    }
    listen(BatchEvent::Started(job));
    let folder = options.out.join(&job.id);
    let mut child = spawn(job, options)?;
    let (finished, last) = converse(job, &mut child, cancel, listen);
    let status = child.wait()?;
    if let Some(outcome) = finished {
        return Ok(outcome);
    }
    if cancel.load(Ordering::Relaxed) {
        return Ok(failure(job, ExitCode::Cancelled, "cancelled".to_owned()));
    }
    // No last word: the worker crashed. Unless it had finished before, that is a mistake of ours.
    if let (true, ClipState::Done(outcome)) = (status.success(), read_outcome(&folder)?) {
        return Ok(outcome);
    }
    let outcome = failure(job, ExitCode::Internal, format!("the worker ended with {status}: {last}"));
    write_failure(&folder, &outcome)?;
    Ok(outcome)
}

fn spawn(job: &ClipJob, options: &BatchOptions) -> io::Result<Child> {
    let mut child = Command::new(&options.worker)
        .args(&options.worker_arguments)
        .arg(&options.out)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let text = serde_json::to_vec(job).map_err(io::Error::other)?;
    if let Some(mut stdin) = child.stdin.take() {
        // A worker that died at once is reported by its exit, not by the broken pipe.
        match stdin.write_all(&text) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => return Err(error),
            _ => {}
        }
    }
    Ok(child)
}

/// Passes a worker's messages on until it closes its output; returns its outcome and the last line
/// it wrote to standard error, which explains a crash.
fn converse(
    job: &ClipJob,
    child: &mut Child,
    cancel: &AtomicBool,
    listen: &(dyn Fn(BatchEvent<'_>) + Sync),
) -> (Option<ClipOutcome>, String) {
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let mut finished = None;
    let mut last = "no message".to_owned();
    let over = AtomicBool::new(false);
    thread::scope(|scope| {
        // Drained beside the messages: a full pipe would stop the worker.
        let errors = scope.spawn(move || last_line(stderr));
        scope.spawn(|| stop_when_cancelled(child, cancel, &over));
        for line in stdout.into_iter().flat_map(|out| BufReader::new(out).lines().map_while(Result::ok)) {
            let Ok(message) = serde_json::from_str::<WorkerMessage>(&line) else { continue };
            listen(BatchEvent::Said(job, &message));
            if let WorkerMessage::Finished { outcome, .. } = message {
                finished = Some(*outcome);
            }
        }
        over.store(true, Ordering::Relaxed);
        if let Ok(Some(line)) = errors.join() {
            last = line;
        }
    });
    (finished, last)
}

fn last_line(stderr: Option<ChildStderr>) -> Option<String> {
    let lines = BufReader::new(stderr?).split(b'\n').map_while(Result::ok);
    let lines =
        lines.map(|bytes| String::from_utf8_lossy(&bytes).trim().chars().take(500).collect::<String>());
    lines.filter(|line| !line.is_empty()).last()
}

/// Asks a cancelled worker to stop; it has five seconds to tidy up.
fn stop_when_cancelled(child: &mut Child, cancel: &AtomicBool, over: &AtomicBool) {
    let mut asked: Option<Instant> = None;
    while !over.load(Ordering::Relaxed) {
        if cancel.load(Ordering::Relaxed) {
            let since = asked.get_or_insert_with(|| {
                terminate(child.id());
                Instant::now()
            });
            if since.elapsed() > Duration::from_secs(5) {
                // Killing what has just ended is not an error.
                child.kill().ok();
            }
        }
        thread::sleep(Duration::from_millis(50));
    }
}

fn terminate(id: u32) {
    if let Some(pid) = i32::try_from(id).ok().and_then(rustix::process::Pid::from_raw) {
        // A worker that has just ended cannot be asked any more; that is what was wanted.
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).ok();
    }
}

fn failure(job: &ClipJob, exit: ExitCode, message: String) -> ClipOutcome {
    ClipOutcome {
        id: job.id.clone(),
        exit,
        stage: None,
        message: Some(message),
        inputs: String::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        frames: None,
        flags: Vec::new(),
    }
}
