//! From samples to the vocabulary's telemetry, as the link over MAVLink fills it.
//!
//! Must never do: keep as known what PX4 says is not valid any more.

use super::wire_clock::WireClock;
use crate::sample::{Attitude, BatteryReport, GnssReport, LocalPosition, Place, Status};
use nalgebra::{Quaternion, UnitQuaternion};
use skein_domain::{
    Battery, BatteryUse, EstimatorHealth, FlightMode, Gnss, GnssFix, LandedState, LocalPositionNed, NodeTime,
    Telemetry, VelocityNed,
};
use skein_px4::local_origin::{LocalOrigin, OriginChange};

/// PX4's number for OFFBOARD.
pub const OFFBOARD: u8 = 14;

/// The vocabulary's word for what PX4 does.
#[must_use]
pub fn flight_mode(nav_state: u8) -> FlightMode {
    match nav_state {
        0 => FlightMode::Manual,
        1 => FlightMode::Altitude,
        // Position, the slow one, and an orbit.
        2 | 6 | 21 => FlightMode::Position,
        3 => FlightMode::Mission,
        4 => FlightMode::Hold,
        5 => FlightMode::Return,
        10 => FlightMode::Acro,
        12 => FlightMode::Descend,
        13 => FlightMode::Termination,
        OFFBOARD => FlightMode::Offboard,
        15 => FlightMode::Stabilized,
        17 => FlightMode::TakeOff,
        18 => FlightMode::Land,
        _ => FlightMode::Unknown,
    }
}

/// What one vehicle last said of itself.
#[derive(Debug, Default)]
pub struct Estimate {
    telemetry: Telemetry,
    position_time: NodeTime,
    measured_us: u64,
    has_attitude: bool,
    /// By its detector of landings, and by its status, which is coarser.
    on_ground: Option<bool>,
    not_taken_off: Option<bool>,
    /// PX4 has told its launch place.
    home_told: bool,
}

impl Estimate {
    /// The telemetry, without what other parts know better.
    #[must_use]
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// When the position was measured.
    #[must_use]
    pub fn position_time(&self) -> NodeTime {
        self.position_time
    }

    /// Forgets what an autopilot that restarted cannot mean any more.
    pub fn restart(&mut self) {
        let Telemetry { mode, armed, .. } = self.telemetry;
        *self = Self::default();
        (self.telemetry.mode, self.telemetry.armed) = (mode, armed);
    }

    /// Yaw in radians, if known.
    #[must_use]
    pub fn yaw_rad(&self) -> Option<f64> {
        self.has_attitude.then(|| f64::from(self.telemetry.yaw_rad))
    }

    /// `vehicle_status`.
    pub fn on_status(&mut self, now: NodeTime, status: &Status) {
        self.telemetry.mode = flight_mode(status.nav_state);
        self.telemetry.armed = status.armed();
        self.telemetry.failsafe = status.failsafe;
        self.telemetry.ready_to_arm = Some(status.ready_to_arm);
        self.telemetry.heard.system_status = now;
        self.not_taken_off = Some(!status.took_off);
        self.telemetry.landed = self.landed();
    }

    /// `vehicle_land_detected`. True if the landed state changed.
    pub fn on_landed(&mut self, on_ground: bool) -> bool {
        self.on_ground = Some(on_ground);
        let landed = self.landed();
        std::mem::replace(&mut self.telemetry.landed, landed) != landed
    }

    /// PX4 tells over MAVLink that it takes off or lands while it is in the mode for it and not on the ground.
    fn landed(&self) -> LandedState {
        match (self.on_ground.or(self.not_taken_off), self.telemetry.mode) {
            (None, _) => LandedState::Unknown,
            (Some(true), _) => LandedState::OnGround,
            (Some(false), FlightMode::TakeOff) => LandedState::TakingOff,
            (Some(false), FlightMode::Land) => LandedState::Landing,
            (Some(false), _) => LandedState::InAir,
        }
    }

    /// `vehicle_local_position`.
    pub fn on_local(&mut self, now: NodeTime, local: &LocalPosition, clock: &WireClock, origin: &mut LocalOrigin) {
        let behind_us = self.measured_us.saturating_sub(local.measured_us);
        if (1..1_000_000).contains(&behind_us) {
            // Overtaken on the way.
            return;
        }
        self.measured_us = local.measured_us;
        self.estimator(now, local);
        let valid = local.valid;
        if !(valid.horizontal && valid.vertical && valid.velocity_horizontal && valid.velocity_vertical) {
            self.telemetry.local = None;
            self.telemetry.velocity = None;
            return;
        }
        let [north, east, down] = local.position_m.map(f64::from);
        let position = LocalPositionNed::new(north, east, down);
        let [north, east, down] = local.velocity_m_s.map(f64::from);
        let velocity = VelocityNed::new(north, east, down);
        self.telemetry.heard.local = now;
        self.telemetry.local = Some(position);
        self.telemetry.velocity = Some(velocity);
        self.position_time = clock.measured(now, local.measured_us);
        origin.on_local(milliseconds(local.measured_us), position, velocity);
        if let Some(said) = local.origin() {
            origin.on_said(said);
        }
    }

    /// PX4 does not publish its estimator's report with the usual topics; what it says of its position is as much.
    fn estimator(&mut self, now: NodeTime, local: &LocalPosition) {
        let valid = local.valid;
        let flags = [
            (self.has_attitude, EstimatorHealth::ATTITUDE),
            (valid.velocity_horizontal, EstimatorHealth::VELOCITY_HORIZONTAL),
            (valid.velocity_vertical, EstimatorHealth::VELOCITY_VERTICAL),
            (
                valid.horizontal,
                EstimatorHealth::POSITION_RELATIVE | EstimatorHealth::POSITION_RELATIVE_PREDICTED,
            ),
            (
                valid.horizontal && local.origin_deg.is_some() && !local.dead_reckoning,
                EstimatorHealth::POSITION_ABSOLUTE | EstimatorHealth::POSITION_ABSOLUTE_PREDICTED,
            ),
            (
                valid.vertical && local.origin_altitude_m.is_some(),
                EstimatorHealth::HEIGHT_ABSOLUTE,
            ),
        ];
        let accuracy = |metres: f32| (metres.is_finite() && metres > 0.0).then_some(metres);
        let [horizontal, vertical] = local.accuracy_m;
        self.telemetry.heard.estimator = now;
        self.telemetry.estimator = Some(EstimatorHealth {
            flags: flags
                .into_iter()
                .filter(|(is, _)| *is)
                .fold(0, |all, (_, flag)| all | flag),
            horizontal_accuracy_m: accuracy(horizontal),
            vertical_accuracy_m: accuracy(vertical),
            position_ratio: 0.0,
            velocity_ratio: 0.0,
        });
    }

    /// `vehicle_global_position`.
    pub fn on_global(&mut self, now: NodeTime, global: &Place, origin: &mut LocalOrigin) -> OriginChange {
        if !global.valid {
            self.telemetry.global = None;
            return OriginChange::None;
        }
        self.telemetry.heard.global = now;
        self.telemetry.global = Some(global.place);
        self.stands_at_home();
        origin.on_global(milliseconds(global.measured_us), &global.place)
    }

    /// `vehicle_attitude`.
    pub fn on_attitude(&mut self, now: NodeTime, attitude: &Attitude) {
        let [w, x, y, z] = attitude.quaternion;
        let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        (
            self.telemetry.roll_rad,
            self.telemetry.pitch_rad,
            self.telemetry.yaw_rad,
        ) = turned.euler_angles();
        self.has_attitude = true;
        self.telemetry.heard.attitude = now;
    }

    /// `battery_status`, of the first battery.
    pub fn on_battery(&mut self, now: NodeTime, battery: &BatteryReport) {
        if battery.id > 1 {
            return;
        }
        let known = |value: f32| (value.is_finite() && value >= 0.0).then_some(value);
        self.telemetry.heard.battery = now;
        self.telemetry.battery = Battery {
            remaining: known(battery.remaining).filter(|share| battery.connected && *share <= 1.0),
            voltage_v: known(battery.voltage_v).filter(|volts| battery.connected && *volts > 0.0),
            current_a: known(battery.current_a).filter(|_| battery.connected),
        };
        self.telemetry.battery_use = BatteryUse {
            consumed_ah: known(battery.discharged_mah).map(|mah| mah * 1e-3),
            consumed_wh: None,
            remaining_s: known(battery.time_remaining_s).filter(|seconds| *seconds > 0.0),
        };
    }

    /// `vehicle_gps_position`: the receivers of the vehicle as PX4 has blended them.
    pub fn on_gnss(&mut self, now: NodeTime, gnss: &GnssReport) {
        self.telemetry.heard.gnss = now;
        let fix = match gnss.fix_type {
            2 => GnssFix::TwoD,
            3 => GnssFix::ThreeD,
            4 | 8 => GnssFix::Dgps,
            5 => GnssFix::RtkFloat,
            6 => GnssFix::RtkFixed,
            _ => GnssFix::None,
        };
        let accuracy = gnss.horizontal_accuracy_m;
        self.telemetry.gnss = Gnss {
            fix,
            satellites: gnss.satellites,
            horizontal_accuracy_m: (accuracy.is_finite() && accuracy > 0.0).then_some(accuracy),
        };
        self.telemetry.gnss_place = gnss.has_fix().then_some(gnss.place);
    }

    /// `home_position`. PX4 tells it when it changes and never again, so that whoever comes later hears nothing of it until the vehicle is armed.
    pub fn on_home(&mut self, home: &Place) {
        if home.valid {
            self.telemetry.home = Some(home.place);
            self.home_told = true;
        }
    }

    /// Until PX4 has told, a vehicle that stands disarmed on the ground would be launched where it is: there PX4 sets its launch place, when it is armed.
    fn stands_at_home(&mut self) {
        let stands = self.telemetry.landed == LandedState::OnGround && !self.telemetry.armed;
        let told_of_arming = self.telemetry.heard.system_status != NodeTime::default();
        if !self.home_told && stands && told_of_arming {
            self.telemetry.home = self.telemetry.global;
        }
    }
}

/// The stamp as the finder of the origin counts: it looks at differences alone, right across the wrap.
fn milliseconds(stamp_us: u64) -> u32 {
    (stamp_us / 1000) as u32
}
