//! Other people's MAVLink software against a simulated vehicle.

mod mavsdk;
mod pymavlink;
