//! Operators' commands: which are taken up in which state, and how they begin.
//!
//! Must never do: lose a command. Each one ends in exactly one of done and refused.

use crate::flight::{ActiveCommand, Arming, Asking, Guided, Phase, Purpose, WaitingCommand};
use crate::model::{GenericUav, is_airborne};
use skein_domain::{CommandId, NodeTime, PositionNed, Refusal, VehicleCommand};
use skein_plugin_sdk::Effects;

/// No take-off goes higher, in metres: a height beyond it is a slip of the hand.
const MAX_HEIGHT_M: f64 = 1_000.0;

impl GenericUav {
    /// A command came in.
    pub(crate) fn take_command(
        &mut self,
        id: CommandId,
        command: VehicleCommand,
        not_before: NodeTime,
        out: &mut Effects,
    ) {
        let known = self.flight.command.is_some_and(|c| c.id == id) || self.flight.waiting.is_some_and(|w| w.id == id);
        if known {
            return; // The same command once more.
        }
        if matches!(command, VehicleCommand::Arm | VehicleCommand::TakeOff { .. }) {
            self.end_landing_on_the_ground(out);
        }
        if let Err(refusal) = self.check_values(&command).and_then(|()| self.check_state(&command)) {
            out.refused(id, refusal);
            return;
        }
        if let Some(waiting) = self.flight.waiting.take() {
            out.refused(waiting.id, Refusal::Superseded);
        }
        if not_before > self.now {
            self.flight.waiting = Some(WaitingCommand {
                id,
                command,
                not_before,
            });
        } else {
            self.begin(id, command, out);
        }
    }

    /// Begins the waiting command when its time has come.
    pub(crate) fn begin_waiting(&mut self, out: &mut Effects) {
        if let Some(WaitingCommand { id, command, .. }) = self.flight.waiting.take_if(|w| w.not_before <= self.now) {
            match self.check_state(&command) {
                Ok(()) => self.begin(id, command, out),
                Err(refusal) => out.refused(id, refusal),
            }
        }
    }

    fn begin(&mut self, id: CommandId, command: VehicleCommand, out: &mut Effects) {
        self.command_refused(Refusal::Superseded, out);
        self.flight.command = Some(ActiveCommand { id, command });
        // The operator outranks the task until a newer one comes.
        if let Some(task) = &self.flight.task {
            self.flight.settled_version = self.flight.settled_version.max(task.version);
        }
        out.executing(id);
        match command {
            VehicleCommand::Arm => self.begin_arming(None),
            VehicleCommand::TakeOff { height_m } => self.begin_arming(Some(height_m)),
            VehicleCommand::Disarm => self.begin_disarming(""),
            VehicleCommand::Land => self.begin_land_command(out),
            VehicleCommand::LandAt { spot } => self.fly(Purpose::LandAt { spot }, None, "to the landing spot", out),
            VehicleCommand::Hold => self.fly(
                Purpose::Hold {
                    at: self.take_off_hold(),
                },
                None,
                "",
                out,
            ),
            VehicleCommand::Return => self.begin_return(out),
            VehicleCommand::GoTo {
                position,
                yaw_rad,
                speed_m_s,
            } => {
                let speed_m_s = speed_m_s.unwrap_or(self.settings.cruise_speed_m_s);
                self.fly(
                    Purpose::GoTo {
                        to: position,
                        speed_m_s,
                    },
                    yaw_rad,
                    "",
                    out,
                );
            }
            VehicleCommand::Observe { .. } => {
                let goal = None;
                self.fly(Purpose::Guided(Guided { id, command, goal }), None, "observing", out);
            }
            VehicleCommand::Steer => self.begin_steering(out),
            // Never admitted.
            VehicleCommand::LookAt { .. } | VehicleCommand::StopObserving => {}
        }
    }

    fn begin_arming(&mut self, take_off_m: Option<f64>) {
        let arming = Arming {
            take_off_m,
            since_s: self.flight.heard_s,
            mode: Asking::default(),
            arm: Asking::default(),
        };
        self.enter(Phase::Arming(arming), "");
    }

    pub(crate) fn begin_disarming(&mut self, detail: &str) {
        self.enter(Phase::Disarming(Asking::default()), detail);
    }

    fn begin_land_command(&mut self, out: &mut Effects) {
        let airborne = self.own.is_some_and(|own| is_airborne(&own));
        match &self.flight.phase {
            // The autopilot lands already.
            Phase::Landing(landing) if !landing.returning => {}
            _ if airborne => self.begin_landing(false, "", out),
            _ => self.begin_disarming("take-off broken off"),
        }
    }

    fn begin_return(&mut self, out: &mut Effects) {
        let home = self.own.and_then(|own| own.home).filter(PositionNed::is_finite);
        match (home, self.measured()) {
            (Some(home), Some(_)) => self.fly(Purpose::Home { home }, None, "", out),
            _ => self.begin_landing(true, "by the autopilot: no home or no position here", out),
        }
    }

    /// Where a take-off that is about to end holds: a hold command then holds there, and not a little below.
    fn take_off_hold(&self) -> Option<PositionNed> {
        match &self.flight.phase {
            Phase::Flying(flying) => match flying.purpose {
                Purpose::TakeOff { hold } => Some(hold),
                _ => None,
            },
            _ => None,
        }
    }

    fn check_values(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        let finite = |name: &str, place: &PositionNed| {
            if place.is_finite() {
                Ok(())
            } else {
                Err(Refusal::invalid(format!("{name} is not finite")))
            }
        };
        match command {
            VehicleCommand::TakeOff { height_m } => {
                let lowest = self.settings.take_off_min_height_m;
                if (lowest..=MAX_HEIGHT_M).contains(height_m) {
                    return Ok(());
                }
                Err(Refusal::invalid(format!(
                    "height {height_m} m is not within {lowest} to {MAX_HEIGHT_M} m"
                )))
            }
            VehicleCommand::LandAt { spot } => finite("the landing spot", spot),
            VehicleCommand::GoTo {
                position,
                yaw_rad,
                speed_m_s,
            } => {
                if yaw_rad.is_some_and(|yaw| !yaw.is_finite()) {
                    return Err(Refusal::invalid("the yaw is not finite"));
                }
                if speed_m_s.is_some_and(|speed| !(speed.is_finite() && speed > 0.0)) {
                    return Err(Refusal::invalid("the speed must be above zero"));
                }
                finite("the goal", position)
            }
            VehicleCommand::Observe { .. } if self.takes_guidance => Ok(()),
            VehicleCommand::Observe { .. } | VehicleCommand::LookAt { .. } | VehicleCommand::StopObserving => {
                let name = command.name();
                Err(Refusal::not_supported(format!(
                    "{name} needs a model with payloads, such as observation-uav"
                )))
            }
            _ => Ok(()),
        }
    }

    /// Whether a command fits the state the vehicle is in.
    fn check_state(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        let Some(own) = self.own else {
            return Err(Refusal::LinkLost { vehicle: self.vehicle });
        };
        let airborne = is_airborne(&own);
        let phase = &self.flight.phase;
        let under_nobodys_control = matches!(phase, Phase::PilotControl | Phase::Faulted);
        let fits = match command {
            VehicleCommand::Arm | VehicleCommand::TakeOff { .. } => {
                let idle = matches!(phase, Phase::Idle | Phase::Arming(_) | Phase::Disarming(_));
                (idle || under_nobodys_control) && !airborne
            }
            VehicleCommand::Disarm => !airborne && !matches!(phase, Phase::Flying(_)),
            VehicleCommand::Land => match phase {
                Phase::Arming(_) | Phase::TakingOff(_) => true,
                Phase::Idle | Phase::Disarming(_) => false,
                _ => airborne,
            },
            VehicleCommand::Hold | VehicleCommand::Return => {
                airborne && !matches!(phase, Phase::Idle | Phase::Arming(_) | Phase::Disarming(_))
            }
            VehicleCommand::GoTo { .. }
            | VehicleCommand::LandAt { .. }
            | VehicleCommand::Observe { .. }
            | VehicleCommand::Steer => {
                airborne && (under_nobodys_control || matches!(phase, Phase::Flying(_) | Phase::Landing(_)))
            }
            // Refused for what they are, before.
            VehicleCommand::LookAt { .. } | VehicleCommand::StopObserving => false,
        };
        if !fits {
            return Err(Refusal::WrongState {
                state: phase.state(),
                command: command.name().to_owned(),
            });
        }
        let needs_position = matches!(
            command,
            VehicleCommand::Hold
                | VehicleCommand::GoTo { .. }
                | VehicleCommand::LandAt { .. }
                | VehicleCommand::Observe { .. }
                | VehicleCommand::Steer
        );
        if needs_position && self.measured().is_none() {
            return Err(Refusal::NoPosition);
        }
        Ok(())
    }
}
