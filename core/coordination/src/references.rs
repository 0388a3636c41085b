//! References: things whose position is told from outside (over the API, or seen over MAVLink) and that a formation may be anchored to.
//!
//! Bound: so many of them; the one not heard for the longest makes room. Must never do: fly anything.

use parking_lot::Mutex;
use serde::{Deserialize, Serialize};
use skein_domain::{AnchorReference, NodeTime, PositionNed, Refusal, VelocityNed};
use skein_flight::reference::{ReferenceError, ReferenceLimits, ReferenceTracker};
use std::collections::BTreeMap;

/// More are not kept.
const MOST: usize = 256;
/// How hard a formation that follows a reference speeds up, in metres per second squared, and turns, in radians per second.
const ACCELERATION_M_S2: f64 = 2.0;
const TURN_RATE_RAD_S: f64 = 0.3;
/// A reference not told for so long, in seconds, is taken to have stopped.
const STALE_AFTER_S: f64 = 2.0;
/// Longest name.
const LONGEST_NAME: usize = 64;

/// Where a reference is, as it is told.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceReport {
    /// Its position in the swarm frame.
    pub position: PositionNed,
    /// Its velocity, if it is known; else it is worked out from the positions.
    #[serde(default)]
    pub velocity: Option<VelocityNed>,
    /// Where it points in radians clockwise from north, if it is known.
    #[serde(default)]
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub heading_rad: Option<f64>,
}

/// A reference as screens see it.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ReferenceSnapshot {
    /// Its name.
    pub name: String,
    /// As last told.
    pub report: ReferenceReport,
    /// How long ago, in seconds.
    pub age_s: f64,
    /// Told too long ago to be followed.
    pub stale: bool,
}

struct Known {
    report: ReferenceReport,
    heard: NodeTime,
    /// It was told at another node of the swarm.
    elsewhere: bool,
    tracker: ReferenceTracker,
}

/// All references of a node.
pub struct References {
    limits: ReferenceLimits,
    known: Mutex<BTreeMap<String, Known>>,
}

impl References {
    /// None yet. No formation follows one faster than this.
    #[must_use]
    pub fn new(max_speed_m_s: f64) -> Self {
        Self {
            limits: ReferenceLimits {
                speed_m_s: max_speed_m_s,
                acceleration_m_s2: ACCELERATION_M_S2,
                turn_rate_rad_s: TURN_RATE_RAD_S,
                stale_after_s: STALE_AFTER_S,
            },
            known: Mutex::default(),
        }
    }

    /// Takes a report that was told at another node of the swarm.
    ///
    /// # Errors
    /// For a name or a number that is of no use.
    pub fn hear(&self, name: &str, report: ReferenceReport, at: NodeTime) -> Result<(), Refusal> {
        let known = |k: &Known| !k.elsewhere && at.seconds_since(k.heard) < STALE_AFTER_S || k.heard >= at;
        if self.known.lock().get(name).is_some_and(known) {
            return Ok(());
        }
        self.take(name, report, at, true)
    }

    /// Those told at this node of late, with when.
    pub fn told_here(&self) -> Vec<(String, ReferenceReport, NodeTime)> {
        let all = self.known.lock();
        all.iter()
            .filter(|(_, known)| !known.elsewhere)
            .map(|(name, known)| (name.clone(), known.report, known.heard))
            .collect()
    }

    /// Takes a report.
    ///
    /// # Errors
    /// For a name or a number that is of no use.
    pub fn tell(&self, name: &str, report: ReferenceReport, now: NodeTime) -> Result<(), Refusal> {
        self.take(name, report, now, false)
    }

    fn take(&self, name: &str, report: ReferenceReport, now: NodeTime, elsewhere: bool) -> Result<(), Refusal> {
        let finite = report.position.is_finite()
            && report.velocity.is_none_or(|v| v.is_finite())
            && report.heading_rad.is_none_or(f64::is_finite);
        if !finite || name.is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
            return Err(Refusal::invalid(format!(
                "a reference has a name of 1 to {LONGEST_NAME} characters and finite numbers"
            )));
        }
        let mut all = self.known.lock();
        if !all.contains_key(name) && all.len() >= MOST {
            let oldest = all
                .iter()
                .min_by_key(|(_, known)| known.heard.0)
                .map(|(name, _)| name.clone());
            if let Some(oldest) = oldest {
                all.remove(&oldest);
            }
        }
        let invalid = |e: ReferenceError| Refusal::invalid(e.to_string());
        let mut known = match all.remove(name) {
            Some(known) => known,
            None => Known {
                report,
                heard: now,
                elsewhere,
                tracker: ReferenceTracker::new(self.limits).map_err(invalid)?,
            },
        };
        let taken = known
            .tracker
            .update(report.position, report.velocity, report.heading_rad, now);
        if taken.is_ok() {
            known.report = report;
            known.heard = now;
            known.elsewhere = elsewhere;
        }
        all.insert(name.to_owned(), known);
        taken.map_err(invalid)
    }

    /// Forgets one; tells whether it was known.
    pub fn forget(&self, name: &str) -> bool {
        self.known.lock().remove(name).is_some()
    }

    /// The anchor a formation follows it with.
    pub fn anchor(&self, name: &str, now: NodeTime) -> Option<AnchorReference> {
        let all = self.known.lock();
        all.get(name)?.tracker.anchor(now).map(|(anchor, _)| anchor)
    }

    /// All of them.
    pub fn list(&self, now: NodeTime) -> Vec<ReferenceSnapshot> {
        let all = self.known.lock();
        all.iter()
            .map(|(name, known)| ReferenceSnapshot {
                name: name.clone(),
                report: known.report,
                age_s: now.seconds_since(known.heard).max(0.0),
                stale: known.tracker.anchor(now).is_none_or(|(_, stale)| stale),
            })
            .collect()
    }
}

impl std::fmt::Debug for References {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("References").field(&self.known.lock().len()).finish()
    }
}
