//! The thread that hands on what arrives.
//!
//! Must never do: look into what is sealed; end while the transport is there.

use crate::LARGEST_BYTES;
use crate::packet::Packet;
use rustdds::no_key::SimpleDataReader;
use skein_bus::arrivals::{Arrivals, MOST_WAITING};
use skein_bus::transport::Class;
use skein_domain::NodeId;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Wake, Waker};
use std::thread::{JoinHandle, Thread};
use std::time::Duration;

pub(crate) type Reader = SimpleDataReader<Packet>;

/// It looks so often though nobody wakes it: RustDDS may drop a notice when very many come at once.
const LOOKS_EVERY: Duration = Duration::from_millis(100);

/// Ends its thread when dropped.
pub(crate) struct Reading {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

struct Unparks(Thread);

impl Wake for Unparks {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

impl Reading {
    /// Begins to hand on what these readers take.
    pub(crate) fn begin(readers: Vec<(Class, Reader)>, me: NodeId, arrivals: Arc<Arrivals>) -> io::Result<Self> {
        let ends = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ends);
        let thread = std::thread::Builder::new().name(format!("dds of {me}"));
        let thread = thread.spawn(move || {
            let waker = Waker::from(Arc::new(Unparks(std::thread::current())));
            while !told.load(Ordering::Acquire) {
                for (class, reader) in &readers {
                    // In this order nothing that comes meanwhile is missed: the waker is there before it is looked.
                    reader.set_waker(Some(waker.clone()));
                    reader.drain_read_notifications();
                    take_all(reader, *class, me, &arrivals);
                }
                std::thread::park_timeout(LOOKS_EVERY);
            }
        })?;
        Ok(Self {
            ends,
            thread: Some(thread),
        })
    }

    /// Whether the thread is there.
    pub(crate) fn goes_on(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

impl Drop for Reading {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It ended by a panic of RustDDS, or as it should: either way it is gone.
            let _gone = thread.join();
        }
    }
}

fn take_all(reader: &Reader, class: Class, me: NodeId, arrivals: &Arrivals) {
    // Bounded, so that a flood of one class does not hold up the others.
    for _ in 0..MOST_WAITING {
        match reader.try_take_one() {
            Ok(Some(sample)) => {
                let packet = sample.into_value().for_node(me);
                if let Some((from, bytes)) = packet.filter(|(_, bytes)| bytes.len() <= LARGEST_BYTES) {
                    arrivals.put(from, class, bytes);
                }
            }
            Ok(None) => return,
            // A stranger's sample that is none.
            Err(_) => {}
        }
    }
}
