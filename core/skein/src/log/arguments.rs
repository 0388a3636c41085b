//! Arguments of `skein log`.

use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// `skein log`
#[derive(Debug, Clone, Args)]
pub struct LogArguments {
    /// What to do.
    #[command(subcommand)]
    pub command: LogCommand,
}

/// What `skein log` does.
#[derive(Debug, Clone, Subcommand)]
pub enum LogCommand {
    /// List the recordings of a folder.
    List {
        /// The folder; folders in it are looked into too.
        #[arg(default_value = ".")]
        folder: PathBuf,
        /// Print them as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Tell what is in a recording: topics, rates, vehicles, events, and whether it is whole.
    Info {
        /// The recording.
        file: PathBuf,
        /// Print it as JSON.
        #[arg(long)]
        json: bool,
    },
    /// Read recordings to the end: damage, gaps, and whether each record of the audit follows on the one before. Exit code 1 if not all is well.
    Check {
        /// The recordings. Of several files of one node each must follow on the one before.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Write a recording in the format of other programs.
    Export {
        /// The recording.
        file: PathBuf,
        /// The format.
        #[arg(long = "as", value_enum, value_name = "FORMAT")]
        format: ExportFormat,
        /// The file or folder to be made; it must not be there yet.
        #[arg(long, value_name = "PATH")]
        out: PathBuf,
    },
    /// Make one recording of those of several nodes, in the order in which things happened.
    Merge {
        /// The recordings; times are told on the clock of the first.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// The file to be made; it must not be there yet.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Make a recording of a part of one.
    Cut {
        /// The recording.
        file: PathBuf,
        /// From so many seconds after its beginning.
        #[arg(long = "from", value_name = "S")]
        from_s: f64,
        /// To so many seconds after its beginning.
        #[arg(long = "until", value_name = "S")]
        until_s: f64,
        /// The file to be made; it must not be there yet.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Write a recording's decisions with all that they were made from, and nothing else: a file small enough to be kept as a test.
    Decisions {
        /// The recording.
        file: PathBuf,
        /// The file to be made; it must not be there yet.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Make recorded decisions again, by this version of the program. Exit code 1 if one comes out otherwise.
    Redecide {
        /// The recording.
        file: PathBuf,
    },
}

/// Formats of other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportFormat {
    /// Tables as text: a folder with telemetry, setpoints and events.
    Csv,
    /// The same tables by column, for pandas, Polars or DuckDB: a folder.
    Parquet,
    /// A track for each vehicle for Google Earth: a file.
    Kml,
    /// A track for each vehicle for maps: a file.
    Gpx,
    /// A bag of ROS 2 (MCAP): a folder.
    Rosbag,
    /// A telemetry log of MAVLink for each vehicle, as ground stations keep them: a folder.
    Tlog,
}
