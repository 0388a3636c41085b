//! What simulated vehicles carry: a gimbal, a camera on it, a telemetry radio, and the scene that cameras see. Here is how each behaves; what
//! it says over MAVLink is the vehicle's.
//!
//! * [`PayloadPlan`]: what each vehicle carries.
//! * [`scene::Scene`]: what a camera sees from anywhere, and where in the picture a place lies.
//! * [`wander::Wander`]: chance, from the generator that it is given.
//!
//! Must never do: know of messages, sockets or clocks; draw randomness from anywhere but what it is given.
#![forbid(unsafe_code)]

pub mod camera;
pub mod gimbal;
pub mod manager;
pub mod radio;
pub mod scene;
pub mod wander;

pub use camera::CameraSettings;
pub use gimbal::{GimbalOutput, GimbalSettings};
pub use radio::RadioSettings;

/// Component id of a gimbal device on a vehicle.
pub const GIMBAL_COMPONENT: u8 = 154;
/// Component id of a camera.
pub const CAMERA_COMPONENT: u8 = 100;
/// Component id of a telemetry radio.
pub const RADIO_COMPONENT: u8 = 68;
/// The system id every SiK radio uses, whatever vehicle it is on.
pub const RADIO_SYSTEM: u8 = 51;

/// What each vehicle carries. By default nothing, so that its traffic is that of a bare vehicle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PayloadPlan {
    /// A gimbal, steered over MAVLink's gimbal protocol (version 2): the manager is the autopilot, as PX4 has it; the device is
    /// component 154 or servos at the autopilot's outputs.
    pub gimbal: Option<GimbalSettings>,
    /// A camera, component 100, with MAVLink's camera protocol (version 2); on the gimbal if there is one, else looking ahead.
    pub camera: Option<CameraSettings>,
    /// A telemetry radio that reports RADIO_STATUS as a SiK radio does.
    pub radio: Option<RadioSettings>,
}

impl PayloadPlan {
    /// One of each.
    #[must_use]
    pub fn all() -> Self {
        Self {
            gimbal: Some(GimbalSettings::default()),
            camera: Some(CameraSettings::default()),
            radio: Some(RadioSettings::default()),
        }
    }
}
