//! Other people's software against ours: clients of MAVLink against a simulated vehicle, a judge of HTTP APIs against the program,
//! Prometheus against its metrics, readers of recordings against what is made of them.

mod mavsdk;
mod prometheus;
mod pymavlink;
mod recordings;
mod schemathesis;
