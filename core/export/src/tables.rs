//! Tables: telemetry, setpoints and events, a row for each message, columns with their units in their names.
//!
//! Must never do: give one column two types, or fill in what was not recorded.

mod comma;
mod parquet;
mod rows;

use crate::told::{Kind, Told, each};
use crate::{ExportError, Exported, Progress, target};
use skein_recording::{Recording, Topic};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One value; nothing where nothing was recorded.
#[derive(Debug, Clone, PartialEq)]
enum Cell {
    /// A moment in nanoseconds since 1970.
    Moment(u64),
    Text(Option<String>),
    Real(Option<f64>),
    Count(Option<i64>),
    Truth(Option<bool>),
}

/// The names of columns with the values of one row.
type Row = Vec<(&'static str, Cell)>;

/// A table that is being written.
trait Table: Sized {
    /// How its file ends.
    const ENDING: &'static str;

    /// Begins one with the columns of this row.
    fn create(path: &Path, first: &Row) -> Result<Self, ExportError>;

    fn add(&mut self, row: Row) -> Result<(), ExportError>;

    fn finish(self) -> Result<(), ExportError>;
}

/// As text with commas.
pub fn csv(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    write::<comma::Comma>(recording, out, progress)
}

/// By column.
pub fn parquet(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    write::<parquet::Parquet>(recording, out, progress)
}

fn write<T: Table>(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    let folder = target::folder(out)?;
    let mut tables: BTreeMap<&'static str, (PathBuf, T)> = BTreeMap::new();
    let mut exported = Exported::default();
    let wants = |topic: &Topic| matches!(topic, Topic::Telemetry(_) | Topic::Setpoint(_) | Topic::Events);
    let unread = each(recording, wants, progress, |told| {
        let Some((name, row)) = row(told) else {
            return Ok(());
        };
        if !tables.contains_key(name) {
            let path = folder.join(format!("{name}.{}", T::ENDING));
            let table = T::create(&path, &row)?;
            tables.insert(name, (path, table));
        }
        if let Some((_, table)) = tables.get_mut(name) {
            table.add(row)?;
            exported.count(name);
        }
        Ok::<_, ExportError>(())
    })?;
    for (path, table) in tables.into_values() {
        table.finish()?;
        exported.files.push(path);
    }
    Ok(exported.without(unread))
}

fn row(told: &Told) -> Option<(&'static str, Row)> {
    match &told.kind {
        Kind::Telemetry(telemetry) => Some(("telemetry", rows::telemetry(told, telemetry))),
        Kind::Setpoint(setpoint) => Some(("setpoints", rows::setpoint(told, setpoint))),
        Kind::Event(event) => Some(("events", rows::event(told, event))),
        Kind::Fleet(_) => None,
    }
}
