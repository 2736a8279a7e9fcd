//! Hand tracks made elsewhere: 21 joints a hand and frame in the camera frame, metres.
//!
//! Two containers are read:
//!
//! * **npz** (NumPy): `left_joints` and/or `right_joints` `[N,21,3]` float32 or float64, or `joints`
//!   `[N,21,3]` for the one hand named by [`ImportParams::single_side`]; optional `left_valid`,
//!   `right_valid`, `valid` `[N]` (0 or 1) and the scalar `fps`. A row with a NaN is a missing hand.
//! * **json**: `left_joints_cam` and/or `right_joints_cam` (also `left_joints`, `right_joints`,
//!   `joints`): a list of N entries, each 21 × `[x, y, z]` or `null`; optional `left_valid`,
//!   `right_valid`, `valid` lists and `fps`. Other keys are left alone.
//!
//! Axes are OpenCV's: x right, y down, z forward.

mod json;
mod npz;
mod resample;

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::HandTrack;
use crate::{
    clip::STANDARD_FPS,
    geometry::{PerSide, Pinhole, Side},
    landmarks::KEYPOINT_COUNT,
};

/// Files larger than this are no hand track: 128 MiB hold an hour.
const LARGEST_FILE: u64 = 128 << 20;
/// Most rows a track may have: over nine hours at 30 FPS.
const MOST_ROWS: usize = 1_000_000;
/// Joints farther from the camera than this are not metres.
const FARTHEST: f64 = 10.0;

/// The joints of one hand on one row.
type Joints = [Vector3<f64>; KEYPOINT_COUNT];

/// What was read from a file, before it meets a clip.
#[derive(Debug, Default)]
struct RawTrack {
    hands: PerSide<Option<Vec<Option<Joints>>>>,
    fps: Option<f64>,
}

/// How a file is read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImportParams {
    /// Rows a second; `None` (the default) takes the file's `fps`, else 30.
    pub fps: Option<f64>,
    /// The hand that a lone `joints` belongs to (default right).
    pub single_side: Side,
    /// Longest gap between rows that is bridged, seconds (default 0.34, ten frames).
    pub longest_bridge_s: f64,
}

impl Default for ImportParams {
    fn default() -> Self {
        Self { fps: None, single_side: Side::Right, longest_bridge_s: 0.34 }
    }
}

/// Why a file is no hand track.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// It cannot be read.
    #[error("cannot read hand track {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is neither npz nor json.
    #[error("hand track {0}: expected a name ending in .npz or .json")]
    Kind(PathBuf),
    /// It is larger than any hand track.
    #[error("hand track {path} has {bytes} bytes, expected at most {limit}")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The most accepted.
        limit: u64,
    },
    /// Its content is not a hand track.
    #[error("hand track {path}: {what}")]
    Content {
        /// The file.
        path: PathBuf,
        /// What was found where, and what was expected.
        what: String,
    },
}

/// Reads `path` and resamples it to a clip whose frames are shown at `times` seconds.
///
/// Rows are interpolated in time and never extrapolated; frames without a row near enough, and
/// hands behind the camera, are invalid.
///
/// # Errors
/// When the file cannot be read, is too large, holds no joints, has a wrong shape, lists of
/// different lengths, infinite values, or coordinates beyond 10 m.
pub fn read(
    path: &Path,
    times: &[f64],
    pinhole: &Pinhole,
    params: &ImportParams,
) -> Result<HandTrack, ImportError> {
    let raw = read_raw(path, params)?;
    let fps = rate(&raw, path, params)?;
    Ok(resample::to_track(&raw, fps, times, pinhole, params.longest_bridge_s))
}

/// A hand track as read, without a clip: rows of each hand in the camera frame, metres.
#[derive(Clone, Debug, Default)]
pub struct WholeTrack {
    /// The left hand's rows; `None` where a row has no hand.
    pub left: Option<Vec<Option<[Vector3<f64>; KEYPOINT_COUNT]>>>,
    /// The right hand's.
    pub right: Option<Vec<Option<[Vector3<f64>; KEYPOINT_COUNT]>>>,
    /// Rows a second, where it is stated.
    pub fps: Option<f64>,
}

/// Reads `path` without a clip: all of it, resampled to 30 frames a second.
///
/// # Errors
/// As [`read`].
pub fn read_whole(path: &Path, pinhole: &Pinhole, params: &ImportParams) -> Result<HandTrack, ImportError> {
    let raw = read_raw(path, params)?;
    whole(&raw, path, pinhole, params)
}

/// All of `track` resampled to 30 frames a second; `path` is what errors name.
///
/// # Errors
/// As [`read`], but for reading.
pub fn resample_whole(
    track: WholeTrack,
    path: &Path,
    pinhole: &Pinhole,
    params: &ImportParams,
) -> Result<HandTrack, ImportError> {
    let raw = RawTrack { hands: PerSide { left: track.left, right: track.right }, fps: track.fps };
    check(&raw).map_err(|what| ImportError::Content { path: path.to_owned(), what })?;
    whole(&raw, path, pinhole, params)
}

fn whole(
    raw: &RawTrack,
    path: &Path,
    pinhole: &Pinhole,
    params: &ImportParams,
) -> Result<HandTrack, ImportError> {
    let fps = rate(raw, path, params)?;
    let rows = raw.hands.iter().filter_map(|(_, hand)| hand.as_ref().map(Vec::len)).max().unwrap_or(0);
    let last = rows.saturating_sub(1) as f64 / fps;
    // Rounding must not cost the last frame.
    let frames = (last * STANDARD_FPS + 1e-6).floor() as usize + 1;
    let times: Vec<f64> = (0..frames.min(MOST_ROWS)).map(|frame| frame as f64 / STANDARD_FPS).collect();
    Ok(resample::to_track(raw, fps, &times, pinhole, params.longest_bridge_s))
}

fn read_raw(path: &Path, params: &ImportParams) -> Result<RawTrack, ImportError> {
    let io = |source| ImportError::Io { path: path.to_owned(), source };
    let content = |what| ImportError::Content { path: path.to_owned(), what };
    let bytes = std::fs::metadata(path).map_err(io)?.len();
    if bytes > LARGEST_FILE {
        return Err(ImportError::TooLarge { path: path.to_owned(), bytes, limit: LARGEST_FILE });
    }
    let kind = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let raw = match kind.as_deref() {
        Some("npz") => npz::parse(std::fs::File::open(path).map_err(io)?, params.single_side),
        Some("json") => json::parse(&std::fs::read(path).map_err(io)?, params.single_side),
        _ => return Err(ImportError::Kind(path.to_owned())),
    };
    let raw = raw.map_err(content)?;
    check(&raw).map_err(content)?;
    Ok(raw)
}

fn rate(raw: &RawTrack, path: &Path, params: &ImportParams) -> Result<f64, ImportError> {
    let fps = params.fps.or(raw.fps).unwrap_or(STANDARD_FPS);
    if (0.1..=1000.0).contains(&fps) {
        return Ok(fps);
    }
    let what = format!("fps is {fps}, expected 0.1 to 1000");
    Err(ImportError::Content { path: path.to_owned(), what })
}

/// Both sides of one length, at least one hand, every coordinate finite and near.
fn check(raw: &RawTrack) -> Result<(), String> {
    let lengths: Vec<usize> = raw.hands.iter().filter_map(|(_, h)| h.as_ref().map(Vec::len)).collect();
    match lengths[..] {
        [] => {
            return Err(
                "no joints: expected left_joints, right_joints or joints `[N,21,3]` (see models/README.md)"
                    .to_owned(),
            );
        }
        [left, right] if left != right => {
            return Err(format!("left has {left} rows, right {right}: expected as many"));
        }
        [0, ..] => return Err("0 rows, expected at least one".to_owned()),
        [rows, ..] if rows > MOST_ROWS => return Err(format!("{rows} rows, expected at most {MOST_ROWS}")),
        _ => {}
    }
    for (side, hands) in raw.hands.iter() {
        for (row, joints) in hands.iter().flatten().enumerate() {
            let Some(joints) = joints else { continue };
            let bad = joints.iter().position(|p| p.iter().any(|v| !v.is_finite() || v.abs() > FARTHEST));
            if let Some(joint) = bad {
                let p = joints[joint];
                return Err(format!(
                    "{} joint {joint} of row {row} is ({}, {}, {}): expected finite metres within {FARTHEST}",
                    side.name(),
                    p.x,
                    p.y,
                    p.z
                ));
            }
        }
    }
    Ok(())
}

/// Rows that `valid` (0 or 1 each) leaves.
fn masked(rows: Vec<Option<Joints>>, valid: Option<Vec<bool>>) -> Result<Vec<Option<Joints>>, String> {
    match valid {
        None => Ok(rows),
        Some(valid) if valid.len() == rows.len() => {
            Ok(rows.into_iter().zip(valid).map(|(row, valid)| row.filter(|_| valid)).collect())
        }
        Some(valid) => Err(format!("valid has {} entries, joints {} rows", valid.len(), rows.len())),
    }
}

/// Joint names of a container, most specific first, with the name of their validity list.
fn names(side: Side, single_side: Side) -> Vec<(String, String)> {
    let name = side.name();
    let mut names = vec![
        (format!("{name}_joints_cam"), format!("{name}_valid")),
        (format!("{name}_joints"), format!("{name}_valid")),
    ];
    if side == single_side {
        names.push(("joints".to_owned(), "valid".to_owned()));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Size, hands::HandState};

    fn pinhole() -> Pinhole {
        Pinhole::from_horizontal_fov(60.0, Size::new(640, 480)).expect("a valid field of view")
    }

    fn times(count: usize) -> Vec<f64> {
        (0..count).map(|t| t as f64 / 30.0).collect()
    }

    fn row(z: f64) -> String {
        let points: Vec<String> = (0..21).map(|k| format!("[{},0.0,{z}]", 0.01 * f64::from(k))).collect();
        format!("[{}]", points.join(","))
    }

    fn read_json(text: &str, frames: usize) -> Result<HandTrack, ImportError> {
        let file = tempfile::Builder::new().suffix(".json").tempfile().expect("a temporary file");
        std::fs::write(file.path(), text).expect("written");
        read(file.path(), &times(frames), &pinhole(), &ImportParams::default())
    }

    #[test]
    fn rows_at_half_the_rate_are_interpolated_in_time() {
        let rows: Vec<String> = (0..5).map(|t| row(0.4 + 0.02 * f64::from(t))).collect();
        let text = format!(r#"{{"fps": 15, "right_joints_cam": [{}], "note": "ignored"}}"#, rows.join(","));
        let track = read_json(&text, 9).expect("a track");
        for (frame, hand) in track.hands.right.iter().enumerate() {
            assert!(hand.is_valid() && (hand.wrist().xyz.z - 0.4 - 0.01 * frame as f64).abs() < 1e-9);
        }
        assert!(track.hands.left.iter().all(|h| !h.is_valid()));
    }

    #[test]
    fn nulls_are_bridged_when_short_and_invalid_when_long() {
        let mut rows = vec![row(0.5); 40];
        rows[5..8].fill("null".to_owned());
        rows[15..30].fill("null".to_owned());
        let text = format!(r#"{{"left_joints": [{}]}}"#, rows.join(","));
        let track = read_json(&text, 45).expect("a track");
        assert_eq!(track.hands.left[6].state, HandState::Bridged);
        assert_eq!(track.hands.left[20].state, HandState::Invalid);
        assert_eq!(track.hands.left[39].state, HandState::Observed);
        assert_eq!(track.hands.left[44].state, HandState::Invalid);
    }

    #[test]
    fn hostile_files_are_refused_with_a_reason() {
        let rows = |n: usize| vec![row(0.5); n].join(",");
        let cases = [
            ("[1, 2]".to_owned(), "object"),
            ("{\"left_joints\": ".to_owned(), "no JSON"),
            (r#"{"hands": []}"#.to_owned(), "no joints"),
            (r#"{"left_joints": []}"#.to_owned(), "0 rows"),
            (r#"{"left_joints": [[[0, 0, 1]]]}"#.to_owned(), "1 points"),
            (r#"{"left_joints": "x"}"#.to_owned(), "expected a list"),
            (format!(r#"{{"left_joints": [{}]}}"#, row(1e300)), "expected finite"),
            (format!(r#"{{"left_joints": [{}], "right_joints": [{}]}}"#, rows(2), rows(3)), "left has 2"),
            (format!(r#"{{"left_joints": [{}], "fps": -1}}"#, rows(2)), "fps"),
            (format!(r#"{{"left_joints": [{}], "left_valid": [1]}}"#, rows(2)), "valid has 1"),
        ];
        for (text, expected) in cases {
            let error = read_json(&text, 3).expect_err(expected).to_string();
            assert!(error.contains(expected), "{error} lacks {expected}");
        }
    }

    #[test]
    fn an_npz_that_claims_a_huge_array_is_refused_before_it_is_read() {
        let mut header = b"\x93NUMPY\x01\x00".to_vec();
        let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 21, 3), }\n";
        header.extend((text.len() as u16).to_le_bytes());
        header.extend(text.as_bytes());
        let file = tempfile::Builder::new().suffix(".npz").tempfile().expect("a temporary file");
        let mut zip = zip::ZipWriter::new(std::fs::File::create(file.path()).expect("created"));
        zip.start_file("joints.npy", zip::write::SimpleFileOptions::default()).expect("an entry");
        std::io::Write::write_all(&mut zip, &header).expect("written");
        zip.finish().expect("a whole file");
        let error = read(file.path(), &times(3), &pinhole(), &ImportParams::default());
        assert!(error.expect_err("refused").to_string().contains("at most"));
    }
}
