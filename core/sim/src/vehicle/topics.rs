//! The autopilot's topics: which are published when, made from the vehicle's own beliefs; and what is taken from them.
//!
//! Must never do: publish what MAVLink would not send either. Rates and occasions are those of PX4 behind its agent.

use super::channel::Outbox;
use super::commander::Commander;
use super::{GLOBAL_KNOWN_S, ORIGIN_KNOWN_S, PendingCommand, SimVehicle, Source};
use crate::topics::{
    Asked, AskedCommand, AskedMode, AttitudeReport, BatteryReport, CommandAnswer, GlobalReport, GnssReport, HomeReport,
    LandedReport, LocalReport, Published, StatusReport, TimesyncReport,
};
use crate::vehicle::battery::BatteryLevel;
use crate::wire::CommandRequest;
use mavlink::dialects::common::MavResult;
use nalgebra::{UnitQuaternion, Vector3};
use skein_domain::FlightMode;

/// Without aid for longer than this the position is dead reckoning, in seconds.
const DEAD_RECKONING_S: f64 = 1.0;
/// Accuracy of the height in metres.
const VERTICAL_ACCURACY_M: f64 = 0.2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    Status,
    Local,
    Attitude,
    Global,
    Landed,
    Battery,
    Gnss,
    Home,
    Timesync,
}

/// Topic and how often it is published by itself, in hertz.
const RATES: [(Topic, f64); 8] = [
    (Topic::Status, 2.0),
    (Topic::Local, 50.0),
    (Topic::Attitude, 50.0),
    (Topic::Global, 50.0),
    (Topic::Landed, 1.0),
    (Topic::Battery, 1.0),
    (Topic::Gnss, 5.0),
    (Topic::Timesync, 1.0),
];

/// What is told at once when it changes: armed, mode, intention, failsafe, whether it would arm.
type ToldStatus = (bool, FlightMode, FlightMode, bool, bool);

/// When each topic is due, and what was last told.
#[derive(Debug, Clone)]
pub(super) struct Topics {
    due_us: [u64; RATES.len()],
    status: Option<ToldStatus>,
    landed: Option<bool>,
    home: Option<Vector3<f64>>,
    home_count: u32,
    armed_us: u64,
}

impl Topics {
    /// The vehicle's number spreads the vehicles' topics over time.
    pub(super) fn new(number: u64, now_us: u64) -> Self {
        let phase = (number as f64 * 0.618_034).fract();
        let due_us = std::array::from_fn(|i| {
            let period_us = RATES.get(i).map_or(0.0, |(_, rate_hz)| 1e6 / rate_hz);
            let share = (phase + i as f64 * 0.414_214).fract();
            now_us + (share * period_us.min(1e6)) as u64
        });
        Self {
            due_us,
            status: None,
            landed: None,
            home: None,
            home_count: 0,
            armed_us: 0,
        }
    }

    fn has_changed(&mut self, topic: Topic, vehicle: &SimVehicle) -> bool {
        match topic {
            Topic::Status => self.status != Some(told(&vehicle.commander)),
            Topic::Landed => self.landed != Some(vehicle.lift.is_landed()),
            Topic::Home => vehicle.home.is_some() && self.home != vehicle.home,
            _ => false,
        }
    }
}

fn told(commander: &Commander) -> ToldStatus {
    (
        commander.is_armed(),
        commander.mode(),
        commander.intention(),
        commander.in_failsafe(),
        commander.would_arm(),
    )
}

impl SimVehicle {
    /// Publishes what is due.
    pub(super) fn publish_topics(&mut self, out: &mut Outbox) {
        // Taken out while the rest of the vehicle is read.
        let Some(mut topics) = self.topics.take() else { return };
        let now_us = self.time_us();
        for (i, (topic, rate_hz)) in RATES.into_iter().enumerate() {
            let Some(due_us) = topics.due_us.get_mut(i) else {
                continue;
            };
            let due = now_us >= *due_us;
            if due {
                let period_us = (1e6 / rate_hz) as u64;
                *due_us += period_us;
                if *due_us <= now_us {
                    // Fell behind by more than one: do not make up for it.
                    *due_us = now_us + period_us;
                }
            }
            if due || topics.has_changed(topic, self) {
                out.published.extend(self.report_of(topic, &mut topics));
            }
        }
        if topics.has_changed(Topic::Home, self) {
            out.published.extend(self.report_of(Topic::Home, &mut topics));
        }
        self.topics = Some(topics);
    }

    fn report_of(&self, topic: Topic, topics: &mut Topics) -> Option<Published> {
        let up_s = self.up_time_s();
        Some(match topic {
            Topic::Local | Topic::Global if self.faults.estimate_stopped => return None,
            Topic::Status => Published::Status(self.status_report(topics)),
            Topic::Local if up_s >= ORIGIN_KNOWN_S => Published::Local(self.local_report()),
            Topic::Global if up_s >= GLOBAL_KNOWN_S => Published::Global(self.global_report()),
            Topic::Local | Topic::Global => return None,
            Topic::Attitude => Published::Attitude(AttitudeReport {
                stamp_us: self.up_us(),
                turned: self.turned(),
            }),
            Topic::Landed => {
                let landed = self.lift.is_landed();
                topics.landed = Some(landed);
                let stamp_us = self.up_us();
                Published::Landed(LandedReport { stamp_us, landed })
            }
            Topic::Battery => Published::Battery(self.battery_report()),
            Topic::Gnss => Published::Gnss(self.gnss_report()),
            Topic::Home => Published::Home(self.home_report(topics)?),
            Topic::Timesync => Published::Timesync(TimesyncReport {
                stamp_us: self.up_us(),
                offset_us: self.utc_us().saturating_sub_unsigned(self.up_us()).saturating_neg(),
            }),
        })
    }

    pub(super) fn utc_us(&self) -> i64 {
        i64::try_from(self.identity.utc_at_zero_us + self.time_us()).unwrap_or(i64::MAX)
    }

    fn status_report(&self, topics: &mut Topics) -> StatusReport {
        let was_armed = topics.status.is_some_and(|(armed, ..)| armed);
        let now = told(&self.commander);
        topics.status = Some(now);
        let (armed, mode, intention, failsafe, checks_pass) = now;
        topics.armed_us = match (was_armed, armed) {
            (_, false) => 0,
            (false, true) => self.up_us(),
            (true, true) => topics.armed_us,
        };
        StatusReport {
            stamp_us: self.up_us(),
            system_id: self.identity.system_id,
            armed,
            armed_us: topics.armed_us,
            mode,
            intention,
            failsafe,
            checks_pass,
        }
    }

    fn turned(&self) -> UnitQuaternion<f64> {
        let (roll, pitch) = self.body.roll_pitch_rad();
        UnitQuaternion::from_euler_angles(roll, pitch, self.body.yaw_rad)
    }

    fn is_dead_reckoning(&self) -> bool {
        self.estimator.satellites.unaided_s() > DEAD_RECKONING_S
    }

    fn local_report(&self) -> LocalReport {
        let now = &self.estimator.now;
        let ready = self.commander.is_estimator_ready();
        LocalReport {
            stamp_us: self.up_us(),
            horizontal_valid: ready && self.estimator.satellites.is_valid(),
            vertical_valid: ready,
            position_m: now.position,
            velocity_m_s: now.velocity,
            acceleration_m_s2: now.acceleration,
            yaw_rad: now.yaw_rad,
            origin: (self.up_time_s() >= GLOBAL_KNOWN_S).then(|| self.own_frame().origin),
            origin_us: (GLOBAL_KNOWN_S * 1e6) as u64,
            height_m: now.height_m,
            accuracy_horizontal_m: self.horizontal_accuracy_m(),
            accuracy_vertical_m: VERTICAL_ACCURACY_M,
            dead_reckoning: self.is_dead_reckoning(),
        }
    }

    fn global_report(&self) -> GlobalReport {
        GlobalReport {
            stamp_us: self.up_us(),
            horizontal_valid: self.commander.is_estimator_ready() && self.estimator.satellites.is_valid(),
            place: self.geodetic_of(&self.estimator.now.position),
            accuracy_horizontal_m: self.horizontal_accuracy_m(),
            accuracy_vertical_m: VERTICAL_ACCURACY_M,
            dead_reckoning: self.is_dead_reckoning(),
        }
    }

    fn battery_report(&self) -> BatteryReport {
        BatteryReport {
            stamp_us: self.up_us(),
            voltage_v: self.battery.voltage_v(),
            current_a: self.battery.current_a(self.commander.is_armed()),
            consumed_mah: self.battery.consumed_mah(),
            charge: self.battery.charge(),
            remaining_s: self.battery.remaining_s(),
            warning: match self.battery.level() {
                BatteryLevel::Good => 0,
                BatteryLevel::Low => 1,
                BatteryLevel::Critical => 2,
                BatteryLevel::Emergency => 3,
            },
        }
    }

    fn home_report(&self, topics: &mut Topics) -> Option<HomeReport> {
        let home = self.home?;
        if topics.home.replace(home) != Some(home) {
            topics.home_count += 1;
        }
        Some(HomeReport {
            stamp_us: self.up_us(),
            place: self.geodetic_of(&home),
            position_m: home,
            count: topics.home_count,
        })
    }

    /// What the first receiver that has a fix tells.
    fn gnss_report(&self) -> GnssReport {
        let satellites = &self.estimator.satellites;
        let first = satellites.first();
        let heard = [Some(first), satellites.second()];
        let heard = heard.into_iter().flatten().find(|receiver| self.hears(receiver));
        let (place, velocity_m_s) = self.place_told(&heard.unwrap_or(first));
        let accuracy_m = if heard.is_some() { 0.7 } else { 100.0 };
        GnssReport {
            stamp_us: self.up_us(),
            fixed: heard.is_some(),
            satellites: if heard.is_some() {
                super::navigation::SATELLITES
            } else {
                0
            },
            place,
            velocity_m_s,
            accuracy_horizontal_m: accuracy_m,
            accuracy_vertical_m: accuracy_m,
            utc_us: self.utc_us().unsigned_abs(),
        }
    }

    /// Takes something that came as a topic; what is answered at once is added to `out`.
    pub fn receive_topic(&mut self, asked: &Asked, out: &mut Outbox) {
        if self.faults.silent || self.faults.topics_cut || self.topics.is_none() {
            return;
        }
        match asked {
            Asked::Command(command) => self.take_command(command, out),
            Asked::Mode(mode) => {
                let at_s = self.time_of(mode);
                self.offboard.keep_alive(mode.follows, at_s);
            }
            // Dropped ones are counted there; nobody is told.
            Asked::Setpoint(setpoint) => {
                let _ = self.offboard.topic(setpoint, self.time_s, self.stalled_s);
            }
        }
    }

    /// When it was stamped, in seconds of the simulation: as PX4 has it, never later than now.
    fn time_of(&self, mode: &AskedMode) -> f64 {
        if mode.stamp_us == 0 {
            return self.time_s;
        }
        let age_s = self.clock_s() - mode.stamp_us as f64 * 1e-6;
        self.time_s - age_s.max(0.0)
    }

    fn take_command(&mut self, c: &AskedCommand, out: &mut Outbox) {
        if !self.is_for_me(c.to_system, c.to_component) {
            return;
        }
        let source = Source::Topics {
            system: c.from_system,
            component: c.from_component,
        };
        let Ok(command) = u16::try_from(c.command) else {
            self.answer_topic(c.command, MavResult::MAV_RESULT_UNSUPPORTED, source, out);
            return;
        };
        let [x, y, z] = c.place;
        let request = CommandRequest {
            command,
            target_system: c.to_system,
            target_component: c.to_component,
            param: c.param,
            x,
            y,
            z,
        };
        let due_s = self.draw_due_s();
        self.pending.push_back(PendingCommand { due_s, source, request });
    }

    pub(super) fn answer_topic(&self, command: u32, result: MavResult, to: Source, out: &mut Outbox) {
        let Source::Topics { system, component } = to else {
            return;
        };
        out.published.push(Published::CommandAnswer(CommandAnswer {
            stamp_us: self.up_us(),
            command,
            result: result as u8,
            to_system: system,
            to_component: component,
        }));
    }
}
