//! The report of a demonstration: each figure with its limit, and whether the flight met all of them.

mod criterion;
mod restarts;

pub use criterion::{Criterion, counted, happened, measured};
pub use restarts::PluginRestarts;

use super::layout;
use super::referee::{self, Figures, Referee};
use crate::args::{DemoArguments, FaultPlan, Scenario};
use serde::Serialize;
use skein_config::Isolation;
use skein_runtime::NodeHandle;
use skein_sim::{TruthFrame, VehicleTruth};
use std::fmt::Write;

/// A machine that stood still for less is not worth a line.
const WORTH_TELLING_S: f64 = 0.1;

/// The report, as it is written to the file.
#[derive(Debug, Serialize)]
pub struct Report {
    /// What was flown.
    pub scenario: Scenario,
    /// All criteria were met.
    pub passed: bool,
    /// Why the flight broke off, if it did.
    pub broke_off: Option<String>,
    /// Program version.
    pub version: &'static str,
    /// How many vehicles flew.
    pub vehicles: u8,
    /// Seed of wind and noise.
    pub seed: u64,
    /// Faults that were injected.
    pub faults: u64,
    /// Seconds from the start to the last disarming.
    pub flight_s: Option<f64>,
    /// Distance between neighbours in the formations, in metres.
    pub spacing_m: f64,
    /// Leader's speed on its route in metres per second.
    pub speed_m_s: f64,
    /// Each criterion with its figure and limit.
    pub criteria: Vec<Criterion>,
    /// Per change of formation, the distance of the farthest vehicle from its slot in metres.
    pub slots: Vec<SlotsReached>,
    /// The nearest that two vehicles came to each other, with when and where.
    pub nearest: String,
    /// Changes of mode that nobody had planned.
    pub unplanned_mode_changes: Vec<String>,
    /// Restarts of actors and plugins during the flight.
    pub restarts: Vec<String>,
    /// Restarts of plugin instances after failures, per isolation.
    pub plugin_restarts: Vec<PluginRestarts>,
    /// Longest time in which the machine did not let this process run, in seconds. The setpoint gap above is without such times.
    pub machine_longest_stall_s: f64,
    /// Longest setpoint gap with all that was in it, as a simulated autopilot sees it, in seconds. Told, not judged.
    pub raw_setpoint_gap_s: Option<f64>,
}

/// How well a formation was reached.
#[derive(Debug, Serialize)]
pub struct SlotsReached {
    /// Which.
    pub shape: String,
    /// Distance of the farthest vehicle from its slot in metres.
    pub farthest_m: Option<f64>,
}

/// How a flight went, beside what the referee saw.
pub struct Outcome<'a> {
    /// The criteria of its own.
    pub criteria: Vec<Criterion>,
    /// Seconds from the start to the last disarming.
    pub flight_s: Option<f64>,
    /// Faults that were injected.
    pub faults: u64,
    /// How many times a link had no fresh setpoint to send, of vehicles that no simulator of ours moves.
    pub setpoints_missing: Option<u64>,
    /// Why it broke off, if it did.
    pub broke_off: Option<&'a anyhow::Error>,
}

/// Those that went without setpoints for no reason of the scenario's.
fn judged<'a>(figures: &'a Figures, truth: &'a TruthFrame) -> impl Iterator<Item = &'a VehicleTruth> {
    let vehicles = truth.vehicles.iter();
    vehicles.filter(|v| !figures.excused.contains(&v.system_id))
}

fn farthest(values: &mut dyn Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

/// What every flight has to meet.
fn common(figures: &Figures, truth: &TruthFrame, unplanned: usize, gap: Criterion) -> Vec<Criterion> {
    let to_land = truth.vehicles.iter().filter(|v| !figures.lost.contains(&v.system_id));
    let landed = truth.vehicles.iter().filter(|v| v.alive && referee::is_down(v)).count();
    let mut criteria = vec![
        measured(
            "smallest distance between two vehicles",
            figures.smallest_distance.map(|(d, ..)| d),
        )
        .at_least(2.0, "m"),
        gap,
        counted("unplanned changes of mode", unplanned).at_most(0.0, ""),
        counted("vehicles that came down untold", figures.came_down.len()).at_most(0.0, ""),
    ];
    // Not every scenario flies a formation; one that was to and did not has broken off.
    if !figures.slots.is_empty() {
        let farthest_m = farthest(&mut figures.slots.iter().map(|(_, m)| *m));
        criteria.push(measured("farthest vehicle from its slot after a change", farthest_m).at_most(1.0, "m"));
    }
    if !figures.landings.is_empty() {
        let landings = referee::landing_errors(truth, &figures.landings);
        criteria.push(
            measured(
                "farthest landing from its spot",
                farthest(&mut landings.iter().map(|(_, m)| *m)),
            )
            .at_most(1.0, "m"),
        );
    }
    criteria.push(counted("vehicles landed and disarmed", landed).at_least(to_land.count() as f64, ""));
    criteria
}

/// Whether setpoints came without a gap: by what the simulated vehicles saw, or by how often a link had none to send.
fn gap(missing: Option<u64>, figures: &Figures, truth: &TruthFrame) -> Criterion {
    let Some(missing) = missing else {
        // A machine that stands still stops the node with everything else: only what is left of a gap without that is the sender's.
        let gap_s = farthest(&mut judged(figures, truth).map(|v| v.offboard_gap_sender_max_s));
        return measured("longest setpoint gap", gap_s).at_most(0.2, "s");
    };
    measured("times a link had no fresh setpoint to send", Some(missing as f64)).at_most(0.0, "")
}

/// Makes the report from the referee's figures.
pub fn make(arguments: &DemoArguments, node: &NodeHandle, referee: &Referee, outcome: Outcome<'_>) -> Report {
    let figures = referee.figures();
    let truth = referee.truth();
    let mut unplanned = referee::unplanned_mode_changes(&truth);
    unplanned.retain(|(system_id, _)| !figures.excused.contains(system_id));
    let restarts = node.restarts();
    let raw_gap_s = farthest(&mut judged(&figures, &truth).map(|v| v.offboard_gap_max_s));
    let mut criteria = outcome.criteria;
    criteria.extend(common(
        &figures,
        &truth,
        unplanned.len(),
        gap(outcome.setpoints_missing, &figures, &truth),
    ));
    if arguments.faults == Some(FaultPlan::Plugins) {
        criteria.extend(restarts::restart_criteria(&restarts, outcome.faults));
    }
    let slots = figures.slots.into_iter().map(|(shape, m)| SlotsReached {
        shape,
        farthest_m: Some(m).filter(|m| m.is_finite()),
    });
    Report {
        scenario: arguments.scenario,
        passed: outcome.broke_off.is_none() && criteria.iter().all(|c| c.met),
        broke_off: outcome.broke_off.map(|e| format!("{e:#}")),
        version: env!("CARGO_PKG_VERSION"),
        vehicles: arguments.count(),
        seed: arguments.seed,
        faults: outcome.faults,
        flight_s: outcome.flight_s,
        spacing_m: layout::SPACING_M,
        speed_m_s: figures.cruise_m_s,
        criteria,
        slots: slots.collect(),
        nearest: figures.nearest,
        unplanned_mode_changes: unplanned.into_iter().map(|(_, text)| text).collect(),
        restarts: restarted(node),
        plugin_restarts: [(Isolation::InProcess, 10.0), (Isolation::Child, 150.0)]
            .map(|(isolation, target_ms)| restarts::plugin_restarts(&restarts, isolation, target_ms))
            .into(),
        machine_longest_stall_s: truth.longest_stall_s,
        raw_setpoint_gap_s: raw_gap_s.filter(|_| arguments.listen.is_empty()),
    }
}

/// Actors and plugins that were started more than once, in words.
fn restarted(node: &NodeHandle) -> Vec<String> {
    let fleet = node.snapshot();
    let vehicles = fleet.vehicles.iter().flat_map(|v| {
        let payloads = v.payloads.iter().map(|payload| payload.plugin.as_actor());
        [v.actor.clone(), v.model.as_actor()].into_iter().chain(payloads)
    });
    vehicles
        .chain(fleet.actors.iter().cloned())
        .filter(|health| health.incarnation.0 > 1)
        .map(|h| {
            // A plugin whose actor was killed has failed by nothing of its own.
            let error = match h.last_error.as_str() {
                "" => String::new(),
                error => format!(", last error: {error}"),
            };
            format!("{} (incarnation {}{error})", h.name, h.incarnation)
        })
        .collect()
}

impl Report {
    fn describe_restarts(&self, text: &mut String) {
        let counted: usize = self.plugin_restarts.iter().map(|r| r.count).sum();
        // Few are told one by one; many are told by their figures.
        if counted <= 10 {
            for restart in &self.restarts {
                let _ = writeln!(text, "restarted: {restart}");
            }
            return;
        }
        let _ = writeln!(text, "{} plugins were ended in flight:", self.faults);
        for r in &self.plugin_restarts {
            let place = match r.isolation {
                Isolation::InProcess => "in the node's process",
                Isolation::Child => "in child processes",
            };
            let _ = writeln!(
                text,
                "  {:>4} restarts {place:<21}: p50 {:.2} ms, p99 {:.2} ms (target {:.0} ms), longest {:.2} ms; state as before {}, \
                 none yet {}, other {}; {} waited on purpose",
                r.count,
                r.p50_ms,
                r.p99_ms,
                r.p99_target_ms,
                r.max_ms,
                r.restored_exactly,
                r.without_state,
                r.restored_differently,
                r.backed_off
            );
        }
    }

    /// The report for a person.
    pub fn describe(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = writeln!(text, "\n{:<66} {:>9}   {:>14}", "criterion", "measured", "limit");
        for c in &self.criteria {
            let value = c
                .value
                .map_or_else(|| "nothing".to_owned(), |v| format!("{v:.2} {}", c.unit));
            let sign = if c.comparison == "at_most" { "<=" } else { ">=" };
            let mark = if c.met { "met" } else { "NOT MET" };
            let _ = writeln!(
                text,
                "{:<66} {value:>9}   {sign} {:>5} {:<3} {mark}",
                c.name, c.limit, c.unit
            );
        }
        let _ = writeln!(text, "nearest to each other: {}", self.nearest);
        if self.machine_longest_stall_s > WORTH_TELLING_S {
            let (stall_s, raw_s) = (self.machine_longest_stall_s, self.raw_setpoint_gap_s.unwrap_or(0.0));
            let _ = writeln!(
                text,
                "this machine did not let the program run for up to {stall_s:.2} s; with that the longest setpoint gap is {raw_s:.2} s, and how well it was flown in the 10 s after that is not judged"
            );
        }
        for change in &self.unplanned_mode_changes {
            let _ = writeln!(text, "unplanned: {change}");
        }
        self.describe_restarts(&mut text);
        if let Some(reason) = &self.broke_off {
            let _ = writeln!(text, "The flight broke off: {reason}");
        }
        let verdict = if self.passed {
            "The flight met all criteria."
        } else {
            "The flight did NOT meet its criteria."
        };
        let _ = writeln!(text, "{verdict}");
        text
    }
}
