//! Hand tracks in NumPy's npz.

use std::io::{Read, Seek};

use nalgebra::Vector3;
use npyz::{NpyFile, TypeChar, npz::NpzArchive};

use super::{Joints, LARGEST_FILE, MOST_ROWS, RawTrack, masked, names};
use crate::{
    geometry::{PerSide, Side},
    landmarks::KEYPOINT_COUNT,
};

pub(super) fn parse(file: std::fs::File, single_side: Side) -> Result<RawTrack, String> {
    let mut archive = NpzArchive::new(file).map_err(|e| format!("no npz: {e}"))?;
    let fps = match numbers(&mut archive, "fps", 1)? {
        None => None,
        Some((_, values)) => Some(*values.first().ok_or("fps: expected one number")?),
    };
    let mut hands = PerSide::default();
    for side in Side::BOTH {
        for (joints, valid) in names(side, single_side) {
            let most = MOST_ROWS * KEYPOINT_COUNT * 3;
            let Some((shape, values)) = numbers(&mut archive, &joints, most)? else { continue };
            if shape.len() != 3 || shape[1..] != [KEYPOINT_COUNT as u64, 3] {
                return Err(format!("{joints} has shape {shape:?}, expected [N, {KEYPOINT_COUNT}, 3]"));
            }
            let rows = values.chunks_exact(KEYPOINT_COUNT * 3).map(to_row).collect();
            let valid = numbers(&mut archive, &valid, MOST_ROWS)?;
            let valid = valid.map(|(_, flags)| flags.iter().map(|v| *v != 0.0).collect());
            hands[side] = Some(masked(rows, valid).map_err(|e| format!("{joints}: {e}"))?);
            break;
        }
    }
    Ok(RawTrack { hands, fps })
}

/// An array's shape and its values, row by row.
type Numbers = (Vec<u64>, Vec<f64>);

/// A row; `None` where a coordinate is NaN.
fn to_row(values: &[f64]) -> Option<Joints> {
    let joint = |k: usize| Vector3::new(values[3 * k], values[3 * k + 1], values[3 * k + 2]);
    (!values.iter().any(|v| v.is_nan())).then(|| std::array::from_fn(joint))
}

/// Shape and values of an array as float64, row by row; `None` when there is no such array.
fn numbers<R: Read + Seek>(
    archive: &mut NpzArchive<R>,
    name: &str,
    most: usize,
) -> Result<Option<Numbers>, String> {
    let array = archive.by_name(name).map_err(|e| format!("{name}: {e}"))?;
    let Some(array) = array else { return Ok(None) };
    let shape = array.shape().to_vec();
    // Checked before anything is allocated: a header may claim any size.
    let count = shape.iter().try_fold(1_u64, |product, n| product.checked_mul(*n));
    if count.is_none_or(|count| count > most as u64 || count * 8 > 2 * LARGEST_FILE) {
        return Err(format!("{name} has shape {shape:?}, expected at most {most} values"));
    }
    if array.order() != npyz::Order::C && shape.len() > 1 {
        return Err(format!("{name} is in Fortran order, expected C order (numpy.ascontiguousarray)"));
    }
    let values = as_f64(array).map_err(|e| format!("{name}: {e}"))?;
    Ok(Some((shape, values)))
}

fn as_f64<R: Read>(array: NpyFile<R>) -> Result<Vec<f64>, String> {
    let npyz::DType::Plain(kind) = array.dtype() else {
        return Err("a record array, expected plain numbers".to_owned());
    };
    let io = |e: std::io::Error| e.to_string();
    match (kind.type_char(), kind.num_bytes()) {
        (TypeChar::Float, Some(8)) => array.into_vec::<f64>().map_err(io),
        (TypeChar::Float, Some(4)) => widened(array.into_vec::<f32>().map_err(io)?),
        (TypeChar::Bool, _) => {
            Ok(array.into_vec::<bool>().map_err(io)?.into_iter().map(|v| f64::from(u8::from(v))).collect())
        }
        (TypeChar::Int, Some(8)) => {
            Ok(array.into_vec::<i64>().map_err(io)?.into_iter().map(|v| v as f64).collect())
        }
        (TypeChar::Int, Some(4)) => widened(array.into_vec::<i32>().map_err(io)?),
        (TypeChar::Uint, Some(1)) => widened(array.into_vec::<u8>().map_err(io)?),
        _ => Err(format!("type {kind}, expected float32, float64, int32, int64, uint8 or bool")),
    }
}

fn widened<T: Into<f64>>(values: Vec<T>) -> Result<Vec<f64>, String> {
    Ok(values.into_iter().map(Into::into).collect())
}
