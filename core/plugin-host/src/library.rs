//! One plugin: a library loaded from a private copy, its handshake and its manifest found right.
//!
//! Must never do: unload. Threads, thread-local values and buffers of a plugin may outlive everything the host knows of.

use crate::entry::Entry;
use crate::private_copy::{self, PrivateCopy};
use crate::trust::sha256_hex;
use crate::{LoadError, Manifest, PluginError, Trust, image};
use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
use skein_plugin_abi::{ENTRY_SYMBOL, Handshake};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Loading and the manifest take milliseconds. A library that takes longer than this hangs.
const LOAD_DEADLINE: Duration = Duration::from_secs(10);

/// A loaded plugin. It stays loaded until the process ends.
#[derive(Debug)]
pub struct Plugin {
    manifest: Manifest,
    path: PathBuf,
    sha256: String,
    /// The bytes that were judged, for child processes.
    sealed: OwnedFd,
    pub(crate) entry: Entry,
    /// Threads that were given up inside this plugin and have not come back.
    pub(crate) hanging: AtomicU32,
}

impl Plugin {
    /// Loads the library at `path`. Loading the same file again gives another plugin, independent of the first, even if the file did
    /// not change.
    pub fn load(path: &Path) -> Result<Arc<Self>, LoadError> {
        Self::load_trusted(path, &Trust::default())
    }

    /// As [`Self::load`], if the library is on the list or signed as the operator wants it.
    pub fn load_trusted(path: &Path, trust: &Trust) -> Result<Arc<Self>, LoadError> {
        let file = private_copy::read(path)?;
        let sha256 = sha256_hex(&file);
        trust.check(path, &file, &sha256)?;
        Self::load_read(path, file, sha256)
    }

    /// Loads a library that was read and found trustworthy.
    pub(crate) fn load_read(path: &Path, file: Vec<u8>, sha256: String) -> Result<Arc<Self>, LoadError> {
        // On a thread of its own, since the library's constructors and its manifest are the plugin's code.
        let (send, receive) = std::sync::mpsc::sync_channel(1);
        let path = path.to_owned();
        std::thread::Builder::new()
            .name("plugin-load".to_owned())
            .spawn(move || {
                // Nobody may be waiting any more.
                let _ = send.send(Self::load_here(path, &file, sha256));
            })?;
        receive
            .recv_timeout(LOAD_DEADLINE)
            .unwrap_or(Err(LoadError::TimedOut { after: LOAD_DEADLINE }))
            .map(Arc::new)
    }

    fn load_here(path: PathBuf, file: &[u8], sha256: String) -> Result<Self, LoadError> {
        let kind = image::judge(file)?;
        let sealed = private_copy::sealed(file)?;
        let copy = PrivateCopy::of(file, &path)?;
        let entry = open(copy.path())?;
        let manifest = entry.manifest().map_err(|e| match e {
            PluginError::Panicked { message } => LoadError::ManifestPanicked { message },
            other => LoadError::BadManifest {
                detail: other.to_string(),
            },
        })?;
        let manifest = Manifest::decode(kind, manifest.bytes())?;
        Ok(Self {
            manifest,
            path,
            sha256,
            sealed,
            entry,
            hanging: AtomicU32::new(0),
        })
    }

    /// What the plugin says of itself.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The file it was loaded from. It may have changed since.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// SHA-256 of the library it was loaded from, in hexadecimal.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// The library in memory that nobody can change.
    pub(crate) fn library_file(&self) -> BorrowedFd<'_> {
        self.sealed.as_fd()
    }

    /// How many threads hang in this plugin.
    #[must_use]
    pub fn hanging_threads(&self) -> u32 {
        self.hanging.load(Ordering::Relaxed)
    }
}

/// Loads a library that was judged, and finds its entry points.
pub(crate) fn open(path: &Path) -> Result<Entry, LoadError> {
    // SAFETY: the library's constructors run here; that nobody else can have written it was checked when it was read.
    let library = unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map_err(|e| LoadError::NotLoadable {
        detail: loader_detail(&e, path),
    })?;
    // SAFETY: the symbol is only used as an address, which `Handshake::of_loaded` judges.
    let symbol = unsafe { library.get::<*const Handshake>(ENTRY_SYMBOL) }.map(|symbol| symbol.into_raw());
    // Never unloaded from here on, whatever it turns out to be: its constructors may have started threads.
    std::mem::forget(library);
    let symbol = symbol.map_err(|_| LoadError::MissingSymbol)?;
    // SAFETY: the address of a data symbol of a library that stays loaded.
    let handshake = unsafe { Handshake::of_loaded(symbol.cast()) }?;
    Ok(Entry::new(handshake.entry_points()?))
}

/// The loader's text without the path of the copy, which nobody can look at any more.
fn loader_detail(error: &libloading::Error, copy: &Path) -> String {
    let mut text = error.to_string();
    if let Some(cause) = std::error::Error::source(error) {
        text = format!("{text}: {cause}");
    }
    text.replace(&format!("{}: ", copy.display()), "")
}
