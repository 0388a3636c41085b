//! PX4's answer to a command, with its numbers as they are: the same over MAVLink (COMMAND_ACK) and over DDS (`vehicle_command_ack`).
//!
//! Must never do: take an unknown result for an acceptance.

/// COMMAND_ACK with its numbers as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Acknowledgement {
    /// `MAV_CMD`.
    pub command: u16,
    /// `MAV_RESULT`.
    pub result: u8,
    /// System it is meant for; 0 if it does not say.
    pub target_system: u8,
    /// Component it is meant for; 0 if it does not say.
    pub target_component: u8,
}

impl Acknowledgement {
    /// `MAV_RESULT_ACCEPTED`.
    pub const ACCEPTED: u8 = 0;
    /// `MAV_RESULT_IN_PROGRESS`.
    pub const IN_PROGRESS: u8 = 5;

    /// The result in words, as refusals carry it.
    #[must_use]
    pub fn result_word(&self) -> String {
        match self.result {
            0 => "accepted",
            1 => "temporarily_rejected",
            2 => "denied",
            3 => "unsupported",
            4 => "failed",
            5 => "in_progress",
            6 => "cancelled",
            7 => "command_long_only",
            8 => "command_int_only",
            9 => "unsupported_frame",
            10 => "not_in_control",
            other => return format!("result_{other}"),
        }
        .to_owned()
    }
}
