//! `include/skein_plugin.h` is what this crate says, in C. If it fails after a change of the interface, write the header anew with
//! `SKEIN_WRITE_HEADER=1 cargo test -p skein-plugin-abi --test header` and look at what changed.

use cbindgen::{Builder, Config, Language, Style};
use skein_plugin_abi::{
    ABI_VERSION, ENDIAN_BIG, ENDIAN_LITTLE, ENTRY_SYMBOL, LogLevel, MAGIC, PANIC_ABORT, PANIC_UNWIND, PluginKind,
    Status, method,
};
use std::fmt::Write;
use std::path::Path;

const HEADER: &str = "include/skein_plugin.h";
const TOP: &str = "\
/* The binary interface of Skein's plugins, made from the source of core/plugin-abi by its tests. ABI.md tells its rules.
 *
 * A plugin is a shared library that exports one constant, SKEIN_PLUGIN, a SkeinHandshake. What crosses as bytes is CBOR. */";

/// The structs, from the source.
fn structs() -> String {
    let mut config = Config {
        language: Language::C,
        style: Style::Both,
        include_guard: Some("SKEIN_PLUGIN_H".to_owned()),
        header: Some(TOP.to_owned()),
        cpp_compat: true,
        documentation: true,
        usize_is_size_t: true,
        line_length: 120,
        ..Config::default()
    };
    config.export.prefix = Some("Skein".to_owned());
    // What a plugin sees of the host's own types is numbers; the constants are written below, from their values.
    config.export.include = ["Handshake"].map(str::to_owned).to_vec();
    config.export.exclude = [
        "EntryPoints",
        "HandshakeMismatch",
        "Prefix",
        "PluginKind",
        "Status",
        "LogLevel",
    ]
    .map(str::to_owned)
    .to_vec();
    config.export.item_types = vec![cbindgen::ItemType::Structs, cbindgen::ItemType::Typedefs];
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = ["bytes.rs", "table.rs", "handshake.rs"];
    let builder = files.iter().fold(
        Builder::new().with_config(config).with_std_types(true),
        |builder, file| builder.with_src(source.join(file)),
    );
    let mut text = Vec::new();
    builder.generate().expect("the source is understood").write(&mut text);
    in_c(&String::from_utf8(text).expect("is text"))
}

/// What C says otherwise: a pointer to a function may be null anyhow, and a comment has no links.
fn in_c(text: &str) -> String {
    let mut text = text.replace("SkeinTARGET_LEN", "SKEIN_TARGET_LEN");
    while let Some((before, rest)) = text.split_once("SkeinOption<") {
        let (function, after) = rest.split_once('>').expect("is closed");
        text = format!("{before}{function}{after}");
    }
    text.replace("[`", "`").replace("`]", "`").replace("crate::", "")
}

/// The numbers, from their values.
fn constants() -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &dyn std::fmt::Display, what: &str| {
        writeln!(text, "/* {what} */\n#define SKEIN_{name} {value}").expect("writes into a text");
    };
    let magic = String::from_utf8_lossy(&MAGIC);
    line("ABI_VERSION", &ABI_VERSION, "SkeinHandshake.abi_version");
    line(
        "MAGIC",
        &format!("\"{magic}\""),
        "SkeinHandshake.magic, without the zero at the end",
    );
    line(
        "ENTRY_SYMBOL",
        &format!("\"{ENTRY_SYMBOL}\""),
        "the name of the exported constant",
    );
    line(
        "TARGET_LEN",
        &skein_plugin_abi::TARGET_LEN,
        "bytes of SkeinHandshake.target",
    );
    line("ENDIAN_LITTLE", &ENDIAN_LITTLE, "SkeinHandshake.endianness");
    line("ENDIAN_BIG", &ENDIAN_BIG, "SkeinHandshake.endianness");
    line(
        "PANIC_UNWIND",
        &PANIC_UNWIND,
        "SkeinHandshake.panic_strategy: what a library in C says too, since nothing in it panics",
    );
    line(
        "PANIC_ABORT",
        &PANIC_ABORT,
        "SkeinHandshake.panic_strategy: no host takes it",
    );
    for (kind, word) in PluginKind::ALL {
        line(&format!("KIND_{}", word.to_uppercase()), &kind.0, "SkeinHandshake.kind");
    }
    for (status, word) in [
        (Status::OK, "OK"),
        (Status::PANICKED, "PANICKED"),
        (Status::REFUSED, "REFUSED"),
        (Status::UNKNOWN_METHOD, "UNKNOWN_METHOD"),
        (Status::UNKNOWN_SCHEMA, "UNKNOWN_SCHEMA"),
        (Status::UNDECODABLE, "UNDECODABLE"),
        (Status::POISONED, "POISONED"),
    ] {
        line(&format!("STATUS_{word}"), &status.0, "SkeinOutcome.status");
    }
    for (level, word) in [
        (LogLevel::ERROR, "ERROR"),
        (LogLevel::WARN, "WARN"),
        (LogLevel::INFO, "INFO"),
        (LogLevel::DEBUG, "DEBUG"),
        (LogLevel::TRACE, "TRACE"),
    ] {
        line(&format!("LOG_{word}"), &level.0, "level of a log line");
    }
    line("METHOD_SNAPSHOT", &method::SNAPSHOT, "method of invoke");
    line("METHOD_HANDLE_EVENTS", &method::HANDLE_EVENTS, "method of invoke");
    text
}

#[test]
fn the_committed_header_is_the_generated_one() {
    let structs = structs();
    let after_includes = structs.find("/**").expect("has a struct");
    let (top, body) = structs.split_at(after_includes);
    let generated = format!("{top}{}\n{body}", constants());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(HEADER);
    if std::env::var_os("SKEIN_WRITE_HEADER").is_some() {
        std::fs::create_dir_all(path.parent().expect("has a folder")).expect("can be made");
        std::fs::write(&path, &generated).expect("can be written");
    }
    let committed = std::fs::read_to_string(&path).expect("the header is there");
    assert_eq!(committed, generated, "{HEADER} is not what the source says");
}

#[test]
fn everything_a_plugin_needs_is_in_it() {
    let header = structs();
    for name in [
        "SkeinHandshake",
        "SkeinPluginTable",
        "SkeinHostServices",
        "SkeinOutcome",
        "SkeinCreateOutcome",
        "SkeinBuffer",
        "SkeinSlice",
        "SkeinFrameBuffer",
        "SkeinPluginHandle",
    ] {
        assert!(header.contains(name), "{name} is missing:\n{header}");
    }
}
