//! Other people's software against ours: clients of MAVLink against a simulated vehicle, a judge of HTTP APIs against the program,
//! Prometheus against its metrics.

mod mavsdk;
mod prometheus;
mod pymavlink;
mod schemathesis;
