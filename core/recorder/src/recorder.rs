//! The recorder actor: hands its thread what the node shows and tells, looks whether that thread still goes round. [`ended`]
//! waits for it a moment when the node has stopped.
//!
//! Bound: the queue to the thread holds [`QUEUE`] messages; more are dropped and counted. Must never do: write a file.

use crate::encoder::FLYING_HZ;
use crate::finishing;
use crate::folder::Keep;
use crate::live::Live;
use crate::tapes::Tapes;
use crate::thread::{Ending, Progress, Work};
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::exchange::Severity;
use skein_runtime::{Adapter, NodeHandle};
use skein_state::Taken;
use skein_view::{RecorderStatus, RecorderWord};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::MissedTickBehavior;

/// Ten seconds of a hundred vehicles.
const QUEUE: usize = 16_384;
/// A thread that has not gone round for so long waits for the disk, in seconds.
const STALLED_S: f64 = 3.0;
/// A node that has stopped waits for its recording so long: no longer than that for a disk that does not answer.
const END_WITHIN: Duration = Duration::from_secs(3);
/// Why nothing is recorded while the thread stands.
const SILENT: &str = "the disk does not answer";

/// The actor.
pub struct Recorder;

/// The thread has ended; that is always a failure.
pub struct Ended;

/// State.
pub struct RecorderState {
    node: NodeHandle,
    thread: Option<JoinHandle<()>>,
    tasks: Vec<tokio::task::JoinHandle<()>>,
}

impl Drop for RecorderState {
    /// Whoever stops the node kills its actors: this is where the thread is told to end the file.
    fn drop(&mut self) {
        end(&self.node);
        for task in &self.tasks {
            task.abort();
        }
    }
}

/// Hands over the last that is to be recorded: how the vehicles stand, if that was not seen before. They may have been disarmed just now.
fn end(node: &NodeHandle) {
    node.tape().take(|| Taken::Fleet(node.snapshot()));
    node.tape().end();
}

impl Actor for Recorder {
    type Msg = Ended;
    type State = RecorderState;
    type Arguments = NodeHandle;

    async fn pre_start(&self, myself: ActorRef<Ended>, node: NodeHandle) -> Result<RecorderState, ActorProcessingErr> {
        let settings = node.config().recorder.clone();
        let live = match settings.foxglove {
            Some(address) => {
                let runtime = tokio::runtime::Handle::current();
                let listening = Live::listen(address, node.name(), &runtime).await;
                Some(listening.map_err(|error| format!("recorder.foxglove: cannot listen on {address}: {error}"))?)
            }
            None => None,
        };
        let (queue, taken) = sync_channel(QUEUE);
        node.tape().begin(queue, settings.everything);
        let progress = Arc::new(Progress::default());
        progress.note(node.now());
        let folder = settings.folder.filter(|_| settings.enabled);
        let keep = Keep {
            bytes: settings.keep_mb << 20,
            age: Duration::from_secs_f64(settings.keep_days * 86_400.0),
        };
        let thread = {
            let ending = Ending::of(progress.clone(), node.tape().writing());
            let (node, progress) = (node.clone(), progress.clone());
            std::thread::Builder::new().name("recorder".into()).spawn(move || {
                let _ending = ending;
                if let Some(folder) = folder.clone() {
                    finish_beside(folder);
                }
                let tapes = folder.map(|folder| Tapes::new(folder, keep));
                Work::new(node, tapes, live).run(&taken, &progress);
            })?
        };
        let tasks = vec![
            tokio::spawn(tell_events(node.clone())),
            tokio::spawn(look(node.clone(), progress, myself)),
        ];
        Ok(RecorderState {
            node,
            thread: Some(thread),
            tasks,
        })
    }

    async fn handle(&self, _: ActorRef<Ended>, _: Ended, state: &mut RecorderState) -> Result<(), ActorProcessingErr> {
        let panicked = state.thread.take().is_some_and(|thread| thread.join().is_err());
        let how = if panicked { "panicked" } else { "ended" };
        Err(format!("the recorder's thread {how}").into())
    }
}

/// Recordings of earlier runs that were cut off are finished meanwhile.
fn finish_beside(folder: PathBuf) {
    let started = std::thread::Builder::new()
        .name("finishing".into())
        .spawn(move || finishing::finish_all(&folder));
    if let Err(error) = started {
        tracing::warn!("earlier recordings are left as they were cut off: {error}");
    }
}

/// What happens, as it is told.
async fn tell_events(node: NodeHandle) {
    let mut events = node.subscribe();
    let mut last = 0;
    for event in node.events_after(0) {
        last = last.max(event.seq);
        node.tape().take(|| Taken::Event(event));
    }
    loop {
        match events.recv().await {
            Ok(event) if event.seq > last => node.tape().take(|| Taken::Event(event)),
            Ok(_) => {}
            Err(RecvError::Lagged(missed)) => node.tape().note_dropped(missed),
            Err(RecvError::Closed) => return,
        }
    }
}

/// The fleet as screens see it, again and again; and whether the thread still takes it.
async fn look(node: NodeHandle, progress: Arc<Progress>, myself: ActorRef<Ended>) {
    let rate_hz = if node.config().recorder.everything {
        node.config().node.snapshot_rate_hz
    } else {
        // Twice as often as it is recorded, so that what is recorded is hardly older than that.
        2.0 * FLYING_HZ
    };
    let mut interval = tokio::time::interval(Duration::from_secs_f64(1.0 / rate_hz));
    interval.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let (mut sequence, mut stalled) = (0, false);
    loop {
        interval.tick().await;
        let fleet = node.snapshot();
        if fleet.sequence != sequence {
            sequence = fleet.sequence;
            node.tape().take(|| Taken::Fleet(fleet));
        }
        let stands = node.now().seconds_since(progress.at()) > STALLED_S;
        if stands && !stalled {
            let text = "flights are not recorded: the disk does not answer; what it does not take is dropped";
            node.tell_of_recorder(Severity::Warning, text);
            note_silent(&node, RecorderWord::Interrupted, Some(SILENT.to_owned()));
        }
        if stalled && !stands {
            note_silent(&node, RecorderWord::Recording, None);
            node.tell_of_recorder(Severity::Advisory, "flights are recorded again: the disk answers");
        }
        stalled = stands;
        if progress.has_ended() {
            // An actor that is gone needs no word of it.
            let _ = myself.cast(Ended);
            return;
        }
    }
}

/// The thread cannot say of itself that it stands.
fn note_silent(node: &NodeHandle, state: RecorderWord, why: Option<String>) {
    let before = node.recorder();
    if before.state == RecorderWord::Recording || before.why.as_deref() == Some(SILENT) {
        node.note_recorder(RecorderStatus {
            state,
            why,
            ..before.as_ref().clone()
        });
    }
}

/// Waits until the recording of a node that has stopped is ended. What the disk does not take in time can be read all the same.
pub async fn ended(node: &NodeHandle) {
    // The actor may not have been dropped yet.
    end(node);
    let waiting = async {
        while node.tape().is_being_written() {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    if tokio::time::timeout(END_WITHIN, waiting).await.is_err() {
        tracing::warn!("the recording was not ended in time");
    }
}

/// It as a part of the node; `None` where nothing is to be recorded or shown.
#[must_use]
pub fn adapter(settings: &skein_config::RecorderSettings) -> Option<Adapter> {
    let records = settings.enabled && settings.folder.is_some();
    if !records && settings.foxglove.is_none() {
        return None;
    }
    Some(Adapter {
        name: "recorder".into(),
        start: Arc::new(move |node, supervisor| {
            Box::pin(async move {
                let spawned = Recorder::spawn_linked(None, Recorder, node, supervisor).await;
                spawned.map(|(actor, _)| actor.get_id()).map_err(|e| e.to_string())
            })
        }),
    })
}
