//! The exported entries, called as a host calls them.

use super::*;
use crate::{CreateError, UavManifest};
use skein_domain::exchange::{Effect, EffectBatch, EventBatch};
use skein_domain::manifest::{EffectKind, PluginManifest};
use skein_domain::{Incarnation, NodeTime, VehicleId};
use skein_plugin_abi::FrameBuffer;
use std::ffi::c_void;

#[derive(Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Settings {
    /// What to do wrong.
    fail: String,
}

struct Model {
    fail: String,
    ticks: u8,
}

impl UavModel for Model {
    type Config = Settings;

    const MANIFEST: UavManifest = UavManifest {
        name: "test",
        version: "1.0.0",
        description: "For tests.",
        effects: &[EffectKind::RouteFinished],
    };

    fn create(create: Create, config: Settings) -> Result<Self, CreateError> {
        log::info!("created as {}", create.vehicle);
        match config.fail.as_str() {
            "refuse" => Err(CreateError::new("not today")),
            "panic in create" => panic!("created badly"),
            _ => Ok(Self {
                fail: config.fail,
                ticks: create.snapshot.and_then(|s| s.first().copied()).unwrap_or(0),
            }),
        }
    }

    fn handle(&mut self, _now: NodeTime, events: &[Event], effects: &mut Effects) {
        assert_ne!(self.fail, "panic in handle", "handled badly");
        for _ in events {
            self.ticks += 1;
            effects.route_finished();
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        vec![self.ticks]
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        log::warn!("dropped after {} ticks", self.ticks);
        assert_ne!(self.fail, "panic in drop", "dropped badly");
    }
}

type Lines = parking_lot::Mutex<Vec<(u32, String)>>;

unsafe extern "C" fn take_line(context: *mut c_void, level: u32, text: Slice) {
    // SAFETY: the context is the `Lines` that `Host` keeps.
    let (lines, text) = unsafe { (&*context.cast::<Lines>(), text.as_bytes()) };
    lines.lock().push((level, String::from_utf8_lossy(text).into_owned()));
}

unsafe extern "C" fn no_frame(_: *mut c_void, _: usize) -> FrameBuffer {
    FrameBuffer::NONE
}

unsafe extern "C" fn released(_: *mut c_void, _: u64) {}

unsafe extern "C" fn nothing_to_read(_: *mut c_void, _: u64) -> Slice {
    Slice::of(&[])
}

/// A host of one instance.
struct Host {
    table: &'static PluginTable,
    handle: PluginHandle,
    lines: Box<Lines>,
}

fn text_of(outcome: &Outcome) -> String {
    // SAFETY: not freed yet.
    String::from_utf8_lossy(unsafe { outcome.buffer.as_slice().as_bytes() }).into_owned()
}

impl Host {
    fn new(config: &str, snapshot: Option<Vec<u8>>) -> Result<Self, (Status, String)> {
        let create = Create {
            vehicle: VehicleId(4),
            incarnation: Incarnation(1),
            config_json: config.to_owned(),
            snapshot,
            now: NodeTime(0),
            payload: None,
            system_id: None,
        };
        Self::with(CREATE_SCHEMA, &minicbor::to_vec(create).expect("encodes"))
    }

    fn with(schema: u32, bytes: &[u8]) -> Result<Self, (Status, String)> {
        let lines = Box::new(Lines::default());
        let context = std::ptr::from_ref::<Lines>(&lines).cast_mut().cast();
        let services = HostServices {
            size: size_of::<HostServices>(),
            context,
            log: take_line,
            acquire_frame: no_frame,
            release_frame: released,
            read_frame: nothing_to_read,
        };
        let table = Exported::<Flying<Model>>::TABLE;
        // SAFETY: services and bytes live over the call; the lines live over the instance.
        let CreateOutcome {
            status, handle, buffer, ..
        } = unsafe { table.create.expect("is there")(&services, schema, Slice::of(bytes)) };
        let outcome = Outcome {
            status,
            schema: 0,
            buffer,
        };
        if status == Status::OK.0 {
            return Ok(Self { table, handle, lines });
        }
        assert!(handle.is_null());
        Err((Status(status), text_of(&outcome)))
    }

    fn invoke(&self, method: u32, schema: u32, bytes: &[u8]) -> (Status, Vec<u8>) {
        // SAFETY: the handle is alive and used by this thread alone.
        let outcome = unsafe { self.table.invoke.expect("is there")(self.handle, method, schema, Slice::of(bytes)) };
        // SAFETY: not freed yet.
        let answer = unsafe { outcome.buffer.as_slice().as_bytes() }.to_vec();
        // SAFETY: the buffer comes from this table and is used no more.
        unsafe { self.table.free.expect("is there")(outcome.buffer) };
        (Status(outcome.status), answer)
    }

    fn handle_events(&self, events: Vec<Event>) -> (Status, Vec<u8>) {
        let batch = EventBatch {
            now: NodeTime(1),
            events,
        };
        self.invoke(
            method::HANDLE_EVENTS,
            EVENT_BATCH_SCHEMA,
            &minicbor::to_vec(batch).expect("encodes"),
        )
    }

    fn destroy(self) -> (Status, String, Vec<(u32, String)>) {
        // SAFETY: the handle is alive and used for the last time.
        let outcome = unsafe { self.table.destroy.expect("is there")(self.handle) };
        (Status(outcome.status), text_of(&outcome), self.lines.lock().clone())
    }
}

#[test]
fn a_life_from_create_to_destroy() {
    let host = Host::new("{}", Some(vec![40])).expect("created");
    let (status, answer) = host.handle_events(vec![Event::Tick, Event::Rebooted]);
    assert_eq!(status, Status::OK);
    let batch: EffectBatch = minicbor::decode(&answer).expect("decodes");
    assert_eq!(batch.effects, vec![Effect::RouteFinished; 2]);
    assert_eq!(host.invoke(method::SNAPSHOT, 0, &[]), (Status::OK, vec![42]));
    let (status, _, lines) = host.destroy();
    assert_eq!(status, Status::OK);
    let expected = [(3, "created as 4".to_owned()), (2, "dropped after 42 ticks".to_owned())];
    assert_eq!(lines, expected);
}

#[test]
fn the_manifest_crosses() {
    // SAFETY: takes nothing.
    let outcome = unsafe { Exported::<Flying<Model>>::TABLE.manifest.expect("is there")() };
    // SAFETY: not freed yet.
    let bytes = unsafe { outcome.buffer.as_slice().as_bytes() };
    let manifest: PluginManifest = minicbor::decode(bytes).expect("decodes");
    assert_eq!(
        (manifest.name.as_str(), manifest.effects),
        ("test", vec![EffectKind::RouteFinished.code()])
    );
    let schema: serde_json::Value = serde_json::from_str(&manifest.config_schema_json).expect("is JSON");
    assert_eq!(schema["properties"]["fail"]["description"], "What to do wrong.");
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn create_says_why_not() {
    let why = |result: Result<Host, (Status, String)>| result.err().expect("not created");
    let (status, text) = why(Host::new(r#"{"unknown": 1}"#, None));
    assert!(
        status == Status::REFUSED && text.contains("unknown field `unknown`, expected `fail`"),
        "{text}"
    );
    assert_eq!(
        why(Host::new(r#"{"fail": "refuse"}"#, None)),
        (Status::REFUSED, "not today".to_owned())
    );
    let (status, text) = why(Host::new(r#"{"fail": "panic in create"}"#, None));
    assert!(
        status == Status::PANICKED && text.starts_with("created badly ("),
        "{text}"
    );
    assert_eq!(why(Host::with(77, &[])).0, Status::UNKNOWN_SCHEMA);
    assert_eq!(why(Host::with(CREATE_SCHEMA, b"garbage")).0, Status::UNDECODABLE);
}

#[test]
fn a_panic_poisons_the_instance_and_nothing_else() {
    let host = Host::new(r#"{"fail": "panic in handle"}"#, None).expect("created");
    let other = Host::new("{}", None).expect("created");
    let (status, answer) = host.handle_events(vec![Event::Tick]);
    assert_eq!(status, Status::PANICKED);
    assert!(String::from_utf8_lossy(&answer).contains("handled badly"));
    assert_eq!(host.handle_events(vec![]).0, Status::POISONED);
    assert_eq!(host.invoke(method::SNAPSHOT, 0, &[]).0, Status::POISONED);
    assert_eq!(other.handle_events(vec![Event::Tick]).0, Status::OK);
    assert_eq!(host.destroy().0, Status::OK);
    assert_eq!(other.destroy().0, Status::OK);
}

#[test]
fn a_drill_panics_before_the_model_sees_anything() {
    let host = Host::new("{}", None).expect("created");
    let (status, answer) = host.handle_events(vec![Event::Tick, Event::FaultDrill(FaultDrill::Panic)]);
    assert!(status == Status::PANICKED && answer.starts_with(b"fault drill ("));
    let (_, _, lines) = host.destroy();
    assert!(lines.contains(&(2, "fault drill: Panic".to_owned())), "{lines:?}");
    assert!(lines.contains(&(2, "dropped after 0 ticks".to_owned())), "{lines:?}");
}

#[test]
fn a_panic_while_dropped_ends_in_a_message() {
    let host = Host::new(r#"{"fail": "panic in drop"}"#, None).expect("created");
    let (status, text, _) = host.destroy();
    assert!(status == Status::PANICKED && text.contains("dropped badly"), "{text}");
}

#[test]
fn what_is_not_understood_is_said() {
    let host = Host::new("{}", None).expect("created");
    assert_eq!(host.invoke(999, 0, &[]).0, Status::UNKNOWN_METHOD);
    assert_eq!(host.invoke(method::HANDLE_EVENTS, 999, &[]).0, Status::UNKNOWN_SCHEMA);
    assert_eq!(
        host.invoke(method::HANDLE_EVENTS, EVENT_BATCH_SCHEMA, b"\xff").0,
        Status::UNDECODABLE
    );
    assert_eq!(host.handle_events(vec![]).0, Status::OK, "it goes on after that");
    host.destroy();
}

#[test]
fn a_logger_that_outlives_its_instance_is_silent() {
    let host = Host::new("{}", None).expect("created");
    // SAFETY: the handle is alive and used by this thread alone.
    let logger = unsafe { &*host.handle.cast::<Living<Flying<Model>>>() }
        .host
        .clone()
        .expect("has one");
    logger.log(log::LogLevel::ERROR, "from elsewhere");
    assert_eq!(
        host.lines.lock().last().map(|(_, text)| text.clone()),
        Some("from elsewhere".to_owned())
    );
    let (_, _, lines) = host.destroy();
    logger.log(log::LogLevel::ERROR, "too late: the host's side is gone");
    assert_eq!(lines.len(), 3);
    assert!(log::Logger::current().is_none());
    log::info!("from nowhere");
}
