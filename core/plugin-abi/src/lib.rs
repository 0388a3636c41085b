//! The binary interface between the node and its plugins: C-shaped structs, function pointers and bytes, nothing else.
//!
//! Must never do: depend on anything but `std`, let a Rust type with an unstable layout cross, grow a field without the rules in
//! `ABI.md`. What the bytes mean is `skein_domain::exchange`'s and `skein_domain::manifest`'s; here they are only bytes.
//!
//! A plugin is a shared library that exports one data symbol, [`ENTRY_SYMBOL`], a [`Handshake`]. It is data and not a function,
//! so that a host can judge a library from its file, without having run any code of it. Only when the handshake fits does the host load
//! it and follow [`Handshake::table`].
//!
//! Rules of the boundary:
//! * Memory is freed by who made it: a [`Buffer`] a plugin returned goes back through [`PluginTable::free`], from any thread.
//! * A [`Slice`] is borrowed for the time of the call only.
//! * A handle is used by one thread at a time, but not always by the same one.
//! * No unwinding crosses: every entry of a plugin catches panics and answers with [`Status::PANICKED`].
//! * Nothing a plugin gives is trusted: the host checks lengths, texts and numbers before it uses them.

mod bytes;
mod handshake;
mod table;

pub use bytes::{Buffer, Slice};
pub use handshake::{
    ABI_VERSION, ENDIAN_BIG, ENDIAN_LITTLE, ENTRY_SYMBOL, Handshake, HandshakeMismatch, MAGIC, PANIC_ABORT,
    PANIC_UNWIND, PluginKind, TARGET_LEN, target,
};
pub use table::{
    CreateFn, CreateOutcome, DestroyFn, EntryPoints, FrameBuffer, FreeFn, HostServices, InvokeFn, LogLevel, ManifestFn,
    Outcome, PluginHandle, PluginTable, Status, method,
};
