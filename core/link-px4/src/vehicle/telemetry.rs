//! From messages to the vocabulary's telemetry: units, missing values, and what is known how late.

use super::clock_sync::ClockSync;
use super::local_origin::{LocalOrigin, OriginChange};
use mavlink::dialects::common::{
    ATTITUDE_DATA, BATTERY_STATUS_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA,
    GpsFixType, HOME_POSITION_DATA, LOCAL_POSITION_NED_DATA, MavLandedState, MavSysStatusSensor, SYS_STATUS_DATA,
};
use skein_domain::{
    Battery, FlightMode, Geodetic, Gnss, GnssFix, LandedState, LocalPositionNed, NodeTime, Telemetry, VelocityNed,
};

/// A battery report counts for this long; then the system status tells, in seconds.
const BATTERY_FRESH_S: f64 = 5.0;
/// Battery cells whose voltage is not given.
const NO_CELL: u16 = u16::MAX;

/// When something was heard, and its own stamp.
#[derive(Debug, Clone, Copy)]
struct Heard {
    at: NodeTime,
    stamp_ms: u32,
}

/// What one vehicle last said of itself.
#[derive(Debug, Default)]
pub struct Estimate {
    telemetry: Telemetry,
    local: Option<Heard>,
    global: Option<Heard>,
    battery: Option<NodeTime>,
    has_attitude: bool,
}

/// A place from the wire: 1e-7 degrees and millimetres.
#[must_use]
pub fn place(latitude: i32, longitude: i32, altitude_mm: i32) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(latitude) / 1e7,
        longitude_deg: f64::from(longitude) / 1e7,
        altitude_amsl_m: f64::from(altitude_mm) / 1e3,
    }
}

impl Estimate {
    /// The telemetry, without what other parts know better (frame, time of the position).
    #[must_use]
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// Forgets what an autopilot that restarted cannot mean any more.
    pub fn restart(&mut self) {
        let (mode, armed) = (self.telemetry.mode, self.telemetry.armed);
        *self = Self::default();
        self.set_mode(mode, armed);
    }

    /// Mode and armed state of a heartbeat.
    pub fn set_mode(&mut self, mode: FlightMode, armed: bool) {
        self.telemetry.mode = mode;
        self.telemetry.armed = armed;
    }

    /// Seconds since a local position was heard; infinite if none was.
    #[must_use]
    pub fn local_age_s(&self, now: NodeTime) -> f64 {
        self.local.map_or(f64::INFINITY, |heard| now.seconds_since(heard.at))
    }

    /// Seconds since a global position was heard; infinite if none was.
    #[must_use]
    pub fn global_age_s(&self, now: NodeTime) -> f64 {
        self.global.map_or(f64::INFINITY, |heard| now.seconds_since(heard.at))
    }

    /// Yaw in radians, if known.
    #[must_use]
    pub fn yaw_rad(&self) -> Option<f64> {
        self.has_attitude.then(|| f64::from(self.telemetry.yaw_rad))
    }

    /// When the position was measured: by the autopilot's stamp where the clock offset is known, else when it was heard.
    #[must_use]
    pub fn position_time(&self, clock: &ClockSync) -> NodeTime {
        let heard = self.local.or(self.global);
        heard.map_or_else(NodeTime::default, |heard| {
            clock.node_time(heard.at, heard.stamp_ms).unwrap_or(heard.at)
        })
    }

    /// LOCAL_POSITION_NED.
    pub fn on_local(&mut self, now: NodeTime, message: &LOCAL_POSITION_NED_DATA, origin: &mut LocalOrigin) {
        let position = LocalPositionNed::new(f64::from(message.x), f64::from(message.y), f64::from(message.z));
        let velocity = VelocityNed::new(f64::from(message.vx), f64::from(message.vy), f64::from(message.vz));
        if !position.is_finite() || !velocity.is_finite() {
            return;
        }
        let is_older = self
            .local
            .is_some_and(|heard| message.time_boot_ms.wrapping_sub(heard.stamp_ms).cast_signed() < 0);
        if is_older {
            // Overtaken on the way.
            return;
        }
        origin.on_local(message.time_boot_ms, position, velocity);
        self.telemetry.local = Some(position);
        self.telemetry.velocity = Some(velocity);
        self.local = Some(Heard {
            at: now,
            stamp_ms: message.time_boot_ms,
        });
    }

    /// GLOBAL_POSITION_INT.
    pub fn on_global(
        &mut self,
        now: NodeTime,
        message: &GLOBAL_POSITION_INT_DATA,
        origin: &mut LocalOrigin,
    ) -> OriginChange {
        let place = place(message.lat, message.lon, message.alt);
        if !place.is_valid() || (message.lat == 0 && message.lon == 0) {
            return OriginChange::None;
        }
        self.telemetry.global = Some(place);
        self.global = Some(Heard {
            at: now,
            stamp_ms: message.time_boot_ms,
        });
        if self.local.is_none() {
            let [north, east, down] = [message.vx, message.vy, message.vz].map(|cm_s| f64::from(cm_s) * 0.01);
            self.telemetry.velocity = Some(VelocityNed::new(north, east, down));
        }
        origin.on_global(message.time_boot_ms, &place)
    }

    /// ATTITUDE.
    pub fn on_attitude(&mut self, message: &ATTITUDE_DATA) {
        if message.roll.is_finite() && message.pitch.is_finite() && message.yaw.is_finite() {
            self.telemetry.roll_rad = message.roll;
            self.telemetry.pitch_rad = message.pitch;
            self.telemetry.yaw_rad = message.yaw;
            self.has_attitude = true;
        }
    }

    /// EXTENDED_SYS_STATE. True if the landed state changed.
    pub fn on_extended_state(&mut self, message: &EXTENDED_SYS_STATE_DATA) -> bool {
        let landed = match message.landed_state {
            MavLandedState::MAV_LANDED_STATE_UNDEFINED => LandedState::Unknown,
            MavLandedState::MAV_LANDED_STATE_ON_GROUND => LandedState::OnGround,
            MavLandedState::MAV_LANDED_STATE_IN_AIR => LandedState::InAir,
            MavLandedState::MAV_LANDED_STATE_TAKEOFF => LandedState::TakingOff,
            MavLandedState::MAV_LANDED_STATE_LANDING => LandedState::Landing,
        };
        std::mem::replace(&mut self.telemetry.landed, landed) != landed
    }

    /// SYS_STATUS.
    pub fn on_system_status(&mut self, message: &SYS_STATUS_DATA) {
        // PX4 sets the health bit alone, neither "present" nor "enabled".
        let prearm = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        self.telemetry.ready_to_arm = Some(message.onboard_control_sensors_health.contains(prearm));
        if self.battery.is_none() {
            self.telemetry.battery = Battery {
                remaining: percent(message.battery_remaining),
                voltage_v: (message.voltage_battery != u16::MAX && message.voltage_battery != 0)
                    .then(|| f32::from(message.voltage_battery) * 1e-3),
                current_a: (message.current_battery >= 0).then(|| f32::from(message.current_battery) * 0.01),
            };
        }
    }

    /// BATTERY_STATUS, of the first battery.
    pub fn on_battery(&mut self, now: NodeTime, message: &BATTERY_STATUS_DATA) {
        if message.id != 0 {
            if self.battery.is_some_and(|at| now.seconds_since(at) > BATTERY_FRESH_S) {
                self.battery = None;
            }
            return;
        }
        self.battery = Some(now);
        let cells = message.voltages.iter().filter(|&&mv| mv != NO_CELL);
        let more = message.voltages_ext.iter().filter(|&&mv| mv != 0 && mv != NO_CELL);
        let millivolts: u32 = cells.chain(more).map(|&mv| u32::from(mv)).sum();
        self.telemetry.battery = Battery {
            remaining: percent(message.battery_remaining),
            voltage_v: (millivolts > 0).then_some(millivolts as f32 * 1e-3),
            current_a: (message.current_battery >= 0).then(|| f32::from(message.current_battery) * 0.01),
        };
    }

    /// GPS_RAW_INT.
    pub fn on_gnss(&mut self, message: &GPS_RAW_INT_DATA) {
        let fix = match message.fix_type {
            GpsFixType::GPS_FIX_TYPE_NO_GPS => GnssFix::Unknown,
            GpsFixType::GPS_FIX_TYPE_NO_FIX => GnssFix::None,
            GpsFixType::GPS_FIX_TYPE_2D_FIX => GnssFix::TwoD,
            GpsFixType::GPS_FIX_TYPE_3D_FIX | GpsFixType::GPS_FIX_TYPE_STATIC => GnssFix::ThreeD,
            GpsFixType::GPS_FIX_TYPE_DGPS | GpsFixType::GPS_FIX_TYPE_PPP => GnssFix::Dgps,
            GpsFixType::GPS_FIX_TYPE_RTK_FLOAT => GnssFix::RtkFloat,
            GpsFixType::GPS_FIX_TYPE_RTK_FIXED => GnssFix::RtkFixed,
        };
        self.telemetry.gnss = Gnss {
            fix,
            satellites: if message.satellites_visible == u8::MAX {
                0
            } else {
                message.satellites_visible
            },
            horizontal_accuracy_m: (message.h_acc > 0).then_some(message.h_acc as f32 * 1e-3),
        };
    }

    /// HOME_POSITION.
    pub fn on_home(&mut self, message: &HOME_POSITION_DATA) {
        let place = place(message.latitude, message.longitude, message.altitude);
        if place.is_valid() && (message.latitude != 0 || message.longitude != 0) {
            self.telemetry.home = Some(place);
        }
    }
}

fn percent(value: i8) -> Option<f32> {
    (0..=100).contains(&value).then(|| f32::from(value) * 0.01)
}
