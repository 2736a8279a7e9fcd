//! Parquet files.

use std::{fs::File, path::Path, sync::Arc};

use arrow_array::{
    Array, ArrayRef, Float32Array, Float64Array, ListArray, RecordBatch, cast::AsArray, types::Float32Type,
};
use arrow_buffer::OffsetBuffer;
use arrow_schema::{DataType, Field, FieldRef, Schema};
use parquet::{
    arrow::{ArrowWriter, ProjectionMask, arrow_reader::ParquetRecordBatchReaderBuilder},
    basic::Compression,
    errors::ParquetError,
    file::{metadata::KeyValue, properties::WriterProperties},
};

use crate::export::dataset::{DatasetError, file};

/// A named column.
pub(super) type Column = (String, ArrayRef);

/// Writes `columns`, all equally long, as one row group; `metadata` goes into the file's key-value pairs.
pub(super) fn write(
    path: &Path,
    columns: Vec<Column>,
    metadata: Option<(&str, String)>,
) -> Result<(), DatasetError> {
    file::write_whole(path, |part| {
        let failed = |source: ParquetError| DatasetError::Table { path: path.to_owned(), source };
        let fields: Vec<Field> =
            columns.iter().map(|(name, data)| Field::new(name, data.data_type().clone(), true)).collect();
        // A reader takes the metadata of the one schema or of the other: they stand in both.
        let pairs: Vec<(String, String)> =
            metadata.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let schema = Arc::new(Schema::new_with_metadata(fields, pairs.iter().cloned().collect()));
        let arrays = columns.into_iter().map(|(_, data)| data).collect();
        let batch =
            RecordBatch::try_new(Arc::clone(&schema), arrays).map_err(|error| failed(error.into()))?;
        let key_values = pairs.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by("agenticfocus".to_owned())
            .set_key_value_metadata((!pairs.is_empty()).then_some(key_values))
            .set_max_row_group_row_count(Some(usize::MAX))
            .build();
        let output = File::create(part).map_err(DatasetError::io(part, "create the file"))?;
        let mut writer = ArrowWriter::try_new(output, schema, Some(properties)).map_err(failed)?;
        writer.write(&batch).map_err(failed)?;
        writer.close().map(|_| ()).map_err(failed)
    })
}

/// A list of `width` numbers a row.
pub(super) fn lists(rows: impl Iterator<Item = impl AsRef<[f32]>>) -> ArrayRef {
    let (mut values, mut ends) = (Vec::new(), vec![0_i32]);
    for row in rows {
        values.extend_from_slice(row.as_ref());
        ends.push(values.len() as i32);
    }
    list_of(Arc::new(Float32Array::from(values)), ends)
}

/// One row with a list of numbers.
pub(super) fn list_row(values: &[f64]) -> ArrayRef {
    list_of(Arc::new(Float64Array::from(values.to_vec())), vec![0, values.len() as i32])
}

/// One row with a list of `values.len()` times one times one number, as pictures' channels are stored.
pub(super) fn channel_row(values: &[f64]) -> ArrayRef {
    let ends: Vec<i32> = (0..=values.len() as i32).collect();
    let one = list_of(Arc::new(Float64Array::from(values.to_vec())), ends.clone());
    list_of(list_of(one, ends), vec![0, values.len() as i32])
}

/// Lists over `values`, which end at `ends` after the first.
pub(super) fn list_of(values: ArrayRef, ends: Vec<i32>) -> ArrayRef {
    let item: FieldRef = Arc::new(Field::new("element", DataType::clone(values.data_type()), true));
    Arc::new(ListArray::new(item, OffsetBuffer::new(ends.into()), values, None))
}

/// The columns of numbers behind the lists in column `name`, one a dimension, appended to `columns`.
pub(super) fn read_lists(path: &Path, name: &str, columns: &mut [Vec<f32>]) -> Result<(), DatasetError> {
    let failed = |source: ParquetError| DatasetError::Table { path: path.to_owned(), source };
    let input = File::open(path).map_err(DatasetError::io(path, "open the table"))?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(input).map_err(failed)?;
    // By its number: a dot in a name is no nesting here.
    let number = builder.schema().index_of(name).map_err(|error| failed(error.into()))?;
    let mask = ProjectionMask::roots(builder.parquet_schema(), [number]);
    for batch in builder.with_projection(mask).build().map_err(failed)? {
        let batch = batch.map_err(|error| failed(error.into()))?;
        let damaged = || DatasetError::Damaged {
            path: path.to_owned(),
            what: format!("column {name} holds no lists of {} numbers", columns.len()),
        };
        let lists = batch.column(0).as_list_opt::<i32>().ok_or_else(damaged)?;
        let values = lists.values().as_primitive_opt::<Float32Type>().ok_or_else(damaged)?.values();
        if values.len() != lists.len() * columns.len() {
            return Err(damaged());
        }
        for row in values.chunks_exact(columns.len()) {
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(*value);
            }
        }
    }
    Ok(())
}
