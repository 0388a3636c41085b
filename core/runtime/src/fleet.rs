//! The fleet actor: takes newly heard vehicles into the swarm by the adoption rules, and supervises their actors.
//!
//! Vehicles are its children, not the coordinator's: ractor ends children with their parent, and the end of the coordinator must
//! stop no setpoint. Must never do: wait for a vehicle's actor, or fly anything itself.

mod payloads;
mod probation;

pub use payloads::{payload_kind, payload_record};

use crate::vehicle::{VehicleActor, VehicleArguments};
use payloads::{PayloadKey, SupervisedPayload};
use probation::Probation;
use ractor::{Actor, ActorId, ActorProcessingErr, ActorRef, RpcReplyPort, SupervisionEvent};
use skein_config::{AdoptionRule, LinkKind, PayloadRule};
use skein_domain::exchange::Severity;
use skein_domain::link::VehicleLink;
use skein_domain::{AutopilotCommand, FlightMode, FlightState, Incarnation, Refusal, RequestId, SystemId, VehicleId};
use skein_plugin_host::{Plugin, PluginKind};
use skein_px4::PairedLink;
use skein_state::restart::{Decision, RestartHistory, VEHICLE_LIMITS};
use skein_state::{PluginIdentity, PluginRecord};
use skein_state::{SharedState, VehicleRecord};
use skein_view::{ActorStatus, EventKind, PeerEntry, UnadoptedVehicle};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

/// The actor.
pub struct Fleet;

/// What the fleet is told.
pub enum FleetMessage {
    /// An endpoint hears a vehicle that it has not heard before.
    Discovered(Discovery),
    /// An endpoint hears something that cannot be flown as it is.
    Trouble(UnadoptedVehicle),
    /// Look at those that are not taken in yet.
    LookAtNewcomers,
    /// The back-off of a vehicle's actor is over.
    Restart(VehicleId),
    /// The back-off of a payload's actor is over.
    RestartPayload((VehicleId, String)),
    /// Put a payload on a vehicle.
    Attach(VehicleId, Box<PayloadRule>, RpcReplyPort<Result<(), Refusal>>),
    /// Take one off.
    Detach(VehicleId, String, RpcReplyPort<Result<(), Refusal>>),
}

/// Whose actor a child is.
enum Child {
    Vehicle(VehicleId),
    Payload(PayloadKey),
}

/// A vehicle heard for the first time on an endpoint.
pub struct Discovery {
    /// Name of the endpoint, or of its place on DDS.
    pub endpoint: String,
    /// What it is heard over.
    pub kind: LinkKind,
    /// Its link.
    pub link: Arc<dyn VehicleLink>,
    /// Its system id there.
    pub system_id: SystemId,
}

/// State.
pub struct FleetState {
    shared: Arc<SharedState>,
    children: HashMap<ActorId, Child>,
    supervised: BTreeMap<VehicleId, Supervised>,
    supervised_payloads: BTreeMap<PayloadKey, SupervisedPayload>,
    probation: Probation,
}

#[derive(Default)]
struct Supervised {
    incarnation: Incarnation,
    history: RestartHistory,
}

impl Actor for Fleet {
    type Msg = FleetMessage;
    type State = FleetState;
    type Arguments = Arc<SharedState>;

    async fn pre_start(
        &self,
        myself: ActorRef<FleetMessage>,
        shared: Arc<SharedState>,
    ) -> Result<FleetState, ActorProcessingErr> {
        let mut state = FleetState {
            shared,
            children: HashMap::new(),
            supervised: BTreeMap::new(),
            supervised_payloads: BTreeMap::new(),
            probation: Probation::default(),
        };
        // After a restart of the fleet itself, its vehicles are in the shared state.
        for record in state.shared.vehicles.records() {
            let incarnation = record.state().actor.incarnation;
            state.supervised.insert(
                record.id,
                Supervised {
                    incarnation,
                    ..Supervised::default()
                },
            );
            state.start(&myself, record.clone()).await;
            state.start_payloads(&myself, &record).await;
        }
        Ok(state)
    }

    async fn handle(
        &self,
        myself: ActorRef<FleetMessage>,
        message: FleetMessage,
        state: &mut FleetState,
    ) -> Result<(), ActorProcessingErr> {
        match message {
            FleetMessage::Discovered(discovery) => state.discovered(&myself, discovery).await,
            FleetMessage::Trouble(trouble) => state.not_adopted(trouble),
            FleetMessage::LookAtNewcomers => state.look_at_newcomers(&myself).await,
            FleetMessage::Restart(id) => {
                if let Some(record) = state.shared.vehicles.record(id) {
                    state.start(&myself, record).await;
                }
            }
            FleetMessage::RestartPayload(key) => state.start_payload(&myself, key).await,
            // Whoever asked may have given up waiting; the event log has the outcome.
            FleetMessage::Attach(vehicle, rule, reply) => {
                let _ = reply.send(state.attach(&myself, vehicle, &rule).await);
            }
            FleetMessage::Detach(vehicle, name, reply) => {
                let _ = reply.send(state.detach(vehicle, &name));
            }
        }
        Ok(())
    }

    async fn handle_supervisor_evt(
        &self,
        myself: ActorRef<FleetMessage>,
        event: SupervisionEvent,
        state: &mut FleetState,
    ) -> Result<(), ActorProcessingErr> {
        let (actor, error) = match event {
            SupervisionEvent::ActorFailed(actor, error) => (actor, error.to_string()),
            SupervisionEvent::ActorTerminated(actor, _, reason) => (actor, reason.unwrap_or_else(|| "ended".into())),
            _ => return Ok(()),
        };
        match state.children.remove(&actor.get_id()) {
            Some(Child::Vehicle(id)) => state.ended(&myself, id, &error).await,
            Some(Child::Payload(key)) => state.payload_ended(&myself, key, &error),
            None => {}
        }
        Ok(())
    }
}

/// Whether a rule is about such a vehicle. Endpoints are MAVLink's.
fn fits(rule: &AdoptionRule, discovery: &Discovery) -> bool {
    let endpoint = rule.endpoint.as_ref().filter(|_| discovery.kind == LinkKind::Mavlink);
    rule.system_ids.contains(discovery.system_id)
        && rule.links.contains(&discovery.kind)
        && endpoint.is_none_or(|name| *name == discovery.endpoint)
}

fn vehicle_id(discovery: &Discovery, rule: &AdoptionRule) -> VehicleId {
    VehicleId(u16::from(discovery.system_id.0).saturating_add(rule.vehicle_id_offset))
}

impl Discovery {
    fn unadopted(&self, why: String) -> UnadoptedVehicle {
        UnadoptedVehicle {
            system_id: self.system_id,
            endpoint: self.endpoint.clone(),
            why,
        }
    }
}

impl FleetState {
    async fn discovered(&mut self, myself: &ActorRef<FleetMessage>, discovery: Discovery) {
        let rules = &self.shared.config.adopt;
        let Some(rule) = rules.iter().find(|rule| fits(rule, &discovery)).cloned() else {
            return self.not_adopted(discovery.unadopted("no adoption rule fits it".to_owned()));
        };
        let id = vehicle_id(&discovery, &rule);
        let flown_before = || {
            self.shared
                .resume
                .before()
                .is_some_and(|flown| flown.vehicles.contains_key(&id))
        };
        let known = self.shared.vehicles.record(id).is_some() || flown_before();
        let now = if known {
            Some(discovery)
        } else {
            self.keep_on_probation(myself, discovery, &rule)
        };
        if let Some(discovery) = now {
            self.take_in(myself, discovery, &rule).await;
        }
    }

    /// Makes a vehicle of ours of it, or says why not.
    async fn take_in(&mut self, myself: &ActorRef<FleetMessage>, discovery: Discovery, rule: &AdoptionRule) {
        if let Err(why) = self.adopt(myself, &discovery, rule).await {
            self.not_adopted(discovery.unadopted(why));
        }
    }

    async fn adopt(
        &mut self,
        myself: &ActorRef<FleetMessage>,
        discovery: &Discovery,
        rule: &AdoptionRule,
    ) -> Result<(), String> {
        let (endpoint, system_id) = (&discovery.endpoint, discovery.system_id);
        let id = vehicle_id(discovery, rule);
        let now = self.shared.now();
        if let Some(known) = self.shared.vehicles.record(id) {
            return self.heard_again(&known, discovery);
        }
        let catalog = &self.shared.plugins.catalog;
        let plugin = catalog
            .get(&rule.model)
            .filter(|plugin| plugin.manifest().kind == PluginKind::UAV_MODEL)
            .ok_or_else(|| format!("its UAV model \"{}\" is not among the plugins found", rule.model))?;
        let name = rule
            .name
            .replace("{system_id}", &system_id.to_string())
            .replace("{vehicle_id}", &id.to_string());
        let link = self.link_of(id, discovery, rule);
        let record = self.new_record(id, name, link, plugin, rule)?;
        let is_it = |u: &UnadoptedVehicle| u.system_id == system_id && u.endpoint == *endpoint;
        self.shared.vehicles.forget_unadopted(is_it);
        let text = format!(
            "{} adopted: system id {system_id} on {endpoint}, model {}",
            record.name, rule.model
        );
        self.shared
            .events
            .record(now, Some(id), Severity::Info, EventKind::Adopted, text);
        self.shared.vehicles.adopt(record.clone());
        // Heard before it was ours, it would be kept away from as a stranger in its own place.
        let sightings = &self.shared.observed.sightings;
        sightings.forget(&skein_link_mavlink::sighting::source_of(system_id.0));
        self.supervised.insert(id, Supervised::default());
        self.start(myself, record.clone()).await;
        self.start_payloads(myself, &record).await;
        Ok(())
    }

    /// A vehicle of ours is heard anew: over its second link, or over a new one in place of one that is lost.
    fn heard_again(&mut self, known: &VehicleRecord, discovery: &Discovery) -> Result<(), String> {
        let now = self.shared.now();
        let Discovery {
            endpoint, kind, link, ..
        } = discovery;
        let (id, name) = (known.id, &known.name);
        if let Some(pair) = self.shared.vehicles.pair(id) {
            let attached = pair.attach(now, *kind, link.clone());
            return attached.then_some(()).ok_or_else(|| {
                let active = pair.active();
                format!("vehicle {id} is already flown over {active} and heard over {kind} ({name})")
            });
        }
        let (_, health) = known.link().read(now);
        if health.connected {
            return Err(format!("vehicle {id} is already flown over another link ({name})"));
        }
        known.replace_link(link.clone());
        let text = format!("{name} is back, heard on {endpoint}");
        self.shared
            .events
            .record(now, Some(id), Severity::Advisory, EventKind::LinkRegained, text);
        Ok(())
    }

    /// The link itself, or one of two.
    fn link_of(&self, id: VehicleId, discovery: &Discovery, rule: &AdoptionRule) -> Arc<dyn VehicleLink> {
        let link = discovery.link.clone();
        match rule.links.as_slice() {
            [first, second] => {
                let pair = Arc::new(PairedLink::new([*first, *second], discovery.kind, link));
                self.shared.vehicles.note_pair(id, pair.clone());
                pair
            }
            _ => link,
        }
    }

    /// A vehicle with what it carries, as its rule says.
    fn new_record(
        &self,
        id: VehicleId,
        name: String,
        link: Arc<dyn VehicleLink>,
        plugin: Arc<Plugin>,
        rule: &AdoptionRule,
    ) -> Result<Arc<VehicleRecord>, String> {
        let system_id = link.system_id();
        let identity = PluginIdentity {
            name: format!("model-{id}"),
            label: format!("{name}: model"),
            vehicle: id,
            payload: None,
            system_id,
        };
        let life = PluginRecord::new(identity, plugin, rule.model_config_json(), rule.model_isolation);
        let record = Arc::new(VehicleRecord::new(
            id,
            name,
            system_id,
            rule.simulated,
            Arc::new(life),
            link,
        ));
        for payload in &rule.payloads {
            let payload = payload_record(&self.shared, &record, payload).map_err(|refusal| refusal.to_string())?;
            record.attach(Arc::new(payload));
        }
        Ok(record)
    }

    fn not_adopted(&mut self, trouble: UnadoptedVehicle) {
        let text = format!(
            "system id {} on {} is not flown: {}",
            trouble.system_id, trouble.endpoint, trouble.why
        );
        self.shared
            .events
            .record(self.shared.now(), None, Severity::Warning, EventKind::NotAdopted, text);
        self.shared.vehicles.note_unadopted(trouble);
    }

    /// Starts the next incarnation of a vehicle's actor. Its `pre_start` only takes what lies ready, so that nothing is waited for.
    async fn start(&mut self, myself: &ActorRef<FleetMessage>, record: Arc<VehicleRecord>) {
        let id = record.id;
        let supervised = self.supervised.entry(id).or_default();
        supervised.incarnation = supervised.incarnation.next();
        let arguments = VehicleArguments {
            shared: self.shared.clone(),
            record,
            incarnation: supervised.incarnation,
        };
        match VehicleActor::spawn_linked(None, VehicleActor, arguments, myself.get_cell()).await {
            Ok((actor, _)) => {
                self.children.insert(actor.get_id(), Child::Vehicle(id));
            }
            Err(error) => self.ended(myself, id, &error.to_string()).await,
        }
    }

    async fn ended(&mut self, myself: &ActorRef<FleetMessage>, id: VehicleId, error: &str) {
        let (record, now) = (self.shared.vehicles.record(id), self.shared.now());
        let Some(record) = record else { return };
        record.actor.end();
        let supervised = self.supervised.entry(id).or_default();
        let decision = supervised
            .history
            .decide(&VEHICLE_LIMITS, now, (now.0 % 1_000) as f64 / 1_000.0);
        let status = match decision {
            Decision::RestartAfter(_) => ActorStatus::Restarting,
            Decision::GiveUp => ActorStatus::GivenUp,
        };
        {
            let mut published = record.change_state();
            published.actor.status = status;
            published.actor.last_error = error.to_owned();
            published.actor.since = now;
        }
        let kind = EventKind::Supervision {
            actor: format!("vehicle-{id}"),
            status,
        };
        match decision {
            Decision::RestartAfter(delay_s) => {
                let text = format!("{}: actor ended ({error}); restarting", record.name);
                self.shared.events.record(now, Some(id), Severity::Warning, kind, text);
                // Through the mailbox even without a delay, so that one crashing vehicle cannot keep the fleet in this loop.
                myself.send_after(Duration::from_secs_f64(delay_s), move || FleetMessage::Restart(id));
            }
            Decision::GiveUp => {
                let text = format!("{}: actor failed too often ({error}); its autopilot holds", record.name);
                self.shared.events.record(now, Some(id), Severity::Critical, kind, text);
                give_up(&self.shared, &record);
            }
        }
    }
}

/// Nobody steers the vehicle any more: its autopilot is told to hold by itself.
fn give_up(shared: &SharedState, record: &VehicleRecord) {
    let (now, peers) = (shared.now(), shared.peers());
    let flown = |e: &PeerEntry| e.telemetry.mode == FlightMode::Offboard && e.airborne;
    if peers.entry(record.id).is_some_and(flown) {
        record.link().request(
            now,
            RequestId(u32::MAX),
            AutopilotCommand::SetMode { mode: FlightMode::Hold },
        );
    }
    let mut published = record.change_state();
    published.flight_state = FlightState::Faulted;
    published.detail = "its actor failed too often; the autopilot holds".into();
    published.since = now;
}
