//! The report of a demonstration: each figure with its limit, and whether the flight met all of them.

use super::director::Director;
use super::layout;
use super::referee::{self, Figures, Referee};
use crate::args::{DemoArguments, FaultPlan};
use serde::Serialize;
use skein_config::Isolation;
use skein_runtime::{RestartRecord, Restored};
use skein_sim::TruthFrame;
use std::fmt::Write;

/// The report, as it is written to the file.
#[derive(Debug, Serialize)]
pub struct Report {
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
    /// Changes of mode that nobody had planned.
    pub unplanned_mode_changes: Vec<String>,
    /// Restarts of actors and plugins during the flight.
    pub restarts: Vec<String>,
    /// Restarts of plugin instances after failures, per isolation.
    pub plugin_restarts: Vec<PluginRestarts>,
    /// Longest time in which the simulation itself did not run, in seconds: part of every setpoint gap it saw.
    pub simulation_longest_stall_s: f64,
}

/// One criterion.
#[derive(Debug, Serialize)]
pub struct Criterion {
    /// What is measured.
    pub name: &'static str,
    /// What was measured; `None` if nothing could be.
    pub value: Option<f64>,
    /// What it is compared with.
    pub limit: f64,
    /// `at_most` or `at_least`.
    pub comparison: &'static str,
    /// Unit of both.
    pub unit: &'static str,
    /// Whether it is met. Nothing measured is not met.
    pub met: bool,
}

/// How plugin instances came back, in one isolation.
#[derive(Debug, Serialize)]
pub struct PluginRestarts {
    /// Where they run.
    pub isolation: Isolation,
    /// How many restarts.
    pub count: usize,
    /// Half of them took no longer, in milliseconds, from the failure until the state was back; a deliberate wait not counted.
    pub p50_ms: f64,
    /// All but one in a hundred took no longer, in milliseconds.
    pub p99_ms: f64,
    /// The longest, in milliseconds.
    pub max_ms: f64,
    /// What p99 should not exceed, in milliseconds.
    pub p99_target_ms: f64,
    /// After so many the state was the former one, byte for byte.
    pub restored_exactly: usize,
    /// After so many there was no state yet to restore.
    pub without_state: usize,
    /// After so many it was another.
    pub restored_differently: usize,
    /// So many waited on purpose before, since they had failed in quick succession.
    pub backed_off: usize,
}

/// The restarts of one isolation.
fn plugin_restarts(restarts: &[RestartRecord], isolation: Isolation, p99_target_ms: f64) -> PluginRestarts {
    let of: Vec<&RestartRecord> = restarts.iter().filter(|r| r.isolation == isolation).collect();
    let mut took_ms: Vec<f64> = of.iter().map(|r| r.took_s * 1e3).collect();
    took_ms.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let rank = (took_ms.len() as f64 * share).ceil().max(1.0) as usize;
        took_ms.get(rank - 1).copied().unwrap_or(0.0)
    };
    let restored = |how: Restored| of.iter().filter(|r| r.restored == how).count();
    PluginRestarts {
        isolation,
        count: of.len(),
        p50_ms: quantile(0.5),
        p99_ms: quantile(0.99),
        max_ms: quantile(1.0),
        p99_target_ms,
        restored_exactly: restored(Restored::Exactly),
        without_state: restored(Restored::Fresh),
        restored_differently: restored(Restored::Differently),
        backed_off: of.iter().filter(|r| r.backoff_s > 0.0).count(),
    }
}

/// How well a formation was reached.
#[derive(Debug, Serialize)]
pub struct SlotsReached {
    /// Which.
    pub shape: String,
    /// Distance of the farthest vehicle from its slot in metres.
    pub farthest_m: Option<f64>,
}

fn at_most(name: &'static str, value: Option<f64>, limit: f64, unit: &'static str) -> Criterion {
    let value = value.filter(|v| v.is_finite());
    Criterion {
        name,
        value,
        limit,
        comparison: "at_most",
        unit,
        met: value.is_some_and(|v| v <= limit),
    }
}

fn at_least(name: &'static str, value: Option<f64>, limit: f64, unit: &'static str) -> Criterion {
    let value = value.filter(|v| v.is_finite());
    Criterion {
        name,
        value,
        limit,
        comparison: "at_least",
        unit,
        met: value.is_some_and(|v| v >= limit),
    }
}

/// Each criterion with what was measured.
fn criteria(arguments: &DemoArguments, figures: &Figures, truth: &TruthFrame, unplanned: usize) -> Vec<Criterion> {
    let landings = referee::landing_errors(truth, &figures.landings);
    let farthest = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::max);
    let gap_s = farthest(&mut truth.vehicles.iter().map(|v| v.offboard_gap_max_s));
    let landed = landings.iter().filter(|(_, error_m)| error_m.is_finite()).count();
    vec![
        at_most(
            "formation error in straight legs, root mean square",
            figures.straight.rms(),
            0.5,
            "m",
        ),
        at_most(
            "formation error in turns, root mean square",
            figures.turning.rms(),
            1.5,
            "m",
        ),
        at_least(
            "smallest distance between two vehicles",
            figures.smallest_distance.map(|(d, ..)| d),
            2.0,
            "m",
        ),
        at_most(
            "farthest vehicle from its slot after a change",
            farthest(&mut figures.slots.iter().map(|(_, m)| *m)),
            1.0,
            "m",
        ),
        at_most("longest setpoint gap", gap_s, 0.2, "s"),
        at_most("unplanned changes of mode", Some(unplanned as f64), 0.0, ""),
        at_most(
            "farthest landing from its spot",
            farthest(&mut landings.iter().map(|(_, m)| *m)),
            1.0,
            "m",
        ),
        at_least(
            "vehicles landed and disarmed",
            Some(landed as f64),
            f64::from(arguments.vehicles),
            "",
        ),
    ]
}

/// What must be the case when plugins were ended during the whole flight.
fn restart_criteria(restarts: &[RestartRecord], faults: u64) -> Vec<Criterion> {
    let wrong = restarts.iter().filter(|r| r.restored == Restored::Differently).count();
    // An end that comes while the same plugin is still away finds nothing to end.
    let least = faults as f64 * 0.9;
    vec![
        at_most("restarts with another state than before", Some(wrong as f64), 0.0, ""),
        at_least("plugins that came back", Some(restarts.len() as f64), least.floor(), ""),
    ]
}

/// Makes the report from the referee's figures.
pub fn make(
    arguments: &DemoArguments,
    director: &Director<'_>,
    referee: &Referee,
    faults: u64,
    broke_off: Option<&anyhow::Error>,
) -> Report {
    let figures = referee.figures();
    let truth = referee.truth();
    let unplanned = referee::unplanned_mode_changes(&truth);
    let restarts = director.plugin_restarts();
    let mut criteria = criteria(arguments, &figures, &truth, unplanned.len());
    if figures.expects_gimbals() {
        criteria.push(at_most(
            "gimbals off what they look at, root mean square",
            figures.pointing.rms().map(f64::to_degrees),
            5.0,
            "deg",
        ));
    }
    if arguments.faults == Some(FaultPlan::Plugins) {
        criteria.extend(restart_criteria(&restarts, faults));
    }
    Report {
        passed: broke_off.is_none() && criteria.iter().all(|c| c.met),
        broke_off: broke_off.map(|e| format!("{e:#}")),
        version: env!("CARGO_PKG_VERSION"),
        vehicles: arguments.vehicles,
        seed: arguments.seed,
        faults,
        flight_s: director.flight_s,
        spacing_m: layout::SPACING_M,
        speed_m_s: layout::SPEED_M_S,
        criteria,
        slots: figures
            .slots
            .into_iter()
            .map(|(shape, m)| SlotsReached {
                shape,
                farthest_m: Some(m).filter(|m| m.is_finite()),
            })
            .collect(),
        unplanned_mode_changes: unplanned,
        restarts: director.restarts(),
        plugin_restarts: [(Isolation::InProcess, 10.0), (Isolation::Child, 150.0)]
            .map(|(isolation, target_ms)| plugin_restarts(&restarts, isolation, target_ms))
            .into(),
        simulation_longest_stall_s: truth.longest_stall_s,
    }
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
        let _ = writeln!(text, "\n{:<52} {:>9}   {:>14}", "criterion", "measured", "limit");
        for c in &self.criteria {
            let value = c
                .value
                .map_or_else(|| "nothing".to_owned(), |v| format!("{v:.2} {}", c.unit));
            let sign = if c.comparison == "at_most" { "<=" } else { ">=" };
            let mark = if c.met { "met" } else { "NOT MET" };
            let _ = writeln!(
                text,
                "{:<52} {value:>9}   {sign} {:>5} {:<3} {mark}",
                c.name, c.limit, c.unit
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
