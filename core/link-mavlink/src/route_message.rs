//! The messages of the mission protocol that are read here.
//!
//! Must never do: take a plan of another kind for a route.

use crate::fields::Fields;

/// A message of the mission protocol that is read here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouteMessage {
    /// MISSION_REQUEST_INT or MISSION_REQUEST.
    Request {
        /// The item it wants.
        item: u16,
        /// Whom it asks.
        target: (u8, u8),
    },
    /// MISSION_ACK.
    Acknowledgement {
        /// `MAV_MISSION_RESULT`.
        result: u8,
        /// Whom it answers.
        target: (u8, u8),
    },
    /// MISSION_ITEM_REACHED.
    Reached {
        /// The item.
        item: u16,
    },
}

impl RouteMessage {
    /// What a payload says; `None` for other messages, and for plans of other kinds than routes.
    pub(crate) fn read(message_id: u32, payload: &[u8]) -> Option<Self> {
        const ROUTE: u8 = 0;
        let fields = Fields(payload);
        match message_id {
            40 | 51 if fields.u8(4) == ROUTE => Some(Self::Request {
                item: fields.u16(0),
                target: (fields.u8(2), fields.u8(3)),
            }),
            47 if fields.u8(3) == ROUTE => Some(Self::Acknowledgement {
                target: (fields.u8(0), fields.u8(1)),
                result: fields.u8(2),
            }),
            46 => Some(Self::Reached { item: fields.u16(0) }),
            _ => None,
        }
    }
}
