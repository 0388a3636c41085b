//! The recorder's thread: takes what comes off the queue, has it encoded, shown and written.
//!
//! Must never do: run on a thread that anything in flight waits for.

use crate::encoder::{Encoder, time_of_day_ns};
use crate::flights::Flights;
use crate::live::Live;
use crate::tapes::{Tapes, Told};
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime};
use skein_recording::{Encoded, FORMAT, Header, RecorderState, TimeBase};
use skein_runtime::NodeHandle;
use skein_state::{Taken, Writing};
use skein_view::{RecorderStatus, RecorderWord};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

/// What was taken is in the file after so long, in seconds: so much is lost at most when the program is killed.
const FLUSH_S: f64 = 0.8;
/// It is on the disk after so long, in seconds.
const SYNC_S: f64 = 1.0;

/// When the thread last went round, in microseconds of node time. One that stands is seen by this.
#[derive(Debug, Default)]
pub struct Progress {
    at_us: AtomicU64,
    ended: AtomicBool,
}

/// Says that the thread has ended, however it does.
pub struct Ending {
    progress: Arc<Progress>,
    _writing: Writing,
}

impl Ending {
    pub fn of(progress: Arc<Progress>, writing: Writing) -> Self {
        Self {
            progress,
            _writing: writing,
        }
    }
}

impl Drop for Ending {
    fn drop(&mut self) {
        self.progress.ended.store(true, Ordering::Release);
    }
}

impl Progress {
    pub fn at(&self) -> NodeTime {
        NodeTime(self.at_us.load(Ordering::Relaxed))
    }

    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    pub fn note(&self, now: NodeTime) {
        self.at_us.store(now.0, Ordering::Relaxed);
    }
}

/// All that the thread has.
pub struct Work {
    node: NodeHandle,
    encoder: Encoder,
    tapes: Option<Tapes>,
    live: Option<Live>,
    flights: Flights,
    flushed: NodeTime,
    synced: NodeTime,
    dropped: u64,
    status: RecorderStatus,
}

/// How node time is told from now on.
fn base(node: &NodeHandle) -> TimeBase {
    TimeBase {
        node: node.now(),
        unix_ns: time_of_day_ns(),
    }
}

impl Work {
    /// For this node.
    pub fn new(node: NodeHandle, tapes: Option<Tapes>, live: Option<Live>) -> Self {
        let now = node.now();
        let state = if tapes.is_some() {
            RecorderWord::Recording
        } else {
            RecorderWord::Off
        };
        let chain = tapes.as_ref().map(|tapes| tapes.last_chain(node.name()));
        Self {
            encoder: Encoder::new(node.clone(), base(&node), chain.unwrap_or_default()),
            dropped: node.tape().dropped(),
            node,
            tapes,
            live,
            flights: Flights::default(),
            flushed: now,
            synced: now,
            status: RecorderStatus {
                state,
                ..RecorderStatus::default()
            },
        }
    }

    /// Until nobody sends any more.
    pub fn run(mut self, queue: &Receiver<Taken>, progress: &Progress) {
        loop {
            let wait_s = FLUSH_S - self.node.now().seconds_since(self.flushed);
            let taken = queue.recv_timeout(Duration::from_secs_f64(wait_s.clamp(0.0, FLUSH_S)));
            match taken {
                Ok(taken) => self.take(taken),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let now = self.node.now();
            if now.seconds_since(self.flushed) >= FLUSH_S {
                self.flush(now);
            }
            progress.note(now);
        }
        let has_flown = self.flights.has_flown();
        self.end(has_flown);
    }

    fn take(&mut self, taken: Taken) {
        let now = self.node.now();
        if let Taken::Fleet(fleet) = &taken {
            let had_flown = self.flights.has_flown();
            let armed = fleet.vehicles.iter().any(|vehicle| vehicle.armed);
            if self.flights.see(now, armed) {
                self.end(had_flown);
            }
        }
        self.begin(now);
        let messages = self.encoder.encode(taken);
        self.put(&messages, now);
        let in_flight = self.flights.is_under_way(now);
        self.note(|status| status.in_flight = in_flight);
    }

    /// Tells screens what has changed.
    fn note(&mut self, change: impl FnOnce(&mut RecorderStatus)) {
        let before = self.status.clone();
        change(&mut self.status);
        if self.status != before {
            self.node.note_recorder(self.status.clone());
        }
    }

    /// Begins a file if there is to be one and there is none.
    fn begin(&mut self, now: NodeTime) {
        let Some(tapes) = self.tapes.as_mut().filter(|tapes| tapes.wants_file(now)) else {
            return;
        };
        let base = base(&self.node);
        let swarm = &self.node.config().swarm;
        let header = Header {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            node: swarm.id.as_ref().and(swarm.node).map(NodeId),
            name: self.node.name().to_owned(),
            swarm: swarm.id.clone().unwrap_or_default(),
            base,
        };
        let told = tapes.begin(header, now);
        let began = told.is_none() && !tapes.wants_file(now);
        self.tell(told);
        if began {
            let file = self.tapes.as_ref().and_then(Tapes::file);
            self.note(|status| {
                (status.state, status.file, status.why) = (RecorderWord::Recording, file, None);
            });
            let first = self.encoder.begin_file(base);
            self.put(&first, now);
        }
    }

    fn put(&mut self, messages: &[Encoded], now: NodeTime) {
        if let Some(live) = &mut self.live {
            for message in messages {
                live.show(message, self.encoder.base());
            }
        }
        let told = self.tapes.as_mut().and_then(|tapes| tapes.write(messages, now));
        self.tell(told);
    }

    fn flush(&mut self, now: NodeTime) {
        self.begin(now);
        self.flushed = now;
        let sync = now.seconds_since(self.synced) >= SYNC_S;
        if sync {
            self.synced = now;
            let state = self.state(now);
            let messages = self.encoder.recorder(&state);
            self.put(&messages, now);
        }
        let told = self.tapes.as_mut().and_then(|tapes| tapes.flush(sync, now));
        self.tell(told);
    }

    fn state(&mut self, now: NodeTime) -> RecorderState {
        let dropped = self.node.tape().dropped();
        let newly = dropped.saturating_sub(std::mem::replace(&mut self.dropped, dropped));
        if newly > 0 {
            let text = format!("{newly} messages were not recorded: the disk did not take them in time");
            self.node.tell_of_recorder(Severity::Advisory, text);
        }
        RecorderState {
            time: now,
            bytes: self.tapes.as_ref().map_or(0, Tapes::bytes),
            dropped,
        }
    }

    fn end(&mut self, has_flown: bool) {
        let file = self.tapes.as_ref().and_then(Tapes::file);
        let ended = self.tapes.as_mut().map_or(Ok(()), |tapes| tapes.end(has_flown));
        if let Err(error) = ended {
            let text = format!("the recording of this flight was not finished: {error}; it can be read all the same");
            self.node.tell_of_recorder(Severity::Advisory, text);
        }
        self.note(|status| {
            status.file = None;
            if has_flown && file.is_some() {
                status.last_flight = file;
            }
        });
    }

    fn tell(&mut self, told: Option<Told>) {
        match told {
            None => {}
            Some(Told::Interrupted(why)) => {
                let text = format!("flights are not recorded: {why}; it is tried again every second");
                self.node.tell_of_recorder(Severity::Warning, text);
                self.note(|status| {
                    (status.state, status.file, status.why) = (RecorderWord::Interrupted, None, Some(why));
                });
            }
            Some(Told::GoesOn(lost)) => {
                let text = format!("flights are recorded again; {lost} messages were lost");
                self.node.tell_of_recorder(Severity::Advisory, text);
                self.note(|status| (status.state, status.why) = (RecorderWord::Recording, None));
            }
        }
    }
}
