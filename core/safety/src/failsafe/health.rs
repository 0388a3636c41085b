//! What the failsafe policy is told of a vehicle, once per period.

use crate::gnss;
use serde::{Deserialize, Serialize};
use skein_domain::fence::BreachAction;
use skein_domain::telemetry::EstimatorHealth;
use skein_domain::{
    EnergyState, FlightMode, FlightState, GnssFix, LandedState, LinkHealth, NodeTime, Reaction, Telemetry,
};

/// What a satellite receiver says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GnssHealth {
    /// Its fix.
    pub fix: GnssFix,
    /// Satellites used.
    pub satellites: u8,
    /// When it was last heard.
    pub heard: NodeTime,
}

/// The vehicle is outside of a fence or inside of a zone where it must not be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FenceBreach {
    /// What the fence asks for.
    pub reaction: Reaction,
    /// How far outside, in metres.
    pub outside_m: f64,
    /// Name of the fence.
    pub zone: String,
}

impl From<&crate::fence::Breach<'_>> for FenceBreach {
    fn from(breach: &crate::fence::Breach<'_>) -> Self {
        let excess = breach.excess;
        Self {
            reaction: reaction_of(breach.action),
            outside_m: excess.outside_m.max(excess.above_m).max(excess.below_m),
            zone: breach.zone.name.clone(),
        }
    }
}

/// A vehicle's health. [`Health::observed`] fills in what its telemetry tells; the rest is the caller's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// In the air, or it is not known that it stands on the ground.
    pub airborne: bool,
    /// Out of the swarm's control: a human pilot flies it, or its autopilot's own failsafe.
    pub pilot_in_control: bool,
    /// The autopilot's own failsafe acts.
    pub failsafe: bool,
    /// Its autopilot runs in a simulation, whose clock goes at a pace of its own.
    pub simulated: bool,
    /// The autopilot's mode.
    pub mode: FlightMode,
    /// What its model says that it does.
    pub state: FlightState,
    /// Setpoints are sent to it.
    pub streaming: bool,
    /// It lands where it is: its autopilot does, or it was commanded to.
    pub lands: bool,
    /// The link is not declared lost.
    pub connected: bool,
    /// When it was last heard.
    pub last_heard: NodeTime,
    /// When its newest position was measured; absent without one.
    pub position_time: Option<NodeTime>,
    /// Its autopilot can hold its position by its own estimate.
    pub holds_position: bool,
    /// Its receiver; absent if it never said anything.
    pub gnss: Option<GnssHealth>,
    /// How far two sources of its position are apart, in metres; absent if there are no two.
    pub disagreement_m: Option<f64>,
    /// Distance from where its setpoint wants it, in metres; while it holds, from where it began to. Absent without a wanted place;
    /// not looked at while the autopilot takes off, returns or lands by itself.
    pub tracking_error_m: Option<f64>,
    /// Its autopilot's clock minus the node's, in seconds.
    pub clock_offset_s: Option<f64>,
    /// Outside of a fence.
    pub breach: Option<FenceBreach>,
    /// When the coordinator last gave a sign of life; absent if the vehicle does nothing that needs one.
    pub coordinator_heard: Option<NodeTime>,
    /// When any operator last gave a sign of life; absent if none ever did.
    pub operator_heard: Option<NodeTime>,
    /// Its charge.
    pub energy: Option<EnergyState>,
    /// The autopilot has a launch place.
    pub home_known: bool,
}

impl Health {
    /// What telemetry and link tell. Left at "nothing wrong": `state` (idle), `tracking_error_m`, `breach`, `coordinator_heard`,
    /// `operator_heard`, `energy`. `pilot_in_control` is whether the mode is one of sticks: a pilot who chose an automatic mode is
    /// seen by the change nobody asked for only. `streaming` is whether setpoints went out lately; a link knows better.
    #[must_use]
    pub fn observed(telemetry: &Telemetry, link: &LinkHealth, now: NodeTime) -> Self {
        let t = telemetry;
        let airborne = match t.landed {
            LandedState::OnGround => false,
            LandedState::Unknown => t.armed,
            LandedState::InAir | LandedState::TakingOff | LandedState::Landing => true,
        };
        let estimator_holds = t.estimator.is_none_or(|e| {
            (e.has(EstimatorHealth::POSITION_RELATIVE) || e.has(EstimatorHealth::POSITION_ABSOLUTE))
                && !(airborne && e.has(EstimatorHealth::CONSTANT_POSITION))
        });
        Self {
            airborne,
            pilot_in_control: matches!(
                t.mode,
                FlightMode::Manual
                    | FlightMode::Altitude
                    | FlightMode::Position
                    | FlightMode::Acro
                    | FlightMode::Stabilized
            ),
            failsafe: t.failsafe,
            simulated: t.simulated,
            mode: t.mode,
            state: FlightState::default(),
            lands: matches!(t.mode, FlightMode::Land | FlightMode::Descend),
            streaming: link.setpoint_rate_hz > 0.0,
            connected: link.connected,
            last_heard: link.last_heard,
            position_time: t.local.is_some_and(|p| p.is_finite()).then_some(t.position_time),
            holds_position: t.local.is_some_and(|p| p.is_finite()) && estimator_holds,
            gnss: (t.gnss.fix != GnssFix::Unknown).then_some(GnssHealth {
                fix: t.gnss.fix,
                satellites: t.gnss.satellites,
                heard: if t.heard.gnss == NodeTime::default() {
                    now
                } else {
                    t.heard.gnss
                },
            }),
            disagreement_m: gnss::disagreement_m(t, now),
            tracking_error_m: None,
            clock_offset_s: link.clock_offset_s,
            breach: None,
            coordinator_heard: None,
            operator_heard: None,
            energy: None,
            home_known: t.home.is_some(),
        }
    }
}

/// The reaction that a fence's action asks for.
#[must_use]
pub fn reaction_of(action: BreachAction) -> Reaction {
    match action {
        BreachAction::Warn => Reaction::Warn,
        BreachAction::Hold => Reaction::Hold,
        BreachAction::Return => Reaction::Return,
        BreachAction::Land => Reaction::Land,
    }
}
