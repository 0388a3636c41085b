//! The state as others see it, told when it changes.

use super::{Gimbal, moment};
use crate::aim::Aim;
use crate::orders::Status;
use skein_domain::NodeTime;
use skein_domain::payload::GimbalState;
use skein_plugin_sdk::Effects;

/// Angles that only drift are told no more often than this, in seconds.
const DRIFT_PAUSE_S: f64 = 0.1;
/// Angles are told to this, in radians: finer is noise.
const STEP_RAD: f64 = 1e-4;

/// The fault of a gimbal that does not follow.
const NOT_FOLLOWING: &str = "does not follow";

/// Tells the state when it changed.
#[derive(Debug, Default)]
pub(super) struct Reporter {
    last: Option<(NodeTime, GimbalState)>,
}

impl Reporter {
    fn tell(&mut self, now: NodeTime, state: GimbalState, effects: &mut Effects) {
        if let Some((when, last)) = &self.last {
            let drifts = only_drifts(last, &state);
            if *last == state || drifts && now.seconds_since(*when) < DRIFT_PAUSE_S {
                return;
            }
        }
        effects.report(&state);
        self.last = Some((now, state));
    }
}

/// Whether two states differ in nothing but measured angles.
fn only_drifts(before: &GimbalState, after: &GimbalState) -> bool {
    let still = GimbalState {
        roll_rad: after.roll_rad,
        pitch_rad: after.pitch_rad,
        yaw_vehicle_rad: after.yaw_vehicle_rad,
        yaw_north_rad: after.yaw_north_rad,
        wanted_pitch_rad: after.wanted_pitch_rad,
        wanted_yaw_north_rad: after.wanted_yaw_north_rad,
        ..before.clone()
    };
    still == *after && before.wanted_pitch_rad.is_some() == after.wanted_pitch_rad.is_some()
}

fn rounded(angle_rad: f64) -> f64 {
    (angle_rad / STEP_RAD).round() * STEP_RAD
}

impl Gimbal {
    pub(super) fn report(&mut self, now: NodeTime, effects: &mut Effects) {
        let state = self.state(now);
        self.reporter.tell(now, state, effects);
    }

    fn state(&self, now: NodeTime) -> GimbalState {
        let at = moment(now, &self.settings, &self.own);
        let Status {
            connected,
            owner,
            attitude,
            limits,
            model,
            fault,
            at_end_stop: _,
            by_servos: _,
        } = self.core.device.status(&at);
        let nose = at.vehicle_yaw_rad;
        let wanted = self.wanted(now);
        let reach = self.limits(now);
        let not_following = self.core.following.stays();
        GimbalState {
            connected,
            mode: self.core.aim.mode(),
            owner,
            roll_rad: attitude.map_or(0.0, |a| rounded(a.roll_rad)),
            pitch_rad: attitude.map_or(0.0, |a| rounded(a.pitch_rad)),
            yaw_vehicle_rad: attitude.and_then(|a| a.yaw.off_nose(nose)).map_or(0.0, rounded),
            yaw_north_rad: attitude.and_then(|a| a.yaw.off_north(nose)).map(rounded),
            wanted_pitch_rad: wanted.map(|w| rounded(w.pitch_rad)),
            wanted_yaw_north_rad: wanted.and_then(|w| w.yaw.off_north(nose)).map(rounded),
            place: match self.core.aim {
                Aim::Place(place) => Some(place),
                _ => None,
            },
            pitch_min_rad: limits.map(|_| reach.pitch_min_rad),
            pitch_max_rad: limits.map(|_| reach.pitch_max_rad),
            model,
            not_following,
            fault: [fault.as_str(), if not_following { NOT_FOLLOWING } else { "" }]
                .into_iter()
                .filter(|words| !words.is_empty())
                .collect::<Vec<_>>()
                .join(", "),
        }
    }
}
