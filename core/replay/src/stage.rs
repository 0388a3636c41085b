//! The thread of a replay: goes through the recording at its pace, and shows each moment on the node that stands for it.
//!
//! Must never do: skip what was recorded because this computer stood still for a moment.

use crate::player::{Player, Step};
use crate::position::Position;
use crate::state::{ReplayChange, ReplayState};
use crate::timeline::Index;
use skein_domain::NodeTime;
use skein_recording::Recording;
use skein_recording::decisions::GateState;
use skein_runtime::NodeHandle;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// A moment is shown so often while it goes on, and orders are looked for so often.
const STEP: Duration = Duration::from_millis(50);
/// A step is no longer than this, in seconds: who stood still for longer goes on from where he was.
const LONGEST_STEP_S: f64 = 0.25;

/// What is asked of the thread, and whom it answers.
pub(crate) struct Order {
    pub change: ReplayChange,
    pub done: oneshot::Sender<ReplayState>,
}

/// What the thread works on.
pub(crate) struct Stage {
    pub node: NodeHandle,
    pub position: Arc<Position>,
    pub state: watch::Sender<ReplayState>,
    pub index: Arc<OnceLock<Index>>,
    pub sequence: u64,
}

/// Goes on until nobody can ask any more.
pub(crate) fn run(recording: &Recording, mut stage: Stage, orders: &Receiver<Order>) {
    let mut at = recording.span().0;
    let mut answer = None;
    loop {
        let player = Player::at(recording, at);
        stage.enter(&player, at);
        if let Some(done) = answer.take() {
            stage.answer(done);
        }
        match stage.play(player, at, recording.span().1, orders) {
            Some((to, done)) => (at, answer) = (to, done),
            None => return,
        }
    }
}

impl Stage {
    /// Shows another moment than the one after the last.
    fn enter(&mut self, player: &Player<'_>, at: NodeTime) {
        if let Some(index) = self.index.get() {
            self.node.show_events(index.events_until(at));
            if let Some(gate) = index.gate_at(at) {
                self.gate(gate);
            }
        } else {
            self.node.show_events([]);
        }
        self.show(player, at);
        let indexed = self.index.get().is_some();
        self.state.send_modify(|state| {
            state.jumps += 1;
            state.indexed = indexed;
        });
    }

    fn gate(&self, gate: &GateState) {
        match gate.gate() {
            Ok(made) => self.node.show_gate(made, gate.fences.clone()),
            Err(error) => tracing::debug!("fences of a recording are not shown: {error}"),
        }
    }

    fn show(&mut self, player: &Player<'_>, at: NodeTime) {
        self.sequence += 1;
        self.position.set(at);
        self.node.show(player.fleet(at, self.sequence));
        self.state
            .send_modify(|state| state.position_s = at.seconds_since(state.begin));
    }

    fn answer(&self, done: oneshot::Sender<ReplayState>) {
        // Who has gone wants no answer.
        let _ = done.send(self.state.borrow().clone());
    }

    /// From a moment on. Where to go, and whom to tell then; nothing if nobody can ask any more.
    fn play(
        &mut self,
        mut player: Player<'_>,
        mut at: NodeTime,
        end: NodeTime,
        orders: &Receiver<Order>,
    ) -> Option<(NodeTime, Option<oneshot::Sender<ReplayState>>)> {
        let mut last = Instant::now();
        loop {
            match orders.recv_timeout(STEP) {
                Ok(Order { change, done }) => {
                    self.set(change, at >= end);
                    if let Some(to) = self.destination(change, at, end) {
                        return Some((to, Some(done)));
                    }
                    self.answer(done);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return None,
            }
            // Before the recording was gone through nothing was known of what had happened.
            if self.index.get().is_some() && !self.state.borrow().indexed {
                return Some((at, None));
            }
            let passed_s = last.elapsed().as_secs_f64().min(LONGEST_STEP_S);
            last = Instant::now();
            let (playing, rate) = {
                let state = self.state.borrow();
                (state.playing, state.rate)
            };
            if playing {
                at = at.plus_seconds(passed_s * rate).min(end);
                let step = player.advance(at);
                self.tell(step);
                self.show(&player, at);
                if at == end {
                    self.state.send_modify(|state| state.playing = false);
                }
            }
        }
    }

    fn set(&self, change: ReplayChange, is_over: bool) {
        self.state.send_modify(|state| {
            state.rate = change.rate.unwrap_or(state.rate);
            state.playing = change.playing.unwrap_or(state.playing);
            // At its end nothing goes on; from its beginning it does.
            state.playing &= !is_over || change.position_s.is_some() || change.playing == Some(true);
        });
    }

    /// Where it is to go on, if not from where it is.
    fn destination(&self, change: ReplayChange, at: NodeTime, end: NodeTime) -> Option<NodeTime> {
        let begin = self.state.borrow().begin;
        match change.position_s {
            Some(position_s) => Some(begin.plus_seconds(position_s.max(0.0)).min(end)),
            None if change.playing == Some(true) && at >= end => Some(begin),
            None => None,
        }
    }

    fn tell(&self, step: Step) {
        for event in step.events {
            self.node.show_event(event);
        }
        if let Some(gate) = &step.gate {
            self.gate(gate);
        }
    }
}
