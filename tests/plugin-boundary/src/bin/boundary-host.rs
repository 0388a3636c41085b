//! The program that runs one instance in a process of its own: the host's side of it, and nothing else.

#![forbid(unsafe_code)]

fn main() -> Result<(), skein_plugin_host::child::ServeError> {
    skein_plugin_host::child::serve()
}
