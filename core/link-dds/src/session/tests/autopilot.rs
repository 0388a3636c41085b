//! As much of a PX4 as the tests need: it answers commands, keeps OFFBOARD only with a stream, and tells its state.

use super::{ORIGIN, hold};
use crate::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use crate::sample::{Ack, Attitude, Landed, LocalPosition, Place, Sample, Status, Timesync, Validity};
use crate::session::setpoint::Outgoing;
use crate::session::{VehicleSession, estimate};
use skein_domain::link::LinkEvent;
use skein_domain::{AutopilotCommand, LocalFrame, LocalPositionNed, NodeTime, Refusal, RequestId, VelocityNed};
use skein_px4::LinkSettings;

/// Where it is.
const POSITION_M: [f32; 3] = [1.5, -2.5, -0.25];

/// The PX4.
pub struct Autopilot {
    pub armed: bool,
    pub nav_state: u8,
    /// Its clock is this much ahead of the node's.
    pub ahead_s: f64,
    /// It stamps with its agent's clock, which is this much ahead of the node's, and tells of that.
    pub synchronised: bool,
    pub agent_s: f64,
    /// Where it is.
    pub place_m: [f32; 3],
    /// So many commands are lost on the way.
    pub deaf_to: u32,
    pub refuses: bool,
    pub silent: bool,
    /// It is in the air.
    pub flying: bool,
    /// It has a topic for that; 1.15 has none.
    pub tells_of_landing: bool,
    pub setpoint: Option<(OffboardControlMode, TrajectorySetpoint)>,
    pub setpoints_before_offboard: u32,
    pub heard: Vec<VehicleCommand>,
    pub answers: Vec<Ack>,
}

impl Default for Autopilot {
    fn default() -> Self {
        Self {
            armed: false,
            nav_state: 4,
            ahead_s: 100.0,
            synchronised: false,
            agent_s: 1.7e9,
            place_m: POSITION_M,
            deaf_to: 0,
            refuses: false,
            silent: false,
            flying: false,
            tells_of_landing: true,
            setpoint: None,
            setpoints_before_offboard: 0,
            heard: Vec::new(),
            answers: Vec::new(),
        }
    }
}

impl Autopilot {
    fn hear(&mut self, outgoing: Outgoing) {
        match outgoing {
            Outgoing::Setpoint(mode, setpoint) => {
                self.setpoints_before_offboard += u32::from(self.nav_state != estimate::OFFBOARD);
                self.setpoint = Some((mode, setpoint));
            }
            Outgoing::Command(_) if self.deaf_to > 0 => self.deaf_to -= 1,
            Outgoing::Command(command) => {
                let result = u8::from(self.refuses);
                self.answers.push(Ack {
                    command: command.command,
                    result,
                    target_system: command.source_system,
                    target_component: command.source_component,
                });
                if !self.refuses {
                    self.obey(&command);
                }
                self.heard.push(command);
            }
        }
    }

    fn obey(&mut self, command: &VehicleCommand) {
        match (command.command, command.param2 as u8, command.param3 as u8) {
            (400, ..) => self.armed = command.param1 == 1.0,
            (176, 6, _) if self.setpoint.is_some() => self.nav_state = estimate::OFFBOARD,
            (176, 4, 3) => self.nav_state = 4,
            (21, ..) => self.nav_state = 18,
            _ => {}
        }
    }

    /// How far it is ahead of the node by its stamps.
    fn stamps_ahead_s(&self) -> f64 {
        if self.synchronised { self.agent_s } else { self.ahead_s }
    }

    fn timesync(&self, stamp_us: u64) -> Sample {
        Sample::Timesync(Timesync {
            stamp_us,
            source: 2,
            offset_us: ((self.ahead_s - self.stamps_ahead_s()) * 1e6) as i64,
            round_trip_us: 900,
        })
    }

    fn samples(&mut self, now: NodeTime, tick: u32) -> Vec<Sample> {
        if self.silent {
            return Vec::new();
        }
        let stamp_us = now.plus_seconds(self.stamps_ahead_s() - 0.001).0;
        let measured_us = stamp_us - 5_000;
        let mut samples = vec![Sample::Local(LocalPosition {
            stamp_us,
            measured_us,
            valid: Validity {
                horizontal: true,
                vertical: true,
                velocity_horizontal: true,
                velocity_vertical: true,
            },
            position_m: self.place_m,
            velocity_m_s: [0.0; 3],
            origin_deg: Some([ORIGIN.latitude_deg, ORIGIN.longitude_deg]),
            origin_altitude_m: Some(ORIGIN.altitude_amsl_m as f32),
            accuracy_m: [0.4, 0.6],
            dead_reckoning: false,
        })];
        if tick.is_multiple_of(10) {
            let [north, east, down] = self.place_m.map(f64::from);
            let place = LocalFrame { origin: ORIGIN }.geodetic(&LocalPositionNed::new(north, east, down));
            let half = 0.5_f32;
            samples.extend([
                Sample::Attitude(Attitude {
                    stamp_us,
                    quaternion: [half.cos(), 0.0, 0.0, half.sin()],
                }),
                Sample::Global(Place {
                    stamp_us,
                    measured_us,
                    valid: true,
                    place,
                }),
                Sample::Status(Status {
                    stamp_us,
                    system_id: 7,
                    arming_state: 1 + u8::from(self.armed),
                    nav_state: self.nav_state,
                    failsafe: false,
                    ready_to_arm: true,
                    took_off: self.flying,
                }),
            ]);
            if self.tells_of_landing {
                samples.push(Sample::Landed(Landed {
                    stamp_us,
                    landed: !self.flying,
                }));
            }
        }
        samples.extend(tick.is_multiple_of(5).then(|| self.timesync(stamp_us)));
        samples.extend(self.answers.drain(..).map(Sample::Ack));
        samples
    }
}

/// Both, and the time.
pub struct Rig {
    pub now: NodeTime,
    pub session: VehicleSession,
    pub autopilot: Autopilot,
    pub events: Vec<LinkEvent>,
    pub feed_forward: Option<VelocityNed>,
    tick: u32,
}

impl Rig {
    pub fn new(autopilot: Autopilot) -> Self {
        let now = NodeTime::from_seconds(10.0);
        Self {
            now,
            session: VehicleSession::new(&LinkSettings::default(), 7, now),
            autopilot,
            events: Vec::new(),
            feed_forward: None,
            tick: 0,
        }
    }

    /// So much time passes in steps of 20 ms, with something done in each.
    pub fn run(&mut self, for_s: f64, mut each: impl FnMut(&mut Self)) {
        for _ in 0..(for_s * 50.0) as u32 {
            self.now = self.now.plus_seconds(0.02);
            self.tick += 1;
            each(self);
            self.exchange();
            for sample in self.autopilot.samples(self.now, self.tick) {
                self.session.on_sample(self.now, &sample);
            }
            self.session.on_tick(self.now);
            self.exchange();
        }
    }

    /// What was sent arrives.
    pub fn exchange(&mut self) {
        for outgoing in self.session.take_outgoing() {
            self.autopilot.hear(outgoing);
        }
        self.collect();
    }

    pub fn collect(&mut self) {
        self.events.extend(self.session.take_events());
    }

    /// A setpoint that is valid for a while.
    pub fn offer(&mut self) {
        let setpoint = hold(self);
        self.session.stream(self.now, setpoint, self.now.plus_seconds(0.3));
    }

    /// Into OFFBOARD, armed and in the air.
    pub fn fly(&mut self) {
        self.run(1.0, |_| {});
        self.session
            .request(self.now, RequestId(101), AutopilotCommand::EnterOffboard);
        self.run(2.0, Self::offer);
        self.session.request(self.now, RequestId(102), AutopilotCommand::Arm);
        self.run(1.0, Self::offer);
        self.autopilot.flying = true;
        self.run(0.5, Self::offer);
        assert_eq!((self.result(101), self.result(102)), (Some(Ok(())), Some(Ok(()))));
    }

    /// How a request ended.
    pub fn result(&self, number: u32) -> Option<Result<(), Refusal>> {
        self.events.iter().find_map(|event| match event {
            LinkEvent::Result { request, outcome } if *request == RequestId(number) => Some(outcome.clone()),
            _ => None,
        })
    }
}
