//! The manifest: a list of clips with prompts, intrinsics, hand tracks and parameters.
//!
//! TOML (`[[clip]]` tables) or JSON Lines (one clip a line), one schema. Unknown keys are an error
//! that names the key and its line.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::{
    clip::{CameraSpec, Rotation},
    geometry::PerSide,
    retarget::{Beta, CameraAngles, CameraRotation, Method, Smoothing, WristTurn},
    select::vlm::VlmWish,
    session::RetargetSettings,
};

/// A list of clips.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The clips, in order.
    #[serde(default)]
    pub clip: Vec<ManifestClip>,
}

/// One clip of a manifest. Paths are relative to the manifest's folder.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestClip {
    /// Name of the output folder (default: the file's stem).
    pub id: Option<String>,
    /// The video file.
    pub path: PathBuf,
    /// The task in one sentence.
    pub task: Option<String>,
    /// Clockwise degrees after decoding: 0, 90, 180 or 270 (default: 0).
    #[serde(default)]
    pub rotate: Rotation,
    /// Which object, in pixels as decoded (before `rotate`) on a frame of the source's own rate.
    pub object: Option<ManifestObject>,
    /// Intrinsics in pixels as decoded, or a horizontal field of view.
    pub camera: Option<ManifestCamera>,
    /// Hand tracks.
    pub hands: Option<ManifestHands>,
    /// Retargeting.
    pub params: Option<ManifestParams>,
    /// `vlm = { mode, model, profile }`: asking a model for the object. Not where it is: that is the command line's.
    pub vlm: Option<VlmWish>,
    /// First second to use.
    pub start: Option<f64>,
    /// Last second to use.
    pub end: Option<f64>,
}

/// `object = { label, frame, box | points, negative }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestObject {
    /// What it is called (default: "object").
    pub label: Option<String>,
    /// Source frame, from 0 (default: 0).
    #[serde(default)]
    pub frame: u32,
    /// `[x0, y0, x1, y1]`.
    #[serde(rename = "box")]
    pub bounds: Option<[f64; 4]>,
    /// `[[x, y], …]` on the object.
    #[serde(default)]
    pub points: Vec<[f64; 2]>,
    /// `[[x, y], …]` beside the object.
    #[serde(default)]
    pub negative: Vec<[f64; 2]>,
}

/// `camera = { fx, fy, cx, cy }` or `{ hfov_deg }`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestCamera {
    fx: Option<f64>,
    fy: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    hfov_deg: Option<f64>,
}

/// `hands = { track, length_mm }`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestHands {
    /// A 21-joint track to import, npz or json.
    pub track: Option<PathBuf>,
    /// Hand length, wrist to middle tip, in millimetres.
    pub length_mm: Option<f64>,
}

/// `params = { method, shared_map, beta, alpha, smoothing, T_offset, R_cam, wrist, hole_dilation }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestParams {
    method: Option<Method>,
    shared_map: Option<bool>,
    beta: Option<ManifestBeta>,
    alpha: Option<f64>,
    smoothing: Option<Smoothing>,
    #[serde(default)]
    wrist: ManifestWrists,
    #[serde(rename = "T_offset")]
    offset: Option<[f64; 3]>,
    #[serde(rename = "R_cam")]
    rotation: Option<ManifestRotation>,
    hole_dilation: Option<f64>,
}

/// `wrist = { left, right }`, each `{ roll_deg, pitch_deg, yaw_deg }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct ManifestWrists {
    left: WristTurn,
    right: WristTurn,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected beta to be a number or \"fit\"")]
enum ManifestBeta {
    Value(f64),
    Word(Fit),
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Fit {
    Fit,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected R_cam to be { pitch_deg, yaw_deg, roll_deg } or a 3×3 list of rows")]
enum ManifestRotation {
    Angles(CameraAngles),
    Rows([[f64; 3]; 3]),
}

/// Why a manifest was refused.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// Not readable.
    #[error("cannot read manifest {path}: {source}")]
    Io {
        /// The manifest.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Not in the schema.
    #[error("{path}:{line}: {message}")]
    Schema {
        /// The manifest.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A value that makes no sense.
    #[error("{path}: clip {clip:?}: {message}")]
    Value {
        /// The manifest.
        path: PathBuf,
        /// The clip's id or path.
        clip: String,
        /// What is wrong.
        message: String,
    },
}

/// A manifest of a few thousand clips is well under this; more is not a manifest.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;

impl Manifest {
    /// Reads `path`: TOML where it ends in `.toml`, JSON Lines otherwise.
    ///
    /// # Errors
    /// When it cannot be read or does not follow the schema.
    pub fn read(path: &Path) -> Result<Self, ManifestError> {
        let io = |source| ManifestError::Io { path: path.to_owned(), source };
        if std::fs::metadata(path).map_err(io)?.len() > MAX_MANIFEST_BYTES {
            let message = format!("larger than {} MiB", MAX_MANIFEST_BYTES >> 20);
            return Err(ManifestError::Schema { path: path.to_owned(), line: 1, message });
        }
        let text = std::fs::read_to_string(path).map_err(io)?;
        let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        if is_toml { parse_toml(path, &text) } else { parse_json_lines(path, &text) }
    }
}

fn parse_toml(path: &Path, text: &str) -> Result<Manifest, ManifestError> {
    toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
        ManifestError::Schema { path: path.to_owned(), line, message: error.message().replace('\n', " ") }
    })
}

fn parse_json_lines(path: &Path, text: &str) -> Result<Manifest, ManifestError> {
    let mut manifest = Manifest::default();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let clip = serde_json::from_str(line).map_err(|error| ManifestError::Schema {
            path: path.to_owned(),
            line: index + 1,
            message: error.to_string(),
        })?;
        manifest.clip.push(clip);
    }
    Ok(manifest)
}

impl ManifestCamera {
    /// As a session keeps it.
    pub(super) fn setting(&self) -> Result<CameraSpec, String> {
        match (self.fx, self.fy, self.cx, self.cy, self.hfov_deg) {
            (Some(fx), Some(fy), Some(cx), Some(cy), None) => Ok(CameraSpec::Intrinsics { fx, fy, cx, cy }),
            (None, None, None, None, Some(degrees)) => Ok(CameraSpec::HorizontalFov(degrees)),
            _ => Err("camera: expected either fx, fy, cx and cy, or hfov_deg alone".to_owned()),
        }
    }
}

/// How far the hole in the background is widened, as a session keeps it.
pub(super) fn hole_dilation(clip: &ManifestClip) -> Option<f64> {
    clip.params.and_then(|params| params.hole_dilation)
}

/// Retargeting as a session keeps it.
pub(super) fn retarget_settings(clip: &ManifestClip) -> RetargetSettings {
    let params = clip.params.unwrap_or_default();
    RetargetSettings {
        method: params.method,
        shared_map: params.shared_map,
        beta: params.beta.map(|beta| match beta {
            ManifestBeta::Value(value) => Beta::Fixed(value),
            ManifestBeta::Word(Fit::Fit) => Beta::Fit,
        }),
        alpha: params.alpha,
        smoothing: params.smoothing,
        wrist: PerSide { left: params.wrist.left, right: params.wrist.right },
        camera_rotation: params.rotation.map(|rotation| match rotation {
            ManifestRotation::Angles(angles) => CameraRotation::Angles(angles),
            ManifestRotation::Rows(rows) => CameraRotation::Rows(rows),
        }),
        offset: params.offset,
        hand_length: clip.hands.as_ref().and_then(|hands| hands.length_mm).map(|mm| mm / 1000.0),
    }
}
