//! The whole node in one process against simulated vehicles: one program for all flights, so that several fly at a time and none is linked twice.

mod adoption;
mod autopilot_logs;
mod by_hand;
mod common_frame;
mod control;
mod documented;
mod flock;
mod gate;
mod neighbours;
mod observing;
mod operator;
mod other_autopilot;
mod overrides;
mod parameters;
mod payloads;
mod pilot;
mod recorder;
mod replay;
mod software_in_the_loop;
mod tracking;
mod trajectories;
mod twice;
mod upgrades;
mod versions;
mod video;
mod web;
