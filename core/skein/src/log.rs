//! `skein log`: recordings after the flight: which there are, what is in them, whether they are whole, and what is made of them.
//!
//! Must never do: change a recording. What it finds goes to standard output, progress to standard error.

mod arguments;
mod progress;
mod show;

pub use arguments::LogArguments;
use arguments::{ExportFormat, LogCommand};
use progress::Bar;
use skein_export::{Exported, Format, Overview};
use skein_recording::{Damage, Recording};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Carries out one of them.
///
/// # Errors
/// When a file is no recording, or something cannot be written.
pub fn log(arguments: LogArguments) -> anyhow::Result<ExitCode> {
    match arguments.command {
        LogCommand::List { folder, json } => list(&folder, json),
        LogCommand::Info { file, json } => info(&file, json),
        LogCommand::Check { files } => check(&files),
        LogCommand::Export { file, format, out } => export(&file, format, &out),
        LogCommand::Merge { files, out } => merge(&files, &out),
        LogCommand::Cut {
            file,
            from_s,
            until_s,
            out,
        } => cut(&file, from_s, until_s, &out),
        LogCommand::Decisions { file, out } => decisions(&file, &out),
        LogCommand::Redecide { file } => redecide(&file),
    }
}

fn list(folder: &Path, json: bool) -> anyhow::Result<ExitCode> {
    let (found, others) = skein_export::list(folder)?;
    if json {
        println!("{}", serde_json::to_string_pretty(&found)?);
    } else if found.is_empty() {
        println!("No recordings in {}.", folder.display());
    } else {
        show::list(&found, folder);
    }
    for other in others {
        eprintln!("skein: {other}");
    }
    Ok(ExitCode::SUCCESS)
}

fn info(file: &Path, json: bool) -> anyhow::Result<ExitCode> {
    let overview = Overview::with_events(&open(file)?);
    if json {
        println!("{}", serde_json::to_string_pretty(&overview)?);
    } else {
        show::info(&overview);
    }
    Ok(ExitCode::SUCCESS)
}

fn check(files: &[PathBuf]) -> anyhow::Result<ExitCode> {
    let recordings = opened(files)?;
    let mut bar = Bar::new("checking");
    let found = skein_export::check(&recordings, &mut |share| bar.at(share));
    drop(bar);
    for finding in &found.findings {
        println!("{finding}");
    }
    let (messages, audited) = (found.messages, found.audited);
    if found.findings.is_empty() {
        println!("Whole: {messages} messages; records of the audit that follow on each other: {audited}.");
        return Ok(ExitCode::SUCCESS);
    }
    let count = found.findings.len();
    println!(
        "{count} {} in {messages} messages.",
        if count == 1 { "finding" } else { "findings" }
    );
    Ok(ExitCode::FAILURE)
}

fn opened(files: &[PathBuf]) -> anyhow::Result<Vec<Recording>> {
    files.iter().map(|file| open(file)).collect()
}

pub(crate) fn open(file: &Path) -> anyhow::Result<Recording> {
    // One without its summary is gone through: a large one takes minutes.
    let mut bar = Bar::new("opening");
    Ok(Recording::open_telling(file, &mut |share| bar.at(share))?)
}

/// What could not be read is said, and is no failure: the rest is there.
fn tell_damage(damage: &[Damage], unreadable: u64) {
    if !damage.is_empty() || unreadable > 0 {
        let parts = damage.len();
        eprintln!(
            "skein: {parts} parts and {unreadable} messages of it cannot be read and are left out; `skein log check` names them"
        );
    }
}

fn export(file: &Path, format: ExportFormat, out: &Path) -> anyhow::Result<ExitCode> {
    let format = match format {
        ExportFormat::Csv => Format::Csv,
        ExportFormat::Parquet => Format::Parquet,
        ExportFormat::Kml => Format::Kml,
        ExportFormat::Gpx => Format::Gpx,
        ExportFormat::Rosbag => Format::Rosbag,
        ExportFormat::Tlog => Format::Tlog,
    };
    let recording = open(file)?;
    let mut bar = Bar::new("writing");
    let written = skein_export::export(&recording, format, out, &mut |share| bar.at(share));
    drop(bar);
    let Exported {
        files,
        counts,
        unreadable,
        damage,
    } = written?;
    tell_damage(&damage, unreadable);
    for (name, count) in counts {
        println!("{count:>10}  {name}");
    }
    for file in files {
        println!("Written: {}", file.display());
    }
    Ok(ExitCode::SUCCESS)
}

fn merge(files: &[PathBuf], out: &Path) -> anyhow::Result<ExitCode> {
    let recordings = opened(files)?;
    let mut bar = Bar::new("merging");
    let report = skein_export::merge(&recordings, out, &mut |share| bar.at(share));
    drop(bar);
    let report = report?;
    tell_damage(&report.written.damage, 0);
    if !report.unmeasured.is_empty() {
        println!(
            "No offset of the clock was measured of {}: put in order by the time of day, as far as that was right.",
            report.unmeasured.join(", ")
        );
    }
    for (index, node) in report.nodes.iter().enumerate() {
        let own = if index == 0 {
            "under its topics' own names".to_owned()
        } else {
            format!("below /nodes/{node}")
        };
        println!("Node {node}: {own}");
    }
    println!("Written: {} ({} messages)", out.display(), report.written.messages);
    Ok(ExitCode::SUCCESS)
}

fn cut(file: &Path, from_s: f64, until_s: f64, out: &Path) -> anyhow::Result<ExitCode> {
    let recording = open(file)?;
    let mut bar = Bar::new("cutting");
    let written = skein_export::cut(&recording, from_s, until_s, out, &mut |share| bar.at(share));
    drop(bar);
    let written = written?;
    tell_damage(&written.damage, 0);
    println!("Written: {} ({} messages)", out.display(), written.messages);
    Ok(ExitCode::SUCCESS)
}

fn decisions(file: &Path, out: &Path) -> anyhow::Result<ExitCode> {
    let recording = open(file)?;
    let mut bar = Bar::new("writing");
    let written = skein_export::decisions(&recording, out, &mut |share| bar.at(share));
    drop(bar);
    let written = written?;
    tell_damage(&written.damage, 0);
    println!("Written: {} ({} messages)", out.display(), written.messages);
    redecide(out)
}

fn redecide(file: &Path) -> anyhow::Result<ExitCode> {
    let recording = open(file)?;
    let mut bar = Bar::new("deciding");
    let again = skein_export::redecide(&recording, &mut |share| bar.at(share));
    drop(bar);
    let again = again?;
    tell_damage(&again.damage, 0);
    let decided = again.decided;
    for difference in &decided.differences {
        println!("{difference}");
    }
    println!(
        "Made again: {} setpoints judged, {} steps of failsafe policies, {} formations planned, {} turns about the leadership.",
        decided.setpoints, decided.failsafe, decided.formations, decided.turns
    );
    println!(
        "Not made again: {} setpoints whose control period was thinned out, {} decisions without all that they were made from.",
        decided.thinned, decided.without_inputs
    );
    if decided.differences.is_empty() {
        println!("None comes out otherwise.");
        return Ok(ExitCode::SUCCESS);
    }
    println!("{} come out otherwise.", decided.differences.len());
    Ok(ExitCode::FAILURE)
}
