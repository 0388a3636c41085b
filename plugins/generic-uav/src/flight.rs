//! The complete flight state as data: all of it goes into the snapshot.
//!
//! Must never do: hold anything that cannot be built again from the snapshot and the settings.

mod parts;

pub use parts::Goal;
pub(crate) use parts::{Asking, Guided, Kept, Steered};

use crate::blend::{Blend, Stop};
use minicbor::{Decode, Encode};
use skein_domain::{
    AccelerationNed, AnchorReference, CommandId, FlightMode, FlightState, FormationHeading, Keeping, NodeTime,
    PositionNed, Refusal, RequestId, Route, SlotMove, Trajectory, VehicleCommand, VehicleId, VehicleTask, VelocityNed,
};
use skein_flight::DragEstimator;

/// Everything a new instance needs to go on.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Flight {
    /// What the vehicle is doing.
    #[n(0)]
    pub phase: Phase,
    /// Why, for the operator.
    #[n(1)]
    pub detail: String,
    /// The state last told.
    #[n(2)]
    pub told: Option<ToldState>,
    /// The operator's command being carried out.
    #[n(3)]
    pub command: Option<ActiveCommand>,
    /// One that is not to be begun yet.
    #[n(4)]
    pub waiting: Option<WaitingCommand>,
    /// The newest task seen.
    #[n(5)]
    pub task: Option<VehicleTask>,
    /// Tasks up to this version were taken up, or an operator's command outranks them.
    #[n(6)]
    pub settled_version: u64,
    /// The leader's anchor as last seen.
    #[n(7)]
    pub anchor: Option<AnchorReference>,
    /// The setpoint last given.
    #[n(8)]
    pub reference: Option<Reference>,
    /// Number of the next request to the autopilot.
    #[n(9)]
    pub next_request: u32,
    /// Nothing is heard from the vehicle.
    #[n(10)]
    pub link_lost: bool,
    /// The last tick.
    #[n(11)]
    pub ticked: Option<NodeTime>,
    /// Seconds of flight with a link; time-outs count in it, so that a lost link uses none of them up.
    #[n(12)]
    pub heard_s: f64,
    /// For how long the gate has been refusing setpoints, in seconds.
    #[n(13)]
    pub refused_for_s: f64,
    /// Derived from the vehicle's own state, because no usable snapshot was there: done with the first such state.
    #[n(14)]
    pub derived: bool,
    /// Answers of the autopilot since the last tick; without a refusal it accepted.
    #[n(15)]
    pub answers: Vec<(RequestId, Option<Refusal>)>,
    /// Changes of mode that nobody here asked for since the last tick: from, to.
    #[n(16)]
    pub unasked_modes: Vec<(FlightMode, FlightMode)>,
    /// Why the gate refused a setpoint since the last tick.
    #[n(17)]
    pub gate_refusal: Option<Refusal>,
    /// When the vehicle was heard again after a silence, in heard seconds.
    #[n(18)]
    pub heard_again_s: Option<f64>,
    /// What is known of how strongly the air slows the vehicle down.
    #[n(19)]
    #[cbor(default)]
    pub drag: DragEstimator,
    /// How much of what followers are told of a leader is its reference, 0..=1; the rest is what is measured.
    #[n(20)]
    #[cbor(default)]
    pub told_reference: f64,
}

/// The state last told to the host.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct ToldState {
    #[n(0)]
    pub state: FlightState,
    #[n(1)]
    pub detail: String,
}

/// A command being carried out.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct ActiveCommand {
    #[n(0)]
    pub id: CommandId,
    #[n(1)]
    pub command: VehicleCommand,
}

/// A command whose time has not come.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct WaitingCommand {
    #[n(0)]
    pub id: CommandId,
    #[n(1)]
    pub command: VehicleCommand,
    #[n(2)]
    pub not_before: NodeTime,
}

/// The setpoint last given, from which the next plan goes on.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Reference {
    #[n(0)]
    pub position: PositionNed,
    #[n(1)]
    pub velocity: VelocityNed,
    #[n(2)]
    pub yaw_rad: Option<f64>,
    #[n(3)]
    pub time: NodeTime,
}

/// What the vehicle is doing.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) enum Phase {
    /// On the ground.
    #[default]
    #[n(0)]
    Idle,
    /// Being armed.
    #[n(1)]
    Arming(#[n(0)] Arming),
    /// Being disarmed on the ground.
    #[n(2)]
    Disarming(#[n(0)] Asking),
    /// The autopilot climbs.
    #[n(3)]
    TakingOff(#[n(0)] TakingOff),
    /// Flies by our setpoints.
    #[n(4)]
    Flying(#[n(0)] Flying),
    /// The autopilot lands, or returns and lands.
    #[n(5)]
    Landing(#[n(0)] Landing),
    /// Out of our control.
    #[n(6)]
    PilotControl,
    /// Something failed that an operator must look at.
    #[n(7)]
    Faulted,
}

/// Being armed.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Arming {
    /// Height to take off to afterwards; none to stay on the ground.
    #[n(0)]
    pub take_off_m: Option<f64>,
    /// When it began, in heard seconds.
    #[n(1)]
    pub since_s: f64,
    /// For a mode in which arming is possible.
    #[n(2)]
    pub mode: Asking,
    /// For arming.
    #[n(3)]
    pub arm: Asking,
}

/// The autopilot climbs.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct TakingOff {
    /// The asked height above the launch place in metres.
    #[n(0)]
    pub height_m: f64,
    /// Where it stood.
    #[n(1)]
    pub launch: PositionNed,
    /// When it began, in heard seconds.
    #[n(2)]
    pub since_s: f64,
    /// For the take-off.
    #[n(3)]
    pub asking: Asking,
    /// Whether the autopilot has taken it up.
    #[n(4)]
    pub accepted: bool,
}

/// Flies by our setpoints.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Flying {
    /// What for.
    #[n(0)]
    pub purpose: Purpose,
    /// For OFFBOARD, until the autopilot is in it. From then on any other mode is the pilot's or a failsafe's.
    #[n(1)]
    pub engaging: Option<Asking>,
    /// The way.
    #[n(2)]
    pub plan: Plan,
    /// How far along it, in seconds.
    #[n(3)]
    pub elapsed_s: f64,
    /// What is left of the difference with which the plan was begun.
    #[n(4)]
    pub blend: Option<Blend>,
    /// Yaw to keep, where the purpose has none of its own.
    #[n(5)]
    pub yaw_rad: Option<f64>,
    /// A request for another mode whose answer is still to come, and when it was made, in heard seconds: not engaged before.
    #[n(6)]
    pub after: Option<(RequestId, f64)>,
}

/// What a flight by setpoints is for.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) enum Purpose {
    /// The end of a take-off: hold above the launch place.
    #[n(0)]
    TakeOff {
        #[n(0)]
        hold: PositionNed,
    },
    /// Hold at a place, or where it comes to a stop.
    #[n(1)]
    Hold {
        #[n(0)]
        at: Option<PositionNed>,
    },
    /// Go to a place.
    #[n(2)]
    GoTo {
        #[n(0)]
        to: PositionNed,
        #[n(1)]
        speed_m_s: f64,
    },
    /// Go to above a spot and land there.
    #[n(3)]
    LandAt {
        #[n(0)]
        spot: PositionNed,
    },
    /// Go to above the launch place and land there.
    #[n(4)]
    Home {
        #[n(0)]
        home: PositionNed,
    },
    /// Lead a formation.
    #[n(5)]
    Lead(#[n(0)] Lead),
    /// Follow in a slot.
    #[n(6)]
    Follow(#[n(0)] Follow),
    /// Fly where a model that is built on this one says.
    #[n(7)]
    Guided(#[n(0)] Guided),
    /// Keep a place among neighbours.
    #[n(8)]
    Keep(#[n(0)] Keeping),
    /// Fly a planned trajectory, then hold at its end.
    #[n(9)]
    Fly(#[n(0)] Fly),
    /// Fly where a hand steers it.
    #[n(10)]
    Steer(#[n(0)] Steered),
}

/// Flying a trajectory.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Fly {
    #[n(0)]
    pub trajectory: Trajectory,
    /// Its end was reported.
    #[n(1)]
    pub finished: bool,
}

/// Leading.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Lead {
    #[n(0)]
    pub route: Option<Route>,
    /// How the formation's heading is chosen.
    #[n(1)]
    pub heading: FormationHeading,
    #[n(2)]
    pub heading_rad: f64,
    #[n(3)]
    pub heading_rate_rad_s: f64,
    /// The end of the route was reported.
    #[n(4)]
    pub finished: bool,
    /// It is steered by hand, or was, and stands since: its route and the way its heading is chosen wait for another task.
    #[n(5)]
    pub steered: Option<Steered>,
}

/// Following.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Follow {
    /// Whose anchor; none for one that is no vehicle.
    #[n(0)]
    pub leader: Option<VehicleId>,
    #[n(1)]
    pub slot: SlotMove,
    /// The slot flown until the leader's first anchor after the change: slot and anchor change together, or the vehicle would jump.
    #[n(2)]
    pub previous: Option<SlotMove>,
    /// When the slot was given; cleared with the first anchor after it.
    #[n(3)]
    pub awaiting_since: Option<NodeTime>,
}

/// A way through space.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) enum Plan {
    /// Brake and stand.
    #[n(0)]
    Stop(#[n(0)] Stop),
    /// Straight to a place.
    #[n(1)]
    Straight {
        #[n(0)]
        from: PositionNed,
        #[n(1)]
        to: PositionNed,
        #[n(2)]
        speed_m_s: f64,
    },
    /// Along the leader's route.
    #[n(2)]
    Route {
        #[n(0)]
        start: PositionNed,
        #[n(1)]
        route: Route,
        /// How it moves there.
        #[n(2)]
        velocity: Option<VelocityNed>,
    },
    /// In the slot.
    #[n(3)]
    Slot,
    /// After a goal that moves: the reference itself, moved on period by period.
    #[n(4)]
    Guided {
        #[n(0)]
        position: PositionNed,
        #[n(1)]
        velocity: VelocityNed,
        #[n(2)]
        acceleration: AccelerationNed,
    },
    /// In a place among neighbours: the reference itself, moved on period by period.
    #[n(5)]
    Kept(#[n(0)] Kept),
    /// Along the trajectory of the purpose, by the common clock.
    #[n(6)]
    Trajectory,
}

/// The autopilot lands, or returns and lands.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Landing {
    /// It returns to launch first.
    #[n(0)]
    pub returning: bool,
    /// For the mode.
    #[n(1)]
    pub asking: Asking,
    /// Whether the autopilot has taken it up.
    #[n(2)]
    pub accepted: bool,
    /// When it began, in heard seconds.
    #[n(3)]
    pub since_s: f64,
    /// What is streamed until it is taken up, and for how long already: the vehicle was flying by our setpoints.
    #[n(4)]
    pub stop: Option<(Stop, f64)>,
    /// Since when it is disarmed without having landed, in heard seconds.
    #[n(5)]
    pub disarmed_since_s: Option<f64>,
    /// It has been said that it takes too long.
    #[n(6)]
    pub overdue: bool,
    /// For a mode that it can be armed in again, once it is down.
    #[n(7)]
    pub leaving: Option<Asking>,
}

impl Phase {
    /// The state as the host knows it.
    pub(crate) fn state(&self) -> FlightState {
        match self {
            Self::Idle | Self::Disarming(_) => FlightState::Idle,
            Self::Arming(_) => FlightState::Arming,
            Self::TakingOff(_) => FlightState::TakingOff,
            Self::Flying(flying) => flying.purpose.state(),
            Self::Landing(landing) if landing.returning => FlightState::Returning,
            Self::Landing(_) => FlightState::Landing,
            Self::PilotControl => FlightState::PilotControl,
            Self::Faulted => FlightState::Faulted,
        }
    }
}

impl Purpose {
    fn state(&self) -> FlightState {
        match self {
            Self::TakeOff { .. } => FlightState::TakingOff,
            Self::Hold { .. } => FlightState::Holding,
            // At the end of its trajectory it stays.
            Self::Fly(fly) if fly.finished => FlightState::Holding,
            Self::GoTo { .. } | Self::Guided(_) | Self::Fly(_) | Self::Steer(_) => FlightState::GoingTo,
            Self::LandAt { .. } => FlightState::Landing,
            Self::Home { .. } => FlightState::Returning,
            Self::Lead(_) => FlightState::Leading,
            Self::Follow(_) | Self::Keep(_) => FlightState::Following,
        }
    }
}
