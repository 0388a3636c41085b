//! A replay, for whoever shows and steers it.
//!
//! Must never do: let its thread go on when nobody has it any more.

use crate::position::Position;
use crate::stage::{self, Order, Stage};
use crate::state::{RATES, ReplayChange, ReplayState};
use crate::timeline::{Index, Timeline};
use skein_domain::NodeTime;
use skein_recording::{ReadError, Recording};
use skein_runtime::{NodeHandle, WiringError};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, OnceLock};
use thiserror::Error;
use tokio::sync::{oneshot, watch};

/// Why there is no replay, or it did not do what was asked of it.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// The file is no recording, or cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Nothing was recorded in it.
    #[error("{}: nothing was recorded in it", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// No node could be made to show it.
    #[error(transparent)]
    Node(#[from] WiringError),
    /// The computer has no thread for it.
    #[error("no thread for it")]
    Thread(#[from] std::io::Error),
    /// It is over: its thread has ended.
    #[error("this replay has ended")]
    Ended,
}

/// A recorded flight that is shown again.
pub struct Replay {
    node: NodeHandle,
    state: watch::Receiver<ReplayState>,
    orders: Sender<Order>,
    index: Arc<OnceLock<Index>>,
}

impl Replay {
    /// Opens a recording and stands at its beginning.
    ///
    /// # Errors
    /// When it is none, is empty, or there is no thread for it.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let recording = Recording::open(path)?;
        let (begin, end) = recording.span();
        if end <= begin {
            return Err(ReplayError::Empty { path: path.to_owned() });
        }
        let position = Arc::new(Position::default());
        position.set(begin);
        let node = NodeHandle::of_recording(&recording.header().name, position.clone())?;
        let (sender, state) = watch::channel(state_of(&recording, begin, end));
        let index: Arc<OnceLock<Index>> = Arc::default();
        let (orders, taken) = channel();
        go_through(path.to_owned(), Arc::downgrade(&index))?;
        let stage = Stage {
            node: node.clone(),
            position,
            state: sender,
            index: index.clone(),
            sequence: 0,
        };
        std::thread::Builder::new()
            .name("replay".into())
            .spawn(move || stage::run(&recording, stage, &taken))?;
        Ok(Self {
            node,
            state,
            orders,
            index,
        })
    }

    /// The node that shows it.
    #[must_use]
    pub fn node(&self) -> &NodeHandle {
        &self.node
    }

    /// Where it is.
    #[must_use]
    pub fn state(&self) -> ReplayState {
        self.state.borrow().clone()
    }

    /// Tells of every step.
    #[must_use]
    pub fn watch(&self) -> watch::Receiver<ReplayState> {
        self.state.clone()
    }

    /// What happened in it, once it has been gone through.
    #[must_use]
    pub fn timeline(&self) -> Timeline {
        self.index
            .get()
            .map_or_else(Timeline::default, |index| index.timeline.clone())
    }

    /// Has it do something, and waits until it is done. A pace beyond what there is becomes the nearest one.
    ///
    /// # Errors
    /// When its thread has ended.
    pub async fn change(&self, change: ReplayChange) -> Result<ReplayState, ReplayError> {
        let change = ReplayChange {
            rate: change.rate.map(|rate| rate.clamp(*RATES.start(), *RATES.end())),
            ..change
        };
        let (done, is_done) = oneshot::channel();
        self.orders
            .send(Order { change, done })
            .map_err(|_| ReplayError::Ended)?;
        is_done.await.map_err(|_| ReplayError::Ended)
    }
}

fn state_of(recording: &Recording, begin: NodeTime, end: NodeTime) -> ReplayState {
    let file = recording.path().file_name().unwrap_or_default();
    ReplayState {
        file: file.to_string_lossy().into_owned(),
        node: recording.header().name.clone(),
        begun_unix_s: recording.header().base.unix_ns(begin) as f64 * 1e-9,
        begin,
        duration_s: end.seconds_since(begin),
        position_s: 0.0,
        rate: 1.0,
        playing: false,
        jumps: 0,
        finished: recording.is_finished(),
        indexed: false,
    }
}

/// Goes through the recording beside its replay, so that it can be looked at meanwhile.
fn go_through(path: PathBuf, index: std::sync::Weak<OnceLock<Index>>) -> Result<(), ReplayError> {
    let work = move || match Recording::open(&path) {
        Ok(recording) => {
            let made = Index::of(&recording);
            if let Some(index) = index.upgrade() {
                // It is made once.
                let _ = index.set(made);
            }
        }
        Err(error) => tracing::warn!("the timeline of a replay is missing: {error}"),
    };
    std::thread::Builder::new().name("timeline".into()).spawn(work)?;
    Ok(())
}
