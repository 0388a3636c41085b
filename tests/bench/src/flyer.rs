//! A vehicle of the load generator: just enough of a PX4 that a program adopts it, takes it off and streams setpoints to it.
//! It does at once what it is told, and sends what it always sends, whatever rates it is asked for.
//!
//! Pure: time, messages in; messages out.

use mavlink::dialects::common::*;
use nalgebra::Vector3;
use skein_domain::{Geodetic, LocalFrame};

/// What it sends, and how often: 115 messages a second in all.
pub(crate) const STREAMS: [(Stream, f64); 8] = [
    (Stream::Attitude, 50.0),
    (Stream::LocalPosition, 50.0),
    (Stream::GlobalPosition, 10.0),
    (Stream::Heartbeat, 1.0),
    (Stream::SystemStatus, 1.0),
    (Stream::Battery, 1.0),
    (Stream::Gnss, 1.0),
    (Stream::ExtendedState, 1.0),
];

/// A message that is sent at a fixed rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    Attitude,
    LocalPosition,
    GlobalPosition,
    Heartbeat,
    SystemStatus,
    Battery,
    Gnss,
    ExtendedState,
}

/// Main and sub mode as PX4 counts them.
type Mode = (u8, u8);
const TAKE_OFF: Mode = (4, 2);
const HOLD: Mode = (4, 3);
const LAND: Mode = (4, 6);
const OFFBOARD: Mode = (6, 0);
/// How fast it moves, and how hard it brakes before it is there.
const SPEED_M_S: f64 = 5.0;
const BRAKES_M_S2: f64 = 4.0;
/// Health bits of SYS_STATUS, the one for "would arm" among them.
const HEALTHY: u32 = 0x1320_FFFF;

/// One vehicle.
#[derive(Debug, Clone)]
pub(crate) struct Flyer {
    system_id: u8,
    frame: LocalFrame,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    target: Vector3<f64>,
    mode: Mode,
    armed: bool,
    moved_at_s: f64,
    misaddressed: u64,
}

/// Where something is sent back to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sender {
    pub system_id: u8,
    pub component_id: u8,
}

impl Flyer {
    /// One that stands at `place`.
    pub fn new(system_id: u8, place: Geodetic) -> Self {
        Self {
            system_id,
            frame: LocalFrame { origin: place },
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            target: Vector3::zeros(),
            mode: HOLD,
            armed: false,
            moved_at_s: 0.0,
            misaddressed: 0,
        }
    }

    /// How many messages came that were for another vehicle.
    pub fn misaddressed(&self) -> u64 {
        self.misaddressed
    }

    fn height_m(&self) -> f64 {
        -self.position.z
    }

    /// Moves on to this time.
    pub fn move_to(&mut self, now_s: f64) {
        let dt_s = now_s - self.moved_at_s;
        if dt_s <= 0.0 {
            return;
        }
        self.moved_at_s = now_s;
        let way = self.target - self.position;
        let speed_m_s = SPEED_M_S.min((2.0 * BRAKES_M_S2 * way.norm()).sqrt());
        let step_m = way.norm().min(speed_m_s * dt_s);
        let step = if self.armed && step_m > 0.0 {
            way.normalize() * step_m
        } else {
            Vector3::zeros()
        };
        self.position += step;
        self.velocity = step / dt_s;
        let arrived = (self.target - self.position).norm() < 1e-3;
        match self.mode {
            TAKE_OFF if self.armed && arrived => self.mode = HOLD,
            LAND if arrived => (self.armed, self.mode) = (false, HOLD),
            _ => {}
        }
    }

    /// A message of one of its streams.
    pub fn telemetry(&self, stream: Stream, now_s: f64) -> MavMessage {
        let time_boot_ms = (now_s * 1e3) as u32;
        let [x, y, z] = (self.position.cast::<f32>()).into();
        let [vx, vy, vz] = (self.velocity.cast::<f32>()).into();
        let place = self.frame.geodetic(&Vector3::into(self.position));
        let (lat, lon) = ((place.latitude_deg * 1e7) as i32, (place.longitude_deg * 1e7) as i32);
        let alt = (place.altitude_amsl_m * 1e3) as i32;
        match stream {
            Stream::Attitude => MavMessage::ATTITUDE(attitude(time_boot_ms)),
            Stream::LocalPosition => MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms,
                x,
                y,
                z,
                vx,
                vy,
                vz,
            }),
            Stream::GlobalPosition => MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                time_boot_ms,
                lat,
                lon,
                alt,
                relative_alt: (self.height_m() * 1e3) as i32,
                vx: (vx * 100.0) as i16,
                vy: (vy * 100.0) as i16,
                vz: (vz * 100.0) as i16,
                hdg: 1719,
            }),
            Stream::Heartbeat => MavMessage::HEARTBEAT(self.heartbeat()),
            Stream::SystemStatus => MavMessage::SYS_STATUS(self.system_status()),
            Stream::Battery => MavMessage::BATTERY_STATUS(battery()),
            Stream::Gnss => MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
                time_usec: (now_s * 1e6) as u64,
                lat,
                lon,
                alt,
                eph: 70,
                epv: 70,
                fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
                satellites_visible: 14,
                h_acc: 700,
                ..GPS_RAW_INT_DATA::default()
            }),
            Stream::ExtendedState => MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
                landed_state: self.landed_state(),
                ..EXTENDED_SYS_STATE_DATA::default()
            }),
        }
    }

    fn heartbeat(&self) -> HEARTBEAT_DATA {
        let (main, sub) = self.mode;
        let armed = if self.armed {
            MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED
        } else {
            MavModeFlag::empty()
        };
        HEARTBEAT_DATA {
            custom_mode: u32::from_le_bytes([0, 0, main, sub]),
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
            base_mode: MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed,
            system_status: if self.armed {
                MavState::MAV_STATE_ACTIVE
            } else {
                MavState::MAV_STATE_STANDBY
            },
            mavlink_version: 3,
        }
    }

    fn system_status(&self) -> SYS_STATUS_DATA {
        let sensors = MavSysStatusSensor::from_bits_retain(HEALTHY);
        SYS_STATUS_DATA {
            onboard_control_sensors_present: sensors,
            onboard_control_sensors_enabled: sensors,
            onboard_control_sensors_health: sensors,
            load: 300,
            voltage_battery: 16_000,
            current_battery: 1200,
            battery_remaining: 80,
            ..SYS_STATUS_DATA::default()
        }
    }

    fn landed_state(&self) -> MavLandedState {
        match self.mode {
            TAKE_OFF if self.armed => MavLandedState::MAV_LANDED_STATE_TAKEOFF,
            LAND => MavLandedState::MAV_LANDED_STATE_LANDING,
            _ if self.height_m() > 0.1 => MavLandedState::MAV_LANDED_STATE_IN_AIR,
            _ => MavLandedState::MAV_LANDED_STATE_ON_GROUND,
        }
    }

    /// Takes in a setpoint; false if it is for another vehicle.
    pub fn setpoint(&mut self, setpoint: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> bool {
        if setpoint.target_system != self.system_id {
            self.misaddressed += 1;
            return false;
        }
        let without = PositionTargetTypemask::POSITION_TARGET_TYPEMASK_X_IGNORE;
        if self.mode == OFFBOARD && !setpoint.type_mask.contains(without) {
            self.target = Vector3::new(setpoint.x, setpoint.y, setpoint.z).cast();
        }
        true
    }

    /// Takes in any other message; gives the answers.
    pub fn on_message(&mut self, message: &MavMessage, from: Sender, now_s: f64) -> Vec<MavMessage> {
        match message {
            MavMessage::COMMAND_LONG(c) => {
                if !self.is_for_me(c.target_system) {
                    return Vec::new();
                }
                self.command(c.command, [c.param1, c.param2, c.param3], c.param7, from)
            }
            MavMessage::COMMAND_INT(c) => {
                if !self.is_for_me(c.target_system) {
                    return Vec::new();
                }
                self.command(c.command, [c.param1, c.param2, c.param3], c.z, from)
            }
            MavMessage::TIMESYNC(t) if t.tc1 == 0 => {
                let answer = TIMESYNC_DATA {
                    tc1: (now_s * 1e9) as i64,
                    ts1: t.ts1,
                    ..TIMESYNC_DATA::default()
                };
                vec![MavMessage::TIMESYNC(answer)]
            }
            MavMessage::PARAM_REQUEST_READ(p) if self.is_for_me(p.target_system) => vec![parameter(p.param_id, 0.0)],
            MavMessage::PARAM_SET(p) if self.is_for_me(p.target_system) => vec![parameter(p.param_id, p.param_value)],
            _ => Vec::new(),
        }
    }

    fn is_for_me(&mut self, target_system: u8) -> bool {
        let mine = target_system == self.system_id || target_system == 0;
        self.misaddressed += u64::from(!mine);
        mine
    }

    fn command(&mut self, command: MavCmd, parameters: [f32; 3], z: f32, from: Sender) -> Vec<MavMessage> {
        let [first, second, third] = parameters;
        let mut answers = vec![MavMessage::COMMAND_ACK(COMMAND_ACK_DATA {
            command,
            result: MavResult::MAV_RESULT_ACCEPTED,
            target_system: from.system_id,
            target_component: from.component_id,
            ..COMMAND_ACK_DATA::default()
        })];
        match command {
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => {
                self.armed = first > 0.5;
                self.target = self.position;
            }
            MavCmd::MAV_CMD_DO_SET_MODE => {
                self.mode = (second as u8, third as u8);
                self.target = if self.mode == LAND {
                    Vector3::new(self.position.x, self.position.y, 0.0)
                } else {
                    self.position
                };
            }
            MavCmd::MAV_CMD_NAV_TAKEOFF => {
                self.mode = TAKE_OFF;
                let height_m = f64::from(z) - self.frame.origin.altitude_amsl_m;
                self.target = Vector3::new(
                    self.position.x,
                    self.position.y,
                    -if height_m > 0.0 { height_m } else { 2.5 },
                );
            }
            MavCmd::MAV_CMD_NAV_LAND => {
                self.mode = LAND;
                self.target = Vector3::new(self.position.x, self.position.y, 0.0);
            }
            MavCmd::MAV_CMD_REQUEST_MESSAGE => answers.extend(self.one_of(first as u32)),
            // Rates are what they are: this vehicle always sends the same.
            _ => {}
        }
        answers
    }

    /// One copy of a message that has no rate.
    fn one_of(&self, id: u32) -> Option<MavMessage> {
        let origin = &self.frame.origin;
        let (latitude, longitude) = ((origin.latitude_deg * 1e7) as i32, (origin.longitude_deg * 1e7) as i32);
        let altitude = (origin.altitude_amsl_m * 1e3) as i32;
        match id {
            49 => Some(MavMessage::GPS_GLOBAL_ORIGIN(GPS_GLOBAL_ORIGIN_DATA {
                latitude,
                longitude,
                altitude,
                ..GPS_GLOBAL_ORIGIN_DATA::default()
            })),
            148 => Some(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
                capabilities: MavProtocolCapability::from_bits_retain(59_647),
                flight_sw_version: 0x0112_0040,
                uid: u64::from(self.system_id) + 1,
                ..AUTOPILOT_VERSION_DATA::default()
            })),
            242 => Some(MavMessage::HOME_POSITION(HOME_POSITION_DATA {
                latitude,
                longitude,
                altitude,
                q: [1.0, 0.0, 0.0, 0.0],
                ..HOME_POSITION_DATA::default()
            })),
            _ => None,
        }
    }
}

fn attitude(time_boot_ms: u32) -> ATTITUDE_DATA {
    ATTITUDE_DATA {
        time_boot_ms,
        roll: 0.01,
        pitch: -0.02,
        yaw: 0.3,
        rollspeed: 0.001,
        pitchspeed: -0.002,
        yawspeed: 0.003,
    }
}

fn battery() -> BATTERY_STATUS_DATA {
    let mut voltages = [u16::MAX; 10];
    voltages[0] = 16_000;
    BATTERY_STATUS_DATA {
        voltages,
        current_battery: 1200,
        battery_remaining: 80,
        ..BATTERY_STATUS_DATA::default()
    }
}

fn parameter(param_id: mavlink::types::CharArray<16>, param_value: f32) -> MavMessage {
    MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
        param_value,
        param_count: 1,
        param_index: 0,
        param_id,
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
    })
}

#[cfg(test)]
mod tests;
