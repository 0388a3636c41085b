//! The plugins of some directories, by name, and what was wrong with the others.

use crate::private_copy::refuse_if_others_may_write;
use crate::{LoadError, Plugin};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Something in a plugin directory that was not taken, or the directory itself.
#[derive(Debug)]
pub struct PluginProblem {
    /// The file or directory.
    pub path: PathBuf,
    /// Why.
    pub error: LoadError,
}

impl std::fmt::Display for PluginProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.error)
    }
}

/// The plugins found at one time. To take in new versions, discover again: plugins of an older catalogue stay loaded and usable.
#[derive(Debug, Default)]
pub struct Catalog {
    plugins: BTreeMap<String, Arc<Plugin>>,
    problems: Vec<PluginProblem>,
}

impl Catalog {
    /// Loads every `lib*.so` of these directories, in the order of the directories and then of the file names. Whatever is wrong
    /// with one is kept as a problem and does not keep the others out. Blocks for some milliseconds per plugin.
    #[must_use]
    pub fn discover(directories: &[PathBuf]) -> Self {
        let mut catalog = Self::default();
        for directory in directories {
            match libraries_in(directory) {
                Ok(libraries) => libraries.iter().for_each(|path| catalog.take(path)),
                Err(error) => catalog.problems.push(PluginProblem {
                    path: directory.clone(),
                    error,
                }),
            }
        }
        catalog
    }

    fn take(&mut self, path: &Path) {
        let problem = |error| PluginProblem {
            path: path.to_owned(),
            error,
        };
        match Plugin::load(path) {
            Ok(plugin) => {
                let name = plugin.manifest().name.clone();
                if let Some(first) = self.plugins.get(&name) {
                    let first = first.path().to_owned();
                    self.problems.push(problem(LoadError::DuplicateName { name, first }));
                } else {
                    self.plugins.insert(name, plugin);
                }
            }
            Err(error) => self.problems.push(problem(error)),
        }
    }

    /// The plugin of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Arc<Plugin>> {
        self.plugins.get(name).cloned()
    }

    /// All plugins by ascending name.
    pub fn plugins(&self) -> impl Iterator<Item = &Arc<Plugin>> {
        self.plugins.values()
    }

    /// What was not taken, in the order it was found.
    #[must_use]
    pub fn problems(&self) -> &[PluginProblem] {
        &self.problems
    }
}

/// The libraries of a directory by name.
fn libraries_in(directory: &Path) -> Result<Vec<PathBuf>, LoadError> {
    refuse_if_others_may_write(directory, &directory.metadata()?)?;
    let mut libraries = Vec::new();
    for entry in directory.read_dir()? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("lib") && name.ends_with(".so") {
            libraries.push(path);
        }
    }
    libraries.sort();
    Ok(libraries)
}

#[cfg(test)]
mod tests;
