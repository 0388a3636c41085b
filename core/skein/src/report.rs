//! `skein report`: makes the report of a recorded flight, as a page for people or as facts for programs.
//!
//! Must never do: overwrite the recording, or fail because a recording is damaged as long as something of it can be read.

use anyhow::{Context, bail};
use clap::Args;
use skein_report::Report;
use std::fs;
use std::path::{Path, PathBuf};

/// `skein report`
#[derive(Debug, Clone, Args)]
pub struct ReportArguments {
    /// The recording: a file that ends in `.mcap`.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where the page goes; `-` for standard output [default: beside the recording, with `.html` at its end].
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write the facts as JSON instead, to standard output unless `--out` says otherwise.
    #[arg(long)]
    pub json: bool,
    /// Times on the page are so far ahead of UTC, for example `+02:00`.
    #[arg(long, value_name = "±HH:MM", value_parser = offset_s, default_value = "+00:00", allow_hyphen_values = true)]
    pub utc_offset: i32,
}

/// An offset from UTC in seconds.
fn offset_s(text: &str) -> Result<i32, String> {
    let wrong = || "an offset such as +02:00 or -03:30 is needed".to_owned();
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let (hours, minutes) = digits.split_once(':').unwrap_or((digits, "0"));
    let number = |part: &str| part.parse::<u8>().map(i32::from).map_err(|_| wrong());
    let (hours, minutes) = (number(hours)?, number(minutes)?);
    if hours > 14 || minutes > 59 {
        return Err(wrong());
    }
    Ok(sign * (hours * 3600 + minutes * 60))
}

/// Makes the report.
///
/// # Errors
/// When the file is no recording, nothing of it can be read, or the page cannot be written.
pub fn report(arguments: &ReportArguments) -> anyhow::Result<()> {
    let file = &arguments.file;
    let recording = crate::log::open(file)?;
    let report = Report::of(&recording).with_context(|| file.display().to_string())?;
    let report = report.at_utc_offset_s(arguments.utc_offset);
    let told = if arguments.json {
        serde_json::to_string_pretty(&report)? + "\n"
    } else {
        skein_report::html(&report)
    };
    let to = match &arguments.out {
        Some(to) => to.clone(),
        None if arguments.json => PathBuf::from("-"),
        None => file.with_extension("html"),
    };
    if to == Path::new("-") {
        print!("{told}");
        return Ok(());
    }
    // A page over the recording would be the end of it.
    let same = fs::canonicalize(&to).ok().zip(fs::canonicalize(file).ok());
    if same.is_some_and(|(to, file)| to == file) {
        bail!(
            "{} is the recording itself: choose another file with --out",
            to.display()
        );
    }
    fs::write(&to, told).with_context(|| format!("cannot write {}", to.display()))?;
    println!("{}", report.verdict.join(" "));
    println!("{}", to.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    //! Offsets are read, and a recording is not overwritten.

    use super::*;

    #[test]
    fn offsets_are_read() {
        assert_eq!(offset_s("+02:00"), Ok(7200));
        assert_eq!(offset_s("-03:30"), Ok(-12_600));
        assert_eq!(offset_s("1"), Ok(3600));
        assert!(offset_s("15:00").is_err() && offset_s("UTC").is_err() && offset_s("").is_err());
    }

    #[test]
    fn what_is_no_recording_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("notes.mcap");
        fs::write(&file, "no recording").expect("is written");
        let arguments = ReportArguments {
            file: file.clone(),
            out: None,
            json: false,
            utc_offset: 0,
        };
        let error = report(&arguments).expect_err("is none").to_string();
        assert!(error.contains("notes.mcap") && error.contains("MCAP"), "{error}");
        assert!(!file.with_extension("html").exists());
    }
}
