//! Parameter files as QGroundControl saves them, and how an autopilot differs from one.
//!
//! Must never do: write a parameter.

use super::Findings;
use super::running::{number, text};
use anyhow::{Context, bail};
use serde_json::Value;
use std::path::Path;

/// Real numbers pass through 32 bits and decimal digits.
const SAME: f64 = 1e-4;

/// One line of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// The value it is to have.
    pub value: f64,
}

/// Reads a file: a line for each parameter, of vehicle, component, name, value and type, apart by tabs; `#` begins a comment.
///
/// # Errors
/// It cannot be read, or a line is none; with its number.
pub fn read(file: &Path) -> anyhow::Result<Vec<Wanted>> {
    let whole = std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let mut wanted = Vec::new();
    for (index, line) in whole.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let read = of_line(line);
        wanted.push(read.with_context(|| format!("{}, line {}: {line}", file.display(), index + 1))?);
    }
    Ok(wanted)
}

fn of_line(line: &str) -> anyhow::Result<Wanted> {
    let [_, _, name, value, kind] = line.split('\t').collect::<Vec<_>>()[..] else {
        bail!("wanted are vehicle, component, name, value and type, apart by tabs");
    };
    let value: f64 = value.trim().parse().context("the value is no number")?;
    // MAV_PARAM_TYPE: 6 is INT32, 9 is REAL32; PX4 has no others.
    let is_whole = match kind.trim() {
        "6" => true,
        "9" => false,
        other => bail!("type {other} is neither 6 (whole number) nor 9 (real number)"),
    };
    if !value.is_finite() || is_whole && value.fract() != 0.0 {
        bail!("{value} does not fit its type");
    }
    let name = name.trim().to_owned();
    Ok(Wanted { name, value })
}

/// Tells how what an autopilot has differs from what is wanted. What it does not know is not told here.
pub fn compare(vehicle: u16, wanted: &[Wanted], known: &[Value], findings: &mut Findings) {
    let mut same = 0;
    for Wanted { name, value } in wanted {
        let Some(has) = known.iter().find(|known| text(known, "/name") == name) else {
            continue;
        };
        let has = number(has, "/value/value").unwrap_or(f64::NAN);
        if (has - value).abs() <= SAME * value.abs().max(1.0) {
            same += 1;
        } else {
            findings.poor(
                format_args!("parameters: vehicle {vehicle} has {name} = {has}, not {value}"),
                "set it in the dashboard's parameters, or load the file with QGroundControl",
            );
        }
    }
    findings.good(format_args!(
        "parameters: {same} of vehicle {vehicle} are as the file wants them"
    ));
}

#[cfg(test)]
mod tests;
