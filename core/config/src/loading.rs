//! From a file, and what is set beside it, to a checked configuration with whole paths.
//!
//! Must never do: let a value that is set hide a mistake in the file.

use crate::{ConfigError, NodeConfig};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// What is said beside a configuration file: many computers share one file, each with a number of its own.
#[derive(Debug, Clone, Default)]
pub struct Overlay {
    /// `KEY=VALUE`, the key with its sections (`swarm.node=3`), the value as in the file; a word without quotes is text.
    pub set: Vec<String>,
    /// Where files go that the node writes and the configuration does not place. Default: the folder of the configuration.
    pub state: Option<PathBuf>,
}

impl NodeConfig {
    /// Reads and checks a configuration file. Relative paths in it are taken from the file's own folder.
    ///
    /// # Errors
    /// When the file cannot be read, does not parse, or its values make no sense.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        Self::load_with(path, &Overlay::default())
    }

    /// The same, with what is said beside it.
    ///
    /// # Errors
    /// As [`Self::load`]; also when a value that is set has no place in a configuration.
    pub fn load_with(path: &Path, overlay: &Overlay) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path).map_err(|source| ConfigError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        let mut config = Self::parse_named(&text, path, &overlay.set)?;
        if let Some(folder) = path.parent() {
            let written = overlay.state.as_deref().unwrap_or(folder);
            config.place_written(path, written);
            config.make_whole(folder);
        }
        config.fences().map_err(|source| ConfigError::Fences {
            path: path.to_owned(),
            source: Box::new(source),
        })?;
        Ok(config)
    }

    /// Names the files that the node writes and the configuration does not name.
    fn place_written(&mut self, path: &Path, folder: &Path) {
        let swarm = &mut self.swarm;
        if let (Some(id), Some(node), None) = (&swarm.id, swarm.node, &swarm.state_file) {
            swarm.state_file = Some(folder.join(format!("{id}-{node}.term.json")));
        }
        self.video.recordings.get_or_insert_with(|| folder.join("recordings"));
        self.recorder.folder.get_or_insert_with(|| folder.join("flights"));
        let resume = path.with_extension("resume");
        let name = resume.file_name().unwrap_or_default();
        self.resume.file.get_or_insert_with(|| folder.join(name));
    }

    /// Relative paths are meant from `folder`.
    fn make_whole(&mut self, folder: &Path) {
        let (plugins, swarm) = (&mut self.plugins, &mut self.swarm);
        let paths = (plugins.directories.iter_mut())
            .chain(&mut plugins.upload_directory)
            .chain(&mut swarm.secret_file)
            .chain(&mut swarm.state_file)
            .chain(&mut self.resume.file)
            .chain(&mut self.video.recordings)
            .chain(&mut self.recorder.folder)
            .chain(&mut self.safety.fence_files);
        for path in paths.filter(|path| path.is_relative()) {
            *path = folder.join(&*path);
        }
    }
}

/// The configuration of a text that is right by itself, with values set over it.
pub(crate) fn with(text: &str, set: &[String]) -> Result<NodeConfig, ConfigError> {
    let wrong = |argument: &str, message: String| ConfigError::Set {
        argument: argument.to_owned(),
        message,
    };
    let mut table: Table = text
        .parse()
        .map_err(|error: toml::de::Error| wrong("", error.to_string()))?;
    let mut config = NodeConfig::default();
    for argument in set {
        let (key, value) = argument
            .split_once('=')
            .ok_or_else(|| wrong(argument, "is not KEY=VALUE, as in swarm.node=3".to_owned()))?;
        let value = value_of(value.trim());
        place(&mut table, key.trim(), value).map_err(|message| wrong(argument, message))?;
        // Each by itself, so that the one that does not fit is named.
        config = table
            .clone()
            .try_into()
            .map_err(|error: toml::de::Error| wrong(argument, error.message().to_owned()))?;
    }
    Ok(config)
}

/// As TOML reads it; what is no TOML is text.
fn value_of(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>();
    let value = parsed
        .ok()
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("value"));
    value.unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Puts a value where its key says, and makes the sections on the way.
fn place(table: &mut Table, key: &str, value: Value) -> Result<(), String> {
    let mut parts = key.split('.').map(str::trim);
    let last = parts
        .next_back()
        .filter(|part| !part.is_empty())
        .ok_or("names no key")?;
    let mut at = table;
    for part in parts {
        let section = at.entry(part).or_insert_with(|| Value::Table(Table::new()));
        at = section.as_table_mut().ok_or_else(|| format!("{part} is no section"))?;
    }
    at.insert(last.to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests;
