//! Commands: what each does, and how it is acknowledged.

use super::channel::{AUTOPILOT_COMPONENT, LinkKind, Outbox, Stream};
use super::commander::Asker;
use super::payloads::{GIMBAL_CONFIGURE, GIMBAL_PITCHYAW};
use super::receive::asked_mode;
use super::{REBOOT_DELAY_S, SimVehicle, Source};
use crate::wire::CommandRequest;
use mavlink::dialects::common::{MESSAGE_INTERVAL_DATA, MavResult, MavSeverity};
use nalgebra::Vector3;
use skein_domain::{FlightMode, Geodetic};

const RETURN_TO_LAUNCH: u16 = 20;
const LAND: u16 = 21;
const TAKE_OFF: u16 = 22;
const DO_SET_MODE: u16 = 176;
const DO_CHANGE_SPEED: u16 = 178;
const DO_SET_HOME: u16 = 179;
const DO_REPOSITION: u16 = 192;
const REBOOT: u16 = 246;
const MISSION_START: u16 = 300;
const ARM_DISARM: u16 = 400;
const GET_MESSAGE_INTERVAL: u16 = 510;
pub(super) const SET_MESSAGE_INTERVAL: u16 = 511;
pub(super) const REQUEST_MESSAGE: u16 = 512;
const REQUEST_CAPABILITIES: u16 = 520;
/// Magic number that forces arming or disarming.
const FORCE: f32 = 21196.0;
/// AUTOPILOT_VERSION.
const AUTOPILOT_VERSION: u32 = 148;

use MavResult::{
    MAV_RESULT_ACCEPTED as ACCEPTED, MAV_RESULT_DENIED as DENIED, MAV_RESULT_FAILED as FAILED,
    MAV_RESULT_TEMPORARILY_REJECTED as REJECTED, MAV_RESULT_UNSUPPORTED as UNSUPPORTED,
};

impl SimVehicle {
    /// Carries out the commands whose time has come, and acknowledges them.
    pub(super) fn run_commands(&mut self, out: &mut Outbox) {
        while self.pending.front().is_some_and(|p| p.due_s <= self.time_s) {
            let Some(pending) = self.pending.pop_front() else {
                return;
            };
            let request = pending.request;
            let Source::Link(link, sender) = pending.source else {
                if let Some(result) = self.run_of_topic(&request) {
                    self.answer_topic(request.command.into(), result, pending.source, out);
                }
                continue;
            };
            let of_payload = self.run_for_payload(link, sender, &request, out);
            let answer = of_payload.or_else(|| {
                let result = self.run(link, &request, out)?;
                Some((AUTOPILOT_COMPONENT, result))
            });
            if let Some((component, result)) = answer {
                self.on_channel(link, |_, channel| {
                    channel.acknowledge(component, out, request.command, result as u8, sender)
                });
            }
        }
    }

    /// Carries out one command that came as a topic. What is about messages of a link is for the links alone: nobody answers.
    fn run_of_topic(&mut self, c: &CommandRequest) -> Option<MavResult> {
        let of_links = [
            SET_MESSAGE_INTERVAL,
            GET_MESSAGE_INTERVAL,
            REQUEST_MESSAGE,
            REQUEST_CAPABILITIES,
        ];
        (!of_links.contains(&c.command)).then(|| self.carry_out(c)).flatten()
    }

    /// Carries out one command; `None` where PX4 gives no acknowledgement.
    fn run(&mut self, link: LinkKind, c: &CommandRequest, out: &mut Outbox) -> Option<MavResult> {
        Some(match c.command {
            SET_MESSAGE_INTERVAL => self.set_interval(link, c),
            GET_MESSAGE_INTERVAL => self.tell_interval(link, c, out),
            REQUEST_MESSAGE => self.send_on_request(link, c.param[0] as u32, out),
            REQUEST_CAPABILITIES => self.send_on_request(link, AUTOPILOT_VERSION, out),
            _ => return self.carry_out(c),
        })
    }

    /// The same for what has nothing to do with a link.
    fn carry_out(&mut self, c: &CommandRequest) -> Option<MavResult> {
        Some(match c.command {
            ARM_DISARM => return self.arm_or_disarm(c),
            DO_SET_MODE => match asked_mode(&c.param) {
                Some(mode) => self.commander.request(mode, Asker::Link, self.time_s),
                None => UNSUPPORTED,
            },
            TAKE_OFF => self.take_off(c),
            LAND => self.commander.request(FlightMode::Land, Asker::Link, self.time_s),
            RETURN_TO_LAUNCH => self.commander.request(FlightMode::Return, Asker::Link, self.time_s),
            DO_REPOSITION => self.reposition(c),
            DO_CHANGE_SPEED => {
                let speed = f64::from(c.param[1]);
                if speed > 0.0 {
                    self.guidance.set_hold(Vector3::repeat(f64::NAN), f64::NAN, speed);
                }
                ACCEPTED
            }
            DO_SET_HOME => self.set_home(c),
            MISSION_START if self.mission.is_there() => {
                self.commander.request(FlightMode::Mission, Asker::Link, self.time_s)
            }
            MISSION_START => REJECTED,
            REBOOT => self.ask_reboot(c),
            // Left to a gimbal manager, and there is none.
            GIMBAL_PITCHYAW | GIMBAL_CONFIGURE => return None,
            _ => UNSUPPORTED,
        })
    }

    fn arm_or_disarm(&mut self, c: &CommandRequest) -> Option<MavResult> {
        let [wanted, force, ..] = c.param;
        let force = force == FORCE;
        if wanted == 1.0 {
            let result = self.commander.arm(self.time_s);
            if result == ACCEPTED && self.lift.is_landed() {
                // Home is where it is armed.
                self.home = Some(self.estimator.now.position);
            }
            Some(result)
        } else if wanted == 0.0 {
            Some(self.commander.disarm(self.lift.is_landed(), force, self.time_s))
        } else {
            let text = format!("Unsupported ARM_DISARM param: {wanted:.3}");
            self.commander.say(MavSeverity::MAV_SEVERITY_CRITICAL, text);
            None
        }
    }

    fn take_off(&mut self, c: &CommandRequest) -> MavResult {
        let now = self.estimator.now.position;
        let down_m = if c.z.is_finite() {
            let here = self.geodetic_of(&now).altitude_amsl_m;
            now.z - (c.z - here)
        } else {
            let height = self.limits.take_off_height_m;
            let text = format!("Using default takeoff altitude: {height:.1} m");
            self.commander.say(MavSeverity::MAV_SEVERITY_INFO, text);
            now.z - height
        };
        if down_m >= now.z {
            self.commander.say(
                MavSeverity::MAV_SEVERITY_CRITICAL,
                "Already higher than takeoff altitude",
            );
        }
        let result = self.commander.request(FlightMode::TakeOff, Asker::Link, self.time_s);
        if result == ACCEPTED {
            self.guidance.set_take_off(down_m);
            // Enter anew even from TAKEOFF: the height may be another one.
            self.mode_entered = FlightMode::Unknown;
        }
        result
    }

    fn reposition(&mut self, c: &CommandRequest) -> MavResult {
        let mut place = Vector3::repeat(f64::NAN);
        let here = self.geodetic_of(&self.estimator.now.position);
        let or = |value: f64, otherwise: f64| if value.is_finite() { value } else { otherwise };
        let goal = Geodetic {
            latitude_deg: or(c.x, here.latitude_deg),
            longitude_deg: or(c.y, here.longitude_deg),
            altitude_amsl_m: or(c.z, here.altitude_amsl_m),
        };
        if !goal.is_valid() {
            return DENIED;
        }
        let own = self.own_frame().position(&goal).vector();
        if c.x.is_finite() && c.y.is_finite() {
            place.x = own.x;
            place.y = own.y;
        }
        if c.z.is_finite() {
            place.z = own.z;
        }
        let result = self.commander.request(FlightMode::Hold, Asker::Link, self.time_s);
        if result == ACCEPTED {
            self.enter_mode();
            self.guidance
                .set_hold(place, f64::from(c.param[3]), f64::from(c.param[0]));
        }
        result
    }

    fn set_home(&mut self, c: &CommandRequest) -> MavResult {
        if c.param[0] == 1.0 {
            self.home = Some(self.estimator.now.position);
            return ACCEPTED;
        }
        let place = Geodetic {
            latitude_deg: c.x,
            longitude_deg: c.y,
            altitude_amsl_m: c.z,
        };
        if !place.is_valid() {
            return DENIED;
        }
        self.home = Some(self.own_frame().position(&place).vector());
        ACCEPTED
    }

    fn ask_reboot(&mut self, c: &CommandRequest) -> MavResult {
        if c.param[0] != 1.0 {
            return DENIED;
        }
        if self.commander.is_armed() {
            return REJECTED;
        }
        self.reboot_at_s = Some(self.time_s + REBOOT_DELAY_S);
        ACCEPTED
    }

    fn set_interval(&mut self, link: LinkKind, c: &CommandRequest) -> MavResult {
        let (id, interval_us, now_us) = (c.param[0] as u32, f64::from(c.param[1]), self.time_us());
        let mut known = false;
        self.on_channel(link, |_, channel| {
            known = channel.set_interval(Stream::of_autopilot(id), interval_us, now_us)
        });
        if known { ACCEPTED } else { FAILED }
    }

    fn tell_interval(&mut self, link: LinkKind, c: &CommandRequest, out: &mut Outbox) -> MavResult {
        let id = c.param[0] as u16;
        self.on_channel(link, |_, channel| {
            // Zero stands for a message it does not have.
            let interval_us = channel.interval_us(Stream::of_autopilot(u32::from(id))).unwrap_or(0);
            channel.send(
                out,
                &MESSAGE_INTERVAL_DATA {
                    interval_us,
                    message_id: id,
                },
            );
        });
        ACCEPTED
    }

    fn send_on_request(&mut self, link: LinkKind, id: u32, out: &mut Outbox) -> MavResult {
        let mut sent = false;
        self.on_channel(link, |vehicle, channel| {
            sent = vehicle.send_of(channel, Stream::of_autopilot(id), 0, out)
        });
        if sent { ACCEPTED } else { DENIED }
    }
}
