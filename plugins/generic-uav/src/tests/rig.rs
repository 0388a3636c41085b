//! One vehicle on the bench: the model, the autopilot, and simulated time.

use super::autopilot::{Autopilot, PERIOD_S};
use crate::{GenericUav, Settings};
use skein_domain::exchange::{CommandProgress, Create, Effect, Event, EventBatch};
use skein_domain::{
    AnchorReference, AutopilotCommand, CommandId, FlightState, Incarnation, NodeTime, PositionNed, Refusal, Setpoint,
    Task, VehicleCommand, VehicleId, VehicleTask,
};
use skein_plugin_sdk::{Effects, UavModel};

/// The vehicle's id in all tests.
pub const VEHICLE: VehicleId = VehicleId(7);

/// The bench.
pub struct Rig {
    pub model: GenericUav,
    pub autopilot: Autopilot,
    pub now: NodeTime,
    /// Events for the next batch, after those of the autopilot and before the tick.
    pub inbox: Vec<Event>,
    /// The gate refuses every setpoint with this.
    pub gate: Option<Refusal>,
    /// Everything the model ever wanted.
    pub log: Vec<(NodeTime, Effect)>,
    /// Everything it was ever given.
    pub given: Vec<EventBatch>,
    pub state: FlightState,
    pub detail: String,
    next_command: u64,
    next_version: u64,
}

pub fn create(snapshot: Option<Vec<u8>>, incarnation: u32, now: NodeTime) -> GenericUav {
    create_with(Settings::default(), snapshot, incarnation, now)
}

pub fn create_with(settings: Settings, snapshot: Option<Vec<u8>>, incarnation: u32, now: NodeTime) -> GenericUav {
    let create = Create {
        vehicle: VEHICLE,
        incarnation: Incarnation(incarnation),
        config_json: "{}".to_owned(),
        snapshot,
        now,
        payload: None,
        system_id: None,
    };
    GenericUav::create(create, settings).expect("is created")
}

impl Rig {
    pub fn new(autopilot: Autopilot) -> Self {
        let now = NodeTime(1_000_000);
        Self {
            model: create(None, 1, now),
            autopilot,
            now,
            inbox: Vec::new(),
            gate: None,
            log: Vec::new(),
            given: Vec::new(),
            state: FlightState::Idle,
            detail: String::new(),
            next_command: 1,
            next_version: 1,
        }
    }

    /// On the ground, ready.
    pub fn idle() -> Self {
        let mut rig = Self::new(Autopilot::default());
        rig.tick();
        rig
    }

    /// Holding at a height after a take-off.
    pub fn holding(height_m: f64) -> Self {
        let mut rig = Self::idle();
        let id = rig.command(VehicleCommand::TakeOff { height_m });
        rig.run_until("taken off", 60.0, |rig| rig.is_done(id));
        rig.run(3.0);
        assert_eq!(rig.state, FlightState::Holding);
        rig
    }

    /// One control period; the effects of it.
    pub fn tick(&mut self) -> Vec<Effect> {
        self.now = self.now.plus_seconds(PERIOD_S);
        self.autopilot.step();
        let mut events = std::mem::take(&mut self.autopilot.events);
        events.push(Event::Own(self.autopilot.own_state(self.now)));
        events.append(&mut self.inbox);
        events.push(Event::Tick);
        self.hand_in(events)
    }

    /// Hands one batch in and carries the effects out.
    pub fn hand_in(&mut self, events: Vec<Event>) -> Vec<Effect> {
        let mut effects = Effects::default();
        self.model.handle(self.now, &events, &mut effects);
        self.given.push(EventBatch { now: self.now, events });
        let effects = effects.take();
        for effect in &effects {
            self.log.push((self.now, effect.clone()));
            match effect {
                Effect::Setpoint(setpoint) => match &self.gate {
                    None => self.autopilot.stream(*setpoint),
                    Some(refusal) => {
                        // As the node does: it holds the vehicle where it is.
                        let here = self.autopilot.position.into();
                        self.autopilot.stream(Setpoint::hold(here, None));
                        self.inbox.push(Event::Refused(refusal.clone()));
                    }
                },
                Effect::StopStream => self.autopilot.stop_stream(),
                Effect::Autopilot { request, command } => self.autopilot.request(*request, *command),
                Effect::State { state, detail } => (self.state, self.detail) = (*state, detail.clone()),
                _ => {}
            }
        }
        effects
    }

    pub fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / PERIOD_S).round() as u32 {
            self.tick();
        }
    }

    pub fn run_until(&mut self, what: &str, limit_s: f64, mut fulfilled: impl FnMut(&Self) -> bool) {
        for _ in 0..(limit_s / PERIOD_S) as u32 {
            if fulfilled(self) {
                return;
            }
            self.tick();
        }
        panic!(
            "not {what} within {limit_s} s: {} ({}), {:?}",
            self.state, self.detail, self.autopilot.mode
        );
    }

    /// Gives a command with the next batch.
    pub fn command(&mut self, command: VehicleCommand) -> CommandId {
        self.command_at(command, NodeTime(0))
    }

    pub fn command_at(&mut self, command: VehicleCommand, not_before: NodeTime) -> CommandId {
        let id = CommandId(self.next_command);
        self.next_command += 1;
        self.inbox.push(Event::Command {
            id,
            command,
            not_before,
        });
        id
    }

    /// Gives a task with the next batch.
    pub fn task(&mut self, task: Task) -> u64 {
        let version = self.next_version;
        self.next_version += 1;
        self.inbox.push(Event::Task(VehicleTask { version, task }));
        version
    }

    /// Hands the anchor in with the next batch.
    pub fn anchor(&mut self, anchor: AnchorReference) {
        self.inbox.push(Event::Anchor(anchor));
    }

    /// All that was said of a command.
    pub fn progress(&self, id: CommandId) -> Vec<CommandProgress> {
        let of = |effect: &Effect| match effect {
            Effect::CommandProgress { id: of, progress } if *of == id => Some(progress.clone()),
            _ => None,
        };
        self.log.iter().filter_map(|(_, effect)| of(effect)).collect()
    }

    pub fn is_done(&self, id: CommandId) -> bool {
        self.progress(id).contains(&CommandProgress::Done)
    }

    pub fn refusal(&self, id: CommandId) -> Option<Refusal> {
        self.progress(id).into_iter().find_map(|progress| match progress {
            CommandProgress::Refused { refusal } => Some(refusal),
            _ => None,
        })
    }

    pub fn requests(&self) -> &[AutopilotCommand] {
        &self.autopilot.requests
    }

    pub fn here(&self) -> PositionNed {
        self.autopilot.position.into()
    }

    /// The setpoints given, with their times.
    pub fn setpoints(&self) -> Vec<(NodeTime, Setpoint)> {
        setpoints_of(&self.log)
    }

    pub fn notices(&self) -> Vec<String> {
        let text = |effect: &Effect| match effect {
            Effect::Notice { text, .. } => Some(text.clone()),
            _ => None,
        };
        self.log.iter().filter_map(|(_, effect)| text(effect)).collect()
    }

    /// Fails if the setpoints jump: in place more than their velocity explains, or in velocity more than an acceleration explains.
    pub fn assert_no_jump_since(&self, since: NodeTime) {
        let setpoints: Vec<_> = self
            .setpoints()
            .into_iter()
            .filter(|(time, _)| *time >= since)
            .collect();
        assert!(setpoints.len() > 10, "only {} setpoints", setpoints.len());
        for pair in setpoints.windows(2) {
            let [(t0, s0), (t1, s1)] = pair else { continue };
            let dt = t1.seconds_since(*t0);
            let (p0, p1) = (s0.position.expect("has one"), s1.position.expect("has one"));
            let (v0, v1) = (
                s0.velocity.expect("has one").vector(),
                s1.velocity.expect("has one").vector(),
            );
            let unexplained_m = (p1.vector() - p0.vector() - (v0 + v1) / 2.0 * dt).norm();
            assert!(
                unexplained_m < 0.02,
                "jump of {unexplained_m:.3} m at {:.2} s: {s0:?} {s1:?}",
                t1.as_seconds()
            );
            let change = (v1 - v0).norm();
            assert!(
                change < 8.0 * dt.max(PERIOD_S),
                "velocity changes by {change:.2} m/s at {:.2} s",
                t1.as_seconds()
            );
            assert!(
                (dt - PERIOD_S).abs() < 1e-6,
                "no setpoint for {dt:.3} s at {:.2} s",
                t1.as_seconds()
            );
        }
    }
}

pub fn setpoints_of(log: &[(NodeTime, Effect)]) -> Vec<(NodeTime, Setpoint)> {
    let of = |(time, effect): &(NodeTime, Effect)| match effect {
        Effect::Setpoint(setpoint) => Some((*time, *setpoint)),
        _ => None,
    };
    log.iter().filter_map(of).collect()
}
