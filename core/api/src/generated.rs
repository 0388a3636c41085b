//! The TypeScript that the dashboard is built with: types of every message, where each number stands in the binary frame, and
//! frames with their known contents. The files are committed; a test makes them anew and compares.
//!
//! Must never do: write files. It only says what they contain.

pub(crate) mod golden;

use crate::body::{DetectionsBody, TrackChangeBody};
use crate::protocol::{
    Accepted, AcknowledgeBody, Acknowledged, AskedObserverList, AutopilotLogList, CameraViewList, ClientMessage,
    CommandBody, CommandReceipts, ControlBody, ControlReceipts, ControlState, CoordinatorBody, EmergencyStopBody,
    ErrorBody, EventList, FenceFileBody, FencePlanBody, FlightList, FormationAnswer, FormationPreview, Health,
    ImportedFencePlan, LinkReport, LogFetchAnswer, ObserverList, OverrideBody, ParameterBody, PayloadList, PluginList,
    ReadingBody, ReferenceList, ReplayAnswer, RestartList, ResumeBody, RouteBody, ServerMessage, SupervisionTree,
    TrackList, TrajectoriesEnded, TrajectoryList, VehicleList, VersionInfo, VideoMessage, VideoRecordingAnswer,
    VideoRecordingList, VideoRequest, VideoStreamList,
};
use crate::upgrades::RolloutBody;
use crate::wire::{self, Field, Header, Record, flag};
use skein_config::PayloadRule;
use skein_coordination::ReferenceReport;
use skein_domain::payload::{
    CameraCommand, CameraState, DetectorState, GimbalCommand, GimbalState, RadioCommand, RadioState,
};
use skein_domain::{
    FlightMode, FlightState, FormationRequest, GnssFix, LandedState, ParameterList, TrajectoryObjection,
    TrajectoryPlan, TrajectoryRequest,
};
use skein_replay::{ReplayChange, Timeline};
use skein_runtime::{
    Detected, EmergencyKey, Fault, FenceAnswer, ObserveRequest, ParameterReceipt, PreflightAnswer, UpgradeReceipt,
};
use skein_view::FleetSnapshot;
use skein_view::FormationReceipt;
use skein_view::UpgradeReport;
use std::collections::BTreeMap;
use std::fmt::Write;
use ts_rs::{Config, TS, TypeVisitor};

/// Folder of the files, from the root of the repository.
pub const FOLDER: &str = "web-ui/src/protocol/generated";

const NOTE: &str =
    "// Made from the Rust types by `SKEIN_REGENERATE=1 cargo test -p skein-api --test generated`. Do not edit.\n";

/// One file: its name in [`FOLDER`] and what is in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GeneratedFile {
    /// Name.
    pub name: &'static str,
    /// Contents.
    pub text: String,
}

/// All files.
#[must_use]
pub fn files() -> Vec<GeneratedFile> {
    vec![
        GeneratedFile {
            name: "types.ts",
            text: types(),
        },
        GeneratedFile {
            name: "frame.ts",
            text: frame(),
        },
        GeneratedFile {
            name: "frame.golden.json",
            text: golden::vectors(),
        },
    ]
}

/// Every type that goes over the wire and every type these are made of, by name.
fn types() -> String {
    // JSON.parse gives numbers, never bigint. Said here too, so that the result does not depend on the environment.
    let config = Config::new().with_large_int("number");
    let mut found = Declarations {
        config: &config,
        by_name: BTreeMap::new(),
    };
    found.visit::<VersionInfo>();
    found.visit::<Health>();
    found.visit::<VehicleList>();
    found.visit::<FleetSnapshot>();
    found.visit::<AcknowledgeBody>();
    found.visit::<Acknowledged>();
    found.visit::<CoordinatorBody>();
    found.visit::<CommandBody>();
    found.visit::<CommandReceipts>();
    found.visit::<ParameterList>();
    found.visit::<ParameterBody>();
    found.visit::<ParameterReceipt>();
    found.visit::<ReadingBody>();
    found.visit::<ControlBody>();
    found.visit::<ControlReceipts>();
    found.visit::<ControlState>();
    found.visit::<FormationRequest>();
    found.visit::<FormationReceipt>();
    found.visit::<FormationAnswer>();
    found.visit::<FormationPreview>();
    found.visit::<ReferenceList>();
    found.visit::<ReferenceReport>();
    plans_and_safety(&mut found);
    what_is_carried(&mut found);
    found.visit::<ErrorBody>();
    found.visit::<ServerMessage>();
    found.visit::<ClientMessage>();
    let mut out = NOTE.to_owned();
    for declaration in found.by_name.values() {
        out.push('\n');
        out.push_str(declaration);
    }
    out
}

fn plans_and_safety(found: &mut Declarations<'_>) {
    found.visit::<TrajectoryRequest>();
    found.visit::<TrajectoryPlan>();
    found.visit::<TrajectoryObjection>();
    found.visit::<TrajectoryList>();
    found.visit::<TrajectoriesEnded>();
    found.visit::<PreflightAnswer>();
    found.visit::<OverrideBody>();
    found.visit::<FenceAnswer>();
    found.visit::<FencePlanBody>();
    found.visit::<FenceFileBody>();
    found.visit::<ImportedFencePlan>();
    found.visit::<EmergencyKey>();
    found.visit::<EmergencyStopBody>();
    found.visit::<RouteBody>();
    found.visit::<ResumeBody>();
    found.visit::<RolloutBody>();
    found.visit::<UpgradeReport>();
    found.visit::<Accepted>();
    found.visit::<Fault>();
}

fn what_is_carried(found: &mut Declarations<'_>) {
    found.visit::<EventList>();
    found.visit::<ReplayAnswer>();
    found.visit::<AutopilotLogList>();
    found.visit::<LogFetchAnswer>();
    found.visit::<ReplayChange>();
    found.visit::<Timeline>();
    found.visit::<PluginList>();
    found.visit::<PayloadList>();
    found.visit::<RestartList>();
    found.visit::<SupervisionTree>();
    found.visit::<LinkReport>();
    found.visit::<CameraViewList>();
    found.visit::<TrackList>();
    found.visit::<TrackChangeBody>();
    found.visit::<DetectionsBody>();
    found.visit::<Detected>();
    found.visit::<ObserverList>();
    found.visit::<ObserveRequest>();
    found.visit::<AskedObserverList>();
    found.visit::<VideoStreamList>();
    found.visit::<VideoMessage>();
    found.visit::<VideoRequest>();
    found.visit::<VideoRecordingList>();
    found.visit::<FlightList>();
    found.visit::<VideoRecordingAnswer>();
    found.visit::<UpgradeReceipt>();
    found.visit::<PayloadRule>();
    found.visit::<GimbalCommand>();
    found.visit::<GimbalState>();
    found.visit::<CameraCommand>();
    found.visit::<CameraState>();
    found.visit::<RadioCommand>();
    found.visit::<RadioState>();
    found.visit::<DetectorState>();
}

/// Collects declarations, each type once, through all types they refer to.
struct Declarations<'a> {
    config: &'a Config,
    by_name: BTreeMap<String, String>,
}

impl TypeVisitor for Declarations<'_> {
    fn visit<T: TS + 'static + ?Sized>(&mut self) {
        // Types without a path of their own are TypeScript's own: numbers, arrays, optional values.
        if T::output_path().is_none() {
            T::visit_generics(self);
            return;
        }
        let name = T::ident(self.config);
        if self.by_name.contains_key(&name) {
            return;
        }
        let docs = T::docs().unwrap_or_default();
        let declaration = format!("{docs}export {}\n", T::decl(self.config));
        self.by_name.insert(name, declaration);
        T::visit_dependencies(self);
    }
}

/// Offsets, bits, codes and magic of the binary frame.
fn frame() -> String {
    let mut out = NOTE.to_owned();
    out.push_str("import type { FlightMode, FlightState, GnssFix, LandedState } from \"./types\";\n\n");
    constants(&mut out);
    offsets(
        &mut out,
        "Where the numbers of the header stand, in bytes from its start. Little-endian.",
        "HEADER",
        Header::FIELDS,
    );
    offsets(
        &mut out,
        "Where the numbers of a record stand, in bytes from its start. Little-endian.",
        "RECORD",
        Record::FIELDS,
    );
    out.push_str("/** The bits of a record's flags. */\nexport const FLAG = {\n");
    for (name, bit) in flag::ALL {
        let _ = writeln!(out, "  {name}: {bit},");
    }
    out.push_str("} as const;\n\n");
    all_codes(&mut out);
    out.truncate(out.trim_end().len());
    out.push('\n');
    out
}

/// The numbers that stand alone.
fn constants(out: &mut String) {
    constant(
        out,
        "First number of a frame; another one is another protocol.",
        "FRAME_MAGIC",
        &format!("0x{:08x}", wire::FRAME_MAGIC),
    );
    constant(
        out,
        "Bytes before the first record.",
        "HEADER_BYTES",
        &wire::HEADER_BYTES.to_string(),
    );
    constant(
        out,
        "Bytes of one record.",
        "RECORD_BYTES",
        &wire::RECORD_BYTES.to_string(),
    );
    constant(
        out,
        "Battery charge that is not known.",
        "UNKNOWN_PERCENT",
        &wire::UNKNOWN_PERCENT.to_string(),
    );
    constant(
        out,
        "Battery voltage that is not known.",
        "UNKNOWN_VOLTAGE",
        &wire::UNKNOWN_VOLTAGE.to_string(),
    );
    constant(
        out,
        "Tracking error or round trip that is not known.",
        "UNKNOWN_U16",
        &wire::UNKNOWN_U16.to_string(),
    );
}

/// The codes of the plain enums, with their words.
fn all_codes(out: &mut String) {
    codes(
        out,
        "FLIGHT_MODES",
        "FlightMode",
        FlightMode::ALL.iter().map(|v| (v.code(), v.word())),
    );
    codes(
        out,
        "LANDED_STATES",
        "LandedState",
        LandedState::ALL.iter().map(|v| (v.code(), v.word())),
    );
    codes(
        out,
        "GNSS_FIXES",
        "GnssFix",
        GnssFix::ALL.iter().map(|v| (v.code(), v.word())),
    );
    codes(
        out,
        "FLIGHT_STATES",
        "FlightState",
        FlightState::ALL.iter().map(|v| (v.code(), v.word())),
    );
}

fn constant(out: &mut String, doc: &str, name: &str, value: &str) {
    let _ = write!(out, "/** {doc} */\nexport const {name} = {value};\n\n");
}

fn offsets(out: &mut String, doc: &str, name: &str, fields: &[Field]) {
    let _ = write!(out, "/** {doc} */\nexport const {name} = {{\n");
    for field in fields {
        let _ = writeln!(out, "  /** {} */\n  {}: {},", field.kind, field.name, field.offset);
    }
    out.push_str("} as const;\n\n");
}

/// A list of words whose place is their code. Codes without a word, if any, are said to be the first one.
fn codes(out: &mut String, name: &str, kind: &str, words: impl Iterator<Item = (u8, String)>) {
    let by_code: BTreeMap<u8, String> = words.collect();
    let _ = write!(
        out,
        "/** The word for each code. */\nexport const {name}: readonly {kind}[] = [\n"
    );
    let unknown = by_code.values().next().cloned().unwrap_or_default();
    for code in 0..=by_code.keys().next_back().copied().unwrap_or(0) {
        let _ = writeln!(out, "  \"{}\",", by_code.get(&code).unwrap_or(&unknown));
    }
    out.push_str("];\n\n");
}
