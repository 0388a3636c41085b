//! What the tests of the host need: its examples, built, and words for what they are told.
#![allow(dead_code, reason = "every test uses a part of it")]

use skein_domain::exchange::{Create, Effect, Event, EventBatch};
use skein_domain::{CommandId, Incarnation, NodeTime, VehicleId};
use skein_plugin_host::{ChildLimits, Instance, Isolation, Plugin, PluginAnswer, PluginError, RunnerSettings, Runners};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// The folder with the built examples: built here, unless `SKEIN_EXAMPLES` says where they are.
fn examples() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        if let Some(built) = std::env::var_os("SKEIN_EXAMPLES") {
            return built.into();
        }
        let program = std::env::current_exe().expect("a test knows its own program");
        let profile = program.ancestors().nth(2).expect("it lies in a build directory");
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        // The whole workspace is selected, as everywhere: another selection has other features, and compiles half of the dependencies anew.
        command.args([
            "build",
            "--quiet",
            "--workspace",
            "--example",
            "child_host",
            "--example",
            "test_camera",
        ]);
        if profile.ends_with("release") {
            command.arg("--release");
        }
        command.current_dir(env!("CARGO_MANIFEST_DIR"));
        command.env(
            "CARGO_TARGET_DIR",
            profile.parent().expect("a profile lies in a build directory"),
        );
        assert!(
            command.status().expect("cargo can be started").success(),
            "{command:?} failed"
        );
        profile.join("examples")
    })
}

/// The program that a child runs.
pub fn host_program() -> PathBuf {
    examples().join("child_host")
}

/// The library of the plugin under test.
pub fn library() -> PathBuf {
    examples().join("libtest_camera.so")
}

/// The plugin under test.
pub fn camera() -> Arc<Plugin> {
    static LOADED: OnceLock<Arc<Plugin>> = OnceLock::new();
    Arc::clone(LOADED.get_or_init(|| Plugin::load(&library()).expect("is taken")))
}

/// A pool with one deadline for everything.
pub fn runners(deadline: Duration) -> Arc<Runners> {
    let runners = Runners::with_settings(RunnerSettings {
        threads: 1,
        call_deadline: deadline,
        create_deadline: deadline,
        ..RunnerSettings::default()
    });
    runners.set_host_program(host_program());
    runners
}

/// A process of its own with the limits that nobody named others for.
pub fn child() -> Isolation {
    Isolation::Child(ChildLimits::default())
}

/// Both ways.
pub fn ways() -> [Isolation; 2] {
    [Isolation::InProcess, child()]
}

/// What an instance is created with.
pub fn create(config_json: &str, snapshot: Option<&[u8]>) -> Create {
    Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: config_json.to_owned(),
        snapshot: snapshot.map(<[u8]>::to_vec),
        now: NodeTime(0),
        payload: Some("eye".to_owned()),
        system_id: None,
    }
}

/// A batch.
pub fn events(events: Vec<Event>) -> EventBatch {
    EventBatch {
        now: NodeTime(1),
        events,
    }
}

/// Tells an instance what to do.
pub async fn told(instance: &Instance, command_json: &str) -> Result<PluginAnswer, PluginError> {
    let command = Event::PayloadCommand {
        id: CommandId(1),
        command_json: command_json.to_owned(),
    };
    instance.call(events(vec![command]), &[]).await
}

/// What it sent to its device.
pub fn transmitted(effects: &[Effect]) -> Vec<u8> {
    let sent = effects.iter().find_map(|effect| match effect {
        Effect::Transmit { bytes } => Some(bytes.clone()),
        _ => None,
    });
    sent.expect("it transmits")
}

/// How many entries a directory has.
pub fn count_of(directory: &str) -> usize {
    std::fs::read_dir(directory).expect("is there").count()
}

/// Whether a thread of this process has this name.
pub fn has_thread(name: &str) -> bool {
    let tasks = std::fs::read_dir("/proc/self/task").expect("is there").flatten();
    let mut names = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok());
    names.any(|comm| comm.trim() == name)
}

/// The processes that this one started and that are not buried, as the system lists them.
pub fn children_of_this_process() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").expect("is there").flatten();
    let children = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
    children
        .flat_map(|list| list.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
        .collect()
}
