//! Times, rates and counts of the link to one vehicle.
//!
//! Must never do: hold a default that PX4's own timeouts contradict.

/// How one vehicle's link behaves.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkSettings {
    /// System id the node uses towards the vehicles.
    pub own_system_id: u8,
    /// Component id the node uses towards the vehicles.
    pub own_component_id: u8,
    /// Heartbeats per second to each vehicle, as `MAV_TYPE_GCS`: without them PX4 sends no status texts.
    pub heartbeat_hz: f64,
    /// Setpoints per second at most; also the rate at which a valid one is repeated and a hold is sent.
    pub setpoint_rate_hz: f64,
    /// How long a hold is sent after a setpoint expired, in seconds. Then the stream is given up on purpose.
    pub hold_for_s: f64,
    /// How long the stream must have run before OFFBOARD is asked for, in seconds.
    pub offboard_lead_s: f64,
    /// How long a request for OFFBOARD waits for the stream at most, in seconds.
    pub offboard_wait_s: f64,
    /// A vehicle that is silent for this long is lost, in seconds.
    pub lost_after_s: f64,
    /// How long one of two vehicles with the same system id must be silent before the other is obeyed, in seconds.
    pub duplicate_clear_s: f64,
    /// How long an acknowledgement is awaited before the command is sent again, in seconds.
    pub ack_timeout_s: f64,
    /// How often a command is sent in all.
    pub command_attempts: u8,
    /// How long a state that should follow an accepted command is awaited, in seconds.
    pub confirm_timeout_s: f64,
    /// How long a command may stay `IN_PROGRESS` in all, in seconds.
    pub progress_timeout_s: f64,
    /// How long after a refusal its status text is awaited, in seconds.
    pub refusal_text_s: f64,
    /// How often TIMESYNC is exchanged, per second.
    pub timesync_hz: f64,
    /// Message rates asked of the vehicle.
    pub rates: MessageRates,
}

impl Default for LinkSettings {
    fn default() -> Self {
        Self {
            own_system_id: 245,
            own_component_id: 190,
            heartbeat_hz: 1.0,
            setpoint_rate_hz: 50.0,
            hold_for_s: 5.0,
            offboard_lead_s: 0.5,
            offboard_wait_s: 3.0,
            lost_after_s: 1.5,
            duplicate_clear_s: 3.0,
            ack_timeout_s: 0.5,
            command_attempts: 5,
            confirm_timeout_s: 3.0,
            progress_timeout_s: 60.0,
            refusal_text_s: 0.25,
            timesync_hz: 1.0,
            rates: MessageRates::default(),
        }
    }
}

/// Messages per second asked of a vehicle; 0 turns one off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MessageRates {
    /// Whether rates are asked for at all. Not where another program owns the line's rates.
    pub manage: bool,
    /// Whether messages that nobody here reads are turned off when they are seen.
    pub turn_off_unused: bool,
    /// Shortest time between two such requests to one vehicle, in seconds, so that a start-up does not flood a radio.
    pub spacing_s: f64,
    /// HEARTBEAT. Mode and armed state are known that fast. PX4 sends 1 Hz unless it grants more.
    pub heartbeat_hz: f64,
    /// ATTITUDE.
    pub attitude_hz: f64,
    /// LOCAL_POSITION_NED.
    pub local_position_hz: f64,
    /// GLOBAL_POSITION_INT.
    pub global_position_hz: f64,
    /// EXTENDED_SYS_STATE.
    pub landed_state_hz: f64,
    /// SYS_STATUS.
    pub system_status_hz: f64,
    /// BATTERY_STATUS.
    pub battery_hz: f64,
    /// GPS_RAW_INT, and GPS2_RAW where there is a second receiver.
    pub gnss_hz: f64,
    /// ESTIMATOR_STATUS.
    pub estimator_hz: f64,
    /// WIND_COV, where the autopilot estimates the wind.
    pub wind_hz: f64,
    /// HOME_POSITION.
    pub home_hz: f64,
}

impl Default for MessageRates {
    fn default() -> Self {
        Self {
            manage: true,
            turn_off_unused: true,
            spacing_s: 0.05,
            heartbeat_hz: 4.0,
            attitude_hz: 10.0,
            local_position_hz: 50.0,
            global_position_hz: 5.0,
            landed_state_hz: 2.0,
            system_status_hz: 1.0,
            battery_hz: 1.0,
            gnss_hz: 2.0,
            estimator_hz: 1.0,
            wind_hz: 0.5,
            home_hz: 0.5,
        }
    }
}
