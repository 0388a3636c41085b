//! The commands this model adds, and what begins and ends with them.
//!
//! Must never do: lose a command. Each one ends in exactly one of done and refused; those that fly end under the flight's control.

use crate::model::ObservationUav;
use crate::target::{Aimed, check, missing};
use crate::watch::{Asked, Observation, Region};
use skein_plugin_sdk::Effects;
use skein_plugin_sdk::domain::exchange::Event;
use skein_plugin_sdk::domain::payload::{GimbalCommand, Target};
use skein_plugin_sdk::domain::{CommandId, NodeTime, Refusal, VehicleCommand};

/// No observation is farther off than this, in metres: a distance beyond it is a slip of the hand.
const MAX_DISTANCE_M: f64 = 2_000.0;

impl ObservationUav {
    pub(crate) fn take_command(
        &mut self,
        id: CommandId,
        command: VehicleCommand,
        not_before: NodeTime,
        out: &mut Effects,
    ) {
        if self.is_known(id) {
            return; // The same command once more.
        }
        match command {
            VehicleCommand::Observe { target, .. } => {
                let known = not_before > self.now || self.sightings.of(&target, self.now).is_some();
                let fits = check(&target, self.uav.vehicle()).and_then(|()| self.check_values(&command));
                if let Err(refusal) = fits.and_then(|()| if known { Ok(()) } else { Err(missing(&target)) }) {
                    out.refused(id, refusal);
                    return;
                }
            }
            VehicleCommand::LookAt { target } => {
                self.look_at(id, target, out);
                return;
            }
            VehicleCommand::StopObserving => {
                self.stop(id, not_before, out);
                return;
            }
            _ => {}
        }
        self.fly(
            &Event::Command {
                id,
                command,
                not_before,
            },
            out,
        );
    }

    fn check_values(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        let VehicleCommand::Observe {
            stand_off_m,
            height_m,
            bearing_rad,
            ..
        } = command
        else {
            return Ok(());
        };
        let invalid = |detail: String| Err(Refusal::InvalidValue { detail });
        if !bearing_rad.is_none_or(f64::is_finite) {
            return invalid("the bearing is none".to_owned());
        }
        let least_m = self.settings.stand_off_min_m;
        if let Some(distance_m) = stand_off_m
            && !(least_m..=MAX_DISTANCE_M).contains(distance_m)
        {
            return invalid(format!(
                "the stand-off distance {distance_m} m is not within {least_m} to {MAX_DISTANCE_M} m"
            ));
        }
        match height_m {
            Some(height_m) if !height_m.is_finite() || height_m.abs() > MAX_DISTANCE_M => {
                invalid(format!("the height {height_m} m is none"))
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn begin_observation(&mut self, id: CommandId, target: Target, asked: Asked, out: &mut Effects) {
        self.end_region(out);
        self.forget_gimbal();
        self.watch.observation = Some(Observation {
            id,
            aimed: Aimed::new(target, self.now),
            stand_off_m: asked.stand_off_m.unwrap_or(self.settings.stand_off_m),
            height_m: asked.height_m,
            bearing_rad: None,
            on_station: false,
            since: self.now,
            asked_bearing_rad: asked.bearing_rad,
            waits: false,
            lowest_down_m: None,
        });
    }

    pub(crate) fn end_observation(&mut self, out: &mut Effects) {
        self.watch.observation = None;
        self.stop_camera(out);
        if self.watch.region.is_none() {
            self.look_ahead(out);
        }
    }

    fn look_at(&mut self, id: CommandId, target: Target, out: &mut Effects) {
        let possible = check(&target, self.uav.vehicle()).and_then(|()| {
            let known = self.sightings.of(&target, self.now).is_some();
            let own = self.uav.own_state();
            let connected = own.is_some_and(|own| own.link_connected);
            match self.payloads.gimbal() {
                _ if !known => Err(missing(&target)),
                _ if !connected => Err(Refusal::LinkLost {
                    vehicle: self.uav.vehicle(),
                }),
                Some(_) if own.is_none_or(|own| own.frame_origin.is_none()) => Err(Refusal::NoSwarmFrame),
                Some(_) => Ok(()),
                None if self.uav.asked_yaw_rad().is_some() => Ok(()),
                None => Err(Refusal::not_supported(
                    "look_at needs a gimbal, or a vehicle in flight that can turn",
                )),
            }
        });
        if let Err(refusal) = possible {
            out.refused(id, refusal);
            return;
        }
        self.end_region(out);
        self.forget_gimbal();
        out.executing(id);
        let mut region = Region {
            command: Some(id),
            aimed: Aimed::new(target, self.now),
            since: self.now,
        };
        region.aimed.look(&self.sightings, self.now, &self.settings);
        self.watch.region = Some(region);
    }

    /// Ends looking at a region; a command whose gimbal has not answered yet is replaced.
    pub(crate) fn end_region(&mut self, out: &mut Effects) {
        if let Some(region) = self.watch.region.take() {
            if let Some(id) = region.command {
                out.refused(id, Refusal::Superseded);
            }
            if self.watch.observation.is_none() {
                self.look_ahead(out);
            }
        }
    }

    fn stop(&mut self, id: CommandId, not_before: NodeTime, out: &mut Effects) {
        self.end_region(out);
        if self.uav.guided().is_some() {
            let hold = VehicleCommand::Hold;
            let command = Event::Command {
                id,
                command: hold,
                not_before,
            };
            self.fly(&command, out);
        } else {
            out.executing(id);
            out.done(id);
        }
    }

    /// The gimbal ahead, and forgotten.
    fn look_ahead(&mut self, out: &mut Effects) {
        let was_pointed = self.watch.pointed.is_some();
        self.forget_gimbal();
        if was_pointed && let Some(name) = self.payloads.gimbal().map(|(name, _)| name.to_owned()) {
            let request = self.new_request();
            out.payload_command(request, &name, &GimbalCommand::Neutral);
        }
    }

    /// The gimbal is told anew where to point.
    fn forget_gimbal(&mut self) {
        self.watch.pointed = None;
        self.watch.off_since = None;
        self.watch.nose_helps = false;
    }
}
