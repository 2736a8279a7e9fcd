//! Progress of a batch: bars with an ETA on a terminal, plain lines otherwise.

use std::{
    collections::BTreeMap,
    io::IsTerminal as _,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::{
    pipeline::{
        ExitCode,
        batch::{BatchEvent, WorkerMessage},
    },
    progress::Watch,
};

/// Between two plain lines about one clip.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Prints the events of a batch to standard error.
pub(super) struct BatchProgress {
    bars: Option<MultiProgress>,
    clips: Mutex<BTreeMap<String, ClipProgress>>,
}

struct ClipProgress {
    bar: Option<ProgressBar>,
    started: Instant,
    spoke: Instant,
}

impl BatchProgress {
    pub(super) fn new() -> Self {
        let bars = std::io::stderr().is_terminal().then(MultiProgress::new);
        Self { bars, clips: Mutex::new(BTreeMap::new()) }
    }

    pub(super) fn hear(&self, event: &BatchEvent<'_>) {
        match event {
            BatchEvent::Started(job) => self.start(&job.id),
            BatchEvent::Said(job, WorkerMessage::Progress { stage, done, total, share }) => {
                self.advance(&job.id, stage, *done, *total, *share);
            }
            BatchEvent::Said(job, WorkerMessage::Note { text }) => self.line(&format!("{}: {text}", job.id)),
            BatchEvent::Said(_, WorkerMessage::Finished { .. }) => {}
            BatchEvent::Ended(job, outcome) => {
                let message = outcome.message.as_ref().map(|m| format!(": {m}")).unwrap_or_default();
                let frames = match (outcome.exit, outcome.frames) {
                    (ExitCode::Done, Some(frames)) => format!(", {frames} frames"),
                    _ => String::new(),
                };
                let flags = match outcome.flags.as_slice() {
                    [] => String::new(),
                    flags => format!(" [{}]", flags.join(", ")),
                };
                self.end(&job.id);
                self.line(&format!("{}: {}{frames}{flags}{message}", job.id, outcome.exit.word()));
            }
        }
    }

    fn start(&self, id: &str) {
        let bar = self.bars.as_ref().map(|bars| {
            let bar = bars.add(ProgressBar::new(1000));
            if let Ok(style) =
                ProgressStyle::with_template("{prefix:20!} {bar:30} {percent:>3}% {eta:>4} {msg}")
            {
                bar.set_style(style);
            }
            bar.set_prefix(id.to_owned());
            bar
        });
        if bar.is_none() {
            self.line(&format!("{id}: started"));
        }
        let now = Instant::now();
        self.lock().insert(id.to_owned(), ClipProgress { bar, started: now, spoke: now });
    }

    fn advance(&self, id: &str, stage: &str, done: usize, total: usize, share: f64) {
        let mut clips = self.lock();
        let Some(clip) = clips.get_mut(id) else { return };
        if let Some(bar) = &clip.bar {
            bar.set_position((share * 1000.0) as u64);
            bar.set_message(format!("{stage} {done}/{total}"));
        } else if clip.spoke.elapsed() >= PLAIN_INTERVAL {
            clip.spoke = Instant::now();
            let left = clip.started.elapsed().as_secs_f64() * (1.0 - share) / share.max(1e-3);
            eprintln!("{id}: {stage} {done}/{total}, {:.0} %, about {left:.0} s left", share * 100.0);
        }
    }

    fn end(&self, id: &str) {
        if let Some(ClipProgress { bar: Some(bar), .. }) = self.lock().remove(id) {
            bar.finish_and_clear();
        }
    }

    fn line(&self, text: &str) {
        match &self.bars {
            // Printing above the bars fails only when standard error is gone.
            Some(bars) => bars.println(text).unwrap_or_default(),
            None => eprintln!("{text}"),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, ClipProgress>> {
        self.clips.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Progress of one piece of work: a bar on a terminal, one line otherwise.
pub(super) struct SimpleProgress<'a> {
    bar: Option<ProgressBar>,
    cancel: &'a AtomicBool,
}

impl<'a> SimpleProgress<'a> {
    pub(super) fn new(name: &str, cancel: &'a AtomicBool) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(1);
            if let Ok(style) = ProgressStyle::with_template("{prefix:20!} {bar:30} {pos}/{len} {eta:>4}") {
                bar.set_style(style);
            }
            bar.set_prefix(name.to_owned());
            bar
        });
        if bar.is_none() {
            eprintln!("{name}: started");
        }
        Self { bar, cancel }
    }
}

impl Watch for SimpleProgress<'_> {
    fn advance(&self, done: usize, total: usize) {
        if let Some(bar) = &self.bar {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Drop for SimpleProgress<'_> {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
