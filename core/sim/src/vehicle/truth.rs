//! What is really the case with a vehicle, for referees.
//!
//! Must never do: reach the vehicle itself, which knows only what it believes.

use super::SimVehicle;
use crate::truth::VehicleTruth;
use skein_domain::{FlightMode, PositionNed};

impl SimVehicle {
    /// Where it really is about the simulation's origin.
    pub(super) fn true_position(&self) -> PositionNed {
        self.swarm.position(&self.start.geodetic(&self.body.position.into()))
    }

    /// What is really the case.
    #[must_use]
    pub fn truth(&self) -> VehicleTruth {
        let geodetic = self.start.geodetic(&self.body.position.into());
        let in_offboard = self.commander.is_armed() && self.commander.mode() == FlightMode::Offboard;
        VehicleTruth {
            system_id: self.identity.system_id,
            alive: true,
            position: self.swarm.position(&geodetic),
            geodetic,
            velocity: self.body.velocity.into(),
            acceleration: self.body.acceleration.into(),
            yaw_rad: self.body.yaw_rad,
            tilt_rad: self.body.tilt_rad(),
            armed: self.commander.is_armed(),
            landed: self.landed_state(),
            touches_ground: self.body.on_ground,
            height_m: -self.body.position.z,
            mode: self.commander.mode(),
            failsafe: self.commander.in_failsafe(),
            estimate_error: self.estimator.error().into(),
            local_origin: self.swarm.position(&self.own_frame().origin),
            battery: self.battery.charge(),
            offboard_gap_s: in_offboard.then(|| self.offboard.age_s(self.time_s)),
            offboard_gap_max_s: self.offboard.gap_max_s,
            offboard_gap_sender_max_s: self.offboard.gap_sender_max_s,
            offboard_gap_recent_s: self.offboard.gap_recent_s,
            setpoints: self.offboard.accepted,
            setpoints_refused: self.offboard.refused,
            touch_down_max_m_s: self.body.touch_down_max_m_s,
            mode_changes: self.commander.changes().clone(),
            gimbal: self.gimbal_truth(),
            camera: self.camera_truth(),
            radio: self.radio_truth(),
            mission: self.mission.places().clone(),
        }
    }
}
