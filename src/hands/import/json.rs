//! Hand tracks in JSON.

use nalgebra::Vector3;
use serde_json::{Map, Value};

use super::{Joints, RawTrack, masked, names};
use crate::{
    geometry::{PerSide, Side},
    landmarks::KEYPOINT_COUNT,
};

pub(super) fn parse(bytes: &[u8], single_side: Side) -> Result<RawTrack, String> {
    let value: Value = serde_json::from_slice(bytes).map_err(|e| format!("no JSON: {e}"))?;
    let Value::Object(map) = value else {
        return Err("expected a JSON object with lists of joints".to_owned());
    };
    let fps = match map.get("fps") {
        None | Some(Value::Null) => None,
        Some(value) => Some(value.as_f64().ok_or("fps: expected a number")?),
    };
    let mut hands = PerSide::default();
    for side in Side::BOTH {
        hands[side] = side_rows(&map, side, single_side)?;
    }
    Ok(RawTrack { hands, fps })
}

fn side_rows(
    map: &Map<String, Value>,
    side: Side,
    single_side: Side,
) -> Result<Option<Vec<Option<Joints>>>, String> {
    for (joints, valid) in names(side, single_side) {
        let Some(value) = map.get(&joints).filter(|v| !v.is_null()) else { continue };
        let rows = value.as_array().ok_or_else(|| format!("{joints}: expected a list"))?;
        let rows: Result<Vec<_>, String> = rows
            .iter()
            .enumerate()
            .map(|(row, value)| parse_row(value).map_err(|e| format!("{joints}[{row}]: {e}")))
            .collect();
        let valid = match map.get(&valid).filter(|v| !v.is_null()) {
            None => None,
            Some(list) => Some(parse_flags(list).map_err(|e| format!("{valid}: {e}"))?),
        };
        return masked(rows?, valid).map(Some).map_err(|e| format!("{joints}: {e}"));
    }
    Ok(None)
}

fn parse_row(value: &Value) -> Result<Option<Joints>, String> {
    if value.is_null() {
        return Ok(None);
    }
    let points = value.as_array().ok_or("expected 21 points or null")?;
    if points.len() != KEYPOINT_COUNT {
        return Err(format!("{} points, expected {KEYPOINT_COUNT}", points.len()));
    }
    let mut joints = [Vector3::zeros(); KEYPOINT_COUNT];
    for (joint, point) in joints.iter_mut().zip(points) {
        let coordinates = point.as_array().filter(|p| p.len() == 3).ok_or("expected [x, y, z]")?;
        for (k, coordinate) in coordinates.iter().enumerate() {
            match coordinate.as_f64() {
                Some(value) => joint[k] = value,
                // JSON has no NaN: null stands for a coordinate that is not known.
                None if coordinate.is_null() => return Ok(None),
                None => return Err("expected a number".to_owned()),
            }
        }
    }
    Ok(Some(joints))
}

fn parse_flags(value: &Value) -> Result<Vec<bool>, String> {
    let list = value.as_array().ok_or("expected a list")?;
    let flag = |v: &Value| v.as_bool().or_else(|| v.as_f64().map(|n| n != 0.0));
    list.iter().map(|v| flag(v).ok_or_else(|| "expected true, false, 0 or 1".to_owned())).collect()
}
