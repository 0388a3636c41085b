//! What comes in: which messages are obeyed, which are answered at once, and which wait their turn as commands.

use super::channel::{AUTOPILOT_COMPONENT, Channel, LinkKind, Outbox};
use super::commander::Notice;
use super::offboard::SetpointProblem;
use super::{PendingCommand, SimVehicle, Source, limits_from, mode};
use crate::wire::{self, CommandRequest, Incoming, Sender};
use mavlink::dialects::common::{
    MavMessage, MavParamType, MavSeverity, PARAM_SET_DATA, PARAM_VALUE_DATA, TIMESYNC_DATA,
};
use mavlink::types::CharArray;
use rand::RngExt;

/// MAV_TYPE_GCS.
const GROUND_STATION_TYPE: u8 = 6;
/// How long the autopilot takes for a command, in seconds: from, and so much longer at most.
const COMMAND_DELAY_S: f64 = 0.002;
const COMMAND_DELAY_SPREAD_S: f64 = 0.009;

impl SimVehicle {
    /// Takes a datagram that came on one of its links; what is answered at once is added to `out`.
    pub fn receive(&mut self, link: LinkKind, datagram: &[u8], out: &mut Outbox) {
        if self.faults.silent || self.faults.mavlink_cut {
            return;
        }
        wire::read_frames(datagram, |sender, message| self.take(link, sender, message, out));
    }

    fn take(&mut self, link: LinkKind, sender: Sender, message: Incoming, out: &mut Outbox) {
        match message {
            Incoming::Heartbeat { vehicle_type } => {
                let now_s = self.time_s;
                if vehicle_type == GROUND_STATION_TYPE {
                    self.on_channel(link, |_, channel| channel.heard_ground_station(now_s));
                }
            }
            Incoming::Command(request) => self.queue(link, sender, request),
            Incoming::Other(message) => self.take_other(link, sender, &message, out),
        }
    }

    /// Whether something is addressed to this autopilot.
    pub(super) fn is_for_me(&self, system: u8, component: u8) -> bool {
        matches!(system, 0) | (system == self.identity.system_id) && matches!(component, 0 | AUTOPILOT_COMPONENT)
    }

    fn queue(&mut self, link: LinkKind, sender: Sender, request: CommandRequest) {
        let of_payload = self.payloads.has(request.target_component) && self.is_for_me(request.target_system, 0);
        if !of_payload && !self.is_for_me(request.target_system, request.target_component) {
            return;
        }
        let due_s = self.draw_due_s();
        let source = Source::Link(link, sender);
        self.pending.push_back(PendingCommand { due_s, source, request });
    }

    /// When a command that has just come is carried out: one after the other, a later one never overtakes an earlier one.
    pub(super) fn draw_due_s(&mut self) -> f64 {
        let delay_s = COMMAND_DELAY_S + self.rng.random_range(0.0..COMMAND_DELAY_SPREAD_S);
        let last_s = self.pending.back().map_or(0.0, |p| p.due_s);
        last_s.max(self.time_s + delay_s)
    }

    fn take_other(&mut self, link: LinkKind, sender: Sender, message: &MavMessage, out: &mut Outbox) {
        match message {
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(m) if self.is_for_me(m.target_system, m.target_component) => {
                let taken = self
                    .offboard
                    .local(m, self.estimator.now.yaw_rad, self.time_s, self.stalled_s);
                self.tell_setpoint_problem("SET_POSITION_TARGET_LOCAL_NED", taken);
            }
            MavMessage::SET_POSITION_TARGET_GLOBAL_INT(m) if self.is_for_me(m.target_system, m.target_component) => {
                let (frame, home) = (self.own_frame(), self.home_or_here());
                let taken = self.offboard.global(m, &frame, &home, self.time_s, self.stalled_s);
                self.tell_setpoint_problem("SET_POSITION_TARGET_GLOBAL_INT", taken);
            }
            MavMessage::TIMESYNC(m) if m.tc1 == 0 => {
                let tc1 = (self.clock_s() * 1e9) as i64;
                let answer = TIMESYNC_DATA {
                    tc1,
                    ts1: m.ts1,
                    ..TIMESYNC_DATA::default()
                };
                self.on_channel(link, |_, channel| channel.send(out, &answer));
            }
            // GIMBAL_MANAGER_SET_PITCHYAW is not among them: PX4 does not know it.
            MavMessage::GIMBAL_MANAGER_SET_ATTITUDE(_) | MavMessage::GIMBAL_MANAGER_SET_MANUAL_CONTROL(_) => {
                self.take_gimbal_message(sender, message)
            }
            _ => self.take_protocol(link, sender, message, out),
        }
    }

    fn tell_setpoint_problem(&mut self, message: &str, taken: Result<(), SetpointProblem>) {
        if let Err(SetpointProblem::Frame(frame)) = taken {
            let text = format!("{message} coordinate frame {frame} unsupported");
            self.notices.push(Notice {
                severity: MavSeverity::MAV_SEVERITY_CRITICAL,
                text,
            });
        }
    }

    /// Parameters, logs and missions.
    fn take_protocol(&mut self, link: LinkKind, sender: Sender, message: &MavMessage, out: &mut Outbox) {
        match message {
            MavMessage::PARAM_REQUEST_LIST(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.on_channel(link, |_, channel| channel.list_next = Some(0));
            }
            MavMessage::PARAM_REQUEST_READ(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.answer_parameter(link, m.param_index, m.param_id.to_str().unwrap_or_default(), out);
            }
            MavMessage::PARAM_SET(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.set_parameter(link, m, out);
            }
            MavMessage::LOG_REQUEST_LIST(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.on_channel(link, |vehicle, channel| vehicle.list_logs(channel, out));
            }
            MavMessage::LOG_REQUEST_DATA(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.on_channel(link, |_, channel| Self::begin_log(channel, m));
            }
            MavMessage::LOG_REQUEST_END(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.on_channel(link, |_, channel| channel.log = super::logs::Sending::default());
            }
            _ => self.take_mission_message(link, sender, message, out),
        }
    }

    fn answer_parameter(&mut self, link: LinkKind, index: i16, name: &str, out: &mut Outbox) {
        if index < 0 && name == "_HASH_CHECK" {
            let answer = PARAM_VALUE_DATA {
                param_value: f32::from_bits(self.parameters.hash()),
                param_count: self.parameters.count() as u16,
                param_index: u16::MAX,
                param_id: CharArray::from(name),
                param_type: MavParamType::MAV_PARAM_TYPE_UINT32,
            };
            self.on_channel(link, |_, channel| channel.send(out, &answer));
            return;
        }
        let found = match usize::try_from(index) {
            Ok(index) => Some(index).filter(|i| *i < self.parameters.count()),
            Err(_) => self.parameters.index(name),
        };
        match found {
            Some(index) => self.on_channel(link, |vehicle, channel| vehicle.send_parameter(channel, index, out)),
            None => {
                let text = format!("unknown param ID: {name}");
                self.notices.push(Notice {
                    severity: MavSeverity::MAV_SEVERITY_WARNING,
                    text,
                });
            }
        }
    }

    fn set_parameter(&mut self, link: LinkKind, m: &PARAM_SET_DATA, out: &mut Outbox) {
        let name = m.param_id.to_str().unwrap_or_default();
        let Some(index) = self.parameters.index(name) else {
            let text = format!("unknown param ID: {name}");
            self.notices.push(Notice {
                severity: MavSeverity::MAV_SEVERITY_WARNING,
                text,
            });
            return;
        };
        let Some(old) = self.parameters.at(index).map(|p| p.value) else {
            return;
        };
        let real = m.param_type == MavParamType::MAV_PARAM_TYPE_REAL32;
        if real != matches!(old, super::ParameterValue::Real(_)) {
            // PX4 says nothing to a value of the wrong type.
            return;
        }
        self.parameters.set(index, old.with_wire(m.param_value));
        self.limits = limits_from(&self.parameters);
        // Once in answer, once because a parameter changed; the other link learns of the change too.
        let mut channels = std::mem::take(&mut self.channels);
        for channel in &mut channels {
            self.send_parameter(channel, index, out);
            if channel.kind == link {
                self.send_parameter(channel, index, out);
            }
        }
        self.channels = channels;
    }

    /// Works with one link while the rest of the vehicle can be read.
    pub(super) fn on_channel(&mut self, link: LinkKind, work: impl FnOnce(&Self, &mut Channel)) {
        let mut channels = std::mem::take(&mut self.channels);
        if let Some(channel) = channels.iter_mut().find(|c| c.kind == link) {
            work(self, channel);
        }
        self.channels = channels;
    }
}

/// The mode that DO_SET_MODE's parameters ask for.
pub(super) fn asked_mode(param: &[f32; 4]) -> Option<skein_domain::FlightMode> {
    let [base, main, sub, _] = param;
    let custom = (*base as u8) & 1 == 1;
    if custom {
        mode::from_px4_numbers(*main as u8, *sub as u8)
    } else {
        None
    }
}
