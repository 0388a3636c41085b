//! What goes out: each message made from the vehicle's own beliefs, never from the truth.

use super::channel::{Channel, Outbox};
use super::commander::Notice;
use super::{GLOBAL_KNOWN_S, HOME_KNOWN_S, ORIGIN_KNOWN_S, SimVehicle, mode};
use crate::vehicle::battery::BatteryLevel;
use crate::vehicle::body::GRAVITY_M_S2;
use mavlink::dialects::common::*;
use mavlink::types::CharArray;
use nalgebra::{UnitQuaternion, Vector3};
use skein_domain::LandedState;

/// SYS_STATUS of a PX4 in simulation: sensors present, enabled, healthy while not ready; and the bit that says "would arm".
const SENSORS_PRESENT: u32 = 33_603_631;
const SENSORS_ENABLED: u32 = 33_669_167;
const SENSORS_HEALTH: u32 = 52_480_063;
const PREARM_CHECK: u32 = 0x1000_0000;
/// The bit of the satellite receiver.
const RECEIVER: u32 = 0x20;
/// 1.18 alpha, and a commit of that time.
const SOFTWARE_VERSION: u32 = 0x0112_0040;
const SOFTWARE_COMMIT: [u8; 8] = [0, 0, 0, 205, 55, 198, 89, 187];
const CAPABILITIES: u64 = 59_647;
/// "No value" in BATTERY_STATUS.
const NO_TEMPERATURE: i16 = i16::MAX;
const NO_VOLTAGE: u16 = u16::MAX;
/// Longest text of one STATUSTEXT.
const TEXT_CHUNK: usize = 50;

/// Degrees as the wire has them: times ten million.
pub(super) fn e7(degrees: f64) -> i32 {
    (degrees * 1e7).round() as i32
}

/// Metres as millimetres.
pub(super) fn mm(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}

/// Metres per second as centimetres per second.
fn cm(speed: f64) -> i16 {
    (speed * 1e2).round() as i16
}

/// An angle in radians as hundredths of a degree, 0..36000.
pub(super) fn centidegrees(angle_rad: f64) -> u16 {
    (angle_rad.to_degrees().rem_euclid(360.0) * 100.0).round() as u16 % 36_000
}

impl SimVehicle {
    /// Sends one message on a link; false if it is not one of this vehicle's, or not known yet.
    pub(super) fn send_message(&self, channel: &mut Channel, id: u32, out: &mut Outbox) -> bool {
        if !self.has_to_tell(id) {
            return false;
        }
        match id {
            0 => channel.send(out, &self.heartbeat()),
            1 => channel.send(out, &self.sys_status()),
            2 => channel.send(out, &self.system_time()),
            42 => channel.send(out, &self.mission_current()),
            111 => channel.send(
                out,
                &TIMESYNC_DATA {
                    ts1: (self.clock_s() * 1e9) as i64,
                    ..TIMESYNC_DATA::default()
                },
            ),
            124 => return self.send_second_gnss(channel, out),
            147 => channel.send(out, &self.battery_status()),
            148 => channel.send(out, &self.autopilot_version()),
            230 => channel.send(out, &self.estimator_status()),
            231 => channel.send(out, &self.wind_cov()),
            241 => channel.send(
                out,
                &VIBRATION_DATA {
                    time_usec: self.up_us(),
                    ..VIBRATION_DATA::default()
                },
            ),
            245 => channel.send(out, &self.extended_sys_state()),
            _ => return self.send_motion(channel, id, out),
        }
        true
    }

    fn send_motion(&self, channel: &mut Channel, id: u32, out: &mut Outbox) -> bool {
        let up_s = self.up_time_s();
        let known_after_s = match id {
            24 | 30 | 31 | 36 | 74 | 83 | 85 | 105 => 0.0,
            32 | 331 => ORIGIN_KNOWN_S,
            33 | 49 | 141 => GLOBAL_KNOWN_S,
            242 => HOME_KNOWN_S,
            _ => return false,
        };
        // The origin is told a little before the first global position.
        if up_s < known_after_s && !(id == 49 && up_s >= 1.0) {
            return false;
        }
        match id {
            24 => channel.send(out, &self.gps_raw_int()),
            30 => channel.send(out, &self.attitude()),
            31 => channel.send(out, &self.attitude_quaternion()),
            32 => channel.send(out, &self.local_position_ned()),
            33 => channel.send(out, &self.global_position_int()),
            36 => channel.send(out, &self.servo_output_raw()),
            49 => channel.send(out, &self.gps_global_origin()),
            74 => channel.send(out, &self.vfr_hud()),
            83 => channel.send(out, &self.attitude_target()),
            85 => channel.send(out, &self.position_target()),
            105 => channel.send(out, &self.highres_imu()),
            141 => channel.send(out, &self.altitude()),
            242 => channel.send(out, &self.home_position()),
            _ => channel.send(out, &self.odometry()),
        }
        true
    }

    pub(super) fn up_ms(&self) -> u32 {
        (self.clock_s() * 1e3) as u32
    }

    pub(super) fn up_us(&self) -> u64 {
        (self.clock_s() * 1e6) as u64
    }

    fn heartbeat(&self) -> HEARTBEAT_DATA {
        let mode = self.commander.mode();
        let mut flags = mode::base_mode_flags(mode);
        let armed = self.commander.is_armed();
        if armed {
            flags |= 128;
        }
        let status = if self.commander.in_failsafe() {
            MavState::MAV_STATE_CRITICAL
        } else if armed {
            MavState::MAV_STATE_ACTIVE
        } else if self.commander.would_arm() {
            MavState::MAV_STATE_STANDBY
        } else {
            MavState::MAV_STATE_UNINIT
        };
        HEARTBEAT_DATA {
            custom_mode: mode::custom_mode(mode),
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
            base_mode: MavModeFlag::from_bits_retain(flags),
            system_status: status,
            mavlink_version: 3,
        }
    }

    fn sys_status(&self) -> SYS_STATUS_DATA {
        let known = if self.up_time_s() > 1.5 { u32::MAX } else { 0 };
        let ready = if self.commander.would_arm() { PREARM_CHECK } else { 0 };
        let sensors = MavSysStatusSensor::from_bits_retain;
        let receiver = if self.estimator.satellites.first().lost {
            RECEIVER
        } else {
            0
        };
        SYS_STATUS_DATA {
            onboard_control_sensors_present: sensors(SENSORS_PRESENT & known),
            onboard_control_sensors_enabled: sensors(SENSORS_ENABLED & known),
            onboard_control_sensors_health: sensors(SENSORS_HEALTH & !receiver | ready),
            load: 160,
            voltage_battery: (self.battery.voltage_v() * 1e3) as u16,
            current_battery: (self.battery.current_a(self.commander.is_armed()) * 1e2) as i16,
            battery_remaining: (self.battery.charge() * 100.0).ceil() as i8,
            onboard_control_sensors_health_extended: MavSysStatusSensorExtended::from_bits_retain(1),
            ..SYS_STATUS_DATA::default()
        }
    }

    fn system_time(&self) -> SYSTEM_TIME_DATA {
        SYSTEM_TIME_DATA {
            time_unix_usec: self.identity.utc_at_zero_us + self.time_us(),
            time_boot_ms: self.up_ms(),
        }
    }

    fn battery_status(&self) -> BATTERY_STATUS_DATA {
        let mut voltages = [NO_VOLTAGE; 10];
        voltages[0] = (self.battery.voltage_v() * 1e3) as u16;
        BATTERY_STATUS_DATA {
            current_consumed: self.battery.consumed_mah() as i32,
            energy_consumed: -1,
            temperature: NO_TEMPERATURE,
            voltages,
            current_battery: (self.battery.current_a(self.commander.is_armed()) * 1e2) as i16,
            id: 0,
            battery_function: MavBatteryFunction::MAV_BATTERY_FUNCTION_ALL,
            mavtype: MavBatteryType::MAV_BATTERY_TYPE_LIPO,
            battery_remaining: (self.battery.charge() * 100.0).ceil() as i8,
            time_remaining: self.battery.remaining_s() as i32,
            charge_state: match self.battery.level() {
                BatteryLevel::Good => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_OK,
                BatteryLevel::Low => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_LOW,
                BatteryLevel::Critical => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_CRITICAL,
                BatteryLevel::Emergency => MavBatteryChargeState::MAV_BATTERY_CHARGE_STATE_EMERGENCY,
            },
            ..BATTERY_STATUS_DATA::default()
        }
    }

    fn autopilot_version(&self) -> AUTOPILOT_VERSION_DATA {
        let mut uid2 = [0; 18];
        uid2[0] = self.identity.system_id;
        AUTOPILOT_VERSION_DATA {
            capabilities: MavProtocolCapability::from_bits_retain(CAPABILITIES),
            uid: if self.settings.says_simulated {
                // PX4's `SIMULATIONID`, of which MAVLink tells these eight letters; each instance adds its system id less one.
                u64::from_le_bytes(*b"ONIDLATI") + u64::from(self.identity.system_id) - 1
            } else {
                0x534B_4549_4E00_0000 | u64::from(self.identity.system_id)
            },
            flight_sw_version: SOFTWARE_VERSION,
            middleware_sw_version: SOFTWARE_VERSION,
            os_sw_version: 0x0612_2CFF,
            board_version: 1,
            flight_custom_version: SOFTWARE_COMMIT,
            middleware_custom_version: SOFTWARE_COMMIT,
            uid2,
            ..AUTOPILOT_VERSION_DATA::default()
        }
    }

    fn extended_sys_state(&self) -> EXTENDED_SYS_STATE_DATA {
        EXTENDED_SYS_STATE_DATA {
            vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
            landed_state: match self.landed_state() {
                LandedState::OnGround => MavLandedState::MAV_LANDED_STATE_ON_GROUND,
                LandedState::TakingOff => MavLandedState::MAV_LANDED_STATE_TAKEOFF,
                LandedState::Landing => MavLandedState::MAV_LANDED_STATE_LANDING,
                LandedState::InAir => MavLandedState::MAV_LANDED_STATE_IN_AIR,
                LandedState::Unknown => MavLandedState::MAV_LANDED_STATE_UNDEFINED,
            },
        }
    }

    fn attitude(&self) -> ATTITUDE_DATA {
        let (roll, pitch) = self.body.roll_pitch_rad();
        let (rollspeed, pitchspeed) = self.body.roll_pitch_rates_rad_s();
        ATTITUDE_DATA {
            time_boot_ms: self.up_ms(),
            roll: roll as f32,
            pitch: pitch as f32,
            yaw: self.body.yaw_rad as f32,
            rollspeed: rollspeed as f32,
            pitchspeed: pitchspeed as f32,
            yawspeed: self.body.yaw_rate_rad_s as f32,
        }
    }

    fn quaternion(&self) -> [f32; 4] {
        let (roll, pitch) = self.body.roll_pitch_rad();
        let q = UnitQuaternion::from_euler_angles(roll, pitch, self.body.yaw_rad);
        wire_quaternion(&q)
    }

    fn attitude_quaternion(&self) -> ATTITUDE_QUATERNION_DATA {
        let [q1, q2, q3, q4] = self.quaternion();
        let a = self.attitude();
        ATTITUDE_QUATERNION_DATA {
            time_boot_ms: a.time_boot_ms,
            q1,
            q2,
            q3,
            q4,
            rollspeed: a.rollspeed,
            pitchspeed: a.pitchspeed,
            yawspeed: a.yawspeed,
            repr_offset_q: [1.0, 0.0, 0.0, 0.0],
        }
    }

    fn local_position_ned(&self) -> LOCAL_POSITION_NED_DATA {
        let now = &self.estimator.now;
        LOCAL_POSITION_NED_DATA {
            time_boot_ms: self.up_ms(),
            x: now.position.x as f32,
            y: now.position.y as f32,
            z: now.position.z as f32,
            vx: now.velocity.x as f32,
            vy: now.velocity.y as f32,
            vz: now.velocity.z as f32,
        }
    }

    pub(super) fn relative_altitude_m(&self) -> f64 {
        self.home_or_here().z - self.estimator.now.position.z
    }

    fn global_position_int(&self) -> GLOBAL_POSITION_INT_DATA {
        let now = &self.estimator.now;
        let place = self.geodetic_of(&now.position);
        GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.up_ms(),
            lat: e7(place.latitude_deg),
            lon: e7(place.longitude_deg),
            alt: mm(place.altitude_amsl_m),
            relative_alt: mm(self.relative_altitude_m()),
            vx: cm(now.velocity.x),
            vy: cm(now.velocity.y),
            vz: cm(now.velocity.z),
            hdg: centidegrees(self.body.yaw_rad),
        }
    }

    fn servo_output_raw(&self) -> SERVO_OUTPUT_RAW_DATA {
        let share = (self.body.thrust_m_s2 / (2.0 * GRAVITY_M_S2)).clamp(0.0, 1.0);
        let raw = if self.commander.is_armed() {
            1100 + (share * 800.0) as u16
        } else {
            900
        };
        SERVO_OUTPUT_RAW_DATA {
            time_usec: self.up_us() as u32,
            servo1_raw: raw,
            servo2_raw: raw,
            servo3_raw: raw,
            servo4_raw: raw,
            ..SERVO_OUTPUT_RAW_DATA::default()
        }
    }

    fn gps_global_origin(&self) -> GPS_GLOBAL_ORIGIN_DATA {
        let origin = self.own_frame().origin;
        GPS_GLOBAL_ORIGIN_DATA {
            latitude: e7(origin.latitude_deg),
            longitude: e7(origin.longitude_deg),
            altitude: mm(origin.altitude_amsl_m),
            time_usec: self.up_us(),
        }
    }

    fn vfr_hud(&self) -> VFR_HUD_DATA {
        let now = &self.estimator.now;
        let speed = now.velocity.xy().norm() as f32;
        VFR_HUD_DATA {
            airspeed: speed,
            groundspeed: speed,
            alt: self.geodetic_of(&now.position).altitude_amsl_m as f32,
            climb: -now.velocity.z as f32,
            heading: (centidegrees(self.body.yaw_rad) / 100) as i16,
            throttle: (self.body.thrust_m_s2 / (2.0 * GRAVITY_M_S2) * 100.0).clamp(0.0, 100.0) as u16,
        }
    }

    fn attitude_target(&self) -> ATTITUDE_TARGET_DATA {
        ATTITUDE_TARGET_DATA {
            time_boot_ms: self.up_ms(),
            q: self.quaternion(),
            body_yaw_rate: self.body.yaw_rate_rad_s as f32,
            thrust: (self.force.norm() / (2.0 * GRAVITY_M_S2)) as f32,
            ..ATTITUDE_TARGET_DATA::default()
        }
    }

    fn position_target(&self) -> POSITION_TARGET_LOCAL_NED_DATA {
        let p = self.target.position.cast::<f32>();
        let mut message = POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: self.up_ms(),
            x: p.x,
            y: p.y,
            z: p.z,
            yaw: self.yaw_hold_rad as f32,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            type_mask: PositionTargetTypemask::empty(),
            ..POSITION_TARGET_LOCAL_NED_DATA::default()
        };
        let flying = matches!(self.lift.stage(), super::Stage::Flying { .. });
        let (v, a) = if flying {
            (self.control.velocity_target, self.control.acceleration_target)
        } else {
            (Vector3::repeat(f64::NAN), Vector3::new(0.0, 0.0, 100.0))
        };
        (message.vx, message.vy, message.vz) = (v.x as f32, v.y as f32, v.z as f32);
        (message.afx, message.afy, message.afz) = (a.x as f32, a.y as f32, a.z as f32);
        if !flying {
            message.type_mask = PositionTargetTypemask::from_bits_retain(63);
        }
        message
    }

    fn highres_imu(&self) -> HIGHRES_IMU_DATA {
        let (roll, pitch) = self.body.roll_pitch_rad();
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, self.body.yaw_rad);
        let felt = turn.inverse() * (self.body.acceleration - Vector3::new(0.0, 0.0, GRAVITY_M_S2));
        let field = turn.inverse() * Vector3::new(0.21, 0.01, 0.43);
        let (xgyro, ygyro) = self.body.roll_pitch_rates_rad_s();
        let altitude_m = self.geodetic_of(&self.estimator.now.position).altitude_amsl_m;
        HIGHRES_IMU_DATA {
            time_usec: self.up_us(),
            xacc: felt.x as f32,
            yacc: felt.y as f32,
            zacc: felt.z as f32,
            xgyro: xgyro as f32,
            ygyro: ygyro as f32,
            zgyro: self.body.yaw_rate_rad_s as f32,
            xmag: field.x as f32,
            ymag: field.y as f32,
            zmag: field.z as f32,
            abs_pressure: (1013.25 * (1.0 - altitude_m / 44_330.0).max(0.0).powf(5.255)) as f32,
            pressure_alt: altitude_m as f32,
            temperature: 15.0,
            fields_updated: HighresImuUpdatedFlags::from_bits_retain(0b1_1111_1111_1111 & !(1 << 10)),
            ..HIGHRES_IMU_DATA::default()
        }
    }

    fn altitude(&self) -> ALTITUDE_DATA {
        let now = &self.estimator.now;
        let amsl = self.geodetic_of(&now.position).altitude_amsl_m as f32;
        ALTITUDE_DATA {
            time_usec: self.up_us(),
            altitude_monotonic: amsl,
            altitude_amsl: amsl,
            altitude_local: -now.position.z as f32,
            altitude_relative: self.relative_altitude_m() as f32,
            altitude_terrain: f32::NAN,
            bottom_clearance: now.height_m as f32,
        }
    }

    fn home_position(&self) -> HOME_POSITION_DATA {
        let home = self.home_or_here();
        let place = self.geodetic_of(&home);
        HOME_POSITION_DATA {
            latitude: e7(place.latitude_deg),
            longitude: e7(place.longitude_deg),
            altitude: mm(place.altitude_amsl_m),
            x: home.x as f32,
            y: home.y as f32,
            z: home.z as f32,
            q: [1.0, 0.0, 0.0, 0.0],
            time_usec: self.up_us(),
            ..HOME_POSITION_DATA::default()
        }
    }

    fn odometry(&self) -> ODOMETRY_DATA {
        let now = &self.estimator.now;
        let (roll, pitch) = self.body.roll_pitch_rad();
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, self.body.yaw_rad);
        let velocity = turn.inverse() * now.velocity;
        let (rollspeed, pitchspeed) = self.body.roll_pitch_rates_rad_s();
        let mut covariance = [f32::NAN; 21];
        for diagonal in [0, 6, 11] {
            covariance[diagonal] = 0.04;
        }
        ODOMETRY_DATA {
            time_usec: self.up_us(),
            x: now.position.x as f32,
            y: now.position.y as f32,
            z: now.position.z as f32,
            q: self.quaternion(),
            vx: velocity.x as f32,
            vy: velocity.y as f32,
            vz: velocity.z as f32,
            rollspeed: rollspeed as f32,
            pitchspeed: pitchspeed as f32,
            yawspeed: self.body.yaw_rate_rad_s as f32,
            pose_covariance: covariance,
            velocity_covariance: covariance,
            frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
            child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            estimator_type: MavEstimatorType::MAV_ESTIMATOR_TYPE_AUTOPILOT,
            quality: 100,
            ..ODOMETRY_DATA::default()
        }
    }

    /// Sends one parameter.
    pub(super) fn send_parameter(&self, channel: &mut Channel, index: usize, out: &mut Outbox) {
        let Some(parameter) = self.parameters.at(index) else {
            return;
        };
        let param_type = match parameter.value {
            super::ParameterValue::Int(_) => MavParamType::MAV_PARAM_TYPE_INT32,
            super::ParameterValue::Real(_) => MavParamType::MAV_PARAM_TYPE_REAL32,
        };
        channel.send(
            out,
            &PARAM_VALUE_DATA {
                param_value: parameter.value.on_wire(),
                param_count: self.parameters.count() as u16,
                param_index: index as u16,
                param_id: CharArray::from(parameter.name.as_str()),
                param_type,
            },
        );
    }

    /// Sends the next parameter of a list that was asked for.
    pub(super) fn send_parameter_list(&self, channel: &mut Channel, out: &mut Outbox) {
        let Some(index) = channel.list_next else { return };
        self.send_parameter(channel, index, out);
        channel.list_next = Some(index + 1).filter(|next| *next < self.parameters.count());
    }
}

/// A rotation as the wire has it: w, x, y, z.
pub(super) fn wire_quaternion(turn: &UnitQuaternion<f64>) -> [f32; 4] {
    [turn.w, turn.i, turn.j, turn.k].map(|value| value as f32)
}

/// Sends a text in chunks of 50 characters; like PX4's it ends with a tab.
pub(super) fn send_text(channel: &mut Channel, notice: &Notice, out: &mut Outbox) {
    let text = format!("{}\t", notice.text);
    let id = channel.next_text_id();
    for (chunk_seq, chunk) in text.as_bytes().chunks(TEXT_CHUNK).enumerate() {
        let mut bytes = [0; TEXT_CHUNK];
        bytes.iter_mut().zip(chunk).for_each(|(to, from)| *to = *from);
        channel.send(
            out,
            &STATUSTEXT_DATA {
                severity: notice.severity,
                text: CharArray::new(bytes),
                id,
                chunk_seq: chunk_seq as u8,
            },
        );
    }
}
