//! The plugin bench without the program's own command line:
//! `cargo build --release -p bench-echo && cargo run --release -p skein-bench --example plugin -- target/release/libbench_echo.so`.
//! A child is this example itself.

use skein_bench::{PluginBenchArgs, run_plugin_bench};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["plugin-host"] => skein_plugin_host::child::serve().map_err(|e| e.to_string()),
        [library] => std::env::current_exe().map_err(|e| e.to_string()).and_then(|program| {
            run_plugin_bench(&PluginBenchArgs::new(library.into(), program))
                .map(|report| println!("{report}"))
                .map_err(|e| e.to_string())
        }),
        _ => Err("usage: plugin LIBRARY".to_owned()),
    };
    done.map_or_else(
        |e| {
            eprintln!("{e}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}
