//! Finished clips: the hand track that a session kept beside its record.

use std::{
    fs,
    path::{Path, PathBuf},
};

use nalgebra::{Matrix3, Vector3};
use npyz::npz::NpzArchive;

use super::{SourceError, io};
use crate::{
    evaluate::study::Episode,
    geometry::Side,
    hands::{HandFrame, HandTrack},
};

/// The episode of a record: of the tracks in the session's cache, older ones among them, the one that the record was
/// made from is the one whose wrists lie where the record wanted the robot's, taken back through its map.
pub(super) fn read(name: &str, record: &Path, tracks: &[PathBuf]) -> Result<Episode, SourceError> {
    let wanted = Wanted::read(record)?;
    let mut best: Option<(f64, HandTrack)> = None;
    for path in tracks {
        let Some(track) = read_sealed(path)? else { continue };
        if let Some(distance) = wanted.distance(&track)
            && best.as_ref().is_none_or(|(least, _)| distance < *least)
        {
            best = Some((distance, track));
        }
    }
    let Some((_, track)) = best else {
        let what =
            "none of the hand tracks in its session's cache has as many frames with hands as the record";
        return Err(SourceError::Content { path: record.to_owned(), what: what.to_owned() });
    };
    Ok(Episode::of_track(name.to_owned(), track))
}

/// Where a record wanted the wrists, in the camera frame, metres of the human scene; left, then right a row.
struct Wanted(Vec<[Option<Vector3<f64>>; 2]>);

impl Wanted {
    fn read(record: &Path) -> Result<Self, SourceError> {
        let content = |what: String| SourceError::Content { path: record.to_owned(), what };
        let file = fs::File::open(record).map_err(io(record))?;
        let mut archive = NpzArchive::new(file).map_err(|error| content(format!("no npz: {error}")))?;
        let mut numbers = |array: &str, width: usize| -> Result<Vec<f64>, SourceError> {
            let found = archive.by_name(array).map_err(|error| content(format!("{array}: {error}")))?;
            let found = found.ok_or_else(|| content(format!("no array `{array}`, expected a record")))?;
            let values: Vec<f64> =
                found.into_vec().map_err(|error| content(format!("{array}: {error}, expected float64")))?;
            let whole = !values.is_empty() && values.len().is_multiple_of(width);
            if whole { Ok(values) } else { Err(content(format!("{array} has {} values", values.len()))) }
        };
        let beta = numbers("beta", 1)?[0];
        let rotation = Matrix3::from_row_slice(&numbers("R_cam", 9)?[..9]);
        let offset = Vector3::from_column_slice(&numbers("T_offset", 3)?[..3]);
        let targets = numbers("target_wrist_torso", 14)?;
        let back = |pose: &[f64]| {
            let torso = Vector3::new(pose[0], pose[1], pose[2]);
            let scene = rotation.transpose() * (torso - offset) / beta;
            scene.iter().all(|value| value.is_finite()).then_some(scene)
        };
        Ok(Self(targets.chunks_exact(14).map(|row| [back(&row[..7]), back(&row[7..])]).collect()))
    }

    /// Mean distance to the wrists of `track`; `None` where it has other frames.
    fn distance(&self, track: &HandTrack) -> Option<f64> {
        if track.frame_count() != self.0.len() {
            return None;
        }
        let (mut sum, mut count) = (0.0, 0_usize);
        for side in Side::BOTH {
            for (wanted, hand) in self.0.iter().zip(&track.hands[side]) {
                match (wanted[side.index()], hand.is_valid()) {
                    (Some(wanted), true) => sum += (wanted - HandFrame::wrist(hand).xyz).norm(),
                    (None, false) => {}
                    // Known to one alone: as bad as half a metre.
                    _ => sum += 0.5,
                }
                count += 1;
            }
        }
        (count > 0).then(|| sum / count as f64)
    }
}

/// A track of a session's cache: the first line is the hash of the rest. `None` where it is damaged.
fn read_sealed(path: &Path) -> Result<Option<HandTrack>, SourceError> {
    let bytes = fs::read(path).map_err(io(path))?;
    let sealed = bytes
        .split_at_checked(65)
        .filter(|(hash, body)| &hash[..64] == blake3::hash(body).to_hex().as_bytes())
        .and_then(|(_, body)| serde_json::from_slice(body).ok());
    Ok(sealed)
}
