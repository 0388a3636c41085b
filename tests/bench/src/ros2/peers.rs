//! The rclpy programs of the bench: their environment, their start, what they tell.
//!
//! Must never do: leave ROS 2's libraries to the program under test.

use crate::error::BenchError;
use crate::process::Part;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::process::Command;

/// What they run.
const SCRIPT: &str = include_str!("peer.py");
/// How long discovery and the first answers may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// What the one that asks tells; all times in microseconds.
#[derive(Debug, Clone, Default, Deserialize)]
pub(crate) struct Asked {
    pub questions: usize,
    pub one_way_us: Vec<u32>,
    pub there_and_back_us: Vec<u32>,
    pub by_timer_us: Vec<u32>,
    /// Below zero where the clocks of vehicle and node are not yet put together exactly.
    pub pose_age_us: Vec<i64>,
    pub pose_every_us: Vec<u32>,
    pub rclpy_call_us: Vec<u32>,
    pub skein_call_us: Vec<u32>,
    pub refused: usize,
    pub unanswered: usize,
}

/// What the one that listens tells.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
pub(crate) struct Heard {
    pub poses: usize,
}

/// A Python with rclpy.
pub(crate) struct Ros2Python {
    python: PathBuf,
    environment: PathBuf,
    files: TempDir,
}

impl Ros2Python {
    /// The one of a virtual environment.
    pub fn at(python: &Path) -> Result<Self, BenchError> {
        let environment = python.parent().and_then(Path::parent);
        let environment = environment
            .filter(|folder| folder.join("share").is_dir())
            .ok_or_else(|| {
                BenchError::Argument(format!(
                    "{} is no Python of an environment with ROS 2; `cargo xtask bench ros2` makes one",
                    python.display()
                ))
            })?;
        let files = TempDir::with_prefix("skein-bench-").map_err(BenchError::system("temporary directory"))?;
        std::fs::write(files.path().join("peer.py"), SCRIPT).map_err(BenchError::system("temporary file"))?;
        Ok(Self {
            python: python.to_owned(),
            environment: environment.to_owned(),
            files,
        })
    }

    /// Starts one of the programs.
    pub fn start(&self, role: &str, more: &[String], domain_id: u16) -> Result<Part, BenchError> {
        let mut command = Command::new(&self.python);
        command
            .env("ROS_DOMAIN_ID", domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
            .env("AMENT_PREFIX_PATH", &self.environment)
            .env("LD_LIBRARY_PATH", self.environment.join("lib"))
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .arg("-u")
            .arg(self.files.path().join("peer.py"))
            .arg(role);
        let more: Vec<&str> = more.iter().map(String::as_str).collect();
        Part::start_by("rclpy program", command, &more, Stdio::inherit())
    }
}

/// Waits until it has heard everybody it speaks with.
pub(crate) async fn ready(part: &mut Part) -> Result<(), BenchError> {
    let begun = Instant::now();
    loop {
        let line = part.line().await?;
        if line == "ready" {
            return Ok(());
        }
        if begun.elapsed() > PATIENCE {
            return Err(BenchError::Program(format!(
                "an rclpy program {line}, for {} s",
                PATIENCE.as_secs()
            )));
        }
        eprintln!("an rclpy program {line}");
    }
}

/// What it tells at the end of a window.
pub(crate) async fn told<T: DeserializeOwned>(part: &mut Part) -> Result<T, BenchError> {
    loop {
        let line = part.line().await?;
        if line.starts_with('{') {
            return serde_json::from_str(&line).map_err(BenchError::Settings);
        }
    }
}
