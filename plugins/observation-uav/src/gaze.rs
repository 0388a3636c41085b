//! Where to look: the gimbal is told the place, and the vehicle's nose helps where that is not enough.
//!
//! Must never do: tell the gimbal more often than its interval allows, or turn the vehicle faster than its rate.

use crate::geometry::Direction;
use crate::model::ObservationUav;
use crate::target::missing;
use crate::watch::Pointed;
use skein_plugin_sdk::Effects;
use skein_plugin_sdk::domain::exchange::Severity;
use skein_plugin_sdk::domain::frames::wrap_angle_rad;
use skein_plugin_sdk::domain::payload::{GimbalCommand, GimbalMode, GimbalState};
use skein_plugin_sdk::domain::{Geodetic, PositionNed, Refusal, RequestId, SwarmFrame};

/// A gimbal that refused, or does something else than it was told, is told again after so long, in seconds.
const RETRY_S: f64 = 2.0;
/// A gimbal that does not look where it was told to for so long does not reach there, in seconds.
const REACH_PATIENCE_S: f64 = 3.0;
/// A gimbal that has not answered within so long will not, in seconds.
const ANSWER_PATIENCE_S: f64 = 5.0;

/// How high pictures are, as a share of their width: most are 4:3 or wider, so the lower ones count.
const HEIGHT_PER_WIDTH: f64 = 0.7;
/// As long as the target is within this share of the height of view, the speed is not limited.
const FULL_SPEED_VIEW: f64 = 0.6;

impl ObservationUav {
    /// One period of looking.
    pub(crate) fn look(&mut self, dt_s: f64, out: &mut Effects) {
        self.look_at_region(out);
        let Some(at) = self.aimed().and_then(|aimed| aimed.position(self.now, &self.settings)) else {
            return;
        };
        let Some(here) = self.uav.position() else { return };
        self.point_gimbal(&at, &here, out);
        self.watch_reach(&at);
        if self.payloads.gimbal().is_none() || self.watch.nose_helps {
            self.turn_nose(&at, &here, dt_s);
            let region = self.watch.region.as_mut();
            if let Some(id) = region.and_then(|region| region.command.take()) {
                out.done(id); // The nose turns to it.
            }
        }
    }

    /// A region that is gone, or a gimbal that never answers.
    fn look_at_region(&mut self, out: &mut Effects) {
        let Some(region) = &mut self.watch.region else { return };
        let seen = region.aimed.look(&self.sightings, self.now, &self.settings);
        let after_s = self.now.seconds_since(region.since);
        let refusal = if !seen {
            out.notice(Severity::Warning, "what was looked at is gone");
            missing(&region.aimed.target)
        } else if region.command.is_some() && after_s > ANSWER_PATIENCE_S {
            let what = "look_at".to_owned();
            Refusal::timed_out(what, after_s)
        } else {
            return;
        };
        if let Some(id) = region.command.take() {
            out.refused(id, refusal);
        }
        self.end_region(out);
    }

    fn point_gimbal(&mut self, at: &PositionNed, here: &PositionNed, out: &mut Effects) {
        let Some((name, state)) = self.payloads.gimbal() else {
            return;
        };
        let origin = self.uav.own_state().and_then(|own| own.frame_origin);
        let Some(place) = origin.map(|origin| SwarmFrame::new(origin).geodetic(at)) else {
            return;
        };
        if !self.is_due(at, here, state) || !place.is_valid() {
            return;
        }
        let name = name.to_owned();
        let request = self.new_request();
        self.watch.pointed = Some(Pointed {
            place: *at,
            time: self.now,
            request,
            refused: false,
        });
        out.payload_command(request, &name, &point_at(place));
    }

    /// Whether the gimbal is to be told now.
    fn is_due(&self, at: &PositionNed, here: &PositionNed, state: &GimbalState) -> bool {
        let Some(pointed) = &self.watch.pointed else {
            return true;
        };
        let waited_s = self.now.seconds_since(pointed.time);
        let turned_rad = match (Direction::from_to(here, &pointed.place), Direction::from_to(here, at)) {
            (Some(told), Some(wanted)) => told.angle_to_rad(&wanted),
            _ => 0.0,
        };
        let elsewhere = pointed.refused || state.mode != GimbalMode::PointAt;
        let changed = turned_rad > self.settings.gimbal_step_rad && !pointed.refused;
        (changed && waited_s >= self.settings.gimbal_interval_s) || (elsewhere && waited_s >= RETRY_S)
    }

    /// Whether the gimbal gets there.
    fn watch_reach(&mut self, at: &PositionNed) {
        let told = self.watch.pointed.is_some() && self.payloads.gimbal().is_some();
        if !told || self.sees(at) {
            self.watch.off_since = None;
            return;
        }
        let since = *self.watch.off_since.get_or_insert(self.now);
        if self.now.seconds_since(since) > REACH_PATIENCE_S {
            self.watch.nose_helps = true;
        }
    }

    fn turn_nose(&mut self, at: &PositionNed, here: &PositionNed, dt_s: f64) {
        let (Some(wanted), Some(asked_rad)) = (Direction::from_to(here, at), self.uav.asked_yaw_rad()) else {
            return;
        };
        let off = at.vector() - here.vector();
        if off.xy().norm() < 1.0 {
            return; // Straight below: any yaw will do.
        }
        let most_rad = self.settings.yaw_rate_rad_s * dt_s;
        let turn_rad = wrap_angle_rad(wanted.yaw_rad - asked_rad).clamp(-most_rad, most_rad);
        self.uav.look_along(wrap_angle_rad(asked_rad + turn_rad));
    }

    /// With which share of its speed the vehicle may fly: a camera that is fixed to it looks at the ground when it leans forward, and the faster it flies, the more
    /// it leans. 1 where a gimbal keeps the picture level, where there is no camera, or nobody says how the vehicle leans.
    pub(crate) fn speed_share(&self, at: &PositionNed) -> f64 {
        let lean_rad = self.uav.own_state().and_then(|own| own.pitch_rad);
        let wanted = self.uav.position().and_then(|here| Direction::from_to(&here, at));
        let (Some(camera_rad), Some(lean_rad), Some(wanted)) = (self.fixed_camera_pitch_rad(), lean_rad, wanted) else {
            return 1.0;
        };
        let level_rad = wanted.pitch_rad - camera_rad;
        let view_rad = self.field_rad() / 2.0 * HEIGHT_PER_WIDTH;
        if level_rad.abs() > view_rad {
            return 1.0; // No slower flight would bring it into view.
        }
        let share_of_view = (level_rad - lean_rad).abs() / view_rad;
        ((1.0 - share_of_view) / (1.0 - FULL_SPEED_VIEW)).clamp(0.0, 1.0)
    }

    /// Where the camera looks, in radians above the horizon, if it is fixed to the vehicle; none where a gimbal turns it, or there is no camera.
    pub(crate) fn fixed_camera_pitch_rad(&self) -> Option<f64> {
        let fixed = self.payloads.gimbal().is_none() && self.payloads.camera().is_some();
        fixed.then_some(self.settings.fixed_camera_pitch_rad)
    }

    fn field_rad(&self) -> f64 {
        let told = self.payloads.camera().and_then(|(_, camera)| camera.field_of_view_rad);
        told.unwrap_or(self.settings.field_of_view_rad)
    }

    /// Whether a place is within the camera's field of view.
    pub(crate) fn sees(&self, at: &PositionNed) -> bool {
        let Some(state) = self.uav.own_state() else {
            return false;
        };
        let Some(own) = state.kinematics else { return false };
        let lean_rad = state.pitch_rad.unwrap_or(0.0);
        let Some(wanted) = self.uav.position().and_then(|here| Direction::from_to(&here, at)) else {
            return false;
        };
        let looking = match self.payloads.gimbal() {
            Some((_, gimbal)) => Direction {
                yaw_rad: gimbal.yaw_north_rad.unwrap_or(own.yaw_rad + gimbal.yaw_vehicle_rad),
                pitch_rad: gimbal.pitch_rad,
            },
            None => Direction {
                yaw_rad: own.yaw_rad,
                pitch_rad: lean_rad + self.settings.fixed_camera_pitch_rad,
            },
        };
        looking.angle_to_rad(&wanted) <= self.field_rad() / 2.0
    }

    /// A payload answered.
    pub(crate) fn take_answer(&mut self, request: RequestId, refusal: Option<&Refusal>, out: &mut Effects) {
        let gimbals = self.watch.pointed.as_mut().filter(|pointed| pointed.request == request);
        let Some(pointed) = gimbals else {
            if let Some(refusal) = refusal {
                out.notice(Severity::Advisory, format!("a payload refused: {refusal}"));
            }
            return;
        };
        let before = std::mem::replace(&mut pointed.refused, refusal.is_some());
        if let Some(refusal) = refusal.filter(|_| !before) {
            out.notice(Severity::Warning, format!("the gimbal refused: {refusal}"));
        }
        let command = self.watch.region.as_mut().and_then(|region| region.command.take());
        match (command, refusal) {
            (Some(id), None) => out.done(id),
            (Some(id), Some(refusal)) => {
                out.refused(id, refusal.clone());
                self.end_region(out);
            }
            (None, _) => {}
        }
    }
}

fn point_at(place: Geodetic) -> GimbalCommand {
    GimbalCommand::PointAt { place }
}
