//! How fast the window answers: a script in the real window, with the real engine, printed as a table.

use std::time::{Duration, Instant};

use agenticfocus::{
    clip::FrameIndex,
    session::{Command, RetargetSettings, Step},
};
use egui::{Context, Event, Modifiers, PointerButton, Pos2, RawInput, ViewportCommand, pos2};

use crate::{action::Action, app::OperatorApp, state::Work};

/// Repetitions of each measurement; the median is printed.
const TIMES: usize = 15;
/// How long anything may take.
const PATIENCE: Duration = Duration::from_secs(1800);

/// What is measured, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Probe {
    Work,
    Parameter,
    CachedStep,
    UncachedStep,
    Dab,
    End,
}

impl Probe {
    fn next(self) -> Self {
        match self {
            Self::Work => Self::Parameter,
            Self::Parameter => Self::CachedStep,
            Self::CachedStep => Self::UncachedStep,
            Self::UncachedStep => Self::Dab,
            Self::Dab | Self::End => Self::End,
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Work => "",
            Self::Parameter => "parameter change to new composite",
            Self::CachedStep => "step to a cached frame",
            Self::UncachedStep => "step to an uncached frame",
            Self::Dab => "brush dab to mask drawn",
            Self::End => "",
        }
    }
}

/// The script.
#[derive(Debug)]
pub struct Measure {
    began: Instant,
    first_frame: Option<Duration>,
    probe: Probe,
    asked: Option<Instant>,
    target: FrameIndex,
    taken: Vec<f64>,
    results: Vec<(&'static str, f64, f64)>,
    pointer: Option<Pos2>,
    last_frame: Option<Instant>,
    frames: Vec<f64>,
    /// Everything was said; the window takes a frame or two to close.
    printed: bool,
}

impl Measure {
    /// A script in a program that began then.
    pub fn new(began: Instant) -> Self {
        Self {
            began,
            first_frame: None,
            probe: Probe::Work,
            asked: None,
            target: FrameIndex(0),
            taken: Vec::new(),
            results: Vec::new(),
            pointer: None,
            last_frame: None,
            frames: Vec::new(),
            printed: false,
        }
    }

    /// Moves the pointer while dabs are measured.
    pub fn inject(&mut self, input: &mut RawInput) {
        let Some(at) = self.pointer.filter(|_| self.probe == Probe::Dab) else { return };
        input.events.push(Event::PointerMoved(at));
        if self.taken.is_empty() && self.asked.is_none() {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            input.events.push(Event::PointerButton { pos: at, button, pressed: true, modifiers });
        }
        self.asked = Some(Instant::now());
    }

    /// Goes on before a frame is drawn.
    pub fn before(&mut self, ctx: &Context, app: &mut OperatorApp) {
        ctx.request_repaint();
        self.time_frame();
        if self.began.elapsed() > PATIENCE {
            self.probe = Probe::End;
        }
        match self.probe {
            Probe::Work => {
                let done = app
                    .workspace()
                    .is_some_and(|workspace| workspace.work == Work::Idle && workspace.found.order.is_some());
                if done {
                    self.begin(Probe::Parameter, app);
                }
            }
            Probe::Parameter if self.asked.is_none() => {
                let alpha = if self.taken.len().is_multiple_of(2) { 0.35 } else { 0.65 };
                let settings = RetargetSettings { alpha: Some(alpha), ..RetargetSettings::default() };
                self.asked = Some(Instant::now());
                app.act(ctx, Action::Change(Command::SetRetarget(settings)));
                // Without the drawing in between: what the engine takes to answer.
                wait_for(app, |app| {
                    let asked = app.workspace().map(|workspace| (workspace.playhead, workspace.revision));
                    asked.is_none_or(|(frame, revision)| {
                        app.pictures().composite(frame, revision).is_some_and(|(_, exact)| exact)
                    })
                });
            }
            Probe::CachedStep | Probe::UncachedStep if self.asked.is_none() => {
                let count = app.workspace().map_or(1, |workspace| workspace.frame_count()) as u32;
                // Cached: there and back; uncached: a frame that nobody looked at yet.
                let step = if self.probe == Probe::CachedStep { 1 } else { 7 };
                self.target = match self.probe {
                    Probe::CachedStep => FrameIndex(self.taken.len() as u32 % 2),
                    _ => FrameIndex((self.target.0 + step) % count.max(1)),
                };
                self.asked = Some(Instant::now());
                app.act(ctx, Action::Seek(self.target));
                if self.probe == Probe::UncachedStep {
                    let target = self.target;
                    wait_for(app, |app| app.pictures().source(target).is_some());
                }
            }
            Probe::End => {
                if !std::mem::replace(&mut self.printed, true) {
                    self.print(app);
                }
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            _ => {}
        }
    }

    /// Goes on after a frame was drawn.
    pub fn after(&mut self, app: &mut OperatorApp) {
        if self.first_frame.is_none() {
            self.first_frame = Some(self.began.elapsed());
        }
        let Some(asked) = self.asked else { return };
        let shown = match self.probe {
            Probe::Parameter => app.workspace().is_some_and(|workspace| {
                let (frame, revision) = (workspace.playhead, workspace.revision);
                app.has_composite(frame, revision)
            }),
            Probe::CachedStep | Probe::UncachedStep => app.has_source(self.target),
            Probe::Dab => true,
            Probe::Work | Probe::End => false,
        };
        if !shown {
            return;
        }
        self.taken.push(asked.elapsed().as_secs_f64() * 1e3);
        self.asked = None;
        if let Some(at) = &mut self.pointer {
            *at += egui::vec2(3.0, 1.0);
        }
        // The first of each kind warms up.
        if self.taken.len() > TIMES {
            self.taken.remove(0);
            self.taken.sort_by(f64::total_cmp);
            let (median, worst) = (self.taken[TIMES / 2], self.taken[TIMES - 1]);
            self.results.push((self.probe.text(), median, worst));
            self.begin(self.probe.next(), app);
        }
    }

    fn time_frame(&mut self) {
        let now = Instant::now();
        if let Some(last) = self.last_frame.replace(now)
            && self.probe == Probe::Dab
        {
            self.frames.push((now - last).as_secs_f64() * 1e3);
        }
    }

    fn begin(&mut self, probe: Probe, app: &mut OperatorApp) {
        self.probe = probe;
        self.taken.clear();
        self.asked = None;
        let here = app.workspace().map_or(FrameIndex(0), |workspace| workspace.playhead);
        match probe {
            Probe::Parameter => app.look_at(here, Step::Composite),
            Probe::CachedStep | Probe::UncachedStep => app.look_at(FrameIndex(0), Step::Object),
            Probe::Dab => {
                app.look_at(here, Step::Masks);
                self.pointer = Some(pos2(600.0, 300.0));
            }
            Probe::Work | Probe::End => {}
        }
    }

    fn print(&mut self, app: &OperatorApp) {
        let size = app.workspace().and_then(|workspace| workspace.size());
        let size = size.map_or_else(String::new, |size| size.to_string());
        let start = self.first_frame.unwrap_or_default().as_secs_f64() * 1e3;
        self.frames.sort_by(f64::total_cmp);
        if let Some(middle) = self.frames.get(self.frames.len() / 2) {
            println!(
                "{:<36} {middle:>8.1} ms median, painting and showing included",
                "a frame of the window"
            );
        }
        println!("{:<36} {start:>8.1} ms", "start to usable window");
        for (text, median, worst) in std::mem::take(&mut self.results) {
            println!("{text:<36} {median:>8.1} ms median, {worst:>8.1} ms worst of {TIMES} ({size})");
        }
    }
}

/// Hears the engine, without drawing, until `done`.
fn wait_for(app: &mut OperatorApp, mut done: impl FnMut(&mut OperatorApp) -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !done(app) && Instant::now() < end {
        app.pump();
        std::thread::sleep(Duration::from_micros(300));
    }
}
