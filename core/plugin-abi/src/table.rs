//! The entry points of a plugin and what goes through them.

use crate::{Buffer, Slice};
use std::ffi::c_void;

/// How a call ended. A number, not an enum: a library may answer one that this host does not know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(transparent)]
pub struct Status(pub u32);

impl Status {
    /// Done; the buffer holds the answer.
    pub const OK: Self = Self(0);
    /// The plugin panicked; the buffer holds its message as text. The instance must only be destroyed.
    pub const PANICKED: Self = Self(1);
    /// The plugin refuses, for example its configuration; the buffer holds the reason as text.
    pub const REFUSED: Self = Self(2);
    /// The plugin does not know this method.
    pub const UNKNOWN_METHOD: Self = Self(3);
    /// The plugin does not know this schema.
    pub const UNKNOWN_SCHEMA: Self = Self(4);
    /// The plugin cannot decode the bytes; the buffer holds the reason as text.
    pub const UNDECODABLE: Self = Self(5);
    /// The instance panicked earlier.
    pub const POISONED: Self = Self(6);
}

/// How urgent a log line is. The host takes an unknown number for [`LogLevel::ERROR`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct LogLevel(pub u32);

impl LogLevel {
    /// Something failed.
    pub const ERROR: Self = Self(1);
    /// Something is not as it should be.
    pub const WARN: Self = Self(2);
    /// For the record.
    pub const INFO: Self = Self(3);
    /// For whoever looks for a fault.
    pub const DEBUG: Self = Self(4);
    /// Everything.
    pub const TRACE: Self = Self(5);
}

/// An instance, as the plugin that made it knows it. The host only keeps it and gives it back.
pub type PluginHandle = *mut c_void;

/// A frame buffer that the host lends to an instance to write a frame into.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct FrameBuffer {
    /// Names it in what is said of the frame later; 0 if there was none to lend.
    pub id: u64,
    /// First byte; null if there was none to lend.
    pub data: *mut u8,
    /// Number of bytes, at least as many as were asked for.
    pub len: usize,
}

impl FrameBuffer {
    /// There was none to lend.
    pub const NONE: Self = Self {
        id: 0,
        data: std::ptr::null_mut(),
        len: 0,
    };
}

/// What the host does for an instance. Given to `create`, so that it is there before any code of the instance runs. The struct is
/// borrowed for the call; what it holds is valid until `create` has failed or `destroy` has returned, from any thread.
///
/// Frames never cross as copies: a camera asks for a buffer, writes into it and names it in an effect, from when on it is the host's;
/// whoever gets an event about the frame reads the same bytes.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct HostServices {
    /// Size of this struct in bytes.
    pub size: usize,
    /// The host's; given back in every call.
    pub context: *mut c_void,
    /// Takes one log line: context, a [`LogLevel`], UTF-8 text.
    pub log: unsafe extern "C" fn(context: *mut c_void, level: u32, text: Slice),
    /// Lends a buffer of at least `len` bytes. None is lent while all of the instance's are in use: the frame is to be dropped then.
    pub acquire_frame: unsafe extern "C" fn(context: *mut c_void, len: usize) -> FrameBuffer,
    /// Takes back a lent buffer that was not named in an effect.
    pub release_frame: unsafe extern "C" fn(context: *mut c_void, id: u64),
    /// The bytes of a frame that an event of the call being made names; empty for any other. Only during that call.
    pub read_frame: unsafe extern "C" fn(context: *mut c_void, id: u64) -> Slice,
}

// SAFETY: the host promises that the functions may be called with `context` from any thread.
unsafe impl Send for HostServices {}
// SAFETY: as above.
unsafe impl Sync for HostServices {}

/// How a call ended, with its answer.
#[derive(Debug)]
#[repr(C)]
pub struct Outcome {
    /// A [`Status`].
    pub status: u32,
    /// Schema of the bytes in `buffer`, 0 for text.
    pub schema: u32,
    /// The answer; its owner is the plugin.
    pub buffer: Buffer,
}

impl Outcome {
    /// An answer.
    #[must_use]
    pub fn ok(schema: u32, bytes: Vec<u8>) -> Self {
        Self {
            status: Status::OK.0,
            schema,
            buffer: Buffer::from_vec(bytes),
        }
    }

    /// A failure with its reason.
    #[must_use]
    pub fn failed(status: Status, reason: String) -> Self {
        Self {
            status: status.0,
            schema: 0,
            buffer: Buffer::from_vec(reason.into_bytes()),
        }
    }
}

/// How the creation of an instance ended.
#[derive(Debug)]
#[repr(C)]
pub struct CreateOutcome {
    /// A [`Status`].
    pub status: u32,
    /// Zero.
    pub reserved: u32,
    /// The instance; null unless the status is [`Status::OK`].
    pub handle: PluginHandle,
    /// The reason as text unless the status is [`Status::OK`]; its owner is the plugin.
    pub buffer: Buffer,
}

/// Gives the manifest (`skein_domain::manifest::PluginManifest`) as CBOR.
pub type ManifestFn = unsafe extern "C" fn() -> Outcome;
/// Makes an instance: what the host does for it, schema of the bytes, the bytes (what they are depends on the kind of plugin).
pub type CreateFn = unsafe extern "C" fn(host: *const HostServices, schema: u32, bytes: Slice) -> CreateOutcome;
/// Calls a method of an instance: a number from [`method`], schema of the bytes, the bytes.
pub type InvokeFn = unsafe extern "C" fn(handle: PluginHandle, method: u32, schema: u32, bytes: Slice) -> Outcome;
/// Ends an instance; the handle is not used again.
pub type DestroyFn = unsafe extern "C" fn(handle: PluginHandle) -> Outcome;
/// Takes back a buffer of this plugin, from any thread.
pub type FreeFn = unsafe extern "C" fn(buffer: Buffer);

/// The entry points of a plugin. Never grows: new things come as new methods of `invoke`. Each may be null in a library that was
/// not made with the SDK, so the host looks before it calls ([`PluginTable::complete`]).
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct PluginTable {
    /// See [`ManifestFn`].
    pub manifest: Option<ManifestFn>,
    /// See [`CreateFn`].
    pub create: Option<CreateFn>,
    /// See [`InvokeFn`].
    pub invoke: Option<InvokeFn>,
    /// See [`DestroyFn`].
    pub destroy: Option<DestroyFn>,
    /// See [`FreeFn`].
    pub free: Option<FreeFn>,
}

/// The entry points of a plugin that has them all. The host's own copy; does not cross.
#[derive(Debug, Clone, Copy)]
pub struct EntryPoints {
    /// See [`ManifestFn`].
    pub manifest: ManifestFn,
    /// See [`CreateFn`].
    pub create: CreateFn,
    /// See [`InvokeFn`].
    pub invoke: InvokeFn,
    /// See [`DestroyFn`].
    pub destroy: DestroyFn,
    /// See [`FreeFn`].
    pub free: FreeFn,
}

impl PluginTable {
    /// All entry points, or `None` if one is null.
    #[must_use]
    pub fn complete(&self) -> Option<EntryPoints> {
        Some(EntryPoints {
            manifest: self.manifest?,
            create: self.create?,
            invoke: self.invoke?,
            destroy: self.destroy?,
            free: self.free?,
        })
    }
}

/// Methods of `invoke`. Numbers are never reused.
pub mod method {
    /// Every kind: the state to go on from after a restart; takes nothing, gives the plugin's own bytes (schema 0).
    pub const SNAPSHOT: u32 = 1;
    /// Every kind: takes an event batch, gives an effect batch.
    pub const HANDLE_EVENTS: u32 = 2;
}
