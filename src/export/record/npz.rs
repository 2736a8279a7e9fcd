//! NumPy's `.npz`: a zip of `.npy` arrays, format version 1.0 (as numpy.lib.format documents it).

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use crate::export::ExportError;

/// Values of an array, row-major.
#[derive(Clone, Debug, PartialEq)]
pub enum ArrayData {
    /// `<f8`.
    F64(Vec<f64>),
    /// `<i8`.
    I64(Vec<i64>),
    /// `|b1`.
    Bool(Vec<bool>),
}

impl ArrayData {
    /// NumPy's name of the type.
    pub const fn dtype(&self) -> &'static str {
        match self {
            Self::F64(_) => "<f8",
            Self::I64(_) => "<i8",
            Self::Bool(_) => "|b1",
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::I64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::Bool(values) => values.iter().map(|value| u8::from(*value)).collect(),
        }
    }
}

/// An array with its name, shape and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedArray {
    /// Its name in the file.
    pub name: &'static str,
    /// Its shape; empty for a scalar.
    pub shape: Vec<usize>,
    /// Its values.
    pub data: ArrayData,
    /// Its unit.
    pub unit: &'static str,
    /// Whether it has one row a frame.
    pub per_row: bool,
    /// Whether it is NaN where no hand drove the side (its second axis is the side then).
    pub unknown_without_hand: bool,
}

impl NamedArray {
    /// One row a frame.
    pub fn per_row(name: &'static str, shape: Vec<usize>, data: ArrayData, unit: &'static str) -> Self {
        Self { name, shape, data, unit, per_row: true, unknown_without_hand: false }
    }

    /// One row of shape `inner` a frame out of fixed-size parts.
    pub(super) fn rows<const W: usize>(
        name: &'static str,
        parts: &[[f64; W]],
        inner: &[usize],
        unit: &'static str,
    ) -> Self {
        let values = parts.as_flattened().to_vec();
        let mut shape = vec![values.len() / inner.iter().product::<usize>()];
        shape.extend_from_slice(inner);
        Self::per_row(name, shape, ArrayData::F64(values), unit)
    }

    /// One value or matrix for the clip.
    pub fn constant(name: &'static str, shape: &[usize], values: Vec<f64>, unit: &'static str) -> Self {
        let data = ArrayData::F64(values);
        Self { name, shape: shape.to_vec(), data, unit, per_row: false, unknown_without_hand: false }
    }

    pub(super) fn unknown_without_hand(self) -> Self {
        Self { unknown_without_hand: true, ..self }
    }

    /// The array as an `.npy` file.
    pub fn to_npy(&self) -> Vec<u8> {
        let mut shape: String = self.shape.iter().map(|length| format!("{length}, ")).collect();
        // Python writes (3,) and (3, 3).
        let shape = if self.shape.len() == 1 {
            format!("({},)", self.shape[0])
        } else {
            shape.truncate(shape.len().saturating_sub(2));
            format!("({shape})")
        };
        let mut header =
            format!("{{'descr': '{}', 'fortran_order': False, 'shape': {shape}, }}", self.data.dtype());
        // Magic, version, length and header together are padded to a multiple of 64.
        let unpadded = 10 + header.len() + 1;
        header.extend(std::iter::repeat_n(' ', unpadded.next_multiple_of(64) - unpadded));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
        bytes.extend_from_slice(header.as_bytes());
        bytes.extend_from_slice(&self.data.bytes());
        bytes
    }
}

/// Writes `arrays` as an uncompressed `.npz` with fixed time stamps.
///
/// # Errors
/// When the file cannot be written.
pub fn write_npz(path: &Path, arrays: &[NamedArray]) -> Result<(), ExportError> {
    let write = || -> std::io::Result<()> {
        let mut zip = ZipWriter::new(BufWriter::new(File::create(path)?));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::DEFAULT)
            .unix_permissions(0o644);
        for array in arrays {
            zip.start_file(format!("{}.npy", array.name), options).map_err(std::io::Error::other)?;
            zip.write_all(&array.to_npy())?;
        }
        let file = zip.finish().map_err(std::io::Error::other)?;
        file.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()
    };
    write().map_err(|source| ExportError::io(path, "write the record", source))
}
