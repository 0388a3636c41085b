//! What the recorder is told beside what it reads by itself: decisions with all that they were made from, and what operators did. A bounded
//! queue; what does not fit is counted and dropped.
//!
//! Must never do: make anybody wait, or cost anything while nobody records.

use arc_swap::ArcSwapOption;
use skein_coordination::steering::GateAnswer;
use skein_coordination::{Formation, PlanInput};
use skein_domain::{FailsafeEvent, NodeTime, Refusal, Setpoint, VehicleId};
use skein_failover::{LeaderMonitor, Leadership, Turn};
use skein_safety::failsafe::Health;
use skein_safety::{FailsafePolicy, Gate};
use skein_view::{Audit, EventRecord, FleetSnapshot, PeerSnapshot};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::SyncSender;

/// Of what is decided in every control period so much is recorded, in hertz: of setpoints, and of setpoints with all vehicles beside them.
const SETPOINTS_HZ: f64 = 2.0;
const PERIODS_HZ: f64 = 1.0;

/// Something to be recorded.
pub enum Taken {
    /// The fleet as screens see it.
    Fleet(Arc<FleetSnapshot>),
    /// What happened.
    Event(Arc<EventRecord>),
    /// A setpoint and what the gate made of it.
    Setpoint(Box<JudgedSetpoint>),
    /// A step of a vehicle's failsafe policy that told of something.
    Failsafe(Box<FailsafeStep>),
    /// A formation was planned.
    Plan(Box<MadePlan>),
    /// It was decided anew who is to coordinate.
    Leadership(Box<LeadershipTurn>),
    /// Somebody did something.
    Audit(Audit),
}

/// A setpoint and what the gate made of it.
pub struct JudgedSetpoint {
    /// When.
    pub at: NodeTime,
    /// Whose.
    pub vehicle: VehicleId,
    /// As its model asked for it.
    pub asked: Setpoint,
    /// The gate's answer.
    pub answer: GateAnswer,
    /// The gate.
    pub gate: Arc<Gate>,
    /// The control period.
    pub peers: Arc<PeerSnapshot>,
    /// It is recorded with that period, so that it can be judged again.
    pub with_period: bool,
}

/// A step of a vehicle's failsafe policy.
pub struct FailsafeStep {
    /// When.
    pub at: NodeTime,
    /// Whose.
    pub vehicle: VehicleId,
    /// The policy before it.
    pub before: FailsafePolicy,
    /// What it was told.
    pub health: Health,
    /// What it told.
    pub events: Vec<FailsafeEvent>,
}

/// A formation that was planned, or why not.
pub struct MadePlan {
    /// When.
    pub at: NodeTime,
    /// From what.
    pub input: PlanInput,
    /// All vehicles.
    pub peers: Arc<PeerSnapshot>,
    /// What came of it.
    pub outcome: Result<Formation, Refusal>,
}

/// What this node is to do about the leadership, which is another thing than before.
pub struct LeadershipTurn {
    /// When.
    pub at: NodeTime,
    /// What it has heard.
    pub monitor: LeaderMonitor,
    /// Whom it obeys.
    pub leadership: Leadership,
    /// What it is to do.
    pub turn: Turn,
}

/// The queue to the recorder.
#[derive(Default)]
pub struct Tape {
    recorder: ArcSwapOption<Recorder>,
    dropped: AtomicU64,
    writers: AtomicUsize,
}

struct Recorder {
    queue: SyncSender<Taken>,
    everything: bool,
}

impl Tape {
    /// A recorder begins, with every setpoint or without. It replaces the one before it.
    pub fn begin(&self, queue: SyncSender<Taken>, everything: bool) {
        self.recorder.store(Some(Arc::new(Recorder { queue, everything })));
    }

    /// Nobody records any more.
    pub fn end(&self) {
        self.recorder.store(None);
    }

    /// Somebody writes what comes from here, until the value that is returned goes.
    #[must_use]
    pub fn writing(self: &Arc<Self>) -> Writing {
        self.writers.fetch_add(1, Ordering::AcqRel);
        Writing(self.clone())
    }

    /// Whether somebody still writes.
    #[must_use]
    pub fn is_being_written(&self) -> bool {
        self.writers.load(Ordering::Acquire) > 0
    }

    /// Whether anybody records.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.recorder.load().is_some()
    }

    /// Records something, if anybody records.
    pub fn take(&self, make: impl FnOnce() -> Taken) {
        let recorder = self.recorder.load();
        if let Some(recorder) = recorder.as_ref()
            && recorder.queue.try_send(make()).is_err()
        {
            self.note_dropped(1);
        }
    }

    /// Something was lost on the way.
    pub fn note_dropped(&self, count: u64) {
        self.dropped.fetch_add(count, Ordering::Relaxed);
    }

    /// How much was dropped since the node started.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn is_everything(&self) -> bool {
        self.recorder
            .load()
            .as_ref()
            .is_some_and(|recorder| recorder.everything)
    }
}

/// Somebody writes.
pub struct Writing(Arc<Tape>);

impl Drop for Writing {
    fn drop(&mut self) {
        self.0.writers.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Which setpoints of one vehicle are recorded: some of each second, and each that is told something new about.
#[derive(Debug, Default)]
pub struct Thinning {
    setpoint: Option<u64>,
    period: Option<u64>,
    noted: Option<Noted>,
}

/// What the gate did to a setpoint, without figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Noted {
    refused: Option<&'static str>,
    slowed: bool,
}

impl Thinning {
    /// Whether this setpoint is recorded, and if so whether with all vehicles. Vehicles come to the same answer in the same period, so that it
    /// is recorded once for all of them.
    pub fn wants(&mut self, tape: &Tape, answer: &GateAnswer, peers: &PeerSnapshot) -> Option<bool> {
        if !tape.is_on() {
            return None;
        }
        let noted = Noted {
            refused: answer.outcome.as_ref().err().map(Refusal::code),
            slowed: answer.slowed.is_some(),
        };
        let before = self.noted.replace(noted);
        // That one begins to give way, or ends, may flicker: it is seen in what is recorded anyway.
        let is_new = before.is_none_or(|before| before != noted);
        let tick = |hz: f64| (peers.made.as_seconds() * hz) as u64;
        let with_period = self.period.replace(tick(PERIODS_HZ)) != Some(tick(PERIODS_HZ));
        let is_due = self.setpoint.replace(tick(SETPOINTS_HZ)) != Some(tick(SETPOINTS_HZ));
        let everything = tape.is_everything();
        let with_period = with_period || is_new || everything;
        (with_period || is_due).then_some(with_period)
    }
}

#[cfg(test)]
mod tests {
    //! What is thinned out, and what is dropped.

    use super::*;
    use std::sync::mpsc::sync_channel;

    fn answer(outcome: Result<skein_safety::Steered, Refusal>) -> GateAnswer {
        GateAnswer { slowed: None, outcome }
    }

    fn flown() -> GateAnswer {
        answer(Ok(skein_safety::Steered {
            setpoint: Setpoint::default(),
            change: None,
        }))
    }

    fn at(seconds: f64) -> PeerSnapshot {
        PeerSnapshot {
            made: NodeTime::from_seconds(seconds),
            ..PeerSnapshot::default()
        }
    }

    #[test]
    fn two_setpoints_a_second_and_one_period_are_recorded_and_every_new_answer() {
        let (queue, _keep) = sync_channel(1);
        let (tape, mut thinning) = (Tape::default(), Thinning::default());
        assert_eq!(thinning.wants(&tape, &flown(), &at(1.0)), None);
        tape.begin(queue, false);
        let second = |thinning: &mut Thinning, answer: &GateAnswer, from: f64| -> Vec<bool> {
            let ticks = (0..50).map(|tick| at(from + f64::from(tick) * 0.02 + 0.001));
            ticks
                .filter_map(|peers| thinning.wants(&tape, answer, &peers))
                .collect()
        };
        assert_eq!(second(&mut thinning, &flown(), 2.0), [true, false]);
        let refused = answer(Err(Refusal::NoPosition));
        assert_eq!(
            second(&mut thinning, &refused, 2.5)
                .iter()
                .filter(|with| **with)
                .count(),
            2
        );
        let (queue, _keep) = sync_channel(1);
        tape.begin(queue, true);
        assert_eq!(second(&mut thinning, &flown(), 4.0).len(), 50);
    }

    #[test]
    fn what_does_not_fit_is_counted_and_nothing_is_made_for_nobody() {
        let tape = Tape::default();
        tape.take(|| panic!("nobody records"));
        let (queue, taken) = sync_channel(2);
        tape.begin(queue, false);
        for _ in 0..5 {
            tape.take(|| Taken::Audit(Audit::default()));
        }
        assert_eq!((tape.dropped(), taken.try_iter().count()), (3, 2));
        tape.end();
        tape.take(|| panic!("nobody records any more"));
    }
}
