//! What can be said on the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::{eval::EvalArguments, models::ModelArguments, vlm::VlmArguments};
use crate::{pipeline::batch::Shard, retarget::Method};

/// Turns first-person video of human hands into demonstrations for a Unitree G1 with BrainCo hands
#[derive(Debug, Parser)]
#[command(
    name = "agenticfocus",
    version,
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    long_about = LONG_ABOUT,
    after_long_help = AFTER_HELP
)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) batch: BatchArguments,
    #[command(subcommand)]
    pub(super) verb: Option<Verb>,
}

const LONG_ABOUT: &str = "\
Turns first-person video of human hands into demonstrations for a Unitree G1 humanoid with BrainCo \
dexterous hands: finds the manipulated object, tracks object and arms, removes the human, restores the \
object from a clean frame, reconstructs both hands in 3-D, retargets them to the robot's arms and \
fingers, renders the robot and layers everything. Out come a mixed-reality video and a synchronised \
action/state record.";

const AFTER_HELP: &str = "\
Examples:
  agenticfocus demo
      A synthetic episode through the whole pipeline; needs nothing but the install.
  agenticfocus --batch kitchen.mp4 --out out
      One video. Its object is proposed from contact motion, and the clip is marked for review.
  agenticfocus --batch clips/manifest.toml --out out --jobs 2
      A list of clips with object prompts, intrinsics, hand tracks and parameters.
  agenticfocus --batch kitchen.mp4 --out out --vlm-url http://localhost:8000/v1 --vlm-model qwen2.5vl:7b
      The same, with the object proposed by a vision-language model that is shown up to four frames.
  agenticfocus --batch out/kitchen.afs --out final
      A session: every human edit in it is obeyed.
  agenticfocus --batch clips.jsonl --out out --shard 3/16
      The fourth of sixteen shards, chosen by the hash of each clip's id.
  agenticfocus export --format lerobot-v3 out --out dataset
      The finished clips of a batch as a LeRobot dataset; more clips are appended by the same line.

Manifest (TOML; JSON Lines takes the same keys, one clip a line):
  [[clip]]
  id = \"put\"                      output folder (default: the file's stem)
  path = \"put.mp4\"                relative to the manifest
  task = \"put the knife away\"
  rotate = 180                    clockwise degrees after decoding
  object = { label = \"knife\", frame = 0, box = [238, 138, 316, 226] }
                                  or points = [[x, y], ...], negative = [[x, y], ...];
                                  pixels as decoded, before rotate, on a frame of the source's rate
  camera = { fx = 248.8, fy = 248.8, cx = 228.0, cy = 128.0 }     or { hfov_deg = 60.0 }
  hands = { track = \"hands.npz\", length_mm = 187 }
  params = { beta = \"fit\", alpha = 0.5, T_offset = [0.0576, 0.0, 0.4299], R_cam = { pitch_deg = 47.6 } }
                                  also smoothing = \"zero_phase\", \"ema\" or \"none\", and
                                  wrist = { right = { roll_deg = 2.0, pitch_deg = -3.0, yaw_deg = 0.0 } },
                                  hole_dilation = 0.012 (share of the picture's width, default 0.009),
                                  method = \"ours\", or \"masquerade\" or \"do-as-i-do\" to compare with;
                                  shared_map = true gives masquerade our camera map
  vlm = { mode = \"live\", model = \"qwen2.5vl:7b\", profile = \"abs-xyxy\" }   each may be left out; not the address
  start = 1.0                     seconds
  end = 9.5

Output, one folder a clip:
  composite.mp4  record.npz  record.json  report.json  template.png  masks/  crops/  debug/
  with --layers also layers/{background,robot,object,front,composite}/, a PNG a frame
  done.json or failed.json, written last; a session beside it, CLIP_ID.afs

A killed run is started again with the same line: what is done is not done again, and the bytes are
those of an undisturbed run.

Exit codes:
  0 done   1 internal error   2 wrong usage   65 bad input   74 input/output error
  75 temporary failure   130 cancelled
A batch ends with the worst of its clips (0 < 65 < 75 < 74 < 1); one bad clip never stops the others.";

/// The batch flags.
#[derive(Debug, Args)]
pub(super) struct BatchArguments {
    /// Clips, sessions (.afs), folders, or manifests (.toml, .jsonl) to process
    #[arg(long, num_args = 1.., value_name = "INPUT", requires = "out")]
    pub(super) batch: Vec<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "DIR", requires = "batch")]
    pub(super) out: Option<PathBuf>,
    /// Clips processed at a time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(super) jobs: u16,
    /// Process only shard I of N, chosen by the hash of each clip's id
    #[arg(long, value_name = "I/N")]
    pub(super) shard: Option<Shard>,
    /// Write every frame's layers too, without loss, as pictures in layers/
    #[arg(long, requires = "batch")]
    pub(super) layers: bool,
    /// Retarget every clip by this method, whatever its session or manifest says: ours, masquerade or
    /// do-as-i-do
    #[arg(long, value_name = "METHOD", requires = "batch")]
    pub(super) method: Option<Method>,
    /// Print a JSON summary to standard output
    #[arg(long)]
    pub(super) json: bool,
    /// Go on where an earlier run stopped (always on; accepted for clarity)
    #[arg(long, hide_short_help = true)]
    pub(super) resume: bool,
    #[command(flatten)]
    pub(super) vlm: VlmArguments,
    #[command(flatten)]
    pub(super) models: ModelArguments,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(super) enum Verb {
    /// Make a synthetic episode, run the whole pipeline on it and report; needs nothing but the install
    Demo {
        /// Folder for the episode and the results
        #[arg(long, value_name = "DIR", default_value = "out/demo")]
        out: PathBuf,
        /// Seed of the episode
        #[arg(long, default_value_t = 3)]
        seed: u64,
        /// Frames of the episode, at 30 a second
        #[arg(long, value_name = "N")]
        frames: Option<u32>,
    },
    /// Make synthetic episodes with exact truth for every stage
    Synth {
        /// How many
        #[arg(long, value_name = "N", default_value_t = 1)]
        episodes: u32,
        /// Seed of the first; the others follow
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Frames of each, at 30 a second
        #[arg(long, value_name = "N")]
        frames: Option<u32>,
        /// Folder for the episodes
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Score every stage and the whole on synthetic truth, as a table or JSON
    Bench(BenchArguments),
    /// Turn finished clips into a dataset that trainers load
    ///
    /// IN are clips' output folders or whole output folders of batches. The dataset is made where DIR is
    /// missing and lengthened where it is there; a killed export is started again with the same line.
    /// Clips that failed are left out, and so are those a person rejected; the closing table names them.
    Export(ExportArguments),
    /// Make your own masks a person's edits of a session: COCO run lengths or DAVIS palette pictures
    ImportMasks(ImportMasksArguments),
    /// Compare retargeting methods on hand tracks: position error, smoothness, intervals, figures
    Eval(EvalArguments),
    /// Check or import a robot description
    Robot {
        #[command(subcommand)]
        verb: RobotVerb,
    },
    /// Open the operator's window (the program agenticfocus-ui)
    Ui {
        /// A clip, a session or a folder
        input: Option<PathBuf>,
        #[command(flatten)]
        models: ModelArguments,
    },
    /// Process one clip for a batch; it speaks JSON on standard input and output
    #[command(hide = true)]
    ClipWorker {
        /// Threads it may use
        #[arg(long, default_value_t = 1)]
        threads: usize,
        /// Keep decoded frames and the background in the session's cache
        #[arg(long)]
        keep_frames: bool,
        /// Write every frame's layers without loss
        #[arg(long)]
        layers: bool,
        #[command(flatten)]
        vlm: VlmArguments,
        #[command(flatten)]
        models: ModelArguments,
        /// The batch's output folder
        out: PathBuf,
    },
    /// Say what is installed, which back end each stage uses, and the command for what is missing
    Doctor {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        models: ModelArguments,
    },
    /// Show the state of every clip below an output folder
    Status {
        /// The output folder of a batch
        out: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
}

/// `export`.
#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// What the dataset is for
    #[arg(long, value_enum)]
    pub(super) format: ExportFormat,
    /// Folders of finished clips, or output folders of batches
    #[arg(value_name = "IN", required = true)]
    pub(super) inputs: Vec<PathBuf>,
    /// The dataset's folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Which thumb motor stands first: bending (the hardware's order), or as xr_teleoperate feeds them
    #[arg(long, value_enum, default_value = "hardware", value_name = "ORDER")]
    pub(super) brainco_thumb_order: ExportThumbOrder,
    /// Take clips that a person rejected, too
    #[arg(long)]
    pub(super) include_rejected: bool,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// `export --format`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ExportFormat {
    /// LeRobot v3.0
    #[value(name = "lerobot-v3")]
    LerobotV3,
    /// LeRobot v2.1 with GR00T's meta/modality.json
    #[value(name = "lerobot-v2.1")]
    LerobotV21,
    /// Episodes of Unitree's xr_teleoperate: JPEG pictures and data.json
    UnitreeJson,
    /// Masks as COCO annotations with run lengths
    Coco,
    /// Masks as DAVIS palette pictures: 1 the object, 2 arms, 3 both
    Davis,
}

/// `export --brainco-thumb-order`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum ExportThumbOrder {
    /// Thumb bends, ThumbAux swings
    Hardware,
    /// Exchanged
    #[value(name = "unitree_xr")]
    UnitreeXr,
}

/// `import-masks`.
#[derive(Debug, Args)]
pub(super) struct ImportMasksArguments {
    /// The session that is edited; every mask is a step that can be undone
    #[arg(long, value_name = "SESSION")]
    pub(super) session: PathBuf,
    /// A COCO file (.json), or a folder of DAVIS pictures named by frame numbers
    pub(super) masks: PathBuf,
    /// What the numbers count: frames of the 30 FPS timeline, as our exports do, or of the source video
    #[arg(long, value_enum, default_value = "timeline")]
    pub(super) frames: MaskNumbering,
    /// Label or category of the object
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) object_label: u32,
    /// Label or category of hands and arms
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(super) arms_label: u32,
    /// Label of pixels that belong to both (3 in our DAVIS exports)
    #[arg(long, value_name = "N")]
    pub(super) both_label: Option<u32>,
}

/// `import-masks --frames`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum MaskNumbering {
    /// The 30 FPS timeline
    Timeline,
    /// The source video
    Source,
}

/// `bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArguments {
    /// Seed of the first episode; those below 3100 may have been used for tuning
    #[arg(long, default_value_t = crate::synth::HELD_OUT_SEED)]
    pub(super) seed: u64,
    /// How many episodes
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub(super) episodes: u32,
    /// Print JSON: {"figures": {KEY: number, …}, "episodes": [{"seed": S, KEY: number, …}, …]}
    #[arg(long)]
    pub(super) json: bool,
    /// Leave out the comparison of memory between a 10 s and a 60 s clip
    #[arg(long)]
    pub(super) quick: bool,
    /// Keep episodes and results in this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
}

/// `robot check` and `robot import`.
#[derive(Debug, Subcommand)]
pub(super) enum RobotVerb {
    /// Report what a description holds, or the first thing that is wrong with it
    Check {
        /// The URDF file
        path: PathBuf,
    },
    /// Check, decimate and store a description, and make it the default robot
    Import {
        /// The URDF file
        path: PathBuf,
    },
}
