//! Which reactions a vehicle can carry out, and whether it is seen to carry one out.

use super::Health;
use skein_domain::{EnergyLevel, FlightMode, FlightState, Reaction};

/// What a vehicle has to carry reactions out with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Means {
    /// It is heard.
    pub reachable: bool,
    /// Its autopilot can hold its position.
    pub holds_position: bool,
    /// It knows where on Earth it is, and where home is.
    pub finds_home: bool,
    /// Its charge lasts for the way home, as far as known.
    pub pays_for_home: bool,
}

impl Means {
    /// The means of a vehicle whose satellite navigation is trusted or not.
    #[must_use]
    pub fn of(health: &Health, gnss_trusted: bool) -> Self {
        Self {
            reachable: health.connected,
            holds_position: health.holds_position,
            finds_home: gnss_trusted && health.holds_position && health.home_known,
            pays_for_home: health
                .energy
                .is_none_or(|e| e.needed_home.is_some() && e.level != EnergyLevel::LandNow),
        }
    }
}

/// The reaction to carry out instead of one that the vehicle has no means for: never a weaker one.
///
/// Who cannot find or pay for the way home lands. Who cannot hold its position lands too (the autopilot descends without one).
/// A vehicle that is not heard is told all the same: it may hear.
#[must_use]
pub fn feasible(reaction: Reaction, means: Means) -> Reaction {
    match reaction {
        Reaction::Warn | Reaction::Release => reaction,
        Reaction::Hold if means.holds_position => Reaction::Hold,
        Reaction::Return if means.finds_home && means.pays_for_home => Reaction::Return,
        Reaction::Hold | Reaction::Return | Reaction::Land => Reaction::Land,
    }
}

/// What follows on a reaction that was not seen to take effect: the next stronger one that the vehicle has means for. One that is
/// not heard is left to its autopilot.
#[must_use]
pub fn next_after(reaction: Reaction, means: Means) -> Reaction {
    if means.reachable {
        feasible(reaction.stronger(), means)
    } else {
        Reaction::Release
    }
}

/// Whether the vehicle is seen to do what was ordered, or something stronger.
#[must_use]
pub fn is_effective(reaction: Reaction, health: &Health) -> bool {
    match reaction {
        Reaction::Warn => true,
        Reaction::Release => !health.streaming,
        // What a vehicle that is not heard does is not seen.
        _ if !health.connected => false,
        _ => doing(health) >= reaction,
    }
}

/// What the vehicle does, as far as that is a reaction. The autopilot's mode counts; in OFFBOARD, what its model says.
fn doing(health: &Health) -> Reaction {
    if !health.airborne {
        return Reaction::Land;
    }
    match health.mode {
        FlightMode::Land | FlightMode::Descend | FlightMode::Termination => Reaction::Land,
        FlightMode::Return => Reaction::Return,
        FlightMode::Hold => Reaction::Hold,
        FlightMode::Offboard => match health.state {
            FlightState::Holding => Reaction::Hold,
            FlightState::Returning => Reaction::Return,
            FlightState::Landing => Reaction::Land,
            _ => Reaction::Warn,
        },
        _ => Reaction::Warn,
    }
}
