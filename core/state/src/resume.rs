//! What a node that was killed in flight needs to go on when it starts again: what is flown is kept in a file, the vehicles that this node flew
//! are taken back out of the failsafe that follows the loss of setpoints, and then fly on, or the operator is asked.
//!
//! Bound: one file of bounded size, written beside everything that flies. Must never do: undo what a pilot, another ground station or another
//! failsafe has done since; believe a file that is damaged, of another node or too old.

pub mod file;
pub mod judge;
mod kept;

pub use kept::{Flown, Kept, node_name};

use judge::{COMES_BACK_S, HEARD_WITHIN_S, SeenVehicle, Taking, Why};
use parking_lot::{Mutex, MutexGuard};
use skein_config::{NodeConfig, ResumeThen};
use skein_domain::exchange::Severity;
use skein_domain::{Geodetic, NodeTime, VehicleId};
use skein_safety::control::ControlTable;
use skein_view::EventLog;
use skein_view::{EventKind, LeftVehicle, ResumeQuestion};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Files written so far ahead of this computer's clock are taken for just written, in seconds.
const CLOCK_ERROR_S: f64 = 1.0;

/// What all parts of a node know of it.
pub struct Resume {
    /// Where what is flown is kept; nothing is, without one.
    path: Option<PathBuf>,
    then: ResumeThen,
    started: NodeTime,
    state: Mutex<State>,
    /// Held while the file is written, or taken away for good.
    file: Mutex<()>,
}

#[derive(Default)]
struct State {
    /// What was flown when the node ended; nothing if that is not gone on with, or not any more.
    before: Option<Flown>,
    taking: BTreeMap<VehicleId, Taking>,
    /// Since when the operator is asked.
    asked: Option<NodeTime>,
}

impl Resume {
    /// Reads what was flown when the node ended, if anything was.
    #[must_use]
    pub fn open(config: &NodeConfig, events: &EventLog, now: NodeTime) -> Self {
        let settings = &config.resume;
        let path = settings.file.clone().filter(|_| settings.then != ResumeThen::Forget);
        let before = path.as_ref().and_then(|path| {
            let usable = file::read(path).map_err(|fault| fault.to_string());
            let usable = usable.and_then(|kept| kept.map_or(Ok(None), |kept| kept.usable(config, unix_us())));
            usable.unwrap_or_else(|why| {
                let text = format!("what was flown before is not gone on with: {}: {why}", path.display());
                events.record(now, None, Severity::Warning, EventKind::Notice, text);
                None
            })
        });
        let awaited = before.iter().flat_map(|flown| flown.vehicles.keys());
        let state = State {
            taking: awaited.map(|id| (*id, Taking::Awaited)).collect(),
            before,
            asked: None,
        };
        Self {
            path,
            then: settings.then,
            started: now,
            state: Mutex::new(state),
            file: Mutex::new(()),
        }
    }

    /// Where what is flown is kept; nothing is, without one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// What follows a restart.
    #[must_use]
    pub fn then(&self) -> ResumeThen {
        self.then
    }

    /// Held by whoever writes the file, or takes it away.
    pub fn writing(&self) -> MutexGuard<'_, ()> {
        self.file.lock()
    }

    /// What was flown when the node ended, as long as it may be gone on with.
    #[must_use]
    pub fn before(&self) -> Option<Flown> {
        self.state.lock().before.clone()
    }

    /// Who had control authority over which vehicle has it again, and is taken for present as of now.
    pub fn hand_back(&self, control: &mut ControlTable, now: NodeTime) {
        let Some(before) = self.before() else { return };
        for entry in before.control.values() {
            if let Some((console, _)) = &entry.holder {
                control.hear(&console.id, now);
            }
        }
        control.merge(before.control);
    }

    /// Where the origin of the swarm's frame was.
    #[must_use]
    pub fn origin(&self) -> Option<Geodetic> {
        self.state.lock().before.as_ref()?.origin
    }

    /// One look at a vehicle that is awaited or held; nothing of any other.
    pub fn look(&self, id: VehicleId, seen: &SeenVehicle, now: NodeTime) -> Option<Taking> {
        let mut state = self.state.lock();
        let taking = state.taking.get_mut(&id).filter(|taking| is_open(taking))?;
        *taking = judge::step(*taking, seen, now);
        Some(*taking)
    }

    /// An operator commands a vehicle: what he says counts, and not what was flown before. Whether it had been awaited or held until now.
    pub fn commanded(&self, id: VehicleId) -> bool {
        let mut state = self.state.lock();
        if state.before.is_none() {
            return false;
        }
        let before = state
            .taking
            .get_mut(&id)
            .map(|taking| std::mem::replace(taking, Taking::Left(Why::Commanded)));
        before.is_some_and(|taking| is_open(&taking))
    }

    /// Whether it is decided of every vehicle. Who was not heard in time is not waited for.
    pub fn is_decided(&self, now: NodeTime) -> bool {
        let mut state = self.state.lock();
        for taking in state.taking.values_mut() {
            let late = match taking {
                Taking::Awaited => now.seconds_since(self.started) > HEARD_WITHIN_S,
                Taking::Holding { since, .. } => now.seconds_since(*since) > COMES_BACK_S + HEARD_WITHIN_S,
                Taking::Taken | Taking::Left(_) => false,
            };
            if late {
                *taking = Taking::Left(Why::NotHeard);
            }
        }
        !state.taking.values().any(is_open)
    }

    /// Who was taken back, and is not commanded by an operator.
    pub fn taken(&self) -> BTreeSet<VehicleId> {
        let state = self.state.lock();
        let taken = state.taking.iter().filter(|(_, taking)| **taking == Taking::Taken);
        taken.map(|(id, _)| *id).collect()
    }

    /// Who was not taken back, and why.
    pub fn left(&self) -> Vec<LeftVehicle> {
        let state = self.state.lock();
        let left = |(id, taking): (&VehicleId, &Taking)| match taking {
            Taking::Left(why) => Some(LeftVehicle {
                vehicle: *id,
                why: why.to_string(),
            }),
            _ => None,
        };
        state.taking.iter().filter_map(left).collect()
    }

    /// What the operator is asked.
    #[must_use]
    pub fn question(&self) -> Option<ResumeQuestion> {
        let since = self.state.lock().asked?;
        let formation = self.before()?.formation.is_some();
        Some(ResumeQuestion {
            vehicles: self.taken().into_iter().collect(),
            left: self.left(),
            formation,
            since,
        })
    }

    /// The operator is asked from now on, if not since before.
    pub fn ask(&self, now: NodeTime) {
        self.state.lock().asked.get_or_insert(now);
    }

    /// Whether the operator is asked.
    #[must_use]
    pub fn is_asking(&self) -> bool {
        self.state.lock().asked.is_some()
    }

    /// It is gone on with, or not: what was flown is given away once.
    pub fn end(&self) -> Option<Flown> {
        let mut state = self.state.lock();
        state.asked = None;
        state.before.take()
    }

    /// Nothing is to be gone on with: the node is stopped on purpose. Nothing is written from now on, by whoever looks at `stopping`.
    pub fn forget(&self) {
        let _writing = self.file.lock();
        if let Some(path) = &self.path {
            // One that was never written cannot be taken away.
            let _ = std::fs::remove_file(path);
        }
    }
}

fn is_open(taking: &Taking) -> bool {
    matches!(taking, Taking::Awaited | Taking::Holding { .. })
}

/// This computer's clock: the only one that goes on over a restart.
#[must_use]
pub fn unix_us() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
