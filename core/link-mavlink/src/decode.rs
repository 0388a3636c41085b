//! From frames to the messages a link reads; all others are left alone before any parsing.
//!
//! Must never do: fail on values newer than the protocol description where the message is vital: a vehicle of an unknown
//! type, or an acknowledgement of an unknown command, must not make a vehicle deaf.

use crate::fields::Fields;
use crate::frame::{Frame, FrameHeader};
use crate::route_message::RouteMessage;
use mavlink::dialects::common::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, BATTERY_STATUS_DATA, ESTIMATOR_STATUS_DATA, EXTENDED_SYS_STATE_DATA,
    GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, GPS_RAW_INT_DATA, GPS2_RAW_DATA, HOME_POSITION_DATA,
    LOCAL_POSITION_NED_DATA, PARAM_ERROR_DATA, PARAM_VALUE_DATA, STATUSTEXT_DATA, SYS_STATUS_DATA, TIMESYNC_DATA,
    WIND_COV_DATA,
};
use mavlink::{MessageData, error::ParserError};
use skein_px4::acknowledgement::Acknowledgement;
use skein_px4::modes::Px4Mode;

/// Ids of the messages of which fields are read by hand.
const HEARTBEAT_ID: u32 = 0;
const COMMAND_ACK_ID: u32 = 77;

/// A message that a link reads.
#[derive(Debug, Clone, PartialEq)]
pub enum Inbound {
    /// HEARTBEAT.
    Heartbeat(Heartbeat),
    /// SYS_STATUS.
    SystemStatus(SYS_STATUS_DATA),
    /// PARAM_VALUE.
    ParameterValue(PARAM_VALUE_DATA),
    /// GPS_RAW_INT.
    Gnss(GPS_RAW_INT_DATA),
    /// GPS2_RAW.
    SecondGnss(GPS2_RAW_DATA),
    /// ESTIMATOR_STATUS.
    Estimator(ESTIMATOR_STATUS_DATA),
    /// WIND_COV.
    Wind(WIND_COV_DATA),
    /// ATTITUDE.
    Attitude(ATTITUDE_DATA),
    /// LOCAL_POSITION_NED.
    LocalPosition(LOCAL_POSITION_NED_DATA),
    /// GLOBAL_POSITION_INT.
    GlobalPosition(GLOBAL_POSITION_INT_DATA),
    /// GPS_GLOBAL_ORIGIN.
    GlobalOrigin(GPS_GLOBAL_ORIGIN_DATA),
    /// COMMAND_ACK.
    Acknowledgement(Acknowledgement),
    /// TIMESYNC.
    TimeSync(TIMESYNC_DATA),
    /// BATTERY_STATUS.
    Battery(BATTERY_STATUS_DATA),
    /// AUTOPILOT_VERSION.
    AutopilotVersion(AUTOPILOT_VERSION_DATA),
    /// HOME_POSITION.
    Home(HOME_POSITION_DATA),
    /// EXTENDED_SYS_STATE.
    ExtendedState(EXTENDED_SYS_STATE_DATA),
    /// STATUSTEXT.
    StatusText(STATUSTEXT_DATA),
    /// PARAM_ERROR.
    ParameterError(PARAM_ERROR_DATA),
    /// A message of the mission protocol.
    Route(RouteMessage),
}

/// HEARTBEAT with its numbers as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heartbeat {
    /// The autopilot's own number for its mode.
    pub custom_mode: u32,
    /// `MAV_TYPE`.
    pub vehicle_type: u8,
    /// `MAV_AUTOPILOT`.
    pub autopilot: u8,
    /// `MAV_MODE_FLAG`.
    pub base_mode: u8,
    /// `MAV_STATE`.
    pub system_status: u8,
}

impl Heartbeat {
    const SAFETY_ARMED: u8 = 128;
    const STATE_CRITICAL: u8 = 5;
    const STATE_EMERGENCY: u8 = 6;
    const TYPE_GCS: u8 = 6;
    const AUTOPILOT_INVALID: u8 = 8;
    /// `MAV_AUTOPILOT_PX4`.
    pub const AUTOPILOT_PX4: u8 = 12;
    /// `MAV_TYPE`s of parts that sit on a vehicle or beside it: antenna tracker, onboard controller, gimbal, ADSB, camera,
    /// charging station, and so on.
    const PART_TYPES: [u8; 19] = [
        5, 18, 26, 27, 30, 31, 32, 33, 34, 36, 37, 38, 39, 40, 41, 42, 44, 48, 49,
    ];

    /// Whether the motors are armed.
    #[must_use]
    pub fn armed(&self) -> bool {
        self.base_mode & Self::SAFETY_ARMED != 0
    }

    /// Whether the autopilot's own failsafe is acting.
    #[must_use]
    pub fn failsafe(&self) -> bool {
        matches!(self.system_status, Self::STATE_CRITICAL | Self::STATE_EMERGENCY)
    }

    /// The mode in PX4's terms; other autopilots number theirs otherwise.
    #[must_use]
    pub fn px4_mode(&self) -> Option<Px4Mode> {
        (self.autopilot == Self::AUTOPILOT_PX4).then(|| Px4Mode::from_custom_mode(self.custom_mode))
    }

    /// Whether a flight controller sent it, and not a ground station or a part of a vehicle.
    #[must_use]
    pub fn is_vehicle(&self) -> bool {
        self.autopilot != Self::AUTOPILOT_INVALID
            && self.vehicle_type != Self::TYPE_GCS
            && !Self::PART_TYPES.contains(&self.vehicle_type)
    }

    fn read(payload: &[u8]) -> Self {
        let fields = Fields(payload);
        Self {
            custom_mode: u32::from_le_bytes([fields.u8(0), fields.u8(1), fields.u8(2), fields.u8(3)]),
            vehicle_type: fields.u8(4),
            autopilot: fields.u8(5),
            base_mode: fields.u8(6),
            system_status: fields.u8(7),
        }
    }
}

/// COMMAND_ACK with its numbers as they are.
fn acknowledgement(payload: &[u8]) -> Acknowledgement {
    let fields = Fields(payload);
    Acknowledgement {
        command: u16::from_le_bytes([fields.u8(0), fields.u8(1)]),
        result: fields.u8(2),
        target_system: fields.u8(8),
        target_component: fields.u8(9),
    }
}

/// Reads a frame's payload; `None` for messages that no link reads.
///
/// # Errors
/// [`ParserError`] if a field holds a value that the protocol description does not know.
pub fn decode(frame: &Frame<'_>) -> Option<Result<Inbound, ParserError>> {
    let FrameHeader {
        version, message_id, ..
    } = frame.header;
    let payload = frame.payload;
    macro_rules! read {
        ($data:ident => $variant:ident) => {
            $data::deser(version, payload).map(Inbound::$variant)
        };
    }
    Some(match message_id {
        LOCAL_POSITION_NED_DATA::ID => read!(LOCAL_POSITION_NED_DATA => LocalPosition),
        ATTITUDE_DATA::ID => read!(ATTITUDE_DATA => Attitude),
        GLOBAL_POSITION_INT_DATA::ID => read!(GLOBAL_POSITION_INT_DATA => GlobalPosition),
        HEARTBEAT_ID => Ok(Inbound::Heartbeat(Heartbeat::read(payload))),
        EXTENDED_SYS_STATE_DATA::ID => read!(EXTENDED_SYS_STATE_DATA => ExtendedState),
        SYS_STATUS_DATA::ID => read!(SYS_STATUS_DATA => SystemStatus),
        GPS_RAW_INT_DATA::ID => read!(GPS_RAW_INT_DATA => Gnss),
        GPS2_RAW_DATA::ID => read!(GPS2_RAW_DATA => SecondGnss),
        ESTIMATOR_STATUS_DATA::ID => read!(ESTIMATOR_STATUS_DATA => Estimator),
        WIND_COV_DATA::ID => read!(WIND_COV_DATA => Wind),
        BATTERY_STATUS_DATA::ID => read!(BATTERY_STATUS_DATA => Battery),
        HOME_POSITION_DATA::ID => read!(HOME_POSITION_DATA => Home),
        COMMAND_ACK_ID => Ok(Inbound::Acknowledgement(acknowledgement(payload))),
        TIMESYNC_DATA::ID => read!(TIMESYNC_DATA => TimeSync),
        STATUSTEXT_DATA::ID => read!(STATUSTEXT_DATA => StatusText),
        PARAM_VALUE_DATA::ID => read!(PARAM_VALUE_DATA => ParameterValue),
        PARAM_ERROR_DATA::ID => read!(PARAM_ERROR_DATA => ParameterError),
        GPS_GLOBAL_ORIGIN_DATA::ID => read!(GPS_GLOBAL_ORIGIN_DATA => GlobalOrigin),
        AUTOPILOT_VERSION_DATA::ID => read!(AUTOPILOT_VERSION_DATA => AutopilotVersion),
        _ => return RouteMessage::read(message_id, payload).map(|message| Ok(Inbound::Route(message))),
    })
}

/// The heartbeat in a frame, if it is one.
#[must_use]
pub fn heartbeat(frame: &Frame<'_>) -> Option<Heartbeat> {
    (frame.header.message_id == HEARTBEAT_ID).then(|| Heartbeat::read(frame.payload))
}
