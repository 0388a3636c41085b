//! A vehicle that says just what a test lets it say, frame by frame.

use mavlink::dialects::common::{
    HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavModeFlag, MavState, MavType,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};

/// Frames of one system.
pub struct Puppet {
    pub system_id: u8,
    pub component_id: u8,
    pub sequence: u8,
    pub stamp_ms: u32,
}

impl Puppet {
    pub fn new(system_id: u8) -> Self {
        Self {
            system_id,
            component_id: 1,
            sequence: 0,
            stamp_ms: 10_000,
        }
    }

    pub fn frame<D: MessageData>(&mut self, message: &D) -> Vec<u8> {
        let header = MavHeader {
            system_id: u32::from(self.system_id),
            component_id: self.component_id,
            sequence: self.sequence,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(header, message);
        raw.raw_bytes().to_vec()
    }

    pub fn heartbeat(&mut self) -> Vec<u8> {
        self.heartbeat_of(MavType::MAV_TYPE_QUADROTOR, MavAutopilot::MAV_AUTOPILOT_PX4)
    }

    pub fn heartbeat_of(&mut self, mavtype: MavType, autopilot: MavAutopilot) -> Vec<u8> {
        self.frame(&HEARTBEAT_DATA {
            custom_mode: 3 << 24 | 4 << 16,
            mavtype,
            autopilot,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_STANDBY,
            mavlink_version: 3,
        })
    }

    pub fn position(&mut self, north_m: f32) -> Vec<u8> {
        self.stamp_ms += 20;
        self.frame(&LOCAL_POSITION_NED_DATA {
            time_boot_ms: self.stamp_ms,
            x: north_m,
            ..LOCAL_POSITION_NED_DATA::default()
        })
    }
}
