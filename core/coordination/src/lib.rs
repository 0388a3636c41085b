//! What a coordinator decides and what a vehicle's control loop works out, as plain functions of plain data: who takes part, who leads, which
//! slot, which task; ways around no-fly volumes and ways home; the anchor of a formation; what the gate makes of a setpoint. The three types
//! to know: [`Coordination`], [`Formation`], [`AnchorKeeper`].
//!
//! Must never do: read a clock, wait, send anything, or know an actor.
#![forbid(unsafe_code)]

mod anchor;
mod clocks;
mod formation;
mod membership;
pub mod neighbours;
pub mod observing;
mod own_tracks;
mod plan;
mod references;
pub mod returns;
mod route;
mod state;
pub mod steering;
mod succession;
mod tasks;
mod trajectories;
pub mod ways;

pub use anchor::AnchorKeeper;
pub use formation::{Formation, available};
pub use membership::{Changed, Judging};
pub use observing::TrackObservation;
pub use own_tracks::OwnTracks;
pub use plan::{Placed, PlanInput, PlanLimits, plan, plan_with_places};
pub use references::{ReferenceReport, ReferenceSnapshot, References};
pub use state::{ActiveRoute, Coordination, Flight, Interrupted};
pub use succession::{by_fitness, succeed};
pub use tasks::intent;
pub use trajectories::{PlannedFlights, TrajectoryInput, plan_trajectories};

#[cfg(test)]
mod tests;
