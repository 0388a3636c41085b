//! What an autopilot command means in PX4's terms: which MAVLink commands in which order, and which state must follow.
//!
//! Pure: a command and what is known of the vehicle in, steps or a refusal out.

use crate::modes::Px4Mode;
use mavlink::dialects::common::MavCmd;
use skein_domain::{AutopilotCommand, FlightMode, Geodetic, LandedState, Refusal};

/// Highest take-off that is taken for meant, in metres.
const HEIGHT_MAX_M: f64 = 5_000.0;

/// What is known of the vehicle when a command is planned.
#[derive(Debug, Clone, Copy, Default)]
pub struct Situation {
    /// Mode in the last heartbeat.
    pub mode: FlightMode,
    /// Armed in the last heartbeat.
    pub armed: bool,
    /// On the ground or in the air.
    pub landed: LandedState,
    /// Whether setpoints are being sent.
    pub streaming: bool,
    /// Present place, if it was measured just now.
    pub place: Option<Geodetic>,
    /// Launch place as the autopilot has it.
    pub home: Option<Geodetic>,
}

/// One MAVLink command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Which.
    pub id: MavCmd,
    /// Its seven parameters.
    pub parameters: [f32; 7],
}

impl Command {
    /// As COMMAND_LONG.
    #[must_use]
    pub fn long(id: MavCmd, parameters: [f32; 7]) -> Self {
        Self { id, parameters }
    }

    /// The number its acknowledgement carries.
    #[must_use]
    pub fn number(&self) -> u16 {
        self.id as u32 as u16
    }
}

/// The state that must be seen before a step counts as done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Goal {
    /// The acknowledgement is enough.
    Acknowledged,
    /// This mode.
    Mode(FlightMode),
    /// Take-off mode, or already in the air and holding.
    TakingOff,
    /// Armed, or not.
    Armed(bool),
}

impl Goal {
    /// The mode that comes with it, if one does.
    #[must_use]
    pub fn mode(self) -> Option<FlightMode> {
        match self {
            Self::Mode(mode) => Some(mode),
            Self::TakingOff => Some(FlightMode::TakeOff),
            Self::Acknowledged | Self::Armed(_) => None,
        }
    }

    /// Whether it is the case.
    #[must_use]
    pub fn is_met(self, situation: &Situation) -> bool {
        match self {
            Self::Acknowledged => true,
            Self::Mode(mode) => situation.mode == mode,
            Self::TakingOff => {
                situation.mode == FlightMode::TakeOff
                    || (situation.mode == FlightMode::Hold
                        && matches!(situation.landed, LandedState::InAir | LandedState::TakingOff))
            }
            Self::Armed(armed) => situation.armed == armed,
        }
    }

    /// In words, for a refusal.
    #[must_use]
    pub fn words(self) -> String {
        match self {
            Self::Acknowledged => "acknowledgement".to_owned(),
            Self::Mode(mode) => format!("mode {mode}"),
            Self::TakingOff => format!("mode {}", FlightMode::TakeOff),
            Self::Armed(true) => "armed motors".to_owned(),
            Self::Armed(false) => "disarmed motors".to_owned(),
        }
    }
}

/// One command and what must follow it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanStep {
    /// The command.
    pub command: Command,
    /// What must follow.
    pub goal: Goal,
}

/// What must be the case before the first step is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Nothing.
    None,
    /// The setpoint stream has run for a while.
    Streaming,
    /// The vehicle has left the ground.
    LiftedOff,
}

/// Which commands replace each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// Where and how it flies.
    Flight,
    /// Motors on or off.
    Arming,
    /// Neither; never replaced.
    Service,
}

/// A command as steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Its name, for refusals.
    pub name: &'static str,
    /// What it replaces.
    pub class: Class,
    /// What is waited for first.
    pub condition: Condition,
    /// In order.
    pub steps: Vec<PlanStep>,
}

impl Plan {
    fn single(name: &'static str, class: Class, step: PlanStep) -> Self {
        Self {
            name,
            class,
            condition: Condition::None,
            steps: vec![step],
        }
    }
}

/// The steps of a command, or why it makes no sense now.
///
/// # Errors
/// A [`Refusal`] where sending it would be wrong whatever the autopilot says.
pub fn plan(command: AutopilotCommand, situation: &Situation) -> Result<Plan, Refusal> {
    let grounded = situation.landed == LandedState::OnGround && !situation.armed;
    match command {
        AutopilotCommand::Arm => Ok(arm(situation)),
        AutopilotCommand::Disarm => {
            let command = Command::long(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [0.0; 7]);
            Ok(Plan::single(
                "disarm",
                Class::Arming,
                PlanStep {
                    command,
                    goal: Goal::Armed(false),
                },
            ))
        }
        AutopilotCommand::TakeOff { height_m } => take_off(height_m, situation),
        AutopilotCommand::Land | AutopilotCommand::ReturnToLaunch if grounded => {
            Err(Refusal::not_permitted("it stands on the ground, disarmed"))
        }
        AutopilotCommand::Land => Ok(land(situation)),
        AutopilotCommand::ReturnToLaunch => Ok(Plan::single(
            "return",
            Class::Flight,
            change_mode(FlightMode::Return, Px4Mode { main: 4, sub: 5 }),
        )),
        AutopilotCommand::SetMode { mode } => match (mode, Px4Mode::of(mode)) {
            (FlightMode::Offboard, _) => Err(Refusal::invalid("OFFBOARD is entered by its own command")),
            (FlightMode::TakeOff, _) => Err(Refusal::invalid("take-off needs a height: use its own command")),
            (FlightMode::Termination, _) => Err(Refusal::not_permitted("flight termination")),
            (_, None) => Err(Refusal::invalid("the mode `unknown` cannot be set")),
            (_, Some(px4)) => Ok(Plan::single("set_mode", Class::Flight, change_mode(mode, px4))),
        },
        // Never one command among others: it has its own way past all of them.
        AutopilotCommand::EmergencyStop => Err(Refusal::invalid("the emergency stop has its own way")),
        AutopilotCommand::EnterOffboard => {
            let step = change_mode(FlightMode::Offboard, Px4Mode { main: 6, sub: 0 });
            Ok(Plan {
                condition: Condition::Streaming,
                ..Plan::single("enter_offboard", Class::Flight, step)
            })
        }
    }
}

fn change_mode(mode: FlightMode, px4: Px4Mode) -> PlanStep {
    const CUSTOM_MODE_ENABLED: f32 = 1.0;
    let parameters = [
        CUSTOM_MODE_ENABLED,
        f32::from(px4.main),
        f32::from(px4.sub),
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    PlanStep {
        command: Command::long(MavCmd::MAV_CMD_DO_SET_MODE, parameters),
        goal: Goal::Mode(mode),
    }
}

/// After a landing from OFFBOARD, PX4 shows OFFBOARD again and refuses to arm until the mode is another or the stream runs.
fn arm(situation: &Situation) -> Plan {
    let command = Command::long(
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let mut plan = Plan::single(
        "arm",
        Class::Arming,
        PlanStep {
            command,
            goal: Goal::Armed(true),
        },
    );
    if situation.mode == FlightMode::Offboard && !situation.armed && !situation.streaming {
        plan.steps
            .insert(0, change_mode(FlightMode::Hold, Px4Mode { main: 4, sub: 3 }));
    }
    plan
}

/// PX4 takes an altitude above mean sea level. Where it stands now is the best ground there is; launch may be from before.
fn take_off(height_m: f64, situation: &Situation) -> Result<Plan, Refusal> {
    if !(height_m > 0.0 && height_m <= HEIGHT_MAX_M) {
        return Err(Refusal::invalid(format!(
            "take-off height {height_m} m; over 0 and up to {HEIGHT_MAX_M} m would be right"
        )));
    }
    if !situation.armed {
        // PX4 would accept it, stay in take-off mode and lift off whenever it is armed later.
        return Err(Refusal::not_permitted("take-off while disarmed"));
    }
    let ground = match situation.landed {
        LandedState::OnGround => situation.place.or(situation.home),
        LandedState::InAir => {
            return Err(Refusal::not_permitted("take-off while in the air"));
        }
        _ => situation.home,
    };
    let altitude_amsl_m = ground.ok_or(Refusal::NoPosition)?.altitude_amsl_m + height_m;
    let unchanged = f32::NAN;
    let parameters = [0.0, 0.0, 0.0, unchanged, unchanged, unchanged, altitude_amsl_m as f32];
    let command = Command::long(MavCmd::MAV_CMD_NAV_TAKEOFF, parameters);
    Ok(Plan::single(
        "take_off",
        Class::Flight,
        PlanStep {
            command,
            goal: Goal::TakingOff,
        },
    ))
}

fn land(situation: &Situation) -> Plan {
    let here = f32::NAN;
    let command = Command::long(MavCmd::MAV_CMD_NAV_LAND, [0.0, 0.0, 0.0, here, here, here, here]);
    let plan = Plan::single(
        "land",
        Class::Flight,
        PlanStep {
            command,
            goal: Goal::Mode(FlightMode::Land),
        },
    );
    // Sent before the take-off has begun it would be lost in it.
    let about_to_lift = situation.mode == FlightMode::TakeOff && situation.landed == LandedState::OnGround;
    Plan {
        condition: if about_to_lift {
            Condition::LiftedOff
        } else {
            Condition::None
        },
        ..plan
    }
}

#[cfg(test)]
mod tests;
