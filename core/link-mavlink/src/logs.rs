//! Logs that an autopilot keeps on its own card, listed and fetched over its link (MAVLink: LOG_REQUEST_LIST, LOG_REQUEST_DATA).
//!
//! Must never do: erase a log, or ask for one while the vehicle is armed: that is for the caller to see to.

mod tap;
mod transfer;

use mavlink::dialects::common::{LOG_REQUEST_DATA_DATA, LOG_REQUEST_END_DATA, LOG_REQUEST_LIST_DATA};
use mavlink::{MavlinkVersion, MessageData};
use skein_domain::link::VehicleLink;
use skein_domain::payload::MavlinkMessage;
use skein_domain::{AutopilotLog, Clock, Refusal};
use std::sync::Arc;
use std::time::Duration;
use tap::{Heard, Tap};
use transfer::{Asked, Listing, Transfer};

use crate::vehicle::AUTOPILOT_COMPONENT;

/// What is due is looked for so often.
const STEP: Duration = Duration::from_millis(20);

/// The logs of one vehicle. One at a time: an autopilot sends one log to one client.
pub struct Logs {
    link: Arc<dyn VehicleLink>,
    clock: Arc<dyn Clock>,
    tap: Arc<Tap>,
}

impl Logs {
    /// Over this link.
    #[must_use]
    pub fn of(link: Arc<dyn VehicleLink>, clock: Arc<dyn Clock>) -> Self {
        let tap = Arc::new(Tap::default());
        let seen: Arc<dyn skein_domain::link::MessageTap> = tap.clone();
        link.tap(Arc::downgrade(&seen));
        Self { link, clock, tap }
    }

    /// Which there are.
    ///
    /// # Errors
    /// When the link is lost or carries no MAVLink, or the autopilot does not answer.
    pub async fn list(&self) -> Result<Vec<AutopilotLog>, Refusal> {
        let mut listing = Listing::default();
        loop {
            for heard in self.tap.take() {
                if let Heard::Entry(entry) = heard {
                    listing.on_entry(&entry);
                }
            }
            if let Some(logs) = listing.whole() {
                return Ok(logs);
            }
            match listing.poll(self.clock.now()) {
                Asked::Nothing => {}
                Asked::GiveUp => {
                    return Err(Refusal::timed_out(
                        "the list of the autopilot's logs",
                        listing.waited_s(),
                    ));
                }
                Asked::Range { .. } => self.send(&LOG_REQUEST_LIST_DATA {
                    start: 0,
                    end: u16::MAX,
                    target_system: self.target(),
                    target_component: AUTOPILOT_COMPONENT,
                })?,
            }
            tokio::time::sleep(STEP).await;
        }
    }

    /// Fetches one. `take` is given its bytes in order, and says why to end, if so.
    ///
    /// # Errors
    /// When the link is lost, the autopilot sends nothing any more, or `take` ends it.
    pub async fn fetch(
        &self,
        log: AutopilotLog,
        mut take: impl FnMut(&[u8]) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let fetched = self.fetch_all(log, &mut take).await;
        // It would go on sending what nobody takes. What does not reach it now ends by itself.
        let _ = self.send(&LOG_REQUEST_END_DATA {
            target_system: self.target(),
            target_component: AUTOPILOT_COMPONENT,
        });
        fetched
    }

    async fn fetch_all(
        &self,
        log: AutopilotLog,
        take: &mut impl FnMut(&[u8]) -> Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        let mut transfer = Transfer::of(log);
        while !transfer.is_whole() {
            for heard in self.tap.take() {
                if let Heard::Data(data) = heard {
                    transfer.on_data(self.clock.now(), &data);
                }
            }
            // Also when nothing has come: whoever takes it may want to end it.
            take(&transfer.take_ready())?;
            match transfer.poll(self.clock.now()) {
                Asked::Nothing => {}
                Asked::GiveUp => return Err(Refusal::timed_out("a part of the log", transfer.waited_s())),
                Asked::Range { offset, count } => self.send(&LOG_REQUEST_DATA_DATA {
                    ofs: offset,
                    count,
                    id: log.number,
                    target_system: self.target(),
                    target_component: AUTOPILOT_COMPONENT,
                })?,
            }
            tokio::time::sleep(STEP).await;
        }
        Ok(())
    }

    fn target(&self) -> u8 {
        self.link.system_id().0
    }

    fn send<M: MessageData>(&self, message: &M) -> Result<(), Refusal> {
        let mut payload = [0; 255];
        let length = message.ser(MavlinkVersion::V2, &mut payload);
        let message = MavlinkMessage {
            message_id: M::ID,
            payload: payload.get(..length).unwrap_or_default().to_vec(),
            ..MavlinkMessage::default()
        };
        self.link.send_payload(self.clock.now(), &message)
    }
}
