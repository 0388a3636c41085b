//! Where a transport keeps what has arrived until it is fetched: bounded per class, the most urgent first.
//!
//! Must never do: grow beyond its bounds, or let one class take another's room.

use crate::transport::{CLASSES, Class, Datagram, Wake};
use parking_lot::Mutex;
use skein_domain::NodeId;
use std::collections::VecDeque;

/// So many datagrams of one class wait; of more the oldest is dropped: for state it is the least worth, and the others are asked again.
pub const MOST_WAITING: usize = 1024;

#[derive(Default)]
struct Waiting {
    of_class: [VecDeque<Datagram>; CLASSES.len()],
    overflowed: u64,
    wake: Option<Wake>,
}

/// Datagrams that have arrived. Shared between whoever brings them and the transport that hands them out.
#[derive(Default)]
pub struct Arrivals(Mutex<Waiting>);

impl std::fmt::Debug for Arrivals {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Arrivals").finish_non_exhaustive()
    }
}

impl Arrivals {
    /// Puts a datagram there and wakes who waits for it.
    pub fn put(&self, from: NodeId, class: Class, bytes: Vec<u8>) {
        let wake = {
            let mut waiting = self.0.lock();
            if let Some(queue) = waiting.of_class.get_mut(class as usize) {
                queue.push_back(Datagram { from, class, bytes });
                if queue.len() > MOST_WAITING {
                    queue.pop_front();
                    waiting.overflowed += 1;
                }
            }
            waiting.wake.clone()
        };
        if let Some(wake) = wake {
            wake();
        }
    }

    /// The oldest of the most urgent class that has one.
    pub fn next(&self) -> Option<Datagram> {
        self.0.lock().of_class.iter_mut().find_map(VecDeque::pop_front)
    }

    /// Whom to wake from now on.
    pub fn wake_on(&self, wake: Wake) {
        self.0.lock().wake = Some(wake);
    }

    /// How many were dropped.
    pub fn overflowed(&self) -> u64 {
        self.0.lock().overflowed
    }
}

#[cfg(test)]
mod tests;
