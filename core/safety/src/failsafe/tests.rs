//! A vehicle in simulated time that obeys, disobeys or is somebody else's, and its failsafe policy.

mod observed;
mod properties;
mod rules;
mod table;

use super::*;
use skein_domain::{FlightMode, FlightState, GnssFix};

/// Control periods per second.
const RATE_HZ: f64 = 50.0;
const PERIOD_S: f64 = 1.0 / RATE_HZ;
/// When a run begins: not at zero, which many things take for never.
const START_S: f64 = 1000.0;

/// A vehicle and its failsafe policy.
struct Rig {
    failsafe: FailsafePolicy,
    settings: FailsafeSettings,
    health: Health,
    now: NodeTime,
    events: Vec<FailsafeEvent>,
    /// After so long it does what was ordered; never, without.
    obeys_after_s: Option<f64>,
    ordered: Option<(Reaction, NodeTime)>,
}

/// A vehicle in formation with which all is well.
fn healthy(now: NodeTime) -> Health {
    Health {
        airborne: true,
        pilot_in_control: false,
        failsafe: false,
        simulated: false,
        mode: FlightMode::Offboard,
        state: FlightState::Following,
        lands: false,
        streaming: true,
        connected: true,
        last_heard: now,
        position_time: Some(now),
        holds_position: true,
        gnss: Some(GnssHealth {
            fix: GnssFix::ThreeD,
            satellites: 12,
            heard: now,
        }),
        disagreement_m: Some(0.4),
        tracking_error_m: Some(0.3),
        clock_offset_s: Some(-812.5),
        breach: None,
        coordinator_heard: Some(now),
        operator_heard: Some(now),
        energy: None,
        home_known: true,
    }
}

impl Rig {
    fn new() -> Self {
        let now = NodeTime::from_seconds(START_S);
        let mut rig = Self {
            failsafe: FailsafePolicy::new(),
            settings: FailsafeSettings::default(),
            health: healthy(now),
            now,
            events: Vec::new(),
            obeys_after_s: Some(0.4),
            ordered: None,
        };
        rig.settings.operator_dead_man.mode = TriggerMode::React;
        rig
    }

    /// Time since the start of the run.
    fn t(&self) -> f64 {
        self.now.seconds_since(NodeTime::from_seconds(START_S))
    }

    /// Flies on for some seconds. Everything is fresh each period before `fault` has its way, which gets the time since it began.
    fn run(&mut self, seconds: f64, mut fault: impl FnMut(&mut Health, f64)) {
        let periods = (seconds * RATE_HZ).round() as u32;
        for i in 1..=periods {
            self.now = self.now.plus_seconds(PERIOD_S);
            let kept = self.health.clone();
            self.health = Health {
                airborne: kept.airborne,
                pilot_in_control: kept.pilot_in_control,
                mode: kept.mode,
                state: kept.state,
                streaming: kept.streaming,
                ..healthy(self.now)
            };
            self.obey();
            fault(&mut self.health, f64::from(i) * PERIOD_S);
            let events = self.failsafe.step(self.now, &self.health, &self.settings);
            let orders: Vec<_> = events.iter().filter(|e| e.kind == FailsafeEventKind::Ordered).collect();
            assert!(orders.len() <= 1, "{orders:?}");
            if let Some(order) = orders.first() {
                self.ordered = Some((order.reaction, self.now));
            }
            self.events.extend(events);
        }
    }

    fn obey(&mut self) {
        let Some((reaction, at)) = self.ordered else { return };
        if self
            .obeys_after_s
            .is_none_or(|after_s| self.now.seconds_since(at) < after_s)
        {
            return;
        }
        match reaction {
            Reaction::Warn => {}
            Reaction::Hold => self.health.mode = FlightMode::Hold,
            // Its model flies it home, in OFFBOARD.
            Reaction::Return => {
                self.health.mode = FlightMode::Offboard;
                self.health.state = FlightState::Returning;
            }
            Reaction::Land => self.health.mode = FlightMode::Land,
            Reaction::Release => self.health.streaming = false,
        }
    }

    /// Events of a kind: reaction and time since the start of the run.
    fn of(&self, kind: FailsafeEventKind) -> Vec<(Reaction, f64)> {
        let start = NodeTime::from_seconds(START_S);
        self.events
            .iter()
            .filter(|e| e.kind == kind)
            .map(|e| (e.reaction, e.at.seconds_since(start)))
            .collect()
    }

    fn orders(&self) -> Vec<(Reaction, f64)> {
        self.of(FailsafeEventKind::Ordered)
    }

    fn order(&self) -> Option<Reaction> {
        self.failsafe.order().map(|o| o.reaction)
    }
}

/// The time that a fault which began `t_s` ago makes everything old by.
fn old(now: NodeTime, t_s: f64) -> NodeTime {
    now.plus_seconds(-t_s)
}

/// Positions that stopped coming when the fault began.
fn stale(health: &mut Health, t_s: f64) {
    health.position_time = health.position_time.map(|now| old(now, t_s));
}

/// A link that went silent when the fault began: declared lost after 1.5 s, and with it everything grows old.
fn silent(health: &mut Health, t_s: f64) {
    stale(health, t_s);
    health.last_heard = old(health.last_heard, t_s);
    health.connected = t_s < 1.5;
    if let Some(gnss) = &mut health.gnss {
        gnss.heard = health.last_heard;
    }
}

/// A receiver without a fix.
fn no_fix(health: &mut Health, _t_s: f64) {
    if let Some(gnss) = &mut health.gnss {
        gnss.fix = GnssFix::None;
    }
}
