//! A table by column (Apache Parquet), packed with zstd.
//!
//! Must never do: keep more than one group of rows in memory.

use super::{Cell, Row, Table};
use crate::{ExportError, target};
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows of a group.
const GROUP: usize = 16_384;

pub struct Parquet {
    path: PathBuf,
    writer: SerializedFileWriter<BufWriter<File>>,
    /// By column the cells that wait.
    columns: Vec<Vec<Cell>>,
    rows: usize,
}

impl Table for Parquet {
    const ENDING: &'static str = "parquet";

    fn create(path: &Path, first: &Row) -> Result<Self, ExportError> {
        let file = target::file(path)?;
        let begun = schema(first).and_then(|schema| {
            let properties = WriterProperties::builder()
                .set_compression(Compression::ZSTD(ZstdLevel::default()))
                .build();
            SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
        });
        Ok(Self {
            path: path.to_owned(),
            writer: begun.map_err(|error| ExportError::write(path, error))?,
            columns: vec![Vec::new(); first.len()],
            rows: 0,
        })
    }

    fn add(&mut self, row: Row) -> Result<(), ExportError> {
        for (column, (_, cell)) in self.columns.iter_mut().zip(row) {
            column.push(cell);
        }
        self.rows += 1;
        if self.rows == GROUP { self.group() } else { Ok(()) }
    }

    fn finish(mut self) -> Result<(), ExportError> {
        if self.rows > 0 {
            self.group()?;
        }
        let file = self
            .writer
            .into_inner()
            .map_err(|error| ExportError::write(&self.path, error))?;
        target::finish(&self.path, file)
    }
}

impl Parquet {
    fn group(&mut self) -> Result<(), ExportError> {
        let written = self.write_group();
        self.rows = 0;
        written.map_err(|error| ExportError::write(&self.path, error))
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for cells in &mut self.columns {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            write_column(&mut column, std::mem::take(cells))?;
            column.close()?;
        }
        group.close()?;
        Ok(())
    }
}

fn schema(row: &Row) -> Result<Type, ParquetError> {
    let fields = row.iter().map(|(name, cell)| {
        let (physical, logical) = match cell {
            Cell::Moment(_) => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
            Cell::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Cell::Real(_) => (Physical::DOUBLE, None),
            Cell::Count(_) => (Physical::INT64, None),
            Cell::Truth(_) => (Physical::BOOLEAN, None),
        };
        Type::primitive_type_builder(name, physical)
            .with_logical_type(logical)
            .with_repetition(Repetition::OPTIONAL)
            .build()
            .map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    Type::group_type_builder("skein").with_fields(fields).build()
}

/// The values that are there, and for each row whether there is one.
fn values<D: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    cells: impl Iterator<Item = Option<D::T>>,
) -> Result<(), ParquetError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        levels.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    column.typed::<D>().write_batch(&values, Some(&levels), None)?;
    Ok(())
}

fn write_column(column: &mut SerializedColumnWriter<'_>, cells: Vec<Cell>) -> Result<(), ParquetError> {
    match cells.first() {
        None => Ok(()),
        Some(Cell::Text(_)) => values::<ByteArrayType>(
            column,
            cells.into_iter().map(|cell| match cell {
                Cell::Text(text) => text.map(|text| ByteArray::from(text.into_bytes())),
                _ => None,
            }),
        ),
        Some(Cell::Real(_)) => values::<DoubleType>(
            column,
            cells.into_iter().map(|cell| match cell {
                Cell::Real(number) => number,
                _ => None,
            }),
        ),
        Some(Cell::Truth(_)) => values::<BoolType>(
            column,
            cells.into_iter().map(|cell| match cell {
                Cell::Truth(truth) => truth,
                _ => None,
            }),
        ),
        Some(Cell::Moment(_) | Cell::Count(_)) => values::<Int64Type>(
            column,
            cells.into_iter().map(|cell| match cell {
                Cell::Moment(unix_ns) => i64::try_from(unix_ns / 1_000).ok(),
                Cell::Count(number) => number,
                _ => None,
            }),
        ),
    }
}
