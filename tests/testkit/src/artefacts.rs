//! The artefacts under test: the program, the plugins, fixtures. Built through cargo once per run, in the profile of the test itself.
//!
//! `cargo xtask test` builds them beforehand and says where they are (`SKEIN_BINARY`, `SKEIN_PLUGINS`, `SKEIN_EXAMPLES`); a plain `cargo test`
//! builds them here. Must never do: test what was built from other sources.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository's root.
///
/// # Panics
/// Never, as long as this crate lies two folders under it.
#[must_use]
pub fn repository() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors()
        .nth(2)
        .expect("the crate lies in tests/testkit")
        .to_path_buf()
}

/// The `skein` program, built.
///
/// # Panics
/// If it does not compile.
#[must_use]
pub fn skein_binary() -> PathBuf {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    let build = || {
        told("SKEIN_BINARY").unwrap_or_else(|| {
            cargo(&["build", "--quiet", "--package", "skein"]);
            present(profile_dir().join("skein"))
        })
    };
    BINARY.get_or_init(build).clone()
}

/// The folder with every plugin of the workspace, built and copied as `cargo xtask build-plugins` does it.
///
/// # Panics
/// If one does not compile.
#[must_use]
pub fn plugins_dir() -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let build = || {
        told("SKEIN_PLUGINS").unwrap_or_else(|| {
            // xtask itself is always a dev build: only what follows `--` says which profile the plugins get
            let mut command = Command::new(cargo_program());
            command.args(["run", "--quiet", "--package", "xtask", "--", "build-plugins"]);
            if is_release() {
                command.arg("--release");
            }
            run(command);
            present(profile_dir().join("plugins"))
        })
    };
    FOLDER.get_or_init(build).clone()
}

/// The shared library that an example of a fixture's package becomes, for example `good_version` of `fixture-next-version`.
///
/// # Panics
/// If it does not compile, or is no `cdylib`.
#[must_use]
pub fn example_library(package: &str, example: &str) -> PathBuf {
    let folder = told("SKEIN_EXAMPLES").unwrap_or_else(|| {
        cargo(&["build", "--quiet", "--package", package, "--example", example]);
        profile_dir().join("examples")
    });
    present(folder.join(format!("lib{example}.so")))
}

/// A place that the environment names; it must be there.
fn told(variable: &str) -> Option<PathBuf> {
    std::env::var_os(variable).map(|path| present(PathBuf::from(path)))
}

fn present(path: PathBuf) -> PathBuf {
    assert!(path.exists(), "{} should be there after the build", path.display());
    path
}

/// `<target>/<profile>`: a test runs from `deps/` in it.
fn profile_dir() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows its own program");
    let folder = test.parent().expect("a program lies in a folder");
    if folder.ends_with("deps") {
        folder.parent().unwrap_or(folder).to_path_buf()
    } else {
        folder.to_path_buf()
    }
}

fn is_release() -> bool {
    profile_dir().ends_with("release")
}

fn cargo(arguments: &[&str]) {
    let mut command = Command::new(cargo_program());
    command.args(arguments);
    if is_release() {
        command.arg("--release");
    }
    run(command);
}

fn cargo_program() -> std::ffi::OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

fn run(mut command: Command) {
    let target = profile_dir()
        .parent()
        .map(Path::to_path_buf)
        .expect("the profile's folder lies in the build directory");
    let status = command
        .current_dir(repository())
        .env("CARGO_TARGET_DIR", target)
        .status();
    let status = status.expect("cargo can be started");
    assert!(status.success(), "{command:?} failed: see the messages above");
}
