//! The committed layout of everything that crosses: fails when a change of the structs was not meant as a new ABI version.

use skein_plugin_abi::{
    ABI_VERSION, Buffer, CreateOutcome, Handshake, HandshakeMismatch, HostSink, LogLevel, Outcome, PluginKind, PluginTable, Slice,
    Status, method,
};
use std::fmt::Write;
use std::mem::{align_of, offset_of, size_of};

macro_rules! describe {
    ($out:ident, $name:ident { $($field:ident),+ $(,)? }) => {
        writeln!($out, "{} size {} align {}", stringify!($name), size_of::<$name>(), align_of::<$name>()).unwrap();
        $(writeln!($out, "  {} at {}", stringify!($field), offset_of!($name, $field)).unwrap();)+
        // Destructuring without `..` fails to compile when a field is missing in the list above.
        let _ = |value: $name| { let $name { $($field: _),+ } = value; };
    };
}

fn layout() -> String {
    let mut out = format!("abi_version {ABI_VERSION}\n");
    describe!(out, Slice { data, len });
    describe!(out, Buffer { data, len, capacity });
    describe!(out, Outcome { status, schema, buffer });
    describe!(out, CreateOutcome { status, reserved, handle, buffer });
    describe!(out, HostSink { size, context, log });
    describe!(out, PluginTable { manifest, create, invoke, destroy, free });
    describe!(
        out,
        Handshake {
            magic,
            abi_version,
            handshake_size,
            table_size,
            kind,
            pointer_bits,
            endianness,
            panic_strategy,
            reserved,
            target,
            table,
        }
    );
    for (name, status) in [
        ("ok", Status::OK),
        ("panicked", Status::PANICKED),
        ("refused", Status::REFUSED),
        ("unknown_method", Status::UNKNOWN_METHOD),
        ("unknown_schema", Status::UNKNOWN_SCHEMA),
        ("undecodable", Status::UNDECODABLE),
        ("poisoned", Status::POISONED),
    ] {
        writeln!(out, "status {name} {}", status.0).unwrap();
    }
    for (kind, word) in PluginKind::ALL {
        writeln!(out, "kind {word} {}", kind.0).unwrap();
    }
    for (name, level) in [
        ("error", LogLevel::ERROR),
        ("warn", LogLevel::WARN),
        ("info", LogLevel::INFO),
        ("debug", LogLevel::DEBUG),
        ("trace", LogLevel::TRACE),
    ] {
        writeln!(out, "level {name} {}", level.0).unwrap();
    }
    writeln!(out, "method snapshot {}\nmethod handle_events {}", method::SNAPSHOT, method::HANDLE_EVENTS).unwrap();
    out
}

#[test]
#[cfg(target_pointer_width = "64")]
fn layout_is_the_committed_one() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/layout.txt");
    if std::env::var_os("SKEIN_WRITE_LAYOUT").is_some() {
        std::fs::write(path, layout()).unwrap();
    }
    let committed = std::fs::read_to_string(path).unwrap();
    assert_eq!(layout(), committed, "the binary layout changed: see ABI.md");
}

#[test]
fn every_version_has_a_row_in_the_history() {
    let history = include_str!("../ABI.md");
    for version in 1..=ABI_VERSION {
        assert!(history.contains(&format!("\n| {version} | ")), "ABI.md does not tell what version {version} changed");
    }
}

unsafe extern "C" fn no_manifest() -> Outcome {
    Outcome::ok(0, vec![])
}
unsafe extern "C" fn no_create(_: *const HostSink, _: u32, _: Slice) -> CreateOutcome {
    CreateOutcome { status: Status::REFUSED.0, reserved: 0, handle: std::ptr::null_mut(), buffer: Buffer::EMPTY }
}
unsafe extern "C" fn no_invoke(_: *mut std::ffi::c_void, _: u32, _: u32, _: Slice) -> Outcome {
    Outcome::ok(0, vec![])
}
unsafe extern "C" fn no_destroy(_: *mut std::ffi::c_void) -> Outcome {
    Outcome::ok(0, vec![])
}
unsafe extern "C" fn free(buffer: Buffer) {
    // SAFETY: all buffers of these tests come from `Buffer::from_vec` of this same program.
    drop(unsafe { buffer.into_vec() });
}

static TABLE: PluginTable =
    PluginTable { manifest: no_manifest, create: no_create, invoke: no_invoke, destroy: no_destroy, free };

#[test]
fn a_handshake_is_judged_field_by_field() {
    let good = || Handshake::new(PluginKind::UAV_MODEL, &TABLE);
    assert_eq!(good().check(), Ok(()));
    assert_eq!(Handshake { magic: *b"SOMETHIN", ..good() }.check(), Err(HandshakeMismatch::Magic));
    assert_eq!(
        Handshake { abi_version: 9, ..good() }.check(),
        Err(HandshakeMismatch::AbiVersion { expected: ABI_VERSION, found: 9 })
    );
    assert!(matches!(
        Handshake { table_size: 8, ..good() }.check(),
        Err(HandshakeMismatch::StructSize { name: "table", found: 8, .. })
    ));
    assert!(matches!(
        Handshake { handshake_size: 8, ..good() }.check(),
        Err(HandshakeMismatch::StructSize { name: "handshake", found: 8, .. })
    ));
    assert!(matches!(Handshake { pointer_bits: 16, ..good() }.check(), Err(HandshakeMismatch::Target { .. })));
    assert!(matches!(Handshake { endianness: 7, ..good() }.check(), Err(HandshakeMismatch::Target { .. })));
    assert!(matches!(Handshake { target: [b'x'; 32], ..good() }.check(), Err(HandshakeMismatch::Target { .. })));
    assert_eq!(Handshake { panic_strategy: 2, ..good() }.check(), Err(HandshakeMismatch::PanicAborts));
    assert_eq!(Handshake { table: std::ptr::null(), ..good() }.check(), Err(HandshakeMismatch::NoTable));
    // An older version is named as such even if its structs had other sizes.
    assert!(matches!(
        Handshake { abi_version: 0, handshake_size: 8, ..good() }.check(),
        Err(HandshakeMismatch::AbiVersion { found: 0, .. })
    ));
}

#[test]
fn bytes_survive_the_way_there_and_back() {
    for bytes in [vec![], Vec::with_capacity(10), vec![1, 2, 3]] {
        let buffer = Buffer::from_vec(bytes.clone());
        // SAFETY: the buffer lives until it is turned back below.
        assert_eq!(unsafe { buffer.as_slice().as_bytes() }, bytes.as_slice());
        // SAFETY: comes from `from_vec` just above and is used once.
        assert_eq!(unsafe { buffer.into_vec() }, bytes);
    }
}
