//! The calls into a plugin, with what comes back made safe to hold. The only place that calls a plugin's functions.
//!
//! Must never do: let a plugin's buffer be freed by anyone but the plugin, or look at it further than its length says.

use crate::PluginError;
use skein_plugin_abi::{Buffer, EntryPoints, FreeFn, HostServices, Outcome, PluginHandle, Slice, Status};
use std::mem::ManuallyDrop;

/// A reason a plugin gives is cut at this length in bytes.
const MAX_REASON_BYTES: usize = 2_000;

/// An instance as its plugin knows it. Only the thread that runs the instance's calls uses it.
#[derive(Debug)]
pub(crate) struct Handle(PluginHandle);

// SAFETY: the rules of the boundary let a handle move between threads, used by one at a time.
unsafe impl Send for Handle {}

/// Bytes a plugin returned; go back to it when this value goes.
#[derive(Debug)]
pub(crate) struct PluginBytes {
    buffer: ManuallyDrop<Buffer>,
    free: FreeFn,
}

// SAFETY: the rules of the boundary let a buffer be read and freed from any thread.
unsafe impl Send for PluginBytes {}
// SAFETY: it is only read as long as it is shared.
unsafe impl Sync for PluginBytes {}

impl PluginBytes {
    fn new(buffer: Buffer, free: FreeFn) -> Self {
        Self {
            buffer: ManuallyDrop::new(buffer),
            free,
        }
    }

    /// The bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        if self.buffer.len > isize::MAX as usize {
            return &[]; // No allocation is that long: the length is not one.
        }
        // SAFETY: the plugin vouches for data and length until the buffer goes back to it, which this value does on drop.
        unsafe { self.buffer.as_slice().as_bytes() }
    }

    /// The bytes as text, cut at a bearable length.
    fn reason(&self) -> String {
        let bytes = self.bytes();
        String::from_utf8_lossy(bytes.get(..MAX_REASON_BYTES).unwrap_or(bytes)).into_owned()
    }
}

impl Drop for PluginBytes {
    fn drop(&mut self) {
        // SAFETY: the buffer is not used after this, and comes from the library that `free` belongs to.
        let buffer = unsafe { ManuallyDrop::take(&mut self.buffer) };
        if !buffer.data.is_null() {
            // SAFETY: as above; the library is never unloaded, its entries do not unwind.
            unsafe { (self.free)(buffer) };
        }
    }
}

/// The entry points of one plugin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry(EntryPoints);

impl Entry {
    pub(crate) fn new(points: EntryPoints) -> Self {
        Self(points)
    }

    /// The manifest's bytes.
    pub(crate) fn manifest(&self) -> Result<PluginBytes, PluginError> {
        // SAFETY: the handshake of this library fits this ABI; the library stays loaded.
        let outcome = unsafe { (self.0.manifest)() };
        self.answer(outcome)
    }

    /// Makes an instance. What `host` holds must stay valid until the instance is destroyed.
    pub(crate) fn create(&self, host: &HostServices, schema: u32, bytes: &[u8]) -> Result<Handle, PluginError> {
        // SAFETY: as in `manifest`; services and bytes are borrowed for the call.
        let outcome = unsafe { (self.0.create)(host, schema, Slice::of(bytes)) };
        let bytes = PluginBytes::new(outcome.buffer, self.0.free);
        check(Status(outcome.status), &bytes)?;
        if outcome.handle.is_null() {
            return Err(PluginError::Undecodable {
                detail: "created, but no handle was given".to_owned(),
            });
        }
        Ok(Handle(outcome.handle))
    }

    /// Calls a method of an instance.
    pub(crate) fn invoke(
        &self,
        handle: &Handle,
        method: u32,
        schema: u32,
        bytes: &[u8],
    ) -> Result<(u32, PluginBytes), PluginError> {
        // SAFETY: as in `manifest`; the handle comes from `create` of this library and was not destroyed; bytes are borrowed.
        let outcome = unsafe { (self.0.invoke)(handle.0, method, schema, Slice::of(bytes)) };
        let schema = outcome.schema;
        Ok((schema, self.answer(outcome)?))
    }

    /// Ends an instance.
    pub(crate) fn destroy(&self, handle: Handle) -> Result<(), PluginError> {
        // SAFETY: as in `invoke`; the handle is used up.
        let outcome = unsafe { (self.0.destroy)(handle.0) };
        self.answer(outcome).map(drop)
    }

    fn answer(&self, outcome: Outcome) -> Result<PluginBytes, PluginError> {
        let bytes = PluginBytes::new(outcome.buffer, self.0.free);
        check(Status(outcome.status), &bytes)?;
        Ok(bytes)
    }
}

/// What a status means here.
fn check(status: Status, bytes: &PluginBytes) -> Result<(), PluginError> {
    let not_understood = |what: &str| {
        Err(PluginError::NotUnderstood {
            detail: format!("{what} {}", bytes.reason()).trim_end().to_owned(),
        })
    };
    match status {
        Status::OK => Ok(()),
        Status::PANICKED => Err(PluginError::Panicked {
            message: bytes.reason(),
        }),
        Status::REFUSED => Err(PluginError::Refused { detail: bytes.reason() }),
        Status::POISONED => Err(PluginError::Panicked {
            message: "earlier".to_owned(),
        }),
        Status::UNKNOWN_METHOD => not_understood("unknown method"),
        Status::UNKNOWN_SCHEMA => not_understood("unknown schema"),
        Status::UNDECODABLE => not_understood("undecodable:"),
        Status(other) => not_understood(&format!("status {other}")),
    }
}
