//! `sensor_msgs`.
//!
//! Must never do: fill in what is not known; what is not has the value that the definition says.

use super::standard::Header;
use super::{Fixed, messages};

messages! { "sensor_msgs":
    /// Kind of satellite fix.
    NavSatStatus { status: i8, service: u16 }
    /// A place on Earth.
    NavSatFix {
        header: Header,
        status: NavSatStatus,
        latitude: f64,
        longitude: f64,
        altitude: f64,
        position_covariance: Fixed<9>,
        position_covariance_type: u8,
    }
    /// A battery.
    BatteryState {
        header: Header,
        voltage: f32,
        temperature: f32,
        current: f32,
        charge: f32,
        capacity: f32,
        design_capacity: f32,
        percentage: f32,
        power_supply_status: u8,
        power_supply_health: u8,
        power_supply_technology: u8,
        present: bool,
        cell_voltage: Vec<f32>,
        cell_temperature: Vec<f32>,
        location: String,
        serial_number: String,
    }
    /// A picture as a file.
    CompressedImage { header: Header, format: String, data: Vec<u8> }
    /// Which part of its picture a camera gives.
    RegionOfInterest { x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool }
    /// How a camera sees.
    CameraInfo {
        header: Header,
        height: u32,
        width: u32,
        distortion_model: String,
        d: Vec<f64>,
        k: Fixed<9>,
        r: Fixed<9>,
        p: Fixed<12>,
        binning_x: u32,
        binning_y: u32,
        roi: RegionOfInterest,
    }
}
