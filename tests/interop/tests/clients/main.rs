//! Other people's software against ours: clients of MAVLink against a simulated vehicle, a judge of HTTP APIs against the program,
//! Prometheus against its metrics, readers of recordings against what is made of them, a judge of the compose files.

mod compose;
mod mavsdk;
mod prometheus;
mod pymavlink;
mod recordings;
mod schemathesis;
