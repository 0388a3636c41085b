//! Message rates: asks for what is read here, turns off what is not, checks what really comes, and asks again after a
//! restart. One request at a time, spread over time.
//!
//! Also asks for single copies of what is sent once only: the autopilot's identity, the origin of its frame, its launch place.

use mavlink::dialects::common::MavCmd;
use skein_domain::NodeTime;
use skein_px4::MessageRates;
use skein_px4::plan::{Class, Command, Condition, Goal, Plan, PlanStep};

/// Length of the window over which rates are measured, in seconds.
const WINDOW_S: f64 = 4.0;
/// A message that is not read is turned off when it came this often in a window.
const UNUSED_MIN: u32 = 2;
/// How often one message's rate is asked for at most, in one boot of the autopilot.
const ATTEMPTS_MAX: u8 = 4;
/// Different unread messages that are remembered.
const UNUSED_MAX: usize = 64;
/// The first requests of different vehicles are spread over this many steps of the spacing.
const STAGGER_STEPS: u32 = 20;
/// First pause before a copy is asked for again, in seconds; it doubles.
const COPY_PAUSE_S: f64 = 1.0;
/// How often a copy is asked for at most.
const COPY_ATTEMPTS_MAX: u8 = 6;

/// HEARTBEAT.
pub const HEARTBEAT: u32 = 0;
/// TIMESYNC; the autopilot's own requests are not used.
pub const TIMESYNC: u32 = 111;
/// GPS_GLOBAL_ORIGIN.
pub const GLOBAL_ORIGIN: u32 = 49;
/// AUTOPILOT_VERSION.
pub const AUTOPILOT_VERSION: u32 = 148;
/// ESTIMATOR_STATUS.
const ESTIMATOR_STATUS: u32 = 230;
/// GPS2_RAW.
const SECOND_GNSS: u32 = 124;
/// WIND_COV.
const WIND: u32 = 231;
/// Messages that a healthy autopilot may have nothing to say in: not every one has a second receiver or estimates the wind.
const MAY_BE_MISSING: [u32; 2] = [SECOND_GNSS, WIND];
/// HOME_POSITION.
pub const HOME: u32 = 242;

/// Messages that come as answers or on events, and so have no rate: text, acknowledgements, parameters, missions, files,
/// commands to others, events, and what is heard of others' places.
const WITHOUT_RATE: [u32; 28] = [
    22, 39, 40, 42, 43, 44, 45, 46, 47, 49, 51, 73, 75, 76, 77, 110, 126, 144, 148, 246, 253, 323, 324, 345, 410, 411,
    412, 413,
];

#[derive(Debug)]
struct Wanted {
    id: u32,
    rate_hz: f64,
    in_window: u32,
    attempts: u8,
    /// To be asked for at the next opportunity.
    due: bool,
}

#[derive(Debug)]
struct Unused {
    id: u32,
    in_window: u32,
    attempts: u8,
    due: bool,
    /// It was turned off, and somebody wants it now.
    missed: bool,
}

#[derive(Debug)]
struct Copy {
    id: u32,
    at: NodeTime,
    attempts: u8,
    have: bool,
}

/// What to ask next.
#[derive(Debug, Clone, PartialEq)]
pub enum Tuning {
    /// A rate of this message.
    Rate(u32, Plan),
    /// One copy of this message.
    Copy(u32, Plan),
}

/// Keeps the message rates of one vehicle.
#[derive(Debug)]
pub struct RateKeeper {
    settings: MessageRates,
    wanted: [Wanted; 12],
    unused: Vec<Unused>,
    copies: [Copy; 3],
    next_request: NodeTime,
    window_started: NodeTime,
}

impl RateKeeper {
    /// Starts asking, a little later for each next system id so that a swarm does not ask at once.
    #[must_use]
    pub fn new(settings: MessageRates, system_id: u8, now: NodeTime) -> Self {
        let wanted = [
            (32, settings.local_position_hz),
            (33, settings.global_position_hz),
            (HEARTBEAT, settings.heartbeat_hz),
            (30, settings.attitude_hz),
            (245, settings.landed_state_hz),
            (1, settings.system_status_hz),
            (24, settings.gnss_hz),
            (147, settings.battery_hz),
            (ESTIMATOR_STATUS, settings.estimator_hz),
            (SECOND_GNSS, settings.gnss_hz),
            (WIND, settings.wind_hz),
            (HOME, settings.home_hz),
        ]
        .map(|(id, rate_hz)| Wanted {
            id,
            rate_hz,
            in_window: 0,
            attempts: 0,
            due: true,
        });
        let copies = [AUTOPILOT_VERSION, GLOBAL_ORIGIN, HOME].map(|id| Copy {
            id,
            at: now,
            attempts: 0,
            have: false,
        });
        let mut keeper = Self {
            settings,
            wanted,
            unused: Vec::new(),
            copies,
            next_request: now,
            window_started: now,
        };
        keeper.restart(system_id, now);
        keeper
    }

    /// Asks for everything anew: the autopilot restarted and has forgotten it.
    pub fn restart(&mut self, system_id: u8, now: NodeTime) {
        let step = u32::from(system_id) * 7 % STAGGER_STEPS;
        self.next_request = now.plus_seconds(f64::from(step) * self.settings.spacing_s);
        self.window_started = now;
        for wanted in &mut self.wanted {
            (wanted.in_window, wanted.attempts, wanted.due) = (0, 0, true);
        }
        self.unused.clear();
        for copy in &mut self.copies {
            (copy.at, copy.attempts, copy.have) = (now, 0, false);
        }
    }

    /// Notes that a message came.
    pub fn on_message(&mut self, id: u32) {
        match self.wanted.iter_mut().find(|wanted| wanted.id == id) {
            Some(wanted) => wanted.in_window += 1,
            None if id == TIMESYNC => {}
            None => self.on_unused(id),
        }
    }

    /// Notes that a message came that nobody reads, or that could not be read.
    pub fn on_unused(&mut self, id: u32) {
        if self.wanted.iter().any(|wanted| wanted.id == id) {
            return;
        }
        if let Some(unused) = self.unused.iter_mut().find(|unused| unused.id == id) {
            unused.in_window += 1;
        } else if self.unused.len() < UNUSED_MAX && !WITHOUT_RATE.contains(&id) {
            self.unused.push(Unused {
                id,
                in_window: 1,
                attempts: 0,
                due: false,
                missed: false,
            });
        }
    }

    /// Notes that a message came that is not read here, but that a payload wants: it stays on.
    pub fn on_wanted(&mut self, id: u32) {
        match self.wanted.iter_mut().find(|wanted| wanted.id == id) {
            Some(wanted) => wanted.in_window += 1,
            None => self.unused.retain(|unused| unused.id != id || unused.missed),
        }
    }

    /// Somebody wants more messages from now on: those among them that were turned off are asked for at their usual rate.
    pub fn want(&mut self, wants: impl Fn(u32) -> bool) {
        for unused in self.unused.iter_mut().filter(|unused| wants(unused.id)) {
            unused.missed = unused.attempts > 0;
            unused.due = false;
        }
    }

    /// Notes that a copy came, asked for or not.
    pub fn on_copy(&mut self, id: u32) {
        if let Some(copy) = self.copies.iter_mut().find(|copy| copy.id == id) {
            copy.have = true;
        }
    }

    /// Asks for a copy again although one came: it may be out of date.
    pub fn renew_copy(&mut self, id: u32, now: NodeTime) {
        if let Some(copy) = self.copies.iter_mut().find(|copy| copy.id == id) {
            (copy.at, copy.attempts, copy.have) = (now, 0, false);
        }
    }

    /// How a request about a rate ended.
    pub fn on_rate_ended(&mut self, id: u32, accepted: bool) {
        if accepted {
            return;
        }
        // Not granted: what comes decides whether it is worth another try.
        if let Some(wanted) = self.wanted.iter_mut().find(|wanted| wanted.id == id) {
            wanted.attempts = wanted
                .attempts
                .max(if id == HEARTBEAT { ATTEMPTS_MAX } else { wanted.attempts });
        }
    }

    /// When the next look is due.
    #[must_use]
    pub fn due(&self) -> NodeTime {
        let waiting =
            self.wanted.iter().any(|wanted| wanted.due) || self.unused.iter().any(|unused| unused.due || unused.missed);
        let window = self.window_started.plus_seconds(WINDOW_S);
        let copies = self
            .copies
            .iter()
            .filter(|copy| copy.is_open())
            .map(|copy| copy.at.max(self.next_request))
            .min();
        let next = if waiting { self.next_request.min(window) } else { window };
        copies.map_or(next, |copy| copy.min(next))
    }

    /// The next request, if one is due. Not to be called while one is under way.
    pub fn poll(&mut self, now: NodeTime) -> Option<Tuning> {
        if !self.settings.manage {
            return None;
        }
        if now.seconds_since(self.window_started) >= WINDOW_S {
            self.judge(now);
        }
        if now < self.next_request {
            return None;
        }
        let tuning = self.next(now)?;
        self.next_request = now.plus_seconds(self.settings.spacing_s);
        Some(tuning)
    }

    fn next(&mut self, now: NodeTime) -> Option<Tuning> {
        if let Some(wanted) = self.wanted.iter_mut().find(|wanted| wanted.due && wanted.attempts == 0) {
            return Some(wanted.ask());
        }
        if let Some(copy) = self.copies.iter_mut().find(|copy| copy.is_open() && copy.at <= now) {
            copy.attempts += 1;
            copy.at = now.plus_seconds(COPY_PAUSE_S * f64::from(1_u32 << copy.attempts.min(10)));
            return Some(Tuning::Copy(copy.id, request_copy(copy.id)));
        }
        if let Some(wanted) = self.wanted.iter_mut().find(|wanted| wanted.due) {
            return Some(wanted.ask());
        }
        if let Some(missed) = self.unused.iter().position(|unused| unused.missed) {
            let Unused { id, .. } = self.unused.swap_remove(missed);
            return Some(Tuning::Rate(id, set_default_interval(id)));
        }
        let unused = self.unused.iter_mut().find(|unused| unused.due)?;
        unused.due = false;
        unused.attempts += 1;
        Some(Tuning::Rate(unused.id, set_interval(unused.id, 0.0)))
    }

    /// Compares what came in the window with what was asked for.
    fn judge(&mut self, now: NodeTime) {
        let window_s = now.seconds_since(self.window_started);
        self.window_started = now;
        // A window of silence says nothing about rates.
        let silent = self.wanted.iter().all(|wanted| wanted.in_window == 0);
        for wanted in &mut self.wanted {
            let measured_hz = f64::from(wanted.in_window) / window_s;
            let expected = wanted.rate_hz * window_s;
            let due = expected >= 3.0 && !MAY_BE_MISSING.contains(&wanted.id);
            let wrong = measured_hz > wanted.rate_hz * 1.6 + 0.5 || (due && measured_hz < wanted.rate_hz * 0.5);
            if !silent && wrong && wanted.attempts > 0 && wanted.attempts < ATTEMPTS_MAX {
                wanted.due = true;
            }
            wanted.in_window = 0;
        }
        for unused in &mut self.unused {
            unused.due =
                self.settings.turn_off_unused && unused.in_window >= UNUSED_MIN && unused.attempts < ATTEMPTS_MAX;
            unused.in_window = 0;
        }
    }
}

impl Wanted {
    fn ask(&mut self) -> Tuning {
        self.due = false;
        self.attempts += 1;
        Tuning::Rate(self.id, set_interval(self.id, self.rate_hz))
    }
}

impl Copy {
    fn is_open(&self) -> bool {
        !self.have && self.attempts < COPY_ATTEMPTS_MAX
    }
}

fn service(name: &'static str, command: Command) -> Plan {
    let steps = vec![PlanStep {
        command,
        goal: Goal::Acknowledged,
    }];
    Plan {
        name,
        class: Class::Service,
        condition: Condition::None,
        steps,
    }
}

/// A message's rate; zero turns it off.
fn set_interval(id: u32, rate_hz: f64) -> Plan {
    // In microseconds; -1 is off.
    let interval_us = if rate_hz > 0.0 { (1e6 / rate_hz) as f32 } else { -1.0 };
    set_interval_us(id, interval_us)
}

/// The autopilot's own rate of a message.
fn set_default_interval(id: u32) -> Plan {
    set_interval_us(id, 0.0)
}

fn set_interval_us(id: u32, interval_us: f32) -> Plan {
    let parameters = [id as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0];
    service(
        "set_message_interval",
        Command::long(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, parameters),
    )
}

/// One copy of a message.
#[must_use]
pub fn request_copy(id: u32) -> Plan {
    let parameters = [id as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    service(
        "request_message",
        Command::long(MavCmd::MAV_CMD_REQUEST_MESSAGE, parameters),
    )
}

#[cfg(test)]
mod tests;
