//! What is said of what is taken: messages on topics, with the fleet thinned to what a person or a chart needs.
//!
//! Must never do: thin out an event, a refusal, an action or a decision that told of something.

mod decisions;

use skein_domain::{FlightMode, LandedState, NodeTime, VehicleId};
use skein_recording::{
    AuditChain, ClockOffset, ClockRecord, Encoded, RecorderState, TimeBase, Topic, VehicleTelemetry, scene,
};
use skein_runtime::NodeHandle;
use skein_safety::Gate;
use skein_state::Taken;
use skein_view::{Audit, EventRecord, FleetSnapshot, VehicleSnapshot};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

/// While somebody is armed vehicles are recorded so often, in hertz; while all stand, once a second. A change of mode, arming or landing is recorded at
/// once.
pub const FLYING_HZ: f64 = 5.0;
/// Places on Earth, the scene and clocks are recorded so often, in hertz, and the whole picture half as often.
const SLOW_HZ: f64 = 1.0;

/// The encoder of one recorder. It begins anew with each file what a file has to hold.
pub struct Encoder {
    node: NodeHandle,
    base: TimeBase,
    chain: AuditChain,
    gate: Option<(u64, Arc<Gate>)>,
    periods: Vec<NodeTime>,
    slow: Option<u64>,
    fast: Option<u64>,
    states: Vec<State>,
    shown: Option<NodeTime>,
    everything: bool,
}

/// What of a vehicle is recorded as soon as it changes.
type State = (VehicleId, bool, FlightMode, LandedState);

/// Now, as this computer's clock has it, in nanoseconds since 1970.
pub fn time_of_day_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}

impl Encoder {
    /// One for this node, whose audit follows on this hash.
    pub fn new(node: NodeHandle, base: TimeBase, chain: AuditChain) -> Self {
        let everything = node.config().recorder.everything;
        Self {
            node,
            base,
            chain,
            gate: None,
            periods: Vec::new(),
            slow: None,
            fast: None,
            states: Vec::new(),
            shown: None,
            everything,
        }
    }

    /// How its time is told.
    pub fn base(&self) -> TimeBase {
        self.base
    }

    /// A file begins: what it opens with.
    pub fn begin_file(&mut self, base: TimeBase) -> Vec<Encoded> {
        self.base = base;
        self.chain = AuditChain::after(self.chain.last());
        (self.gate, self.slow, self.fast, self.shown) = (None, None, None, None);
        self.periods.clear();
        let mut said = Said::default();
        let begins = Audit {
            time: self.node.now(),
            over: "node".into(),
            what: "a recording begins".into(),
            outcome: format!("version {}", env!("CARGO_PKG_VERSION")),
            ..Audit::default()
        };
        self.audit(&mut said, begins);
        said.messages
    }

    /// What is said of it.
    pub fn encode(&mut self, taken: Taken) -> Vec<Encoded> {
        let mut said = Said::default();
        match taken {
            Taken::Fleet(fleet) => self.fleet(&mut said, &fleet),
            Taken::Event(event) => self.event(&mut said, &event),
            Taken::Setpoint(judged) => self.setpoint(&mut said, &judged),
            Taken::Failsafe(step) => self.failsafe(&mut said, *step),
            Taken::Leadership(turn) => Self::leadership(&mut said, &turn),
            Taken::Plan(made) => self.plan(&mut said, &made),
            Taken::Audit(audit) => self.audit(&mut said, audit),
        }
        said.messages
    }

    /// How the recorder fares.
    pub fn recorder(&self, state: &RecorderState) -> Vec<Encoded> {
        let mut said = Said::default();
        said.json(Topic::Recorder, state.time, state);
        said.messages
    }

    fn audit(&mut self, said: &mut Said, audit: Audit) {
        let record = self.chain.add(audit);
        said.json(Topic::Audit, record.audit.time, &record);
    }

    fn event(&self, said: &mut Said, event: &EventRecord) {
        let unix_ns = self.base.unix_ns(event.time);
        said.json(Topic::Events, event.time, event);
        said.theirs(Topic::Log, event.time, &scene::log(event, unix_ns));
    }

    fn fleet(&mut self, said: &mut Said, fleet: &FleetSnapshot) {
        // The last one is handed over at the end by somebody else than those before: one of these may come after it.
        if self.shown.is_some_and(|shown| fleet.time <= shown) {
            return;
        }
        self.shown = Some(fleet.time);
        let at = fleet.time;
        let tick = |hz: f64| Some((at.as_seconds() * hz) as u64);
        let flies = fleet.vehicles.iter().any(|vehicle| vehicle.armed);
        let slow = self.everything || self.slow != tick(SLOW_HZ);
        let state = |vehicle: &VehicleSnapshot| (vehicle.id, vehicle.armed, vehicle.mode, vehicle.landed);
        let states: Vec<State> = fleet.vehicles.iter().map(state).collect();
        let changed = states != self.states;
        let fast = slow || changed || flies && self.fast != tick(FLYING_HZ);
        let whole = self.slow.is_none() || tick(SLOW_HZ).is_some_and(|tick| tick % 2 == 0);
        (self.slow, self.fast, self.states) = (tick(SLOW_HZ), tick(FLYING_HZ), states);
        let unix_ns = self.base.unix_ns(at);
        if slow && (whole || self.everything) {
            said.json(Topic::Fleet, at, fleet);
        }
        if slow {
            said.json(Topic::Clock, at, &clock(fleet));
            for vehicle in &fleet.vehicles {
                if let Some(location) = scene::location(vehicle, unix_ns) {
                    said.theirs(Topic::Location(vehicle.id), at, &location);
                }
            }
            said.theirs(Topic::Scene, at, &scene::scene(fleet, unix_ns));
        }
        if fast {
            for vehicle in &fleet.vehicles {
                said.json(Topic::Telemetry(vehicle.id), at, &VehicleTelemetry::of(vehicle, at));
            }
            let transforms = scene::transforms(fleet, unix_ns);
            if !transforms.transforms.is_empty() {
                said.theirs(Topic::Transforms, at, &transforms);
            }
        }
    }
}

/// How the clocks stand to each other.
fn clock(fleet: &FleetSnapshot) -> ClockRecord {
    let nodes = fleet.swarm.iter().flat_map(|swarm| &swarm.nodes);
    let offset = nodes.filter_map(|node| {
        Some(ClockOffset {
            node: node.node,
            ahead_s: node.clock_offset_s?,
            error_s: node.clock_error_s,
        })
    });
    ClockRecord {
        time: fleet.time,
        unix_ns: time_of_day_ns(),
        others: offset.collect(),
    }
}

/// Messages that came of one thing.
#[derive(Default)]
struct Said {
    messages: Vec<Encoded>,
}

impl Said {
    fn json(&mut self, topic: Topic, at: NodeTime, message: &impl serde::Serialize) {
        match Encoded::json(topic, at, message) {
            Ok(encoded) => self.messages.push(encoded),
            Err(error) => tracing::warn!("not recorded: {error}"),
        }
    }

    fn theirs(&mut self, topic: Topic, at: NodeTime, message: &impl foxglove::Encode) {
        self.messages.push(Encoded::theirs(topic, at, message));
    }
}
