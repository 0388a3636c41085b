//! The model in simulated time: a vehicle, a gimbal and something that moves.

mod commands;
mod coordination;
mod moving;
mod rig;
mod snapshots;
