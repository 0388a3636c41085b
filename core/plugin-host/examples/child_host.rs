//! A host program with nothing but the child's side of the isolation, for tests and benches: what `skein plugin-host` is without the rest.

use std::process::ExitCode;

fn main() -> ExitCode {
    match skein_plugin_host::child::serve() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
