//! A table as text with commas (RFC 4180).
//!
//! Must never do: write a number so that another one is read.

use super::{Cell, Row, Table};
use crate::{ExportError, target, utc};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

pub struct Comma {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
}

impl Table for Comma {
    const ENDING: &'static str = "csv";

    fn create(path: &Path, first: &Row) -> Result<Self, ExportError> {
        let mut writer = csv::Writer::from_writer(target::file(path)?);
        let names = writer.write_record(first.iter().map(|(name, _)| name));
        names.map_err(|error| ExportError::write(path, error))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
        })
    }

    fn add(&mut self, row: Row) -> Result<(), ExportError> {
        let written = self.writer.write_record(row.into_iter().map(|(_, cell)| text(cell)));
        written.map_err(|error| ExportError::write(&self.path, error))
    }

    fn finish(self) -> Result<(), ExportError> {
        let file = self.writer.into_inner();
        let file = file.map_err(|error| ExportError::write(&self.path, error.error()))?;
        target::finish(&self.path, file)
    }
}

fn text(cell: Cell) -> String {
    match cell {
        Cell::Moment(unix_ns) => utc::precise(unix_ns),
        Cell::Text(text) => text.unwrap_or_default(),
        Cell::Real(number) => number.map_or_else(String::new, |number| number.to_string()),
        Cell::Count(number) => number.map_or_else(String::new, |number| number.to_string()),
        Cell::Truth(truth) => truth.map_or_else(String::new, |truth| truth.to_string()),
    }
}
