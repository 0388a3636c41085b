//! The configuration of a node: typed, with units in the key names, unknown keys refused, checked whole before any socket opens.
//! `default.toml` beside this crate documents every key; a test parses it and compares it with the defaults here.
//!
//! Must never do: open sockets, read anything but the one file it is asked to read and the fence files that it names, fill in a value silently that was given wrongly.
#![forbid(unsafe_code)]

mod check;
mod dds;
mod energy_settings;
mod failsafe_settings;
mod fences;
mod ids;
mod loading;
mod operators;
mod preflight_settings;
mod problem;
mod recorder;
mod resume;
mod ros2;
pub mod settings;
mod swarm;
mod tracking;
mod upgrade;
mod video;

pub use dds::{DdsPeer, DdsPeerError, DdsSettings, LinkKind};
pub use fences::{FenceFault, FenceFileError, ImportedFences, parse_fences, read_fence_file, to_geojson};
pub use ids::SystemIdSet;
pub use loading::Overlay;
pub use operators::OperatorSettings;
pub use problem::Problem;
pub use recorder::RecorderSettings;
pub use resume::{ResumeSettings, ResumeThen};
pub use ros2::Ros2Settings;
pub use settings::{
    AdoptionRule, CoordinatorSettings, EndpointSettings, Escalation, FaultSettings, FenceSettings, Isolation,
    LinkSettings, NewcomerSettings, NodeConfig, NodeSettings, OnStop, PayloadRule, PluginSettings, ReturningSettings,
    SafetySettings, WebSettings,
};
pub use swarm::{Apart, SwarmSettings, SwarmTransport, ZenohSettings};
pub use tracking::TrackingSettings;
pub use upgrade::UpgradeSettings;
pub use video::{RtpQuality, RtpSettings, VideoSettings};

use std::path::{Path, PathBuf};
use thiserror::Error;

/// The documented default configuration, as text.
pub const DEFAULT_TOML: &str = include_str!("../default.toml");

/// Why a configuration could not be used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file could not be read.
    #[error("cannot read the configuration {path}: {source}")]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is not TOML, a key is unknown, or a value has the wrong type. The message names line and key.
    #[error("the configuration {path} does not parse:\n{message}")]
    Unparsable {
        /// Which file; `<text>` for text.
        path: PathBuf,
        /// The parser's message with line and column.
        message: String,
    },
    /// It parses, but values make no sense; all of them are listed.
    #[error("the configuration {path} is wrong:\n{}", problems.iter().map(|p| format!("  {p}")).collect::<Vec<_>>().join("\n"))]
    Wrong {
        /// Which file; `<text>` for text.
        path: PathBuf,
        /// Everything that is wrong.
        problems: Vec<Problem>,
    },
    /// A value that is set beside the file does not fit it.
    #[error("--set {argument}: {message}")]
    Set {
        /// As it was given.
        argument: String,
        /// What is wrong with it.
        message: String,
    },
    /// A fence file that it names cannot be used, or its zones cannot be placed.
    #[error("the configuration {path}: safety: {source}")]
    Fences {
        /// Which configuration.
        path: PathBuf,
        /// What is wrong.
        source: Box<FenceFileError>,
    },
}

impl NodeConfig {
    /// Parses and checks a configuration text.
    ///
    /// # Errors
    /// As [`Self::load`], but for reading.
    pub fn parse(text: &str) -> Result<Self, ConfigError> {
        Self::parse_named(text, Path::new("<text>"), &[])
    }

    fn parse_named(text: &str, path: &Path, set: &[String]) -> Result<Self, ConfigError> {
        let wrong = |problems| ConfigError::Wrong {
            path: path.to_owned(),
            problems,
        };
        let config: Result<Self, _> = toml::from_str(text);
        let mut config = config.map_err(|error| {
            let renamed = renamed_keys(text);
            if renamed.is_empty() {
                let (path, message) = (path.to_owned(), error.to_string());
                ConfigError::Unparsable { path, message }
            } else {
                wrong(renamed)
            }
        })?;
        if !set.is_empty() {
            config = loading::with(text, set)?;
        }
        let problems = config.problems();
        if problems.is_empty() {
            Ok(config)
        } else {
            Err(wrong(problems))
        }
    }
}

/// Keys that have another name now, in a section, and that name.
const RENAMED: [(&str, &str, &str); 1] = [("safety", "ladder", "failsafe")];

/// The keys of a text that have another name now, each with it. A text that is no TOML has none.
fn renamed_keys(text: &str) -> Vec<Problem> {
    let Ok(table) = text.parse::<toml::Table>() else {
        return Vec::new();
    };
    let has = |section: &str, key: &str| table.get(section).is_some_and(|section| section.get(key).is_some());
    let found = RENAMED.iter().filter(|(section, old, _)| has(section, old));
    found
        .map(|(section, old, new)| Problem {
            key: format!("{section}.{old}"),
            message: format!("is called {section}.{new}"),
        })
        .collect()
}

#[cfg(test)]
mod tests;
