//! The emergency stop: the forced disarm, sent at once, ahead of every other command, and again and again until the autopilot has
//! acknowledged it and shows disarmed motors.
//!
//! Must never do: be started by anything but its own request, or go on once it has ended. It does not wait for the link to be
//! there: a vehicle that is not heard may hear. Of two vehicles with one system id neither is stopped: nobody can tell which would be.

use crate::acknowledgement::Acknowledgement;
use crate::plan::Command;
use crate::status_text::StatusTexts;
use mavlink::dialects::common::MavCmd;
use skein_domain::{NodeTime, Refusal, RequestId};

/// `MAV_CMD_COMPONENT_ARM_DISARM`.
pub const ARM_DISARM: u16 = 400;
/// Parameter 2 that makes it happen in flight as well.
const FORCE: f32 = 21_196.0;
/// Pause between two sendings until it is acknowledged, and from then on until it is seen, in seconds.
const PERIOD_S: f64 = 0.05;
const PERIOD_ACKNOWLEDGED_S: f64 = 0.25;
/// A heartbeat that comes earlier than this after the first sending may have been sent before that arrived, in seconds.
const SETTLE_S: f64 = 0.2;
/// How long it is tried, in seconds.
pub const TRY_FOR_S: f64 = 10.0;
/// Motors that are not seen stopped this long after the first sending are told, in seconds.
const CONFIRM_WITHIN_S: f64 = 1.0;
/// Late answers must not be taken for those of a later command of this number, in seconds.
const REST_S: f64 = 0.5;

/// One emergency stop under way: what is to be sent when, and when it has ended. The same on any link.
#[derive(Debug)]
pub struct EmergencyStop {
    request: RequestId,
    first: NodeTime,
    next: NodeTime,
    sent: u8,
    acknowledged: bool,
    /// It has been told that it takes long.
    told: bool,
    /// What the autopilot said against it last.
    refused: Option<String>,
}

/// What an emergency stop wants now.
#[derive(Debug, Clone, PartialEq)]
pub enum Urgent {
    /// Nothing yet.
    Wait,
    /// This is to be sent, which was sent so often before.
    Send(Command, u8),
    /// It has been tried for so long, in seconds, that somebody has to know; it goes on.
    Unconfirmed(f64),
    /// It has been tried for long enough.
    Over(Refusal),
}

impl EmergencyStop {
    /// One that begins now.
    #[must_use]
    pub fn new(request: RequestId, now: NodeTime) -> Self {
        Self {
            request,
            first: now,
            next: now,
            sent: 0,
            acknowledged: false,
            told: false,
            refused: None,
        }
    }

    /// Who asked.
    #[must_use]
    pub fn request(&self) -> RequestId {
        self.request
    }

    /// When there is something to do next.
    #[must_use]
    pub fn due(&self) -> NodeTime {
        self.next
    }

    /// What it wants now.
    pub fn poll(&mut self, now: NodeTime, texts: &StatusTexts) -> Urgent {
        let after_s = now.seconds_since(self.first);
        if after_s >= TRY_FOR_S {
            return Urgent::Over(match self.refused.take().filter(|_| !self.acknowledged) {
                Some(result) => Refusal::Autopilot {
                    result,
                    text: texts.between(self.first, now),
                },
                None => Refusal::timed_out("motors that have stopped", after_s),
            });
        }
        if after_s >= CONFIRM_WITHIN_S && !std::mem::replace(&mut self.told, true) {
            return Urgent::Unconfirmed(after_s);
        }
        if now < self.next {
            return Urgent::Wait;
        }
        let command = Command::long(
            MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            [0.0, FORCE, 0.0, 0.0, 0.0, 0.0, 0.0],
        );
        let before = self.sent;
        self.sent = self.sent.saturating_add(1);
        self.next = now.plus_seconds(if self.acknowledged {
            PERIOD_ACKNOWLEDGED_S
        } else {
            PERIOD_S
        });
        Urgent::Send(command, before)
    }

    /// An acknowledgement; true if it is this one's. An accepted one may still be that of a command of the same number which was
    /// under way before, so that the motors have to be seen stopped as well.
    pub fn acknowledge(&mut self, ack: &Acknowledgement) -> bool {
        if ack.command != ARM_DISARM {
            return false;
        }
        match ack.result {
            Acknowledgement::ACCEPTED => self.acknowledged = true,
            Acknowledgement::IN_PROGRESS => {}
            _ => self.refused = Some(ack.result_word()),
        }
        true
    }

    /// Whether disarmed motors that are seen now are its doing: what was on the way when it was first sent tells nothing.
    #[must_use]
    pub fn is_settled(&self, now: NodeTime, round_trip_s: f64) -> bool {
        now.seconds_since(self.first) >= SETTLE_S.max(2.0 * round_trip_s)
    }

    /// Until when late answers may come, which must not be taken for those of a later command of its number.
    #[must_use]
    pub fn rests_until(now: NodeTime) -> NodeTime {
        now.plus_seconds(REST_S)
    }
}
