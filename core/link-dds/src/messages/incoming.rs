//! What PX4 subscribes to under `/fmu/in/`, as far as Skein sends it.
//!
//! Must never do: be sent to a PX4 that has not said that it reads this shape.

super::messages! {
    /// Version 0: all releases from 1.15 on.
    VehicleCommand = "VehicleCommand" {
        timestamp: u64,
        param1: f32,
        param2: f32,
        param3: f32,
        param4: f32,
        param5: f64,
        param6: f64,
        param7: f32,
        command: u32,
        target_system: u8,
        target_component: u8,
        source_system: u8,
        source_component: u16,
        confirmation: u8,
        from_external: bool,
    }

    /// All releases from 1.15 on.
    OffboardControlMode = "OffboardControlMode" {
        timestamp: u64,
        position: bool,
        velocity: bool,
        acceleration: bool,
        attitude: bool,
        body_rate: bool,
        thrust_and_torque: bool,
        direct_actuator: bool,
    }

    /// Version 0: all releases from 1.15 on.
    TrajectorySetpoint = "TrajectorySetpoint" {
        timestamp: u64,
        position: [f32; 3],
        velocity: [f32; 3],
        acceleration: [f32; 3],
        jerk: [f32; 3],
        yaw: f32,
        yawspeed: f32,
    }
}
