//! Which libraries may be loaded at all: those that nobody but this user and root can have written, and if the operator says so only
//! those on a list of digests or signed with a key.
//!
//! Must never do: look at what others may change between the look and the use.

use crate::LoadError;
use minisign_verify::{PublicKey, Signature};
use sha2::{Digest, Sha256};
use std::fs::Metadata;
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Permission bit: others may write.
const OTHERS_MAY_WRITE: u32 = 0o002;
/// Permission bit: the group may write.
const GROUP_MAY_WRITE: u32 = 0o020;
/// Permission bit of a directory in which only the owner of a file may rename or delete it.
const STICKY: u32 = 0o1000;
/// A signature is shorter, in bytes.
const MAX_SIGNATURE_BYTES: u64 = 4 << 10;

/// Which libraries are taken. With neither a list nor a key: every library in the directories. With both: one is enough.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Trust {
    /// SHA-256 digests in hexadecimal of the libraries that may be loaded.
    pub allow_sha256: Vec<String>,
    /// Public key of minisign (the line of base64, without the comment). The signature of `libx.so` is `libx.so.minisig` beside it.
    pub minisign_public_key: Option<String>,
}

impl Trust {
    /// Refuses a library that is neither on the list nor signed.
    pub(crate) fn check(&self, path: &Path, bytes: &[u8], sha256: &str) -> Result<(), LoadError> {
        if self.allow_sha256.is_empty() && self.minisign_public_key.is_none() {
            return Ok(());
        }
        if self
            .allow_sha256
            .iter()
            .any(|allowed| allowed.trim().eq_ignore_ascii_case(sha256))
        {
            return Ok(());
        }
        let detail = match &self.minisign_public_key {
            None => "its digest is not on the list".to_owned(),
            Some(key) => match verify(key, path, bytes) {
                Ok(()) => return Ok(()),
                Err(detail) => detail,
            },
        };
        Err(LoadError::NotTrusted {
            sha256: sha256.to_owned(),
            detail,
        })
    }
}

/// Verifies the signature beside a library.
fn verify(key: &str, path: &Path, bytes: &[u8]) -> Result<(), String> {
    let key =
        PublicKey::from_base64(key.trim()).map_err(|e| format!("the public key of the configuration is none: {e}"))?;
    let mut name = path.as_os_str().to_owned();
    name.push(".minisig");
    let name = PathBuf::from(name);
    let unreadable = |e: std::io::Error| format!("its signature {} cannot be read: {e}", name.display());
    let file = std::fs::File::open(&name).map_err(unreadable)?;
    let mut text = String::new();
    file.take(MAX_SIGNATURE_BYTES)
        .read_to_string(&mut text)
        .map_err(unreadable)?;
    let signature = Signature::decode(&text).map_err(|e| format!("its signature is none: {e}"))?;
    key.verify(bytes, &signature, false)
        .map_err(|e| format!("its signature is not right: {e}"))
}

/// The digest of these bytes in hexadecimal.
pub(crate) fn sha256_hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    Sha256::digest(bytes)
        .iter()
        .fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

/// Refuses a library that others can change, by itself or by one of the directories above it.
pub(crate) fn refuse_file_of_others(path: &Path, metadata: &Metadata) -> Result<(), LoadError> {
    refuse_if_others_may_write(path, metadata)?;
    path.parent().map_or(Ok(()), refuse_directory_of_others)
}

/// Refuses a directory into which others can put something, or that they can exchange.
pub(crate) fn refuse_directory_of_others(directory: &Path) -> Result<(), LoadError> {
    refuse_if_others_may_write(directory, &directory.metadata()?)?;
    for above in directory.ancestors().skip(1) {
        let metadata = above.metadata()?;
        // In a sticky directory others can put in what they like, but not take away or rename what is ours.
        let (sticky, owner_is_ours) = (metadata.mode() & STICKY != 0, is_ours(metadata.uid(), own_uid()));
        if !(sticky && owner_is_ours) {
            refuse_if_others_may_write(above, &metadata)?;
        }
    }
    Ok(())
}

fn own_uid() -> u32 {
    rustix::process::geteuid().as_raw()
}

fn is_ours(id: u32, own: u32) -> bool {
    id == 0 || id == own
}

/// Refuses what belongs to others or can be written by them.
fn refuse_if_others_may_write(path: &Path, metadata: &Metadata) -> Result<(), LoadError> {
    let uid = metadata.uid();
    if !is_ours(uid, own_uid()) {
        return Err(LoadError::NotOurs {
            path: path.to_owned(),
            uid,
        });
    }
    let others = metadata.mode() & OTHERS_MAY_WRITE != 0;
    let group = metadata.mode() & GROUP_MAY_WRITE != 0 && !is_ours(metadata.gid(), rustix::process::getegid().as_raw());
    if others || group {
        return Err(LoadError::WritableByOthers {
            path: path.to_owned(),
            mode: metadata.mode() & 0o777,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
