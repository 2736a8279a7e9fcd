//! `agenticfocus-ui`: the window on this machine, with the engine in this process.

use std::{
    env,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
    time::Instant,
};

use agenticfocus::{cli::ModelArguments, engine::LocalEngine, pipeline::Installation};
use agenticfocus_ui::{
    app::{NativeDialogs, OperatorApp, window_file},
    measure::Measure,
    renderer::RendererChoice,
    tour::Tour,
};
use clap::Parser;
use eframe::Renderer;

/// Curate clips: correct object, masks, template, hands and the robot's motion, and judge the result.
#[derive(Clone, Debug, Parser)]
#[command(name = "agenticfocus-ui", version)]
struct Arguments {
    /// A clip, a session (NAME.afs), a folder of clips, or a manifest
    input: Option<PathBuf>,

    /// Where sessions of opened clips and results go
    #[arg(long, value_name = "DIR", default_value = "sessions")]
    out: PathBuf,

    #[command(flatten)]
    models: ModelArguments,

    /// Go through all steps of the clip, save a picture of each in this folder, and end
    #[arg(long, value_name = "DIR", requires = "input")]
    screenshots: Option<PathBuf>,

    /// Measure how fast the window answers on the clip, print it, and end
    #[arg(long, requires = "input", conflicts_with = "screenshots")]
    measure: bool,

    /// What the window is drawn with
    #[arg(long, value_enum, default_value_t, hide_short_help = true)]
    renderer: RendererChoice,
}

fn main() -> ExitCode {
    let began = Instant::now();
    let arguments = Arguments::parse();
    let renderer = arguments.renderer.renderer();
    let mut run = open_window(&arguments, renderer, began);
    if run.is_err() && arguments.renderer == RendererChoice::Auto && renderer == Renderer::Glow {
        run = open_window(&arguments, Renderer::Wgpu, began);
    }
    match run {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "agenticfocus-ui: no window: {error}; a display and a Vulkan or OpenGL driver are needed"
            );
            ExitCode::from(1)
        }
    }
}

/// Opens the window and comes back when it was closed.
fn open_window(arguments: &Arguments, renderer: Renderer, began: Instant) -> eframe::Result {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("AgenticFocus")
            .with_app_id("agenticfocus")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([900.0, 600.0])
            .with_drag_and_drop(true),
        renderer,
        // Flat colours have no bands, and pictures are to be shown as they are.
        dithering: false,
        ..eframe::NativeOptions::default()
    };
    let arguments = arguments.clone();
    eframe::run_native(
        "AgenticFocus",
        options,
        Box::new(move |creation| {
            let context = creation.egui_ctx.clone();
            let waker = Arc::new(move || context.request_repaint());
            let demo = demo_session(&arguments.out);
            let installation = Installation { models: arguments.models.options(), ..Installation::locate() };
            let engine = LocalEngine::start(arguments.out, installation, waker);
            let mut app =
                OperatorApp::new(Box::new(engine), Box::<NativeDialogs>::default()).offering_demo(demo);
            // Pictures and figures must be the same everywhere: neither takes up nor leaves anything.
            let by_hand = arguments.screenshots.is_none() && !arguments.measure;
            let file = window_file(env::var_os("XDG_CONFIG_HOME"), env::var_os("HOME")).filter(|_| by_hand);
            if let Some(file) = file {
                app = app.remembering(file);
            }
            if let Some(input) = arguments.input {
                app.open(input);
            }
            let tour = arguments.screenshots.map(Tour::new);
            let measure = arguments.measure.then(|| Measure::new(began));
            Ok(Box::new(Window { app, tour, measure }))
        }),
    )
}

/// The session of the demo, where it was made: `agenticfocus demo` puts it in `out/demo`.
fn demo_session(out: &Path) -> Option<PathBuf> {
    [out, Path::new("out")]
        .map(|folder| folder.join("demo").join("episode.afs"))
        .into_iter()
        .find(|path| path.is_dir())
}

/// The app as eframe wants it.
struct Window {
    app: OperatorApp,
    tour: Option<Tour>,
    measure: Option<Measure>,
}

impl eframe::App for Window {
    fn raw_input_hook(&mut self, _ctx: &egui::Context, input: &mut egui::RawInput) {
        if let Some(measure) = &mut self.measure {
            measure.inject(input);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        if let Some(tour) = &mut self.tour {
            tour.walk(ui.ctx(), &mut self.app);
            if let Some(fault) = tour.fault.take() {
                eprintln!("agenticfocus-ui: {fault}");
            }
        }
        if let Some(measure) = &mut self.measure {
            measure.before(ui.ctx(), &mut self.app);
        }
        self.app.show(ui);
        if let Some(measure) = &mut self.measure {
            measure.after(&mut self.app);
        }
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.app.close();
    }
}
