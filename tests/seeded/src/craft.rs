//! One vehicle: what flies, its autopilot's failsafe, its link in both directions, and the node's side of it: its UAV model, what the
//! node knows of it, and what the gate makes of its setpoints.

use crate::air_link::AirLink;
use crate::case::{Case, Fate, id_of};
use generic_uav::{GenericUav, Settings};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_config::LinkSettings;
use skein_coordination::steering;
use skein_domain::exchange::{Create, Effect, Event};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    CommandId, FlightMode, FlightState, Incarnation, Intent, LandedState, LinkHealth, NodeTime, PositionNed, Refusal,
    Setpoint, Task, Telemetry, VehicleCommand, VehicleId, VelocityNed,
};
use skein_plugin_sdk::{Effects, UavModel};
use skein_safety::Gate;
use skein_safety::avoidance::{Change, NeighbourId};
use skein_sim::vehicle::plant::Plant;
use skein_view::{PeerEntry, PeerSnapshot};

/// How long an autopilot flies its last setpoint without hearing another, in seconds: PX4's `COM_OF_LOSS_T`.
const FLIES_ON_S: f64 = 1.0;
/// Share of the wind that carries a drifting vehicle with it.
const DRIFT: f64 = 0.2;
/// Slower than this it stands, in metres per second.
const STANDS_M_S: f64 = 0.4;
/// Setpoints take so much less time than telemetry: they wait for nobody's turn.
const UPLINK_SHARE: f64 = 0.4;
/// A setpoint that is changed by less than this holds nobody back, in metres per second.
const HELD_BACK_M_S: f64 = 0.2;
/// Further delay of a message, drawn up to this, in seconds.
const JITTER_S: f64 = 0.02;

/// A vehicle that does not answer any more.
#[derive(Debug, Clone, Copy)]
pub struct Lost {
    fate: Fate,
    at_s: f64,
    stands: bool,
    place: Vector3<f64>,
    velocity: Vector3<f64>,
}

/// A vehicle that drifts unheard and unseen is nowhere, as far as anybody knows, when it has come so far from where it was, in metres:
/// a vehicle that falls silent is taken to have stopped (see `neighbours::vehicle`), and only a track would tell otherwise.
const KNOWN_WITHIN_M: f64 = 0.6;
/// For so long what was last heard of it tells where it goes, in seconds.
const CARRIED_ON_S: f64 = 3.0;

impl Lost {
    /// Whether a vehicle that is silent and here can be kept away from: unless something tracks it, nobody knows how far it drifts.
    fn is_known_at(&self, place: &Vector3<f64>, now_s: f64) -> bool {
        if self.fate != Fate::Drifts {
            return true;
        }
        let age_s = (now_s - self.at_s).min(CARRIED_ON_S);
        (self.place + self.velocity * age_s - place).norm() < KNOWN_WITHIN_M
    }
}

/// What a vehicle tells of itself.
#[derive(Debug, Clone, Copy)]
struct ToldKinematics {
    kinematics: VehicleKinematics,
    roll_pitch_rad: (f64, f64),
}

/// The vehicle.
pub struct Craft {
    pub id: VehicleId,
    pub plant: Plant,
    pub lost: Option<Lost>,
    /// What the node knows of it.
    pub entry: PeerEntry,
    /// What its model wants, and what was changed of it; as of the last period.
    pub change: Option<Change>,
    /// Who has held it back, a fence being nobody, and when last.
    pub held_back: Vec<(Option<NeighbourId>, f64)>,
    /// Why its last setpoint was refused, if it was.
    pub refusal: Option<Refusal>,
    pub route_finished: bool,
    pub calls: u64,
    pub changed: u64,
    pub infeasible: u64,
    /// Still climbing, as far as the node is told.
    pub climbing: bool,
    model: GenericUav,
    down: AirLink<ToldKinematics>,
    up: AirLink<Setpoint>,
    rng: ChaCha8Rng,
    waiting: Vec<Event>,
    task_version: u64,
    refused_at: Option<PositionNed>,
    streamed_until: NodeTime,
    told: Vec<String>,
}

impl Craft {
    pub fn new(case: &Case, index: usize, now: NodeTime) -> Self {
        let id = id_of(index);
        let seed = case.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index as u64);
        let plant = Plant::of(
            case.airframe,
            case.starts[index],
            case.yaws_rad[index],
            &case.noise,
            0.3 * case.wind.gust_m_s,
            seed,
        );
        let create = Create {
            vehicle: id,
            incarnation: Incarnation(1),
            config_json: "{}".into(),
            snapshot: None,
            now,
            payload: None,
            system_id: None,
        };
        let model = GenericUav::create(create, settings(case, index)).expect("its own settings are usable");
        let latency_s = case.latencies_s[index];
        let mut craft = Self {
            id,
            plant,
            lost: None,
            entry: first_entry(id, now),
            change: None,
            held_back: Vec::new(),
            refusal: None,
            route_finished: false,
            calls: 0,
            changed: 0,
            infeasible: 0,
            climbing: case.joins.iter().any(|(joining, _)| *joining == id),
            model,
            down: AirLink::new(latency_s, JITTER_S, case.loss),
            up: AirLink::new(UPLINK_SHARE * latency_s, 0.5 * JITTER_S, case.loss),
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x5eed),
            waiting: Vec::new(),
            task_version: 0,
            refused_at: None,
            streamed_until: now,
            told: Vec::new(),
        };
        // It has been heard before the flight begins.
        craft.entry.kinematics = Some(craft.believed(now));
        craft
    }

    pub fn answers(&self) -> bool {
        self.lost.is_none()
    }

    /// In the air at all.
    pub fn flies(&self) -> bool {
        !matches!(self.lost, Some(Lost { fate: Fate::Falls, .. }))
    }

    /// Whether the others can know where it is.
    pub fn is_known(&self, now_s: f64) -> bool {
        self.lost
            .is_none_or(|lost| lost.is_known_at(&self.plant.position(), now_s))
    }

    fn believed(&self, now: NodeTime) -> VehicleKinematics {
        let (position, velocity, yaw_rad) = self.plant.believed();
        VehicleKinematics {
            position: position.into(),
            velocity: velocity.into(),
            yaw_rad,
            measured: now,
        }
    }

    /// Its link is dead from now on.
    pub fn lose(&mut self, fate: Fate, now_s: f64) {
        self.down.cut();
        self.up.cut();
        let velocity: VelocityNed = match fate {
            Fate::FliesOn => self.plant.velocity().into(),
            Fate::Hovers | Fate::Drifts | Fate::Falls => VelocityNed::default(),
        };
        self.plant.obey(&only(velocity));
        self.lost = Some(Lost {
            fate,
            at_s: now_s,
            stands: false,
            place: self.plant.position(),
            velocity: self.plant.velocity(),
        });
    }

    /// The autopilot by itself, once per control period.
    pub fn failsafe(&mut self, now_s: f64, wind: &Vector3<f64>) {
        let Some(lost) = &mut self.lost else { return };
        match lost.fate {
            Fate::Drifts => self.plant.obey(&only((wind * DRIFT).into())),
            Fate::FliesOn if now_s < lost.at_s + FLIES_ON_S => {}
            Fate::Hovers | Fate::FliesOn if !lost.stands => {
                self.plant.obey(&only(VelocityNed::default()));
                if self.plant.velocity().norm() < STANDS_M_S {
                    lost.stands = true;
                    let (place, _, yaw_rad) = self.plant.believed();
                    self.plant.obey(&Setpoint::hold(place.into(), Some(yaw_rad)));
                }
            }
            Fate::Hovers | Fate::FliesOn | Fate::Falls => {}
        }
    }

    /// What is in the air between it and the node: setpoints that arrive, its state that is sent.
    pub fn exchange(&mut self, now_s: f64, now: NodeTime) {
        if let Some(setpoint) = self.up.receive(now_s).pop() {
            self.plant.obey(&setpoint);
        }
        let state = ToldKinematics {
            kinematics: self.believed(now),
            roll_pitch_rad: self.plant.roll_pitch_rad(),
        };
        self.down.send(now_s, state, &mut self.rng);
    }

    /// What the node hears of it.
    pub fn hear(&mut self, now_s: f64, now: NodeTime, link: &LinkSettings) {
        for state in self.down.receive(now_s) {
            self.entry.link.last_heard = now;
            if self
                .entry
                .kinematics
                .is_none_or(|known| state.kinematics.measured > known.measured)
            {
                self.entry.kinematics = Some(state.kinematics);
                self.entry.telemetry.position_time = state.kinematics.measured;
                let (roll_rad, pitch_rad) = state.roll_pitch_rad;
                (self.entry.telemetry.roll_rad, self.entry.telemetry.pitch_rad) = (roll_rad as f32, pitch_rad as f32);
            }
        }
        let connected = now.seconds_since(self.entry.link.last_heard) <= link.lost_after_s;
        if connected != self.entry.link.connected {
            self.entry.link.connected = connected;
            self.waiting.push(Event::LinkLost(!connected));
        }
        self.entry.link.setpoint_rate_hz = if now < self.streamed_until { 50.0 } else { 0.0 };
    }

    /// An operator's command.
    pub fn command(&mut self, command: VehicleCommand) {
        self.waiting.push(Event::Command {
            id: CommandId(1),
            command,
            not_before: NodeTime::default(),
        });
    }

    /// One control period of the node for it; what it tells.
    pub fn period(
        &mut self,
        now_s: f64,
        now: NodeTime,
        gate: &Gate,
        peers: &PeerSnapshot,
        intent: &Intent,
        link: &LinkSettings,
    ) -> Vec<String> {
        let Some(entry) = peers.entry(self.id) else {
            return Vec::new();
        };
        let mut events = std::mem::take(&mut self.waiting);
        events.push(Event::Own(steering::own_state(entry, None)));
        events.extend(steering::told(intent, peers, self.id, &mut self.task_version));
        let task = intent.tasks.get(&self.id).map(|task| &task.task);
        if matches!(task, Some(Task::Keep(_))) {
            events.push(Event::Peers(steering::others(peers, self.id)));
        }
        events.push(Event::Tick);
        let mut effects = Effects::default();
        self.model.handle(now, &events, &mut effects);
        for effect in effects.take() {
            match effect {
                Effect::Setpoint(wanted) => self.steer(&wanted, entry, gate, peers, (now_s, now), link),
                Effect::State { state, detail } => {
                    self.entry.flight_state = state;
                    if state != FlightState::Leading {
                        self.entry.anchor = None;
                    }
                    self.told.push(format!("{state} {detail}"));
                }
                Effect::Anchor(anchor) => self.entry.anchor = Some(anchor),
                Effect::RouteFinished => {
                    self.route_finished = true;
                    self.told.push("end of the route".into());
                }
                Effect::Notice { text, .. } => self.told.push(text),
                Effect::Limits(limits) => self.entry.limits = Some(limits),
                Effect::StopStream => self.streamed_until = now,
                _ => {}
            }
        }
        std::mem::take(&mut self.told)
    }

    /// What becomes of a setpoint that its model wants.
    fn steer(
        &mut self,
        wanted: &Setpoint,
        entry: &PeerEntry,
        gate: &Gate,
        peers: &PeerSnapshot,
        (now_s, now): (f64, NodeTime),
        link: &LinkSettings,
    ) {
        let outcome = if entry.link.connected {
            steering::steer(gate, entry, wanted, &peers.surroundings, now).outcome
        } else {
            Err(Refusal::LinkLost { vehicle: self.id })
        };
        self.calls += 1;
        match outcome {
            Ok(steered) => {
                self.refused_at = None;
                self.refusal = None;
                self.change = steered.change;
                if let Some(change) = &steered.change {
                    self.changed += 1;
                    if change.by_m_s > HELD_BACK_M_S {
                        self.held_back.retain(|(who, _)| *who != change.because);
                        self.held_back.push((change.because, now_s));
                    }
                    self.infeasible += u64::from(!change.feasible);
                }
                self.stream(&steered.setpoint, now_s, now, link);
            }
            Err(refusal) => {
                self.change = None;
                if steering::is_answered_by_holding(&refusal)
                    && let Some(own) = entry.kinematics
                {
                    let place = *self.refused_at.get_or_insert(own.position);
                    let hold = steering::hold(gate, entry, place, &peers.surroundings, now);
                    self.stream(&hold, now_s, now, link);
                }
                if self.refusal.as_ref().map(Refusal::code) != Some(refusal.code()) {
                    self.told.push(format!("refused: {refusal}"));
                }
                self.refusal = Some(refusal.clone());
                self.waiting.push(Event::Refused(refusal));
            }
        }
    }

    fn stream(&mut self, setpoint: &Setpoint, now_s: f64, now: NodeTime, link: &LinkSettings) {
        self.streamed_until = now.plus_seconds(link.setpoint_valid_s);
        // As the node hands it to its link.
        let handed_over = Setpoint {
            acceleration: setpoint.forward_acceleration(),
            ..*setpoint
        };
        self.up.send(now_s, handed_over, &mut self.rng);
    }

    /// What the others see of it: the same, but for one that is still climbing.
    pub fn published(&self) -> PeerEntry {
        let mut entry = self.entry;
        if self.climbing {
            entry.flight_state = FlightState::TakingOff;
        }
        entry
    }
}

/// What its model says of it.
fn settings(case: &Case, index: usize) -> Settings {
    let usual = Settings::default();
    case.abilities.get(index).map_or(usual, |able| Settings {
        max_speed_m_s: able.speed_m_s,
        cruise_speed_m_s: usual.cruise_speed_m_s.min(able.speed_m_s),
        climb_m_s: able.climb_m_s,
        descent_m_s: able.descent_m_s,
        acceleration_m_s2: able.acceleration_m_s2,
        ..usual
    })
}

/// A velocity and nothing else.
fn only(velocity: VelocityNed) -> Setpoint {
    Setpoint {
        velocity: Some(velocity),
        ..Setpoint::default()
    }
}

/// Armed, in the air and under the swarm's control.
fn first_entry(id: VehicleId, now: NodeTime) -> PeerEntry {
    PeerEntry {
        id,
        kinematics: None,
        airborne: true,
        telemetry: Telemetry {
            mode: FlightMode::Offboard,
            armed: true,
            landed: LandedState::InAir,
            ..Telemetry::default()
        },
        link: LinkHealth {
            connected: true,
            last_heard: now,
            ..LinkHealth::default()
        },
        flight_state: FlightState::Idle,
        anchor: None,
        home: None,
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    }
}
