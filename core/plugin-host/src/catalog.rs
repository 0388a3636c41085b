//! The plugins of some directories by name, in all versions found since the program began, and what was wrong with the others.
//!
//! Must never do: change which version is active by itself once there is one, or hold its lock while a library is loaded.

use crate::private_copy::{self, FileState};
use crate::trust::{refuse_directory_of_others, sha256_hex};
use crate::{LoadError, Plugin, Trust};
use parking_lot::Mutex;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// So many versions of a plugin are kept beside the active one and the one before it.
const MAX_VERSIONS: usize = 4;

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

/// The plugins found, shared by all who use them. A plugin that is no longer in it stays usable for who holds it, and its library stays
/// loaded for ever.
#[derive(Debug)]
pub struct Catalog {
    directories: Vec<PathBuf>,
    trust: Trust,
    /// Held for the time of a scan, so that two do not load the same file.
    scanning: Mutex<()>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    plugins: BTreeMap<String, Versions>,
    files: BTreeMap<PathBuf, SeenFile>,
    problems: Vec<Arc<PluginProblem>>,
}

/// A file as it was when it was last looked into.
#[derive(Debug)]
struct SeenFile {
    state: FileState,
    problem: Option<Arc<PluginProblem>>,
}

#[derive(Debug)]
struct Versions {
    /// In the order in which their files were found.
    loaded: Vec<Arc<Plugin>>,
    active: Arc<Plugin>,
    previous: Option<Arc<Plugin>>,
}

impl Catalog {
    /// Loads every `lib*.so` of these directories, in the order of the directories and then of the file names. Whatever is wrong
    /// with one is kept as a problem and does not keep the others out. Of two with the same name the first is taken. Blocks for
    /// some milliseconds per plugin.
    #[must_use]
    pub fn discover(directories: &[PathBuf], trust: Trust) -> Self {
        let catalog = Self {
            directories: directories.to_vec(),
            trust,
            scanning: Mutex::new(()),
            state: Mutex::default(),
        };
        catalog.scan(true);
        catalog
    }

    /// Looks into the directories again and loads what is new or has changed, beside what is loaded. A plugin of a new name is active at
    /// once; another version of a known one is a candidate until [`Self::activate`]. Gives what was loaded. Blocks as
    /// [`Self::discover`] does.
    pub fn rescan(&self) -> Vec<Arc<Plugin>> {
        self.scan(false)
    }

    fn scan(&self, first: bool) -> Vec<Arc<Plugin>> {
        let _scanning = self.scanning.lock();
        let (mut loaded, mut problems, mut present) = (Vec::new(), Vec::new(), Vec::new());
        for directory in &self.directories {
            match libraries_in(directory) {
                Ok(libraries) => {
                    for path in libraries {
                        let (plugin, problem) = self.look_into(&path, first);
                        loaded.extend(plugin);
                        problems.extend(problem);
                        present.push(path);
                    }
                }
                Err(error) => problems.push(Arc::new(PluginProblem {
                    path: directory.clone(),
                    error,
                })),
            }
        }
        let mut state = self.state.lock();
        state.problems = problems;
        state.files.retain(|path, _| present.contains(path));
        loaded
    }

    /// Loads a file if it is not known as it is now. Gives the plugin if it is new, and what is wrong with the file.
    fn look_into(&self, path: &Path, first: bool) -> (Option<Arc<Plugin>>, Option<Arc<PluginProblem>>) {
        let now = path.metadata().map(|metadata| FileState::of(&metadata));
        if let (Ok(now), Some(seen)) = (&now, self.state.lock().files.get(path))
            && seen.state == *now
            && seen.problem.as_ref().is_none_or(|problem| !problem.error.may_pass())
        {
            return (None, seen.problem.clone());
        }
        let loaded = match &now {
            Ok(_) => self.load(path, first),
            Err(error) => Err(std::io::Error::new(error.kind(), error.to_string()).into()),
        };
        let (plugin, problem) = match loaded {
            Ok(plugin) => (plugin, None),
            Err(error) => {
                let path = path.to_owned();
                (None, Some(Arc::new(PluginProblem { path, error })))
            }
        };
        if let Ok(state) = now {
            let problem = problem.clone();
            self.state
                .lock()
                .files
                .insert(path.to_owned(), SeenFile { state, problem });
        }
        (plugin, problem)
    }

    /// Loads a file, unless its bytes are loaded already. Gives the plugin if it is new.
    fn load(&self, path: &Path, first: bool) -> Result<Option<Arc<Plugin>>, LoadError> {
        let bytes = private_copy::read(path)?;
        let sha256 = sha256_hex(&bytes);
        self.trust.check(path, &bytes, &sha256)?;
        if !first && self.state.lock().found_again(path, &sha256) {
            return Ok(None);
        }
        let plugin = Plugin::load_read(path, bytes, sha256)?;
        self.state.lock().take(&plugin, first)?;
        Ok(Some(plugin))
    }

    /// The active version of the plugin of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Arc<Plugin>> {
        self.state
            .lock()
            .plugins
            .get(name)
            .map(|versions| Arc::clone(&versions.active))
    }

    /// The loaded versions of the plugin of that name, in the order in which they were found; the oldest are let go when there are
    /// many.
    #[must_use]
    pub fn versions(&self, name: &str) -> Vec<Arc<Plugin>> {
        self.state
            .lock()
            .plugins
            .get(name)
            .map_or(Vec::new(), |versions| versions.loaded.clone())
    }

    /// What was found last under that name, if it is not the active version.
    #[must_use]
    pub fn candidate(&self, name: &str) -> Option<Arc<Plugin>> {
        let state = self.state.lock();
        let versions = state.plugins.get(name)?;
        versions
            .loaded
            .last()
            .filter(|last| !Arc::ptr_eq(last, &versions.active))
            .cloned()
    }

    /// Makes this version the active one, if it is one of that name's; tells whether it is.
    pub fn activate(&self, name: &str, plugin: &Arc<Plugin>) -> bool {
        self.state
            .lock()
            .plugins
            .get_mut(name)
            .is_some_and(|versions| versions.activate(plugin))
    }

    /// The version that was active before the present one.
    #[must_use]
    pub fn previous(&self, name: &str) -> Option<Arc<Plugin>> {
        self.state.lock().plugins.get(name)?.previous.clone()
    }

    /// Takes a plugin out in all its versions; tells whether it was there. Its file is not taken in again before it changes.
    pub fn remove(&self, name: &str) -> bool {
        self.state.lock().plugins.remove(name).is_some()
    }

    /// The active version of every plugin, by ascending name.
    #[must_use]
    pub fn plugins(&self) -> Vec<Arc<Plugin>> {
        self.state
            .lock()
            .plugins
            .values()
            .map(|versions| Arc::clone(&versions.active))
            .collect()
    }

    /// What was not taken at the last look, in the order it was found.
    #[must_use]
    pub fn problems(&self) -> Vec<Arc<PluginProblem>> {
        self.state.lock().problems.clone()
    }
}

impl State {
    /// Whether the file has the bytes of a version that is loaded; that becomes the one found last.
    fn found_again(&mut self, path: &Path, sha256: &str) -> bool {
        for versions in self.plugins.values_mut() {
            let same = |plugin: &Arc<Plugin>| plugin.path() == path && plugin.sha256() == sha256;
            if let Some(at) = versions.loaded.iter().position(same) {
                let plugin = versions.loaded.remove(at);
                versions.loaded.push(plugin);
                return true;
            }
        }
        false
    }

    fn take(&mut self, plugin: &Arc<Plugin>, first: bool) -> Result<(), LoadError> {
        let name = &plugin.manifest().name;
        match self.plugins.get_mut(name) {
            Some(versions) if first => Err(LoadError::DuplicateName {
                name: name.clone(),
                first: versions.active.path().to_owned(),
            }),
            Some(versions) => {
                versions.add(plugin);
                Ok(())
            }
            None => {
                let versions = Versions {
                    loaded: vec![Arc::clone(plugin)],
                    active: Arc::clone(plugin),
                    previous: None,
                };
                self.plugins.insert(name.clone(), versions);
                Ok(())
            }
        }
    }
}

impl Versions {
    fn add(&mut self, plugin: &Arc<Plugin>) {
        self.loaded.push(Arc::clone(plugin));
        while self.loaded.len() > MAX_VERSIONS {
            let in_use = |p: &Arc<Plugin>| {
                Arc::ptr_eq(p, &self.active) || self.previous.as_ref().is_some_and(|previous| Arc::ptr_eq(p, previous))
            };
            match self.loaded.iter().position(|p| !in_use(p)) {
                Some(oldest) => drop(self.loaded.remove(oldest)),
                None => return,
            }
        }
    }

    fn activate(&mut self, plugin: &Arc<Plugin>) -> bool {
        if !self.loaded.iter().any(|loaded| Arc::ptr_eq(loaded, plugin)) {
            return false;
        }
        if !Arc::ptr_eq(&self.active, plugin) {
            self.previous = Some(std::mem::replace(&mut self.active, Arc::clone(plugin)));
        }
        true
    }
}

/// The libraries of a directory by name.
fn libraries_in(directory: &Path) -> Result<Vec<PathBuf>, LoadError> {
    refuse_directory_of_others(&directory.canonicalize()?)?;
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
