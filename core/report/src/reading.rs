//! Reads a recording once, from its beginning to its end, and keeps what the report needs.
//!
//! Must never do: keep something for every message, or stop at a message that it does not understand.

mod actions;
mod findings;
mod fleet;
mod incidents;
mod vehicle;
mod wire;

use crate::facts::{About, Report, ReportError, VehicleFacts, Wholeness};
use crate::verdict;
use actions::Actions;
use findings::Findings;
use fleet::Fleet;
use skein_domain::NodeTime;
use skein_recording::{AuditRecord, ClockRecord, Message, RecorderState, Recording, Select, Topic, VehicleTelemetry};
use skein_view::EventRecord;
use std::collections::BTreeMap;

/// So many points has a curve, and all curves of one chart together.
const POINTS: usize = 1_000;
const POINTS_OF_CHART: usize = 24_000;
/// Clocks that differ by less from what they should were not set, in seconds.
const CLOCK_SET_S: f64 = 0.5;

/// Moments as seconds since the recording begins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Since(NodeTime);

impl Since {
    fn s(self, at: NodeTime) -> f64 {
        at.seconds_since(self.0)
    }
}

/// What is kept while it reads.
struct Reading<'a> {
    recording: &'a Recording,
    fleet: Fleet,
    findings: Findings,
    actions: Actions,
    whole: Wholeness,
    clock_set_s: f64,
}

impl Report {
    /// Of a recording.
    ///
    /// # Errors
    /// When nothing of it can be read. A recording that is damaged or cut off gives a report that says so.
    pub fn of(recording: &Recording) -> Result<Self, ReportError> {
        let vehicles = recording.topics();
        let vehicles = vehicles.filter(|(info, _)| matches!(info.topic, Some(Topic::Telemetry(_))));
        let points = (POINTS_OF_CHART / vehicles.count().max(1)).clamp(100, POINTS);
        let since = Since(recording.span().0);
        let mut reading = Reading {
            recording,
            fleet: Fleet::new(since, points),
            findings: Findings::new(since),
            actions: Actions::new(since),
            whole: Wholeness::default(),
            clock_set_s: 0.0,
        };
        reading.read()?;
        Ok(reading.finish())
    }

    /// The same with times on the page so many seconds ahead of UTC.
    #[must_use]
    pub fn at_utc_offset_s(mut self, offset_s: i32) -> Self {
        self.about.utc_offset_s = offset_s;
        self
    }
}

fn wanted(topic: &Topic) -> bool {
    matches!(
        topic,
        Topic::Fleet
            | Topic::Events
            | Topic::Audit
            | Topic::Clock
            | Topic::Recorder
            | Topic::Gate
            | Topic::Failsafe
            | Topic::Telemetry(_)
            | Topic::Setpoint(_)
    )
}

impl Reading<'_> {
    fn read(&mut self) -> Result<(), ReportError> {
        let (mut read, mut damage) = (0_u64, BTreeMap::<String, u64>::new());
        for wrong in self.recording.damage() {
            *damage.entry(wrong.to_string()).or_default() += 1;
        }
        for message in self.recording.messages(Select::only(wanted)) {
            match message {
                Ok(message) => {
                    read += 1;
                    if self.take(&message).is_none() {
                        self.whole.unreadable += 1;
                    }
                }
                Err(wrong) => *damage.entry(wrong.to_string()).or_default() += 1,
            }
        }
        self.whole.finished = self.recording.is_finished();
        self.whole.damage = damage.into_iter().collect();
        match (read, self.whole.damage.first()) {
            (0, Some((why, _))) => Err(ReportError::Unreadable(why.clone())),
            _ => Ok(()),
        }
    }

    /// `None` if it cannot be understood.
    fn take(&mut self, message: &Message) -> Option<()> {
        match message.topic.as_ref()? {
            Topic::Telemetry(_) => {
                let telemetry: VehicleTelemetry = message.json().ok()?;
                self.fleet.telemetry(telemetry, &mut self.findings);
            }
            Topic::Setpoint(_) => {
                let setpoint = message.json().ok()?;
                self.fleet.setpoint(&setpoint);
                self.findings.setpoint(&setpoint, &self.fleet);
            }
            Topic::Fleet if self.fleet.wants_whole(message.at) => {
                let whole = message.json().ok()?;
                self.fleet.whole(message.at, whole);
            }
            Topic::Events => {
                let event: EventRecord = message.json().ok()?;
                self.fleet.event(&event);
                self.findings.event(&event, &self.fleet);
                self.actions.event(&event);
            }
            Topic::Audit => self.actions.audit(message.json::<AuditRecord>().ok()?),
            Topic::Clock => {
                let clock: ClockRecord = message.json().ok()?;
                let told_ns = self.recording.header().base.unix_ns(clock.time);
                let off_s = (i128::from(clock.unix_ns) - i128::from(told_ns)) as f64 * 1e-9;
                if off_s.abs() > self.clock_set_s.abs() {
                    self.clock_set_s = off_s;
                }
            }
            Topic::Recorder => self.whole.dropped = message.json::<RecorderState>().ok()?.dropped,
            Topic::Gate => self.fleet.gate(&message.json().ok()?),
            Topic::Failsafe => self.fleet.failsafe_rules(&message.json().ok()?),
            _ => {}
        }
        Some(())
    }

    fn finish(mut self) -> Report {
        self.fleet.finish_tick(&mut self.findings);
        let about = self.about();
        let (findings, findings_left_out) = self.findings.finish();
        let (map, charts, vehicles) = self.fleet.finish(about.duration_s);
        let done = self.actions.finish();
        let mut report = Report {
            about: About {
                simulated: vehicles.iter().filter(|vehicle| vehicle.simulated).count(),
                ..about
            },
            verdict: Vec::new(),
            findings,
            findings_left_out,
            map,
            charts,
            vehicles,
            actions: done.actions,
            audit_broken: done.broken,
            commands: done.commands,
            events: done.events,
            left_out: done.left_out,
        };
        report.verdict = verdict::of(&report);
        report
    }

    fn about(&self) -> About {
        let header = self.recording.header();
        let (begin, end) = self.recording.span();
        let begins_unix_ms = i64::try_from(header.base.unix_ns(begin) / 1_000_000).unwrap_or_default();
        let file = self.recording.path().file_name().unwrap_or_default();
        About {
            file: file.to_string_lossy().into_owned(),
            bytes: self.recording.bytes(),
            node_name: header.name.clone(),
            node: header.node,
            swarm: header.swarm.clone(),
            version: header.version.clone(),
            begins_unix_ms,
            duration_s: end.seconds_since(begin),
            utc_offset_s: 0,
            origin: self.fleet.origin(),
            simulated: 0,
            clock_set_s: Some(self.clock_set_s).filter(|off_s| off_s.abs() > CLOCK_SET_S),
            whole: self.whole.clone(),
        }
    }
}

impl Report {
    /// A vehicle of it.
    #[must_use]
    pub fn vehicle(&self, id: skein_domain::VehicleId) -> Option<&VehicleFacts> {
        let at = self.vehicles.binary_search_by_key(&id, |vehicle| vehicle.id).ok()?;
        self.vehicles.get(at)
    }
}
