//! The committed layout of everything that crosses: fails when a change of the structs was not meant as a new ABI version.

#![expect(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_plugin_abi::{
    ABI_VERSION, Buffer, CreateOutcome, FrameBuffer, Handshake, HandshakeMismatch, HostServices, LogLevel, Outcome,
    PluginKind, PluginTable, Slice, Status, method,
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
    describe!(
        out,
        CreateOutcome {
            status,
            reserved,
            handle,
            buffer
        }
    );
    describe!(out, FrameBuffer { id, data, len });
    describe!(
        out,
        HostServices {
            size,
            context,
            log,
            acquire_frame,
            release_frame,
            read_frame
        }
    );
    describe!(
        out,
        PluginTable {
            manifest,
            create,
            invoke,
            destroy,
            free
        }
    );
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
    out + &numbers()
}

fn numbers() -> String {
    let mut out = String::new();
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
    writeln!(
        out,
        "method snapshot {}\nmethod handle_events {}",
        method::SNAPSHOT,
        method::HANDLE_EVENTS
    )
    .unwrap();
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

/// FNV-1a over the layout without its version: a change of layout must not hide behind an unchanged version.
fn fingerprint() -> String {
    let layout = layout();
    let (_, numbers) = layout.split_once('\n').unwrap();
    let hash = numbers.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    format!("{hash:016x}")
}

#[test]
#[cfg(target_pointer_width = "64")]
fn the_layout_is_the_one_its_version_was_given() {
    let history = include_str!("../../ABI.md");
    let row = history
        .lines()
        .find(|line| line.starts_with(&format!("| {ABI_VERSION} | ")))
        .unwrap();
    let fingerprint = fingerprint();
    assert!(
        row.contains(&fingerprint),
        "version {ABI_VERSION} was given another layout than {fingerprint}: count the version up and write its row, see ABI.md"
    );
}

#[test]
fn every_version_has_a_row_in_the_history() {
    let history = include_str!("../../ABI.md");
    for version in 1..=ABI_VERSION {
        assert!(
            history.contains(&format!("\n| {version} | ")),
            "ABI.md does not tell what version {version} changed"
        );
    }
}

unsafe extern "C" fn no_manifest() -> Outcome {
    Outcome::ok(0, vec![])
}
unsafe extern "C" fn no_create(_: *const HostServices, _: u32, _: Slice) -> CreateOutcome {
    CreateOutcome {
        status: Status::REFUSED.0,
        reserved: 0,
        handle: std::ptr::null_mut(),
        buffer: Buffer::EMPTY,
    }
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

static TABLE: PluginTable = PluginTable {
    manifest: Some(no_manifest),
    create: Some(no_create),
    invoke: Some(no_invoke),
    destroy: Some(no_destroy),
    free: Some(free),
};

#[test]
fn a_handshake_is_judged_field_by_field() {
    static INCOMPLETE: PluginTable = PluginTable { free: None, ..TABLE };
    type Change = fn(&mut Handshake);
    let cases: &[(Change, &str)] = &[
        (|h| h.magic = *b"SOMETHIN", "is not a handshake"),
        (|h| h.abi_version = 9, "ABI version 9, this host has 2"),
        (|h| h.table_size = 8, "its table has 8 bytes instead of 40"),
        (|h| h.handshake_size = 8, "its handshake has 8 bytes instead of 72"),
        (|h| h.pointer_bits = 16, "built for"),
        (|h| h.endianness = 7, "built for"),
        (|h| h.target = [b'x'; 32], "built for xxxx"),
        (|h| h.panic_strategy = 2, "panic = \"abort\""),
        (|h| h.table = std::ptr::null(), "lacks an entry point"),
        (|h| h.table = &INCOMPLETE, "lacks an entry point"),
        // An older version is named as such even if its structs had other sizes.
        (|h| (h.abi_version, h.handshake_size) = (0, 8), "ABI version 0"),
    ];
    let good = || Box::leak(Box::new(Handshake::new(PluginKind::UAV_MODEL, &TABLE)));
    assert!(good().entry_points().is_ok());
    for (change, said) in cases {
        let handshake = good();
        change(handshake);
        let mismatch = handshake.entry_points().unwrap_err().to_string();
        assert!(mismatch.contains(said), "{mismatch:?} does not say {said:?}");
    }
}

#[test]
fn a_symbol_is_looked_at_no_further_than_its_prefix_vouches_for() {
    static OURS: Handshake = Handshake::new(PluginKind::CAMERA, &TABLE);
    #[repr(align(8))]
    struct Foreign(#[expect(dead_code, reason = "only read through the pointer")] [u8; 16]);
    static FOREIGN: Foreign = Foreign([7; 16]);
    static OLD: Foreign = Foreign(*b"SKEINPLG\0\0\0\0\x10\0\0\0");
    let read = |symbol: *const Handshake| {
        // SAFETY: statics of this program; the short ones end their reading at the prefix.
        unsafe { Handshake::of_loaded(symbol) }.map(|handshake| handshake.kind)
    };
    let old = Err(HandshakeMismatch::AbiVersion {
        expected: ABI_VERSION,
        found: 0,
    });
    assert_eq!(read(&raw const OURS), Ok(PluginKind::CAMERA.0));
    assert_eq!(read((&raw const FOREIGN).cast()), Err(HandshakeMismatch::Magic));
    assert_eq!(read((&raw const OLD).cast()), old);
    assert_eq!(read(std::ptr::null()), Err(HandshakeMismatch::Magic));
    assert_eq!(
        read((&raw const OURS).wrapping_byte_add(1)),
        Err(HandshakeMismatch::Magic)
    );

    // The same from the bytes of a file, cut anywhere and at any alignment.
    // SAFETY: a static of this program, read as the bytes it is made of; it has no padding.
    let bytes = unsafe { std::slice::from_raw_parts((&raw const OURS).cast::<u8>(), size_of::<Handshake>()) };
    let shifted: Vec<u8> = std::iter::once(0).chain(bytes.iter().copied()).collect();
    assert_eq!(
        Handshake::from_file(&shifted[1..]).map(|h| (h.kind, h.check())),
        Ok((PluginKind::CAMERA.0, Ok(())))
    );
    for cut in 0..bytes.len() {
        assert_eq!(
            Handshake::from_file(&bytes[..cut]).map(|h| h.kind),
            Err(HandshakeMismatch::Magic),
            "cut at {cut}"
        );
    }
    let old_bytes = b"SKEINPLG\0\0\0\0\x10\0\0\0";
    assert_eq!(Handshake::from_file(old_bytes).map(|h| h.kind), old);
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
