//! Other people's software against ours: clients of MAVLink against a simulated vehicle, a judge of HTTP APIs against the program.

mod mavsdk;
mod pymavlink;
mod schemathesis;
