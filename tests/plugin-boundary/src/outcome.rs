//! How a fixture ended, in the words of the table in `README.md`.

use crate::tick;
use skein_domain::exchange::Create;
use skein_domain::{Incarnation, NodeTime, SystemId, VehicleId};
use skein_plugin_host::{ChildLimits, Isolation, LoadError, Plugin, PluginError, PluginKind, RunnerSettings, Runners};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A call that takes longer is given up. Shorter than what `slow_in_handle` takes.
const CALL_DEADLINE: Duration = Duration::from_millis(250);
/// The same for the beginning and the end of an instance; a process takes a while to start on a busy machine.
const CREATE_DEADLINE: Duration = Duration::from_secs(4);
/// What a child may use here: little, so that a leak ends soon.
const LIMITS: ChildLimits = ChildLimits {
    memory_mib: 128,
    cpu_share: 1.0,
    open_files: 64,
};

/// Where a fixture runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In the process of the test.
    InProcess,
    /// In a process of its own.
    Child,
}

/// One fixture: a library, and what it is told to do wrong.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixture {
    /// The library.
    pub library: String,
    /// The key and the word of its configuration; none for a library that is wrong as a whole.
    pub way: Option<(String, String)>,
}

impl Fixture {
    /// `library` or `library/word`, as the table names it.
    #[must_use]
    pub fn name(&self) -> String {
        match &self.way {
            Some((_, word)) => format!("{}/{word}", self.library),
            None => self.library.clone(),
        }
    }

    /// All that a library can do wrong, as the schema of its configuration lists it; the library itself if it cannot be loaded or has
    /// no choice.
    #[must_use]
    pub fn all_of(library: &str, path: &Path) -> Vec<Self> {
        let ways = Plugin::load(path).map_or(Vec::new(), |plugin| ways(&plugin.manifest().config_schema_json));
        if ways.is_empty() {
            let library = library.to_owned();
            return vec![Self { library, way: None }];
        }
        let fixture = |way| Self {
            library: library.to_owned(),
            way: Some(way),
        };
        ways.into_iter().map(fixture).collect()
    }
}

/// The one choice in a schema: the key and each of its words.
fn ways(schema: &str) -> Vec<(String, String)> {
    let schema: serde_json::Value = serde_json::from_str(schema).unwrap_or_default();
    let Some(properties) = schema["properties"].as_object() else {
        return Vec::new();
    };
    let words_of = |property: &serde_json::Value| {
        let mut places = vec![property.clone()];
        // What serde derives stands among the definitions.
        places.extend(
            schema["$defs"]
                .as_object()
                .into_iter()
                .flat_map(|defs| defs.values().cloned()),
        );
        let mut words = Vec::new();
        for place in places {
            let listed = place["enum"].as_array().cloned().unwrap_or_default();
            let described = place["oneOf"].as_array().cloned().unwrap_or_default();
            for one in described {
                words.extend(one["const"].as_str().map(str::to_owned));
                words.extend(strings(&one["enum"]));
            }
            words.extend(listed.iter().filter_map(|word| word.as_str().map(str::to_owned)));
        }
        words
    };
    let of = |(key, property): (&String, &serde_json::Value)| {
        let key = key.clone();
        words_of(property).into_iter().map(move |word| (key.clone(), word))
    };
    properties.iter().flat_map(of).collect()
}

fn strings(list: &serde_json::Value) -> Vec<String> {
    let words = list.as_array().cloned().unwrap_or_default();
    words
        .iter()
        .filter_map(|word| word.as_str().map(str::to_owned))
        .collect()
}

/// Takes a fixture through a whole life and says how it ended.
pub async fn outcome(path: &Path, fixture: &Fixture, place: Place, host: &Path) -> String {
    let plugin = match Plugin::load(path) {
        Ok(plugin) => plugin,
        Err(error) => return format!("not loaded: {}", load_word(&error)),
    };
    let runners = Runners::with_settings(RunnerSettings {
        threads: 1,
        call_deadline: CALL_DEADLINE,
        create_deadline: CREATE_DEADLINE,
        ..RunnerSettings::default()
    });
    runners.set_host_program(host.to_owned());
    let isolation = match place {
        Place::InProcess => Isolation::InProcess,
        Place::Child => Isolation::Child(LIMITS),
    };
    let create = create(&plugin, fixture);
    let instance = match runners.create(Arc::clone(&plugin), isolation, create).await {
        Ok(instance) => instance,
        Err(error) => return format!("not created: {}", word(&error)),
    };
    let first = instance.call(tick(1), &[]).await.map(drop);
    let ended = match first {
        Ok(()) => "answers".to_owned(),
        Err(error) => {
            // Whether it can be called again is part of what is promised.
            let again = instance
                .call(tick(2), &[])
                .await
                .is_err_and(|error| error.needs_restart());
            let lives = if again || error.needs_restart() {
                "restart"
            } else {
                "lives on"
            };
            format!("{}; {lives}", word(&error))
        }
    };
    let pid = instance.pid();
    drop(instance);
    end(&runners, &plugin, pid).await;
    ended
}

/// Waits until the instance is gone, by itself or given up.
async fn end(runners: &Arc<Runners>, plugin: &Arc<Plugin>, pid: Option<u32>) {
    let process_there = || pid.is_some_and(|pid| Path::new(&format!("/proc/{pid}")).exists());
    skein_testkit::eventually(skein_testkit::patience(), "the instance is gone", async || {
        let given_up = plugin.hanging_threads() > 0;
        (!process_there() && (runners.health().instances == 0 || given_up)).then_some(())
    })
    .await;
}

fn create(plugin: &Plugin, fixture: &Fixture) -> Create {
    let config_json = match &fixture.way {
        Some((key, word)) => format!(r#"{{"{key}": "{word}"}}"#),
        None => "{}".to_owned(),
    };
    let is_payload = plugin.manifest().kind != PluginKind::UAV_MODEL;
    Create {
        vehicle: VehicleId(9),
        incarnation: Incarnation(1),
        config_json,
        snapshot: None,
        now: NodeTime(0),
        payload: is_payload.then(|| "payload".to_owned()),
        system_id: Some(SystemId(9)),
    }
}

/// The word of the table for why a library is not loaded.
fn load_word(error: &LoadError) -> String {
    match error {
        LoadError::Handshake(mismatch) => format!("{mismatch}"),
        LoadError::NotLoadable { .. } => "no library".to_owned(),
        LoadError::MissingSymbol => "no symbol".to_owned(),
        LoadError::UnknownKind { .. } => "unknown kind".to_owned(),
        LoadError::BadManifest { .. } => "manifest".to_owned(),
        LoadError::ManifestPanicked { .. } => "panicked".to_owned(),
        LoadError::TimedOut { .. } => "too late".to_owned(),
        LoadError::ChangedWhileRead => "changed".to_owned(),
        other => other.to_string(),
    }
}

/// The word of the table for what an instance did.
fn word(error: &PluginError) -> String {
    let word = match error {
        PluginError::Panicked { .. } => "panicked",
        PluginError::DeadlineExceeded { .. } => "too late",
        PluginError::Refused { .. } => "refused",
        PluginError::Undecodable { .. } => "undecodable",
        PluginError::NotUnderstood { .. } => "not understood",
        PluginError::NotPermitted { .. } => "not permitted",
        PluginError::TooManyEffects { .. } => "too many effects",
        PluginError::TooLarge { .. } => "too large",
        PluginError::SchemaViolation { .. } => "against its schema",
        PluginError::BadFrame { .. } => "bad frame",
        PluginError::ProcessEnded { how, .. } => return format!("process ended, {how}"),
        other => return other.to_string(),
    };
    word.to_owned()
}
