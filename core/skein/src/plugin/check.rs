//! `skein plugin check`: a library is loaded as a node does it, an instance is made, called, restored from its snapshot and ended.
//!
//! Must never do: take a shortcut past the host. What passes here is taken by a node with the same settings.

use crate::exit;
use clap::{Args, ValueEnum};
use skein_domain::exchange::{Create, Event, EventBatch, OwnState};
use skein_domain::manifest::EffectKind;
use skein_domain::{Incarnation, NodeTime, SystemId, VehicleId};
use skein_plugin_host::{
    ChildLimits, Instance, Isolation, Manifest, Plugin, PluginError, PluginKind, RunnerSettings, Runners, Trust,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// On the bench there is no vehicle that waits for an answer, but a slow machine.
const CALL_DEADLINE: Duration = Duration::from_secs(2);
/// Starting a process on a busy machine takes a while.
const CREATE_DEADLINE: Duration = Duration::from_secs(10);
/// When the instance is called, in microseconds.
const CALLED_AT: NodeTime = NodeTime(1_000_000);

/// `skein plugin check`
#[derive(Debug, Clone, Args)]
pub struct CheckArguments {
    /// The libraries.
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Configuration of the instance, as JSON.
    #[arg(long, default_value = "{}", value_name = "JSON")]
    pub config: String,
    /// Take only libraries that are signed with this minisign key (`FILE.minisig`).
    #[arg(long, value_name = "KEY")]
    pub minisign_public_key: Option<String>,
    /// Where the instance runs.
    #[arg(long, value_enum, default_value_t = Where::Child)]
    pub isolation: Where,
}

/// Where an instance runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Where {
    /// In a process of its own, with the default limits.
    Child,
    /// In this process: what ends it ends the check.
    InProcess,
}

/// What an instance did.
struct Lived {
    effects: usize,
    snapshot_bytes: usize,
}

pub(super) async fn check(arguments: &CheckArguments) -> anyhow::Result<ExitCode> {
    let mut code = ExitCode::SUCCESS;
    for file in &arguments.files {
        match check_one(file, arguments).await {
            Ok(lines) => println!("{}: right\n{lines}", file.display()),
            Err(why) => {
                println!("{}: not right: {why}", file.display());
                code = ExitCode::from(exit::FAILED);
            }
        }
    }
    Ok(code)
}

/// What is to be said of a plugin that is right, or the sentence of what is wrong.
async fn check_one(file: &Path, arguments: &CheckArguments) -> Result<String, String> {
    let trust = Trust {
        allow_sha256: Vec::new(),
        minisign_public_key: arguments.minisign_public_key.clone(),
    };
    let plugin = Plugin::load_trusted(file, &trust).map_err(|e| e.to_string())?;
    let manifest = plugin.manifest();
    manifest.check_config(&arguments.config).map_err(|e| {
        format!(
            "the configuration {} is not as its schema has it: {e}",
            arguments.config
        )
    })?;
    let runners = Runners::with_settings(RunnerSettings {
        threads: 1,
        call_deadline: CALL_DEADLINE,
        create_deadline: CREATE_DEADLINE,
        ..RunnerSettings::default()
    });
    let wanted = match arguments.isolation {
        Where::Child => Isolation::Child(ChildLimits::default()),
        Where::InProcess => Isolation::InProcess,
    };
    let (lived, place) = match live(&runners, &plugin, wanted, &arguments.config).await {
        Err((_, PluginError::NotStarted { .. })) if wanted.is_child() => {
            let lived = live(&runners, &plugin, Isolation::InProcess, &arguments.config).await;
            (lived, "in this process; no process of its own could be started")
        }
        lived if wanted.is_child() => (lived, "in a process of its own"),
        lived => (lived, "in this process"),
    };
    let lived = lived.map_err(|(step, error)| format!("{step}: {error}"))?;
    Ok(summary(&plugin, &lived, place))
}

/// Makes an instance, calls it once, and makes another from its snapshot. Gives the step that failed.
async fn live(
    runners: &Arc<Runners>,
    plugin: &Arc<Plugin>,
    isolation: Isolation,
    config: &str,
) -> Result<Lived, (&'static str, PluginError)> {
    let create = |snapshot| {
        runners.create(
            Arc::clone(plugin),
            isolation,
            create(plugin.manifest(), config, snapshot),
        )
    };
    let instance: Instance = create(None).await.map_err(|e| ("an instance was not made", e))?;
    let batch = EventBatch {
        now: CALLED_AT,
        events: vec![Event::Own(on_the_ground()), Event::Peers(Vec::new()), Event::Tick],
    };
    let answer = instance.call(batch, &[]).await.map_err(|e| ("its first call", e))?;
    drop(instance);
    let restored = create(Some(answer.snapshot.clone()))
        .await
        .map_err(|e| ("no instance was made from its snapshot", e))?;
    let again = restored
        .snapshot()
        .await
        .map_err(|e| ("the snapshot of the restored instance", e))?;
    if again != answer.snapshot {
        let detail = "an instance made from a snapshot must give the same bytes again until its first event".to_owned();
        return Err(("its snapshot", PluginError::Refused { detail }));
    }
    Ok(Lived {
        effects: answer.effects.len() + answer.frames.len(),
        snapshot_bytes: again.len(),
    })
}

fn create(manifest: &Manifest, config: &str, snapshot: Option<Vec<u8>>) -> Create {
    let is_payload = manifest.kind != PluginKind::UAV_MODEL;
    Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: config.to_owned(),
        snapshot,
        now: NodeTime(0),
        payload: is_payload.then(|| "payload".to_owned()),
        system_id: Some(SystemId(1)),
    }
}

/// A vehicle that is heard, and no more.
fn on_the_ground() -> OwnState {
    OwnState {
        link_connected: true,
        ..OwnState::default()
    }
}

fn summary(plugin: &Plugin, lived: &Lived, place: &str) -> String {
    let manifest = plugin.manifest();
    let effects: Vec<_> = manifest
        .effects
        .iter()
        .map(|effect: &EffectKind| effect.word())
        .collect();
    let schemas: Vec<_> = [
        ("configuration", true),
        ("commands", manifest.command_schema_json.is_some()),
        ("state", manifest.state_schema_json.is_some()),
        ("events", manifest.event_schema_json.is_some()),
    ]
    .into_iter()
    .filter_map(|(what, there)| there.then_some(what))
    .collect();
    let mut lines = vec![
        format!("  plugin    {} {} ({})", manifest.name, manifest.version, manifest.kind),
        format!("  what      {}", manifest.description),
        format!("  SHA-256   {}", plugin.sha256()),
        format!("  effects   {}", effects.join(", ")),
        format!("  schemas   {}", schemas.join(", ")),
    ];
    if !manifest.mavlink_messages.is_empty() {
        let ids: Vec<_> = manifest.mavlink_messages.iter().map(u32::to_string).collect();
        lines.push(format!("  MAVLink   {}", ids.join(", ")));
    }
    if manifest.tick_rate_hz > 0 {
        lines.push(format!("  called    {} times per second", manifest.tick_rate_hz));
    }
    let Lived {
        effects,
        snapshot_bytes,
    } = lived;
    lines.push(format!(
        "  instance  made, called ({effects} effects), restored from its snapshot ({snapshot_bytes} bytes), ended {place}"
    ));
    lines.join("\n")
}
