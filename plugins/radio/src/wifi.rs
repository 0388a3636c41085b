//! The computer's Wi-Fi, asked on a thread of its own: the kernel may take its time.

mod interface;
mod netlink;

use crate::link::Figures;
use skein_domain::{CommandId, Refusal};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// How many commands and how much news may wait.
const QUEUE_LEN: usize = 8;
/// How long the end of the thread is waited for.
const END_WAIT: Duration = Duration::from_millis(250);

/// What the thread tells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WifiReport {
    /// What was measured.
    Figures(Box<Figures>),
    /// Why nothing was.
    Fault(String),
    /// How a change ended.
    Changed(CommandId, Result<(), Refusal>),
}

/// A change of settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    /// To the channel with this middle, in megahertz.
    Frequency(u32),
    /// To this power, in hundredths of a decibel over a milliwatt.
    Power(u32),
}

impl Change {
    /// To a channel by its number; `None` if there is none of that number.
    pub(crate) fn channel(channel: u32) -> Option<Self> {
        let mhz = match channel {
            1..=13 => 2407 + 5 * channel,
            14 => 2484,
            32..=177 => 5000 + 5 * channel,
            _ => return None,
        };
        Some(Self::Frequency(mhz))
    }

    /// To a power above zero.
    pub(crate) fn power(power_dbm: f64) -> Self {
        Self::Power((power_dbm * 100.0).round().max(0.0) as u32)
    }
}

/// The channel with this middle.
pub(crate) fn channel_of(mhz: u32) -> Option<u32> {
    match mhz {
        2484 => Some(14),
        2412..=2472 => Some((mhz - 2407) / 5),
        5160..=5885 => Some((mhz - 5000) / 5),
        5955..=7115 => Some((mhz - 5950) / 5),
        _ => None,
    }
}

/// Asks the kernel again and again, on its own thread.
#[derive(Debug)]
pub(crate) struct Wifi {
    commands: Option<SyncSender<(CommandId, Change)>>,
    told: Receiver<WifiReport>,
    ended: Receiver<()>,
}

impl Wifi {
    pub(crate) fn start(interface: &str, poll_hz: f64) -> std::io::Result<Self> {
        let (commands, orders) = sync_channel(QUEUE_LEN);
        let (tell, told) = sync_channel(QUEUE_LEN);
        let (end, ended) = sync_channel(0);
        let (interface, pause) = (interface.to_owned(), Duration::from_secs_f64(1.0 / poll_hz));
        std::thread::Builder::new()
            .name("skein-wifi".to_owned())
            .spawn(move || {
                watch(&interface, pause, &orders, &tell);
                // Its disconnection is the message.
                drop(end);
            })?;
        Ok(Self {
            commands: Some(commands),
            told,
            ended,
        })
    }

    /// What was told since, oldest first.
    pub(crate) fn take(&self) -> Option<WifiReport> {
        self.told.try_recv().ok()
    }

    /// Asks for a change. False if too many wait.
    pub(crate) fn tell(&self, id: CommandId, change: Change) -> bool {
        self.commands
            .as_ref()
            .is_some_and(|commands| commands.try_send((id, change)).is_ok())
    }
}

impl Drop for Wifi {
    fn drop(&mut self) {
        // The thread waits for commands between two measurements, and ends when there is nobody to give any.
        self.commands = None;
        let _ = self.ended.recv_timeout(END_WAIT);
    }
}

/// Measures until nobody wants to know.
fn watch(interface: &str, pause: Duration, orders: &Receiver<(CommandId, Change)>, tell: &SyncSender<WifiReport>) {
    let mut station = interface::Station::default();
    loop {
        let news = match station.measure(interface) {
            Ok(figures) => WifiReport::Figures(Box::new(figures)),
            Err(error) => WifiReport::Fault(error.to_string()),
        };
        // What nobody takes is out of date.
        let _ = tell.try_send(news);
        match orders.recv_timeout(pause) {
            Ok((id, change)) => {
                let outcome = station.change(interface, change).map_err(|error| error.refusal());
                if tell.send(WifiReport::Changed(id, outcome)).is_err() {
                    return;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

#[cfg(test)]
mod tests;
