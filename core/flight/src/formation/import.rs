//! Offsets of a free shape from a table or a list.

use skein_domain::OffsetFrd;
use thiserror::Error;

/// Why a table or list of offsets cannot be read. Lines count from 1.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum OffsetsError {
    /// There is no offset in it.
    #[error("there is no offset in it")]
    Empty,
    /// More offsets than a formation can have members.
    #[error("more than {most} offsets")]
    TooMany {
        /// The most that are read.
        most: usize,
    },
    /// A heading names something else.
    #[error("line {line}: column {column:?}; known are forward_m, right_m, down_m and up_m")]
    UnknownColumn {
        /// Where.
        line: u64,
        /// What it says.
        column: String,
    },
    /// A heading lacks a column, or has it twice, or has down as well as up.
    #[error("line {line}: the headings must be forward_m, right_m and one of down_m and up_m, each once")]
    Columns {
        /// Where.
        line: u64,
    },
    /// A row has more or fewer fields than there are columns.
    #[error("line {line}: {fields} fields instead of three")]
    Fields {
        /// Where.
        line: u64,
        /// How many.
        fields: usize,
    },
    /// A field is no finite number.
    #[error("line {line}: {text:?} is not a finite number")]
    NotANumber {
        /// Where.
        line: u64,
        /// What it says.
        text: String,
    },
    /// The text is no list of offsets.
    #[error("line {line}: {detail}")]
    Syntax {
        /// Where.
        line: u64,
        /// What is wrong with it.
        detail: String,
    },
}

/// More offsets are no formation but a mistake, or an attempt to fill the memory.
pub const MOST_OFFSETS: usize = 10_000;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Forward,
    Right,
    Down,
    Up,
}

/// Offsets from a table of three columns separated by commas: `forward_m,right_m,down_m` in that order, or as its heading names them
/// (`up_m` instead of `down_m`, in any order). Blank lines and those that begin with `#` are left out.
///
/// # Errors
/// [`OffsetsError`] with the line.
pub fn offsets_from_csv(text: &str) -> Result<Vec<OffsetFrd>, OffsetsError> {
    let mut columns = [Column::Forward, Column::Right, Column::Down];
    let mut offsets = Vec::new();
    let rows = text
        .trim_start_matches('\u{feff}')
        .lines()
        .zip(1_u64..)
        .map(|(row, line)| (row.trim(), line))
        .filter(|(row, _)| !row.is_empty() && !row.starts_with('#'));
    for (at, (row, line)) in rows.enumerate() {
        // Numbers need no quotes, but some programs put them around headings.
        let fields: Vec<&str> = row.split(',').map(|field| field.trim().trim_matches('"')).collect();
        // A first row without any number in it is a heading; one with some is a row with a mistake.
        if at == 0 && fields.iter().all(|field| field.parse::<f64>().is_err()) {
            columns = heading(&fields, line)?;
            continue;
        }
        if fields.len() != columns.len() {
            return Err(OffsetsError::Fields {
                line,
                fields: fields.len(),
            });
        }
        let mut offset = OffsetFrd::default();
        for (column, field) in columns.iter().zip(&fields) {
            let value = number(field, line)?;
            match column {
                Column::Forward => offset.forward_m = value,
                Column::Right => offset.right_m = value,
                Column::Down => offset.down_m = value,
                Column::Up => offset.down_m = 0.0 - value,
            }
        }
        push(&mut offsets, offset)?;
    }
    not_empty(offsets)
}

fn heading(fields: &[&str], line: u64) -> Result<[Column; 3], OffsetsError> {
    let named = |name: &&str| match name.to_ascii_lowercase().as_str() {
        "forward_m" => Ok(Column::Forward),
        "right_m" => Ok(Column::Right),
        "down_m" => Ok(Column::Down),
        "up_m" => Ok(Column::Up),
        _ => Err(OffsetsError::UnknownColumn {
            line,
            column: shortened(name),
        }),
    };
    let columns: Vec<Column> = fields.iter().map(named).collect::<Result<_, _>>()?;
    let columns: [Column; 3] = columns.try_into().map_err(|_| OffsetsError::Columns { line })?;
    let times = |wanted: &[Column]| columns.iter().filter(|column| wanted.contains(column)).count();
    if times(&[Column::Forward]) == 1 && times(&[Column::Right]) == 1 && times(&[Column::Down, Column::Up]) == 1 {
        Ok(columns)
    } else {
        Err(OffsetsError::Columns { line })
    }
}

fn number(text: &str, line: u64) -> Result<f64, OffsetsError> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(OffsetsError::NotANumber {
            line,
            text: shortened(text),
        }),
    }
}

/// What is quoted back of a field.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

fn push(offsets: &mut Vec<OffsetFrd>, offset: OffsetFrd) -> Result<(), OffsetsError> {
    if offsets.len() == MOST_OFFSETS {
        return Err(OffsetsError::TooMany { most: MOST_OFFSETS });
    }
    offsets.push(offset);
    Ok(())
}

fn not_empty(offsets: Vec<OffsetFrd>) -> Result<Vec<OffsetFrd>, OffsetsError> {
    if offsets.is_empty() {
        Err(OffsetsError::Empty)
    } else {
        Ok(offsets)
    }
}

/// One offset of a list. Unknown or doubled names match none of the forms.
#[derive(serde::Deserialize)]
#[serde(
    untagged,
    expecting = "an offset is an object with forward_m, right_m and one of down_m and up_m, or a list of three numbers"
)]
enum Listed {
    Down(Down),
    Up(Up),
    Plain([f64; 3]),
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Down {
    forward_m: f64,
    right_m: f64,
    down_m: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Up {
    forward_m: f64,
    right_m: f64,
    up_m: f64,
}

/// Offsets from a JSON list: of objects with `forward_m`, `right_m` and `down_m` or `up_m`, or of lists of three numbers (forward,
/// right, down).
///
/// # Errors
/// [`OffsetsError`] with the line.
pub fn offsets_from_json(text: &str) -> Result<Vec<OffsetFrd>, OffsetsError> {
    let listed: Vec<Listed> = serde_json::from_str(text).map_err(|e| OffsetsError::Syntax {
        line: e.line() as u64,
        detail: e.to_string(),
    })?;
    let mut offsets = Vec::new();
    for entry in listed {
        let offset = match entry {
            Listed::Down(place) => OffsetFrd::new(place.forward_m, place.right_m, place.down_m),
            Listed::Up(place) => OffsetFrd::new(place.forward_m, place.right_m, 0.0 - place.up_m),
            Listed::Plain([forward_m, right_m, down_m]) => OffsetFrd::new(forward_m, right_m, down_m),
        };
        push(&mut offsets, offset)?;
    }
    not_empty(offsets)
}
