//! What Skein says in ROS 2, whether live or in a bag: messages and services as data, names of vehicles and frames, values in the frames of REP-103
//! and REP-105. The three types to know: [`interfaces::Interface`], [`names::Names`], [`interfaces::Definitions`].
//!
//! Must never do: speak; that is for `core/ros2` (DDS) and `core/export` (bags).
#![forbid(unsafe_code)]

pub mod frames;
pub mod interfaces;
pub mod names;
pub mod values;
