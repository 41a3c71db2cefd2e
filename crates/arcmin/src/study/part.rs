//! Rows as Parquet: one file per part, optional columns, repeated numbers for curves; the identity of the study in
//! the metadata.

use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::get_typed_column_reader;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::plan::{Kind, Plan};

/// Version of the format of parts; part of every identity.
pub(super) const FORMAT: &str = "arcmin study part 1";
const IDENTITY: &str = "arcmin.study.identity";

/// A value of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// No value: not computed or not defined.
    Absent,
    /// Number in the unit of the column.
    Number(f64),
    /// Word or text.
    Word(String),
    /// Numbers at several hours.
    Curve(Vec<f64>),
}

impl Cell {
    /// The number of a numeric cell; `None` of others.
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Number(number) => Some(*number),
            _ => None,
        }
    }
}

/// A computed row.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Number of the row in the plan, from 0.
    pub number: u64,
    /// Cells in the order of [`Plan::columns`]; results of a failed row are absent.
    pub cells: Vec<Cell>,
    /// Reason for missing results.
    pub failed: Option<String>,
}

/// Error of the content of a part.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The bytes are no Parquet file that can be read.
    #[error("it is not a readable Parquet file: {0}")]
    Parquet(#[from] ParquetError),
    /// The identity in the file is that of another study.
    #[error("it belongs to another study, or to another version of this one")]
    Other,
    /// Columns or rows do not agree with the plan.
    #[error("its columns or rows differ from those of the plan")]
    Shape,
}

fn schema(plan: &Plan) -> Result<TypePtr, ParquetError> {
    let field = |name: &str, physical: Physical, repetition: Repetition| {
        let logical = (physical == Physical::BYTE_ARRAY).then_some(LogicalType::String);
        let builder = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        builder.with_logical_type(logical).build().map(Arc::new)
    };
    let mut fields = vec![field("sample", Physical::INT64, Repetition::REQUIRED)?];
    for (name, kind) in plan.columns() {
        fields.push(match kind {
            Kind::Number => field(name, Physical::DOUBLE, Repetition::OPTIONAL)?,
            Kind::Word => field(name, Physical::BYTE_ARRAY, Repetition::OPTIONAL)?,
            Kind::Curve => field(name, Physical::DOUBLE, Repetition::REPEATED)?,
        });
    }
    fields.push(field("failed", Physical::BYTE_ARRAY, Repetition::OPTIONAL)?);
    Type::group_type_builder("study").with_fields(fields).build().map(Arc::new)
}

/// The bytes of a part; the same rows always give the same bytes.
///
/// # Errors
/// [`PartError::Parquet`], [`PartError::Shape`] for records that do not match the plan.
pub fn encode(plan: &Plan, records: &[Record]) -> Result<Vec<u8>, PartError> {
    let columns = plan.columns();
    if records.iter().any(|record| record.cells.len() != columns.len()) {
        return Err(PartError::Shape);
    }
    let metadata = vec![KeyValue::new(IDENTITY.to_owned(), plan.identity().to_owned())];
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema(plan)?, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let numbers: Vec<i64> = records.iter().map(|record| record.number as i64).collect();
    write::<Int64Type>(&mut group, &numbers, None, None)?;
    for (index, (_, kind)) in columns.iter().enumerate() {
        let cells = records.iter().map(|record| &record.cells[index]);
        match kind {
            Kind::Number => {
                let values: Vec<f64> = cells.clone().filter_map(Cell::number).collect();
                let there: Vec<i16> = cells.map(|cell| i16::from(cell.number().is_some())).collect();
                write::<DoubleType>(&mut group, &values, Some(&there), None)?;
            }
            Kind::Word => {
                let words = cells.map(|cell| match cell {
                    Cell::Word(word) => Some(word.as_str()),
                    _ => None,
                });
                write_words(&mut group, words)?;
            }
            Kind::Curve => {
                let (mut values, mut there, mut again) = (Vec::new(), Vec::new(), Vec::new());
                for cell in cells {
                    match cell {
                        Cell::Curve(curve) if !curve.is_empty() => {
                            values.extend_from_slice(curve);
                            there.extend(curve.iter().map(|_| 1_i16));
                            again.extend((0..curve.len()).map(|k| i16::from(k > 0)));
                        }
                        _ => {
                            there.push(0);
                            again.push(0);
                        }
                    }
                }
                write::<DoubleType>(&mut group, &values, Some(&there), Some(&again))?;
            }
        }
    }
    write_words(&mut group, records.iter().map(|record| record.failed.as_deref()))?;
    group.close()?;
    Ok(writer.into_inner()?)
}

fn write<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    values: &[T::T],
    there: Option<&[i16]>,
    again: Option<&[i16]>,
) -> Result<(), PartError> {
    let mut column = group.next_column()?.ok_or(PartError::Shape)?;
    column.typed::<T>().write_batch(values, there, again)?;
    Ok(column.close()?)
}

fn write_words<'a>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    words: impl Iterator<Item = Option<&'a str>> + Clone,
) -> Result<(), PartError> {
    let there: Vec<i16> = words.clone().map(|word| i16::from(word.is_some())).collect();
    let values: Vec<ByteArray> = words.flatten().map(ByteArray::from).collect();
    write::<ByteArrayType>(group, &values, Some(&there), None)
}

/// The computed rows of a part, in their order; an incomplete part contains fewer.
///
/// # Errors
/// [`PartError`]: not a Parquet file, another identity, other columns, rows of another part.
pub fn decode(plan: &Plan, part: u64, bytes: Vec<u8>) -> Result<Vec<Record>, PartError> {
    let reader = SerializedFileReader::new(bytes::Bytes::from(bytes))?;
    let metadata = reader.metadata();
    let identity = metadata
        .file_metadata()
        .key_value_metadata()
        .and_then(|all| all.iter().find(|entry| entry.key == IDENTITY))
        .and_then(|entry| entry.value.as_deref());
    if identity != Some(plan.identity()) {
        return Err(PartError::Other);
    }
    if metadata.file_metadata().schema() != schema(plan)?.as_ref() || metadata.num_row_groups() != 1 {
        return Err(PartError::Shape);
    }
    let rows = usize::try_from(metadata.file_metadata().num_rows()).map_err(|_| PartError::Shape)?;
    let expected = plan.rows_of(part);
    if rows as u64 > expected.end.saturating_sub(expected.start) {
        return Err(PartError::Shape);
    }
    let group = reader.get_row_group(0)?;
    let group = group.as_ref();
    let (numbers, ..) = read::<Int64Type>(group, 0, rows)?;
    let mut records: Vec<Record> = numbers
        .iter()
        .map(|number| Record { number: *number as u64, cells: Vec::new(), failed: None })
        .collect();
    let in_order = records.windows(2).all(|pair| pair[0].number < pair[1].number);
    if records.len() != rows || !in_order || !records.iter().all(|r| expected.contains(&r.number)) {
        return Err(PartError::Shape);
    }
    let columns = plan.columns();
    for (index, (_, kind)) in columns.iter().enumerate() {
        let cells = match kind {
            Kind::Number => {
                let (values, there, _) = read::<DoubleType>(group, index + 1, rows)?;
                spread(values, &there, Cell::Number)
            }
            Kind::Word => words(group, index + 1, rows)?
                .into_iter()
                .map(|word| word.map_or(Cell::Absent, Cell::Word))
                .collect(),
            Kind::Curve => curves(group, index + 1, rows)?,
        };
        if cells.len() != rows {
            return Err(PartError::Shape);
        }
        records.iter_mut().zip(cells).for_each(|(record, cell)| record.cells.push(cell));
    }
    let failed = words(group, columns.len() + 1, rows)?;
    records.iter_mut().zip(failed).for_each(|(record, failed)| record.failed = failed);
    Ok(records)
}

type Levels = (Vec<i16>, Vec<i16>);

fn read<T: DataType>(
    group: &dyn RowGroupReader,
    column: usize,
    rows: usize,
) -> Result<(Vec<T::T>, Vec<i16>, Vec<i16>), PartError> {
    let mut reader = get_typed_column_reader::<T>(group.get_column_reader(column)?);
    let (mut values, (mut there, mut again)): (Vec<T::T>, Levels) = Default::default();
    let mut done = 0;
    while done < rows {
        let (records, ..) =
            reader.read_records(rows - done, Some(&mut there), Some(&mut again), &mut values)?;
        if records == 0 {
            break;
        }
        done += records;
    }
    Ok((values, there, again))
}

fn spread<T>(values: Vec<T>, there: &[i16], cell: fn(T) -> Cell) -> Vec<Cell> {
    let mut values = values.into_iter();
    there
        .iter()
        .map(|there| if *there == 1 { values.next().map_or(Cell::Absent, cell) } else { Cell::Absent })
        .collect()
}

fn words(group: &dyn RowGroupReader, column: usize, rows: usize) -> Result<Vec<Option<String>>, PartError> {
    let (values, there, _) = read::<ByteArrayType>(group, column, rows)?;
    let mut values = values.into_iter();
    there
        .iter()
        .map(|there| match (*there == 1).then(|| values.next()).flatten() {
            None => Ok(None),
            Some(bytes) => match bytes.as_utf8() {
                Ok(word) => Ok(Some(word.to_owned())),
                Err(_) => Err(PartError::Shape),
            },
        })
        .collect()
}

fn curves(group: &dyn RowGroupReader, column: usize, rows: usize) -> Result<Vec<Cell>, PartError> {
    let (values, there, again) = read::<DoubleType>(group, column, rows)?;
    let mut values = values.into_iter();
    let mut cells: Vec<Cell> = Vec::new();
    for (there, again) in there.iter().zip(&again) {
        let value = (*there == 1).then(|| values.next()).flatten();
        match (again, value, cells.last_mut()) {
            (0, Some(value), _) => cells.push(Cell::Curve(vec![value])),
            (0, None, _) => cells.push(Cell::Absent),
            (_, Some(value), Some(Cell::Curve(curve))) => curve.push(value),
            _ => return Err(PartError::Shape),
        }
    }
    Ok(cells)
}
