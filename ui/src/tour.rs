//! A walk through the window that takes a picture of every step: for the README and for the eyes of who builds it.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, mpsc},
    time::{Duration, Instant},
};

use agenticfocus::{clip::FrameIndex, session::Step};
use egui::{ColorImage, Context, ViewportCommand};

use crate::{app::OperatorApp, state::Work, theme::ThemeChoice};

/// How long pictures and layout may settle before the window is taken.
const SETTLE: Duration = Duration::from_millis(1500);
/// How long they are waited for where a message stays.
const LONGEST: Duration = Duration::from_secs(8);
/// How long the clip may take to be worked out.
const PATIENCE: Duration = Duration::from_secs(1800);

/// Where the walk is.
#[derive(Debug)]
enum Place {
    /// Waiting until the clip is worked out.
    Working,
    /// A step is on screen since then.
    Settling(Instant),
    /// The picture was asked for.
    Asked(mpsc::Receiver<Arc<ColorImage>>),
}

/// The walk.
#[derive(Debug)]
pub struct Tour {
    folder: PathBuf,
    stops: Vec<(ThemeChoice, Step)>,
    at: usize,
    place: Place,
    began: Instant,
    /// Why it ended early.
    pub fault: Option<String>,
}

impl Tour {
    /// A walk whose pictures go to `folder`.
    pub fn new(folder: PathBuf) -> Self {
        let stops = [ThemeChoice::Dark, ThemeChoice::Light]
            .into_iter()
            .flat_map(|theme| Step::ALL.into_iter().map(move |step| (theme, step)))
            .collect();
        Self { folder, stops, at: 0, place: Place::Working, began: Instant::now(), fault: None }
    }

    /// Goes on with the walk; call it once a frame.
    pub fn walk(&mut self, ctx: &Context, app: &mut OperatorApp) {
        ctx.request_repaint_after(Duration::from_millis(50));
        match &self.place {
            Place::Working => {
                let Some(workspace) = app.workspace() else {
                    match app.messages().last() {
                        Some(message) if !app.is_opening() => self.end(ctx, Some(message.text.clone())),
                        _ => self.check_patience(ctx),
                    }
                    return;
                };
                match &workspace.work {
                    Work::Failed(failure) => self.end(ctx, Some(failure.message.clone())),
                    Work::Idle if workspace.found.order.is_some() => self.show(app),
                    _ => self.check_patience(ctx),
                }
            }
            Place::Settling(since) if settled(*since, app) => {
                let (sender, receiver) = mpsc::channel();
                ctx.request_screenshot(move |picture| {
                    // Nobody waits any more only when the window closes.
                    sender.send(picture).ok();
                });
                self.place = Place::Asked(receiver);
            }
            Place::Settling(_) => {}
            Place::Asked(receiver) => {
                let Ok(picture) = receiver.try_recv() else { return };
                let (theme, step) = self.stops[self.at];
                let name = format!("{step:?}_{theme:?}.png").to_lowercase();
                if let Err(error) = write_png(&self.folder.join(&name), &picture) {
                    return self.end(ctx, Some(format!("{name} not written: {error}")));
                }
                self.at += 1;
                if self.at == self.stops.len() { self.end(ctx, None) } else { self.show(app) }
            }
        }
    }

    fn show(&mut self, app: &mut OperatorApp) {
        let (theme, step) = self.stops[self.at];
        let middle = app.workspace().map_or(0, |workspace| workspace.frame_count() / 2);
        app.look_at(FrameIndex(middle as u32), step);
        app.options_mut().theme = theme;
        self.place = Place::Settling(Instant::now());
    }

    fn check_patience(&mut self, ctx: &Context) {
        if self.began.elapsed() > PATIENCE {
            self.end(ctx, Some("the clip was not worked out in time".to_owned()));
        }
    }

    fn end(&mut self, ctx: &Context, fault: Option<String>) {
        self.fault = fault;
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }
}

/// Whether the window stands still: pictures are there, and what the engine mentions by the way has gone.
fn settled(since: Instant, app: &OperatorApp) -> bool {
    since.elapsed() > SETTLE && (app.messages().is_empty() || since.elapsed() > LONGEST)
}

fn write_png(path: &Path, picture: &ColorImage) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, picture.size[0] as u32, picture.size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let pixels: Vec<u8> = picture.pixels.iter().flat_map(|pixel| [pixel.r(), pixel.g(), pixel.b()]).collect();
    let mut writer = encoder.write_header().map_err(std::io::Error::other)?;
    writer.write_image_data(&pixels).map_err(std::io::Error::other)
}
