//! From messages to the vocabulary's telemetry: units, missing values, and what is known how late.

use super::clock_sync::ClockSync;
use mavlink::dialects::common::{
    ATTITUDE_DATA, BATTERY_STATUS_DATA, ESTIMATOR_STATUS_DATA, EXTENDED_SYS_STATE_DATA, GLOBAL_POSITION_INT_DATA,
    GPS_RAW_INT_DATA, GPS2_RAW_DATA, GpsFixType, HOME_POSITION_DATA, LOCAL_POSITION_NED_DATA, MavLandedState,
    MavSysStatusSensor, SYS_STATUS_DATA, WIND_COV_DATA,
};
use skein_domain::{
    Battery, BatteryUse, EstimatorHealth, FlightMode, Geodetic, Gnss, GnssFix, LandedState, LocalPositionNed, NodeTime,
    Telemetry, VelocityNed,
};
use skein_px4::local_origin::{LocalOrigin, OriginChange};

/// A battery report counts for this long; then the system status tells, in seconds.
const BATTERY_FRESH_S: f64 = 5.0;
/// Battery cells whose voltage is not given.
const NO_CELL: u16 = u16::MAX;
/// Local positions with stamps from before the newest that are passed over in a row: more are a clock that was set back.
const OVERTAKEN_MAX: u8 = 4;

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
    overtaken: u8,
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
        let before = self.telemetry;
        *self = Self::default();
        self.set_mode(before.mode, before.armed, before.failsafe);
        self.set_simulated(before.simulated);
    }

    /// Nothing is heard: whether it would arm is not known any more.
    pub fn forget_readiness(&mut self) {
        self.telemetry.ready_to_arm = None;
    }

    /// Mode and armed state of a heartbeat, and whether the autopilot's own failsafe acts.
    pub fn set_mode(&mut self, mode: FlightMode, armed: bool, failsafe: bool) {
        self.telemetry.mode = mode;
        self.telemetry.armed = armed;
        self.telemetry.failsafe = failsafe;
    }

    /// Whether the autopilot runs in a simulation.
    pub fn set_simulated(&mut self, simulated: bool) {
        self.telemetry.simulated = simulated;
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
        if is_older && self.overtaken < OVERTAKEN_MAX {
            // Overtaken on the way.
            self.overtaken += 1;
            return;
        }
        self.overtaken = 0;
        self.telemetry.heard.local = now;
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
        self.telemetry.heard.global = now;
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
    pub fn on_attitude(&mut self, now: NodeTime, message: &ATTITUDE_DATA) {
        if message.roll.is_finite() && message.pitch.is_finite() && message.yaw.is_finite() {
            self.telemetry.roll_rad = message.roll;
            self.telemetry.pitch_rad = message.pitch;
            self.telemetry.yaw_rad = message.yaw;
            self.has_attitude = true;
            self.telemetry.heard.attitude = now;
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
    pub fn on_system_status(&mut self, now: NodeTime, message: &SYS_STATUS_DATA) {
        self.telemetry.heard.system_status = now;
        // PX4 sets the health bit alone, neither "present" nor "enabled".
        let prearm = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
        self.telemetry.ready_to_arm = Some(message.onboard_control_sensors_health.contains(prearm));
        let receiver = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_GPS;
        self.telemetry.gnss_healthy = message
            .onboard_control_sensors_present
            .contains(receiver)
            .then(|| message.onboard_control_sensors_health.contains(receiver));
        if self.battery.is_none() {
            self.telemetry.heard.battery = now;
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
        self.telemetry.heard.battery = now;
        self.telemetry.battery_use = BatteryUse {
            consumed_ah: (message.current_consumed >= 0).then_some(message.current_consumed as f32 * 1e-3),
            // In hundreds of joules.
            consumed_wh: (message.energy_consumed >= 0).then_some(message.energy_consumed as f32 / 36.0),
            remaining_s: (message.time_remaining > 0).then_some(message.time_remaining as f32),
        };
        let cells = message.voltages.iter().filter(|&&mv| mv != NO_CELL);
        let more = message.voltages_ext.iter().filter(|&&mv| mv != 0 && mv != NO_CELL);
        let millivolts: u32 = cells.chain(more).map(|&mv| u32::from(mv)).sum();
        self.telemetry.battery = Battery {
            remaining: percent(message.battery_remaining),
            voltage_v: (millivolts > 0).then_some(millivolts as f32 * 1e-3),
            current_a: (message.current_battery >= 0).then(|| f32::from(message.current_battery) * 0.01),
        };
    }

    /// GPS_RAW_INT: the first receiver.
    pub fn on_gnss(&mut self, now: NodeTime, message: &GPS_RAW_INT_DATA) {
        let fix = fix(message.fix_type);
        self.telemetry.heard.gnss = now;
        self.telemetry.gnss = receiver(fix, message.satellites_visible, message.h_acc);
        self.telemetry.gnss_place = fixed_place(fix, message.lat, message.lon, message.alt);
    }

    /// GPS2_RAW: the second receiver.
    pub fn on_second_gnss(&mut self, now: NodeTime, message: &GPS2_RAW_DATA) {
        let fix = fix(message.fix_type);
        self.telemetry.heard.gnss2 = now;
        self.telemetry.gnss2 = receiver(fix, message.satellites_visible, message.h_acc);
        self.telemetry.gnss2_place = fixed_place(fix, message.lat, message.lon, message.alt);
    }

    /// ESTIMATOR_STATUS.
    pub fn on_estimator(&mut self, now: NodeTime, message: &ESTIMATOR_STATUS_DATA) {
        let accuracy = |metres: f32| (metres.is_finite() && metres > 0.0).then_some(metres);
        let ratio = |ratio: f32| if ratio.is_finite() { ratio } else { f32::MAX };
        self.telemetry.heard.estimator = now;
        self.telemetry.estimator = Some(EstimatorHealth {
            flags: message.flags.bits(),
            horizontal_accuracy_m: accuracy(message.pos_horiz_accuracy),
            vertical_accuracy_m: accuracy(message.pos_vert_accuracy),
            position_ratio: ratio(message.pos_horiz_ratio),
            velocity_ratio: ratio(message.vel_ratio),
        });
    }

    /// WIND_COV. PX4 gives no vertical part: it sends zero.
    pub fn on_wind(&mut self, now: NodeTime, message: &WIND_COV_DATA) {
        let wind = VelocityNed::new(
            f64::from(message.wind_x),
            f64::from(message.wind_y),
            f64::from(message.wind_z),
        );
        if wind.is_finite() {
            self.telemetry.heard.wind = now;
            self.telemetry.wind = Some(wind);
        }
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

fn fix(kind: GpsFixType) -> GnssFix {
    match kind {
        GpsFixType::GPS_FIX_TYPE_NO_GPS => GnssFix::Unknown,
        GpsFixType::GPS_FIX_TYPE_NO_FIX => GnssFix::None,
        GpsFixType::GPS_FIX_TYPE_2D_FIX => GnssFix::TwoD,
        GpsFixType::GPS_FIX_TYPE_3D_FIX | GpsFixType::GPS_FIX_TYPE_STATIC => GnssFix::ThreeD,
        GpsFixType::GPS_FIX_TYPE_DGPS | GpsFixType::GPS_FIX_TYPE_PPP => GnssFix::Dgps,
        GpsFixType::GPS_FIX_TYPE_RTK_FLOAT => GnssFix::RtkFloat,
        GpsFixType::GPS_FIX_TYPE_RTK_FIXED => GnssFix::RtkFixed,
    }
}

fn receiver(fix: GnssFix, satellites: u8, accuracy_mm: u32) -> Gnss {
    const UNKNOWN: u8 = u8::MAX;
    Gnss {
        fix,
        satellites: if satellites == UNKNOWN { 0 } else { satellites },
        horizontal_accuracy_m: (accuracy_mm > 0).then_some(accuracy_mm as f32 * 1e-3),
    }
}

/// Where a receiver is, if it has a fix; without one the numbers are old or zero.
fn fixed_place(fix: GnssFix, latitude: i32, longitude: i32, altitude_mm: i32) -> Option<Geodetic> {
    let fixed = !matches!(fix, GnssFix::Unknown | GnssFix::None) && (latitude != 0 || longitude != 0);
    Some(place(latitude, longitude, altitude_mm)).filter(|place| fixed && place.is_valid())
}
