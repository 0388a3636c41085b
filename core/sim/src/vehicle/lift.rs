//! Between standing and flying: motors run up, lift-off, touch-down found, disarming by itself.

use super::commander::Commander;
use mavlink::dialects::common::MavSeverity;

/// From the start of the run-up: the take-off is reported, and the vehicle lifts off, after these times in seconds.
const TAKE_OFF_SEEN_S: f64 = 0.8;
const LIFT_OFF_S: f64 = 2.6;
/// Climb at lift-off in metres per second, and how much faster it may climb each second.
const FIRST_CLIMB_M_S: f64 = 0.5;
const CLIMB_RAMP_M_S2: f64 = 0.5;
/// On the ground and meaning to go down for this long: landed. In seconds.
const LANDED_AFTER_S: f64 = 1.3;
/// Disarmed for this long: landed, wherever it is. In seconds.
const LANDED_DISARMED_S: f64 = 0.5;

/// How far the take-off is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stage {
    /// Motors off.
    Off,
    /// Armed; motors idle. Since when it waits, in seconds of the simulation.
    Idle { since_s: f64 },
    /// Motors are being run up for the take-off.
    RunUp { since_s: f64 },
    /// Flies.
    Flying { since_s: f64 },
}

/// What the lift logic needs to know in every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LiftInput {
    pub now_s: f64,
    /// Stands on the ground.
    pub on_ground: bool,
    /// Something asks it to take off.
    pub wants_up: bool,
    /// Something asks it to go down, or to sink to the ground it stands on.
    pub wants_down: bool,
    /// COM_SPOOLUP_TIME.
    pub spool_up_s: f64,
    /// COM_DISARM_LAND; not positive = never.
    pub disarm_after_landing_s: f64,
    /// COM_DISARM_PRFLT; not positive = never.
    pub disarm_idle_s: f64,
}

/// Take-off and land detection.
#[derive(Debug, Clone)]
pub(crate) struct Lift {
    stage: Stage,
    landed: bool,
    contact_since_s: Option<f64>,
    /// Has left "landed" since it was armed.
    flew: bool,
    /// Since when it has been disarmed, in seconds of the simulation.
    off_since_s: Option<f64>,
}

impl Lift {
    pub(crate) fn new() -> Self {
        Self {
            stage: Stage::Off,
            landed: true,
            contact_since_s: None,
            flew: false,
            off_since_s: None,
        }
    }

    pub(crate) fn stage(&self) -> Stage {
        self.stage
    }

    /// What the land detector says.
    pub(crate) fn is_landed(&self) -> bool {
        self.landed
    }

    /// Bound of the climb in metres per second while the take-off is being run up, up to `full_m_s`.
    pub(crate) fn climb_limit_m_s(&self, now_s: f64, full_m_s: f64) -> f64 {
        match self.stage {
            Stage::Flying { since_s } => (FIRST_CLIMB_M_S + CLIMB_RAMP_M_S2 * (now_s - since_s)).min(full_m_s),
            _ => 0.0,
        }
    }

    /// One step; gives true at the moment of lift-off.
    pub(crate) fn step(&mut self, input: &LiftInput, commander: &mut Commander) -> bool {
        let now_s = input.now_s;
        let Some(armed_for_s) = commander.armed_for_s(now_s) else {
            self.stage = Stage::Off;
            self.flew = false;
            // As PX4 has it: disarmed counts as landed, also in the middle of a fall.
            let since_s = *self.off_since_s.get_or_insert(now_s);
            if input.on_ground || now_s - since_s >= LANDED_DISARMED_S {
                self.landed = true;
            }
            return false;
        };
        self.off_since_s = None;
        let mut lifted = false;
        match self.stage {
            Stage::Off => self.stage = Stage::Idle { since_s: now_s },
            Stage::Idle { .. } => {
                if input.wants_up && armed_for_s >= input.spool_up_s {
                    self.stage = Stage::RunUp { since_s: now_s };
                }
            }
            Stage::RunUp { since_s } => {
                let t = now_s - since_s;
                if self.landed && t >= TAKE_OFF_SEEN_S {
                    self.landed = false;
                    self.flew = true;
                    commander.say(MavSeverity::MAV_SEVERITY_INFO, "Takeoff detected");
                }
                if t >= LIFT_OFF_S {
                    self.stage = Stage::Flying { since_s: now_s };
                    lifted = true;
                }
            }
            Stage::Flying { .. } => self.look_for_ground(input, commander),
        }
        self.disarm_by_itself(input, commander);
        lifted
    }

    fn look_for_ground(&mut self, input: &LiftInput, commander: &mut Commander) {
        if !(input.on_ground && input.wants_down) {
            self.contact_since_s = None;
            return;
        }
        let since_s = *self.contact_since_s.get_or_insert(input.now_s);
        if input.now_s - since_s >= LANDED_AFTER_S {
            self.landed = true;
            self.contact_since_s = None;
            self.stage = Stage::Idle { since_s: input.now_s };
            commander.say(MavSeverity::MAV_SEVERITY_INFO, "Landing detected");
        }
    }

    fn disarm_by_itself(&mut self, input: &LiftInput, commander: &mut Commander) {
        let Stage::Idle { since_s } = self.stage else { return };
        let waited_s = input.now_s - since_s;
        if self.flew {
            if input.disarm_after_landing_s > 0.0 && waited_s >= input.disarm_after_landing_s {
                commander.disarmed("Disarmed by landing", input.now_s);
            }
        } else if input.disarm_idle_s > 0.0 && waited_s >= input.disarm_idle_s {
            commander.disarmed("Disarmed by auto preflight disarming", input.now_s);
        }
    }
}
