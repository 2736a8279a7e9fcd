//! `agenticfocus eval`: retargeting methods compared on hand tracks.

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::Args;

use super::{Failure, Outcome, batch::cancel_on_signals, progress::SimpleProgress};
use crate::{
    evaluate::{
        metrics::Alignment,
        study::{
            self, Setting, Sources, Study, StudyError, StudyParams, Summary, Sweep, draw_figures,
            find_sources, frontier, report_json, summary, to_csv, to_html, to_table,
        },
    },
    pipeline::{ExitCode, Installation},
    progress::Watch,
    retarget::Method,
    robot::RobotModel,
    session::write_durably,
};

/// Settings that show the trade-off of smoothing where no sweep is asked for: the published average and its zero-phase
/// form over α, and steadier wrists.
const TRADEOFF: [&str; 3] = [
    "smoothing=ema,alpha=0.2/0.35/0.5/0.7",
    "smoothing=zero_phase,alpha=0.2/0.5",
    "smoothing=zero_phase,across=1.5/2/3/5,depth=1.5",
];
/// First of the seeds that were never tuned on.
const UNTUNED_SEED: u64 = 5000;
/// Methods of one study.
const MOST_METHODS: usize = 8;

/// `eval`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  agenticfocus eval --synthetic 75 --seed 5000 --out out/eval
      Ours and both baselines on 75 synthetic episodes with truth, in under a minute.
  agenticfocus eval out/kitchen tracks/*.npz --out out/eval
      On finished clips and on hand tracks of any origin: .npz or .json, see models/README.md.
  agenticfocus eval --synthetic 40 --seed 1 --sweep alpha=0.1..0.9,beta=fit --out out/sweep
      The frontier between error and smoothness. Tune on seeds below 5000, report on others.

Written: report.html (all in one file), report.json, episodes.csv, and the figures position_error,
sparc_episodes, sparc and tradeoff, each .svg and .png.")]
pub(super) struct EvalArguments {
    /// Finished clips (folders with record.npz), hand tracks (.npz, .json), or folders with any of them
    #[arg(value_name = "DIR")]
    inputs: Vec<PathBuf>,
    /// Synthetic episodes: motion with truth, tracks with an estimator's errors, no pictures
    #[arg(long, value_name = "N", default_value_t = 0)]
    synthetic: u32,
    /// Seed of the first synthetic episode; those below 5000 may have been used for tuning
    #[arg(long, default_value_t = UNTUNED_SEED)]
    seed: u64,
    /// Frames of each synthetic episode, at 30 a second
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Folder for the report
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A method to compare (may be given several times; default: all): ours, masquerade, do-as-i-do
    #[arg(long = "method", value_name = "METHOD")]
    methods: Vec<Method>,
    /// Give the baselines our camera map instead of their own scale
    #[arg(long)]
    shared_map: bool,
    /// Settings of our method to try, for example alpha=0.1..0.9,beta=fit,smoothing=ema/zero_phase; also across and
    /// depth, the cut-offs of the wrist's smoother in Hz
    #[arg(long, value_name = "SPEC")]
    sweep: Option<Sweep>,
    /// Fit every path onto the human's before its error is taken; hides constant errors
    #[arg(long, value_enum, default_value_t = AlignmentName::None)]
    align: AlignmentName,
    /// Threads; the result does not depend on it (default: all cores)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print report.json to standard output
    #[arg(long)]
    json: bool,
}

/// [`Alignment`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum AlignmentName {
    None,
    Rigid,
    Similarity,
}

impl From<AlignmentName> for Alignment {
    fn from(name: AlignmentName) -> Self {
        match name {
            AlignmentName::None => Self::None,
            AlignmentName::Rigid => Self::Rigid,
            AlignmentName::Similarity => Self::Similarity,
        }
    }
}

pub(super) fn run(arguments: &EvalArguments) -> Outcome {
    let cancel = cancel_on_signals()?;
    if arguments.inputs.is_empty() && arguments.synthetic == 0 {
        return Err(failed(&StudyError::NoEpisodes));
    }
    let mut sources = find_sources(&arguments.inputs).map_err(|error| failed(&error.into()))?;
    sources.add_synthetic(arguments.synthetic, arguments.seed, arguments.frames);
    let robot = default_robot()?;
    let threads = usize::from(arguments.threads.unwrap_or(0));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Failure::new(ExitCode::Internal, error))?;
    let params = StudyParams { alignment: arguments.align.into(), ..StudyParams::default() };
    let make = |settings: &[Setting], watch: &dyn Watch| {
        pool.install(|| study::run(&sources, settings, &robot, params, watch)).map_err(|error| failed(&error))
    };
    let settings = methods(arguments)?;
    let progress = SimpleProgress::new("eval", &cancel);
    let compared = make(&settings, &progress)?;
    drop(progress);
    let progress = SimpleProgress::new("sweep", &cancel);
    let swept = make(&arguments.sweep.as_ref().map_or_else(tradeoff, Sweep::settings), &progress)?;
    drop(progress);
    let figures = (summary(&compared), summary(&swept));
    let report = write_report(arguments, &sources, (&compared, &figures.0), (&swept, &figures.1))?;
    if arguments.json {
        println!("{report:#}");
        return Ok(ExitCode::Done);
    }
    print!("{}", to_table(&compared, &figures.0, None));
    if arguments.sweep.is_some() {
        println!("\nsweep; nothing beats settings with * in both error and sal");
        print!("{}", to_table(&swept, &figures.1, Some(&frontier(&figures.1))));
    }
    println!("{}", arguments.out.join("report.html").display());
    Ok(ExitCode::Done)
}

fn methods(arguments: &EvalArguments) -> Result<Vec<Setting>, Failure> {
    let chosen = if arguments.methods.is_empty() { &Method::ALL[..] } else { &arguments.methods };
    if chosen.len() > MOST_METHODS || chosen.iter().any(|m| chosen.iter().filter(|n| *n == m).count() > 1) {
        return Err(Failure::new(ExitCode::Usage, "--method: expected each method once"));
    }
    let setting = |method: &Method| {
        let mut setting = Setting::of_method(*method);
        setting.params.shared_map = arguments.shared_map;
        setting
    };
    Ok(chosen.iter().map(setting).collect())
}

/// The settings of the figure where no sweep is asked for.
fn tradeoff() -> Vec<Setting> {
    TRADEOFF.iter().filter_map(|text| text.parse::<Sweep>().ok()).flat_map(|sweep| sweep.settings()).collect()
}

/// Writes all files, `report.json` last.
fn write_report(
    arguments: &EvalArguments,
    sources: &Sources,
    compared: (&Study, &Summary),
    swept: (&Study, &Summary),
) -> Result<serde_json::Value, Failure> {
    let out = &arguments.out;
    let internal = |error: &dyn std::fmt::Display| Failure::new(ExitCode::Internal, error);
    fs::create_dir_all(out).map_err(|error| unwritten(out, &error))?;
    let write = |name: &str, bytes: &[u8]| {
        let path = out.join(name);
        write_durably(&path, bytes).map_err(|error| unwritten(&path, &error))
    };
    let figures = draw_figures(compared.0, compared.1, Some(swept)).map_err(|error| internal(&error))?;
    for figure in &figures {
        write(&format!("{}.svg", figure.name), figure.svg.as_bytes())?;
        write(&format!("{}.png", figure.name), &figure.png)?;
    }
    write("episodes.csv", to_csv(compared.0).as_bytes())?;
    let drawn: Vec<(&str, &str, String)> =
        figures.into_iter().map(|figure| (figure.title, figure.caption, figure.svg)).collect();
    write("report.html", to_html(compared.0, compared.1, &drawn).as_bytes())?;
    let mut report = report_json(compared.0, compared.1, sources);
    report["sweep"] = study::sweep_json(swept.0, swept.1);
    let text = serde_json::to_string_pretty(&report).map_err(|error| internal(&error))?;
    write("report.json", format!("{text}\n").as_bytes())?;
    Ok(report)
}

fn unwritten(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(ExitCode::from(error), format!("cannot write {}: {error}", path.display()))
}

fn failed(error: &StudyError) -> Failure {
    let exit = match error {
        StudyError::NoEpisodes | StudyError::NoSettings => ExitCode::Usage,
        StudyError::Source(source) if source.is_bad_input() => ExitCode::BadInput,
        StudyError::Source(_) => ExitCode::InputOutput,
        StudyError::Retarget { .. } => ExitCode::Internal,
        StudyError::Cancelled(_) => ExitCode::Cancelled,
    };
    Failure::new(exit, error)
}

/// The robot that was imported as the default, else the embedded one.
fn default_robot() -> Result<RobotModel, Failure> {
    let imported = crate::robot::default_robot(&Installation::locate().data)
        .map_err(|error| Failure::new(ExitCode::BadInput, error))?;
    match imported {
        Some(robot) => Ok(robot),
        None => RobotModel::embedded().map_err(|error| Failure::new(ExitCode::Internal, error)),
    }
}
