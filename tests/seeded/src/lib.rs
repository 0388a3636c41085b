//! Whole flights of swarms in simulated time: drawn from a seed, flown by the code that decides in a node, judged by the truth.
//!
//! What decides is the product: the coordinator's decisions, the UAV model, the gate with its fences and its separation filter. What
//! they stand in is drawn and simulated: vehicles, wind, noise, links that lose and delay. The same seed gives the same flight.
//!
//! Must never do: decide anything in place of the code under test, or read a clock.
#![forbid(unsafe_code)]

mod air_link;
mod case;
mod craft;
mod ground;
mod judge;
mod outcome;
mod world;

pub use case::{Ability, Ask, Case, Closed, Fate, FlightStep, Foreign, Leave, Moving, When};
pub use outcome::{Arrival, Closest, Crossing, Failure, FilterFigures, Lowest, OnRoute, Outcome};
pub use world::fly;

/// Draws the case of a seed and flies it.
#[must_use]
pub fn fly_seed(seed: u64, trace: bool) -> Outcome {
    fly(&Case::draw(seed), trace)
}
