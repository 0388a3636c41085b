//! Tests of the plugin: on a simulated vehicle with a simulated radio, on flights away from it, and against anything.

mod anything;
mod flights;
mod simulated;
