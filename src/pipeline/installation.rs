//! Where the parts that are not Rust lie, and whether they work.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use serde::Serialize;

use super::{
    ModelOptions, ModelReport,
    learned::{Findings, backend},
};
use crate::{
    hands::network::HAND_POSE,
    inpaint::{network::IMAGE_INPAINT, video::VIDEO_INPAINT},
    render::{self, DeviceChoice},
    segment::sam2::SAM2_VIDEO,
    select::vlm::{VlmPlan, VlmSettings, VlmWish},
};

/// The parts the pipeline finds at run time.
#[derive(Clone, Debug)]
pub struct Installation {
    /// `.deps/`, filled by `make setup`.
    pub dependencies: PathBuf,
    /// The user's data folder: imported robots, model weights.
    pub data: PathBuf,
    /// The vision-language model that may be asked for objects.
    pub vlm: VlmSettings,
    /// Which learned models may be used.
    pub models: ModelOptions,
    /// Models that were looked for already.
    pub findings: Findings,
}

/// One part as `doctor` shows it.
#[derive(Clone, Debug, Serialize)]
pub struct PartReport {
    /// What it is.
    pub name: &'static str,
    /// Version and place; `None` when it is missing or does not work.
    pub found: Option<String>,
    /// What it is for.
    pub purpose: &'static str,
    /// The command that installs it.
    pub remedy: &'static str,
    /// Whether the pipeline cannot run without it.
    pub required: bool,
}

/// The back end a stage would use.
#[derive(Clone, Debug, Serialize)]
pub struct StageBackend {
    /// The stage.
    pub stage: &'static str,
    /// Its back end.
    pub backend: String,
}

impl Installation {
    /// Looks beside the program, in the working folder and where the program was built.
    pub fn locate() -> Self {
        let beside = std::env::current_exe().ok().and_then(|path| path.parent().map(Path::to_owned));
        let candidates = [
            beside.map(|folder| folder.join(".deps")),
            Some(PathBuf::from(".deps")),
            Some(Path::new(env!("CARGO_MANIFEST_DIR")).join(".deps")),
        ];
        let found = candidates.into_iter().flatten().find(|folder| folder.is_dir());
        let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/share"));
        let data = std::env::var_os("XDG_DATA_HOME").map(PathBuf::from).or_else(home).unwrap_or_default();
        Self {
            dependencies: found.unwrap_or_else(|| PathBuf::from(".deps")),
            data: data.join("agenticfocus"),
            vlm: VlmSettings::from_environment(|name| std::env::var(name).ok()),
            models: ModelOptions::default(),
            findings: Findings::default(),
        }
    }

    /// The Python interpreter of the shipped hand estimator.
    pub fn estimator_python(&self) -> PathBuf {
        self.dependencies.join("venv/bin/python")
    }

    /// Where `libonnxruntime` is expected.
    pub fn onnx_runtime(&self) -> PathBuf {
        self.dependencies.join("onnxruntime/libonnxruntime.so.1.31.1")
    }

    /// Tries every part.
    pub fn examine(&self) -> Vec<PartReport> {
        let python = self.estimator_python();
        let script = "import mediapipe; mediapipe.solutions.hands; print('MediaPipe', mediapipe.__version__)";
        let runtime =
            self.runtime().map(|_| format!("ONNX Runtime 1.31.1, {}", self.onnx_runtime().display()));
        vec![
            PartReport {
                name: "ffmpeg",
                found: first_line(Command::new("ffmpeg").arg("-version")),
                purpose: "reading and writing video",
                remedy: "sudo apt-get install ffmpeg",
                required: true,
            },
            PartReport {
                name: "ffprobe",
                found: first_line(Command::new("ffprobe").arg("-version")),
                purpose: "reading video",
                remedy: "sudo apt-get install ffmpeg",
                required: true,
            },
            PartReport {
                name: "off-screen OpenGL",
                found: render::describe_device(DeviceChoice::Auto).ok(),
                purpose: "rendering the robot",
                remedy: "sudo apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri",
                required: true,
            },
            PartReport {
                name: "hand estimator",
                found: first_line(Command::new(python).args(["-c", script])),
                purpose: "finding hands (not needed with imported hand tracks)",
                remedy: "make setup",
                required: false,
            },
            PartReport {
                name: "ONNX Runtime",
                found: runtime.ok(),
                purpose: "learned back ends",
                remedy: "make setup",
                required: false,
            },
        ]
    }

    /// Who proposes objects.
    fn selector(&self) -> String {
        let contact = "contact motion (a manifest's or operator's prompt wins)";
        match self.vlm.plan(&VlmWish::default()) {
            Ok(VlmPlan::Ask(server)) => {
                format!("{} at {}, beside {contact}", server.backend(), server.url.host())
            }
            Ok(_) => contact.to_owned(),
            Err(error) => format!("{contact}; no model: {error}"),
        }
    }

    /// Which back end each stage would use with the parts and the models that were found.
    pub fn stage_backends(&self, parts: &[PartReport], models: &[ModelReport]) -> Vec<StageBackend> {
        let has = |name| parts.iter().any(|part| part.name == name && part.found.is_some());
        let either = |ok: bool, yes: &str, no: &str| if ok { yes.to_owned() } else { no.to_owned() };
        let unseen = backend(models, &IMAGE_INPAINT, "smooth fill");
        let plate = format!("temporal background plate (what no frame saw: {unseen})");
        let row = |stage, backend| StageBackend { stage, backend };
        let estimator =
            either(has("hand estimator"), "MediaPipe, fitted in 3-D", "imported hand tracks only");
        let hands = match self.models.estimator.first() {
            Some(program) => format!("{program}, fitted in 3-D"),
            None => backend(models, &HAND_POSE, &estimator),
        };
        vec![
            row("clip", either(has("ffmpeg"), "ffmpeg", "unavailable: ffmpeg is missing")),
            row("select", self.selector()),
            row("segment", backend(models, &SAM2_VIDEO, "classical: dense flow, colour models, graph cuts")),
            row("template", "clean frame of the clip".to_owned()),
            row("inpaint", backend(models, &VIDEO_INPAINT, &plate)),
            row("hands", hands),
            row("retarget", "damped least squares in MuJoCo".to_owned()),
            row(
                "render",
                either(has("off-screen OpenGL"), "MuJoCo through EGL", "unavailable: no OpenGL context"),
            ),
            row("composite", "layer stack".to_owned()),
            row("export", either(has("ffmpeg"), "H.264, npz, json, PNG", "unavailable: ffmpeg is missing")),
        ]
    }
}

fn first_line(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_owned)
}
