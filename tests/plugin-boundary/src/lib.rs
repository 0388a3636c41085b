//! The plugin boundary under test: the libraries that ship and libraries made to misbehave, built through cargo and loaded as a node loads
//! them.
//!
//! Must never do: stand in for host or plugin. Both sides are the real ones.
#![forbid(unsafe_code)]

pub mod outcome;

use skein_domain::exchange::{Create, Effect, Event, EventBatch};
use skein_domain::{Incarnation, NodeTime, VehicleId};
use skein_plugin_host::{Instance, Isolation, Plugin, PluginError, Runners};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};

/// Packages under `fixtures/`; each example of theirs is one library.
pub const FIXTURE_PACKAGES: [&str; 2] = ["misbehaving", "failing-model"];

/// The fixture of that name, built in the profile of the test, unless `SKEIN_EXAMPLES` says where it has been built.
///
/// # Panics
/// If it does not compile.
#[must_use]
pub fn fixture(name: &str) -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let folder = BUILT.get_or_init(|| {
        if let Some(built) = std::env::var_os("SKEIN_EXAMPLES") {
            return built.into();
        }
        let mut arguments = vec!["--examples"];
        arguments.extend(profile_dir().ends_with("release").then_some("--release"));
        build(&FIXTURE_PACKAGES.map(package), &target_dir(), &arguments);
        profile_dir().join("examples")
    });
    library(folder, name)
}

/// A fixture of `misbehaving` built in another way than the test, in a build directory of its own.
///
/// # Panics
/// If it does not compile.
#[must_use]
pub fn fixture_built_with(way: &[&str], profile: &str, name: &str) -> PathBuf {
    let target = target_dir().join("plugin-boundary").join(profile);
    let arguments = [&["--example", name], way].concat();
    build(&[package("misbehaving")], &target, &arguments);
    let folder = if way.contains(&"--release") { "release" } else { "debug" };
    library(&target.join(folder).join("examples"), name)
}

/// The failing model, built so that every Rust struct in it that may be laid out anew is: nothing that crosses may depend on it.
///
/// # Panics
/// If it does not compile.
#[must_use]
pub fn fixture_with_other_layouts() -> PathBuf {
    let target = target_dir().join("plugin-boundary").join("other-layouts");
    let mut command = cargo_build(&[package("failing-model")], &target, &["--example", "failing_model"]);
    // The only use of an unstable option, in a library that is only ever tested.
    command.env("RUSTC_BOOTSTRAP", "1");
    command.env("RUSTFLAGS", "-Zrandomize-layout -Zlayout-seed=4711");
    run(command);
    library(&target.join("debug").join("examples"), "failing_model")
}

/// The names of all fixtures, as their manifests list them.
///
/// # Panics
/// If a manifest cannot be read.
#[must_use]
pub fn fixture_names() -> Vec<String> {
    let names = |package: &&str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("fixtures")
            .join(package)
            .join("Cargo.toml");
        let manifest: toml::Table = std::fs::read_to_string(path)
            .expect("is there")
            .parse()
            .expect("is TOML");
        let examples = manifest["example"].as_array().expect("is a list").clone();
        examples
            .into_iter()
            .map(|e| e["name"].as_str().expect("is a name").to_owned())
    };
    FIXTURE_PACKAGES.iter().flat_map(names).collect()
}

/// The plugin in C, compiled with the command of its README into a folder of the test.
///
/// # Panics
/// If it does not compile.
#[must_use]
pub fn example_c(folder: &Path) -> PathBuf {
    let repository = skein_testkit::repository();
    let readme = std::fs::read_to_string(repository.join("plugins/example-c/README.md")).expect("is there");
    let blocks = sh_blocks(&readme);
    let compile = blocks[0].lines().next().expect("has a command");
    let library = folder.join("libexample_c.so");
    let compile = compile.replace("-o libexample_c.so", &format!("-o {}", library.display()));
    let status = Command::new("sh")
        .args(["-c", &compile])
        .current_dir(repository)
        .status()
        .expect("is started");
    assert!(status.success(), "{compile}");
    library
}

fn package(folder: &str) -> String {
    format!("fixture-{folder}")
}

fn build(packages: &[String], target: &Path, arguments: &[&str]) {
    run(cargo_build(packages, target, arguments));
}

fn cargo_build(packages: &[String], target: &Path, arguments: &[&str]) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["build", "--quiet"]).args(arguments);
    for package in packages {
        command.args(["--package", package]);
    }
    command
        .current_dir(skein_testkit::repository())
        .env("CARGO_TARGET_DIR", target);
    command
}

fn run(mut command: Command) {
    let status = command.status().expect("cargo can be started");
    assert!(status.success(), "{command:?} failed: see the messages above");
}

fn library(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(format!("lib{name}.so"));
    assert!(path.exists(), "{} should be there after the build", path.display());
    path
}

/// `<target>/<profile>`: a test runs from `deps/` in it, an example from `examples/`.
fn profile_dir() -> PathBuf {
    let program = std::env::current_exe().expect("a test knows its own program");
    program
        .ancestors()
        .nth(2)
        .expect("a program lies in a build directory")
        .to_owned()
}

fn target_dir() -> PathBuf {
    profile_dir()
        .parent()
        .expect("a profile lies in a build directory")
        .to_owned()
}

/// The blocks of shell commands in a document, in order.
#[must_use]
pub fn sh_blocks(markdown: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut open: Option<String> = None;
    for line in markdown.lines() {
        match &mut open {
            Some(block) if line == "```" => {
                blocks.push(std::mem::take(block));
                open = None;
            }
            Some(block) => *block += &format!("{line}\n"),
            None if line == "```sh" => open = Some(String::new()),
            None => {}
        }
    }
    blocks
}

/// The plugin of that name among those that ship.
///
/// # Panics
/// If it is not there or is refused.
#[must_use]
pub fn shipped(name: &str) -> Arc<Plugin> {
    let library = format!("lib{}_plugin.so", name.replace('-', "_"));
    let plugin = Plugin::load(&skein_testkit::plugins_dir().join(library)).expect("is taken");
    assert_eq!(plugin.manifest().name, name);
    plugin
}

/// What an instance is created with.
#[must_use]
pub fn create_uav(id: u16, config_json: &str, snapshot: Option<Vec<u8>>) -> Create {
    Create {
        vehicle: VehicleId(id),
        incarnation: Incarnation(1),
        config_json: config_json.to_owned(),
        snapshot,
        now: NodeTime(0),
        payload: None,
        system_id: None,
    }
}

/// An instance of a fixture that does `what` wrong.
///
/// # Errors
/// As the host gives them.
pub async fn wrong_instance(
    runners: &Arc<Runners>,
    plugin: &Arc<Plugin>,
    key: &str,
    what: &str,
) -> Result<Instance, PluginError> {
    let config = format!(r#"{{"{key}": "{what}"}}"#);
    runners
        .create(Arc::clone(plugin), Isolation::InProcess, create_uav(9, &config, None))
        .await
}

/// One period: a tick at `milliseconds`.
#[must_use]
pub fn tick(milliseconds: u64) -> EventBatch {
    EventBatch {
        now: NodeTime(milliseconds * 1_000),
        events: vec![Event::Tick],
    }
}

/// A vehicle on the ground that is asked for something impossible, and must say so: a sign of life of `generic-uav` which no other plugin
/// gives.
///
/// # Panics
/// If the instance gives anything else than it should.
pub async fn assert_alive(instance: &Instance) {
    use skein_domain::exchange::{CommandProgress, OwnState};
    let own = OwnState {
        link_connected: true,
        ..OwnState::default()
    };
    let land = Event::Command {
        id: skein_domain::CommandId(5),
        command: skein_domain::VehicleCommand::Land,
        not_before: NodeTime(0),
    };
    let batch = EventBatch {
        now: NodeTime(1_000),
        events: vec![Event::Own(own), land, Event::Tick],
    };
    let effects = instance
        .call(batch, &[])
        .await
        .expect("the healthy instance answers")
        .effects;
    let refused = |effect: &Effect| {
        matches!(
            effect,
            Effect::CommandProgress {
                progress: CommandProgress::Refused { .. },
                ..
            }
        )
    };
    assert!(effects.iter().any(refused), "{effects:?}");
}
