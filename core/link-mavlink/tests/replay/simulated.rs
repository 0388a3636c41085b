//! The simulated vehicle beside the recorded ones: the setpoints that were sent to six vehicles of a real PX4 are flown by the simulated
//! airframe of the same kind, and its path is held against theirs.

use crate::log::{self, Recorded};
use mavlink::dialects::common::{
    ATTITUDE_DATA, LOCAL_POSITION_NED_DATA, PositionTargetTypemask as Mask, SET_POSITION_TARGET_LOCAL_NED_DATA,
};
use mavlink::{MavlinkVersion, MessageData};
use nalgebra::Vector3;
use skein_domain::Setpoint;
use skein_sim::vehicle::plant::Plant;
use skein_sim::{Airframe, NoiseSettings};

/// The route is flown between these, in seconds since the recording began; before that all hover.
const FROM_S: f64 = 8.4;
const TO_S: f64 = 51.0;
/// The simulated vehicle hovers from here on.
const BEGIN_S: f64 = 5.0;
const STEP_S: f64 = 0.004;

/// Where a vehicle was, by its own clock.
struct Place {
    time_s: f64,
    position: Vector3<f64>,
}

/// A recording, with everything on the vehicle's clock, which runs from zero.
struct Flight {
    path: Vec<Place>,
    setpoints: Vec<(f64, Setpoint)>,
    yaw_rad: f64,
}

fn read<M: MessageData>(frame: &Recorded) -> Option<M> {
    (frame.message_id() == M::ID).then(|| M::deser(MavlinkVersion::V2, frame.payload()).unwrap())
}

impl Flight {
    fn of(system_id: u8) -> Self {
        let frames = log::read(&format!("route-of-six-system-{system_id}"));
        let told: Vec<(f64, LOCAL_POSITION_NED_DATA)> =
            frames.iter().filter_map(|f| Some((f.time_s, read(f)?))).collect();
        let boot_s = |data: &LOCAL_POSITION_NED_DATA| f64::from(data.time_boot_ms) * 1e-3;
        let zero_s = boot_s(&told[0].1);
        let clock = Clock::of(
            &told
                .iter()
                .map(|(at_s, data)| (*at_s, boot_s(data) - zero_s))
                .collect::<Vec<_>>(),
        );
        let path = told.iter().map(|(_, data)| Place {
            time_s: boot_s(data) - zero_s,
            position: Vector3::new(data.x, data.y, data.z).map(f64::from),
        });
        let asked = frames.iter().filter_map(|f| Some((f.time_s, read(f)?)));
        Self {
            path: path.collect(),
            setpoints: asked
                .map(|(at_s, data)| (clock.vehicle_s(at_s), setpoint(&data)))
                .collect(),
            yaw_rad: frames
                .iter()
                .find_map(read::<ATTITUDE_DATA>)
                .map_or(0.0, |a| f64::from(a.yaw)),
        }
    }

    /// Where it was at a moment.
    fn at(&self, time_s: f64) -> Vector3<f64> {
        let next = self
            .path
            .partition_point(|place| place.time_s < time_s)
            .clamp(1, self.path.len() - 1);
        let (a, b) = (&self.path[next - 1], &self.path[next]);
        a.position + (b.position - a.position) * ((time_s - a.time_s) / (b.time_s - a.time_s))
    }

    /// How far the simulated vehicle is off along the route, horizontally in metres: root mean square and greatest.
    fn errors_m(&self, airframe: Airframe) -> (f64, f64) {
        let mut plant = Plant::of(airframe, self.at(BEGIN_S), self.yaw_rad, &NoiseSettings::NONE, 0.0, 1);
        let (mut squares, mut worst, mut count) = (0.0_f64, 0.0_f64, 0_u32);
        let mut next = self.setpoints.partition_point(|(at_s, _)| *at_s <= BEGIN_S);
        for step in 0..((TO_S - BEGIN_S) / STEP_S) as u32 {
            let now_s = BEGIN_S + f64::from(step) * STEP_S;
            while let Some((_, setpoint)) = self.setpoints.get(next).filter(|(at_s, _)| *at_s <= now_s) {
                plant.obey(setpoint);
                next += 1;
            }
            plant.step(STEP_S, &Vector3::zeros());
            if now_s >= FROM_S {
                let off_m = (plant.position() - self.at(now_s + STEP_S)).xy().norm();
                (squares, worst, count) = (squares + off_m * off_m, worst.max(off_m), count + 1);
            }
        }
        ((squares / f64::from(count)).sqrt(), worst)
    }
}

fn setpoint(data: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> Setpoint {
    let given = |mask: Mask| !data.type_mask.intersects(mask);
    let three = |x: f32, y: f32, z: f32| Vector3::new(x, y, z).map(f64::from);
    Setpoint {
        position: given(Mask::POSITION_TARGET_TYPEMASK_X_IGNORE).then(|| three(data.x, data.y, data.z).into()),
        velocity: given(Mask::POSITION_TARGET_TYPEMASK_VX_IGNORE).then(|| three(data.vx, data.vy, data.vz).into()),
        acceleration: given(Mask::POSITION_TARGET_TYPEMASK_AX_IGNORE)
            .then(|| three(data.afx, data.afy, data.afz).into()),
        yaw_rad: given(Mask::POSITION_TARGET_TYPEMASK_YAW_IGNORE).then(|| f64::from(data.yaw)),
        yaw_rate_rad_s: given(Mask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE).then(|| f64::from(data.yaw_rate)),
        drag_per_s: None,
    }
}

/// From the recorder's time to the vehicle's: both run evenly, and what came in with the least delay tells how they lie to each other.
struct Clock {
    rate: f64,
    ahead_s: f64,
}

impl Clock {
    /// Of times of arrival and the vehicle's times.
    fn of(pairs: &[(f64, f64)]) -> Self {
        let count = pairs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (mean_at, mean_boot) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = pairs.iter().map(|p| (p.0 - mean_at).powi(2)).sum();
        let rate = pairs.iter().map(|p| (p.0 - mean_at) * (p.1 - mean_boot)).sum::<f64>() / spread;
        let mut ahead: Vec<f64> = pairs.iter().map(|p| p.1 - rate * p.0).collect();
        ahead.sort_by(f64::total_cmp);
        Self {
            rate,
            ahead_s: ahead[ahead.len() * 98 / 100],
        }
    }

    fn vehicle_s(&self, at_s: f64) -> f64 {
        self.rate * at_s + self.ahead_s
    }
}

#[test]
fn the_simulated_vehicle_flies_recorded_setpoints_as_the_recorded_ones_did() {
    for system_id in 1..=6 {
        let flight = Flight::of(system_id);
        let (rms_m, worst_m) = flight.errors_m(Airframe::Sih);
        let (usual_rms_m, usual_worst_m) = flight.errors_m(Airframe::Quadrotor);
        println!(
            "system {system_id}: SIH rms {rms_m:.3} m, worst {worst_m:.3} m; usual quadrotor rms {usual_rms_m:.3} m, worst {usual_worst_m:.3} m"
        );
        // System 4 was held back by the separation filter again and again: velocities without a place, along which errors add up.
        let limit_m = if system_id == 4 { 0.45 } else { 0.2 };
        assert!(rms_m < limit_m, "system {system_id}: {rms_m} m");
        assert!(
            usual_rms_m > 2.0 * rms_m,
            "another airframe would do as well: {usual_rms_m} m"
        );
    }
}
