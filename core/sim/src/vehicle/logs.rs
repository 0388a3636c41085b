//! The logs on a vehicle's card, as PX4's log handler tells and sends them: numbered from 0, sent piece by piece until another request comes, and
//! nothing sent before they were listed.
//!
//! Must never do: be a real ULog behind its head; nobody here reads one.

use super::SimVehicle;
use super::channel::{Channel, Outbox};
use mavlink::dialects::common::{LOG_DATA_DATA, LOG_ENTRY_DATA, LOG_REQUEST_DATA_DATA};

/// What a ULog begins with.
const HEAD: [u8; 8] = [0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01];
/// Bytes of one message.
const PIECE: usize = 90;
/// Pieces that go out in one step: half a megabyte a second at 50 steps.
const PIECES_IN_STEP: usize = 40;
/// Size of the first log; each vehicle's are a little larger than those of the one before.
const SIZE_BYTES: u32 = 200_000;
/// How many logs there are.
const COUNT: u16 = 2;

/// What a channel sends of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sending {
    listed: bool,
    number: u16,
    next: u32,
    end: u32,
}

fn size_bytes(system_id: u8, number: u16) -> u32 {
    SIZE_BYTES / (u32::from(number) + 1) + 7 * u32::from(system_id)
}

fn byte(system_id: u8, number: u16, at: u32) -> u8 {
    let of_head = usize::try_from(at).ok().and_then(|at| HEAD.get(at));
    of_head
        .copied()
        .unwrap_or(((at ^ (at >> 8)).wrapping_mul(31) as u8) ^ system_id ^ number as u8)
}

impl SimVehicle {
    /// What is in one of its logs.
    #[must_use]
    pub fn log(system_id: u8, number: u16) -> Vec<u8> {
        (0..size_bytes(system_id, number))
            .map(|at| byte(system_id, number, at))
            .collect()
    }

    pub(super) fn list_logs(&self, channel: &mut Channel, out: &mut Outbox) {
        channel.log.listed = true;
        for id in 0..COUNT {
            channel.send(
                out,
                &LOG_ENTRY_DATA {
                    time_utc: (self.utc_us() / 1_000_000) as u32,
                    size: size_bytes(self.identity.system_id, id),
                    id,
                    num_logs: COUNT,
                    last_log_num: COUNT - 1,
                },
            );
        }
    }

    pub(super) fn begin_log(channel: &mut Channel, asked: &LOG_REQUEST_DATA_DATA) {
        if channel.log.listed && asked.id < COUNT {
            channel.log = Sending {
                listed: true,
                number: asked.id,
                next: asked.ofs,
                end: asked.ofs.saturating_add(asked.count),
            };
        }
    }

    /// Sends what is next of the log that was asked for.
    pub(super) fn send_log(&self, channel: &mut Channel, out: &mut Outbox) {
        let Sending { number, end, .. } = channel.log;
        let end = end.min(size_bytes(self.identity.system_id, number));
        for _ in 0..PIECES_IN_STEP {
            let ofs = channel.log.next;
            let count = end.saturating_sub(ofs).min(PIECE as u32);
            if count == 0 {
                return;
            }
            let mut data = [0; PIECE];
            for (at, place) in (ofs..ofs + count).zip(&mut data) {
                *place = byte(self.identity.system_id, number, at);
            }
            let count = count as u8;
            channel.send(
                out,
                &LOG_DATA_DATA {
                    ofs,
                    id: number,
                    count,
                    data,
                },
            );
            channel.log.next = ofs + u32::from(count);
        }
    }
}
