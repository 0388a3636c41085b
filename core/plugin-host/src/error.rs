//! What can go wrong with a plugin: when it is loaded, and when an instance of it is called.

use skein_domain::manifest::EffectKind;
use skein_plugin_abi::HandshakeMismatch;
use std::path::PathBuf;
use std::time::Duration;
use thiserror::Error;

/// Why a directory or a library was not taken.
#[derive(Debug, Error)]
pub enum LoadError {
    /// It cannot be read.
    #[error("cannot be read: {source}")]
    Unreadable {
        /// Why.
        #[from]
        source: std::io::Error,
    },
    /// Others on this machine could exchange it for something else.
    #[error("{} can be written by others (mode {mode:03o}): take that away with `chmod go-w`", path.display())]
    WritableByOthers {
        /// The file, or the directory it stands in.
        path: PathBuf,
        /// Its permission bits.
        mode: u32,
    },
    /// It belongs to a user who is neither this one nor root.
    #[error("{} belongs to user {uid}, who is neither this program's nor root", path.display())]
    NotOurs {
        /// The file, or a directory above it.
        path: PathBuf,
        /// Whose it is.
        uid: u32,
    },
    /// It is neither on the list of digests nor signed with the key.
    #[error("it is not among the libraries allowed here: {detail} (SHA-256 {sha256})")]
    NotTrusted {
        /// Its digest in hexadecimal.
        sha256: String,
        /// What was looked for and not found.
        detail: String,
    },
    /// Someone wrote to it while it was read.
    #[error("it changed while it was read; try again when it is whole")]
    ChangedWhileRead,
    /// No private copy could be made.
    #[error("no private copy could be made: {source}")]
    NotCopied {
        /// Why.
        source: std::io::Error,
    },
    /// The system's loader refuses it: no shared library, another machine, an unresolved symbol.
    #[error("the system's loader refuses it: {detail}")]
    NotLoadable {
        /// What the loader says.
        detail: String,
    },
    /// It is a library, but no plugin.
    #[error("it does not export {symbol}, so it is no plugin", symbol = skein_plugin_abi::ENTRY_SYMBOL)]
    MissingSymbol,
    /// The handshake does not fit.
    #[error("{0}")]
    Handshake(#[from] HandshakeMismatch),
    /// It is for something this program has no word for.
    #[error("it is a plugin of kind {kind}, which this host does not know")]
    UnknownKind {
        /// The number in the handshake.
        kind: u32,
    },
    /// Its manifest does not make sense.
    #[error("its manifest is not right: {detail}")]
    BadManifest {
        /// What is wrong.
        detail: String,
    },
    /// It panicked while it made its manifest.
    #[error("it panicked while it made its manifest: {message}")]
    ManifestPanicked {
        /// The panic's message.
        message: String,
    },
    /// Loading it did not come to an end.
    #[error("loading it did not end within {} ms", after.as_millis())]
    TimedOut {
        /// The limit.
        after: Duration,
    },
    /// Another library of that name was found before.
    #[error("the name {name} is taken by {}", first.display())]
    DuplicateName {
        /// The name in both manifests.
        name: String,
        /// The one that was taken.
        first: PathBuf,
    },
}

impl LoadError {
    /// Whether the same file may be found right later: what is wrong is not in its bytes.
    pub(crate) fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::Unreadable { .. }
                | Self::WritableByOthers { .. }
                | Self::NotOurs { .. }
                | Self::NotTrusted { .. }
                | Self::ChangedWhileRead
                | Self::NotCopied { .. }
        )
    }
}

/// Why a call of an instance gave no answer. After some of these the instance can still be called: [`Self::needs_restart`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PluginError {
    /// It panicked, now or earlier. Create it anew from its last snapshot.
    #[error("panicked: {message}")]
    Panicked {
        /// Message and place of the panic.
        message: String,
    },
    /// The call did not return in time; its thread was given up and the instance with it.
    #[error("a call did not return within {} ms", after.as_millis())]
    DeadlineExceeded {
        /// How long was waited.
        after: Duration,
    },
    /// It refuses: its configuration is not right, for example.
    #[error("refused: {detail}")]
    Refused {
        /// Why.
        detail: String,
    },
    /// Its answer cannot be decoded.
    #[error("gave an answer that cannot be decoded: {detail}")]
    Undecodable {
        /// Why.
        detail: String,
    },
    /// It says that it cannot decode what it was given, or does not know the method or the schema.
    #[error("does not understand this host: {detail}")]
    NotUnderstood {
        /// What it does not understand.
        detail: String,
    },
    /// It returned an effect that its manifest does not name. None of the batch is carried out.
    #[error("returned the effect {effect}, which its manifest does not name")]
    NotPermitted {
        /// The effect.
        effect: EffectKind,
    },
    /// It returned more effects than one period can need. None of the batch is carried out.
    #[error("returned {count} effects at once, the limit is {limit}")]
    TooManyEffects {
        /// How many.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// Its answer is longer than the limit.
    #[error("gave an answer of {len} bytes, the limit is {limit}")]
    TooLarge {
        /// Length in bytes.
        len: usize,
        /// The limit in bytes.
        limit: usize,
    },
    /// It reported something that its own schema does not allow. None of the batch is carried out.
    #[error("gave {what} that its schema does not allow: {error}")]
    SchemaViolation {
        /// What: a state or an event.
        what: &'static str,
        /// Where and why.
        error: SchemaError,
    },
    /// It gave a frame that it had not been lent, or whose header does not fit its bytes. None of the batch is carried out.
    #[error("gave a frame that is not right: {detail}")]
    BadFrame {
        /// What is wrong.
        detail: String,
    },
    /// Its process ended, by itself or by force.
    #[error("its process ended: {how}{}", last_words(said))]
    ProcessEnded {
        /// How: `killed by signal 11 (SIGSEGV)`, `exit code 1`, or the limit for which it was ended.
        how: String,
        /// The last line it wrote to its standard error; may be empty.
        said: String,
    },
    /// Its process could not be started.
    #[error("no process could be started for it: {detail}")]
    NotStarted {
        /// Why.
        detail: String,
    },
    /// What its process sent makes no sense. The process is ended.
    #[error("its process broke the protocol: {detail}")]
    Protocol {
        /// What is wrong.
        detail: String,
    },
    /// Too many threads hang in this plugin already.
    #[error("{hanging} threads hang in it already, no more are given to it")]
    Quarantined {
        /// How many.
        hanging: u32,
    },
    /// No thread could be started to call it.
    #[error("no thread could be started: {detail}")]
    NoThread {
        /// What the system says.
        detail: String,
    },
    /// The instance is not there any more.
    #[error("is not running any more")]
    Gone,
}

impl PluginError {
    /// Whether the instance is lost, so that it has to be created anew. Otherwise it can be called again, and whoever calls it
    /// decides how long to put up with it.
    #[must_use]
    pub fn needs_restart(&self) -> bool {
        matches!(
            self,
            Self::Panicked { .. }
                | Self::DeadlineExceeded { .. }
                | Self::NoThread { .. }
                | Self::Gone
                | Self::ProcessEnded { .. }
                | Self::NotStarted { .. }
                | Self::Protocol { .. }
        )
    }
}

fn last_words(said: &str) -> String {
    if said.is_empty() {
        String::new()
    } else {
        format!(" ({said})")
    }
}

/// Why a text is not what a schema asks for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SchemaError {
    /// The manifest has no schema for it: the plugin takes, or gives, nothing of the kind.
    #[error("the plugin has none")]
    NoSchema,
    /// It is not JSON.
    #[error("not JSON: {detail}")]
    NotJson {
        /// Why.
        detail: String,
    },
    /// It is not as the schema has it.
    #[error("at {}: {reason}", if path.is_empty() { "the top" } else { path })]
    Violated {
        /// Where, as a JSON pointer; empty for the whole.
        path: String,
        /// Why.
        reason: String,
    },
}
