//! Tests of the plugin, on a simulated vehicle with a simulated gimbal, and against anything.

mod anything;
mod managers;
mod mavlink;
mod siyi;
