//! The faults of `--faults links`: once the formation flies its route, the first of each vehicle's two links is cut and mended again, one
//! vehicle after the other.
//!
//! Must never do: cut both links of a vehicle.

use super::report::{Criterion, measured};
use super::scenario_runner::ScenarioRunner;
use skein_domain::{FlightMode, VehicleId};
use skein_sim::{Face, Fault};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::time::Instant;

/// How long a link stays cut.
const CUT: Duration = Duration::from_secs(2);
/// On a busy computer a link may fall silent by itself, and flies again only after some steady seconds: so long its cut waits for that.
const BACK_WITHIN: Duration = Duration::from_secs(12);
/// Until the next vehicle's turn.
const APART: Duration = Duration::from_millis(500);
/// How often the mode of the vehicle is looked at meanwhile.
const LOOK: Duration = Duration::from_millis(50);
/// What is told when a vehicle changes its link, and to which.
const FLOWN_OVER: &str = "flown over ";
const TO_DDS: &str = "flown over DDS";
const TO_MAVLINK: &str = "flown over MAVLink";

/// What was cut, and what came of it.
#[derive(Debug, Default)]
pub struct LinkCuts {
    made: AtomicU64,
    handed_over: AtomicU64,
    left_offboard: AtomicU64,
}

impl LinkCuts {
    /// How many links were cut.
    pub fn made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    /// Cuts the first link of each vehicle in turn. Ends only when it cannot.
    pub async fn cut_in_turn(&self, runner: &ScenarioRunner<'_>) -> anyhow::Error {
        match self.cut_all(runner).await {
            Ok(()) => std::future::pending().await,
            Err(error) => error,
        }
    }

    async fn cut_all(&self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        while runner
            .node
            .snapshot()
            .formation
            .as_ref()
            .is_none_or(|f| f.route.is_none())
        {
            tokio::time::sleep(LOOK).await;
        }
        let vehicles: Vec<_> = runner
            .node
            .snapshot()
            .vehicles
            .iter()
            .map(|v| (v.id, v.system_id.0))
            .collect();
        for (vehicle, system_id) in vehicles {
            let cut = |cut| Fault::Cut { face: Face::Dds, cut };
            flown_over_dds(runner, vehicle).await;
            let before = told(runner, vehicle, TO_MAVLINK).len();
            runner.simulation()?.inflict(system_id, cut(true))?;
            self.made.fetch_add(1, Ordering::Relaxed);
            let until = Instant::now() + CUT;
            let mut stayed = true;
            while Instant::now() < until {
                tokio::time::sleep(LOOK).await;
                let fleet = runner.node.snapshot();
                stayed &= fleet
                    .vehicles
                    .iter()
                    .any(|v| v.id == vehicle && v.mode == FlightMode::Offboard);
            }
            runner.simulation()?.inflict(system_id, cut(false))?;
            self.left_offboard.fetch_add(u64::from(!stayed), Ordering::Relaxed);
            let handed_over = told(runner, vehicle, TO_MAVLINK).len() > before;
            self.handed_over.fetch_add(u64::from(handed_over), Ordering::Relaxed);
            runner.say(&format!("vehicle {vehicle}: DDS was cut for {} s", CUT.as_secs()));
            tokio::time::sleep(APART).await;
        }
        Ok(())
    }

    /// What such a flight has to meet beside the others: every vehicle's link was cut, and each was flown on over the other one.
    pub fn criteria(&self, vehicles: usize) -> Vec<Criterion> {
        let count = |counter: &AtomicU64| Some(counter.load(Ordering::Relaxed) as f64);
        vec![
            measured("links cut", count(&self.made)).at_least(vehicles as f64, ""),
            measured("vehicles flown on over the other link", count(&self.handed_over)).at_least(vehicles as f64, ""),
            measured(
                "vehicles that left OFFBOARD with their link cut",
                count(&self.left_offboard),
            )
            .at_most(0.0, ""),
        ]
    }
}

/// What a vehicle was told of with these words, in order.
fn told(runner: &ScenarioRunner<'_>, vehicle: VehicleId, words: &str) -> Vec<String> {
    let events = runner.node.events_after(0);
    let of_it = events.iter().filter(|e| e.vehicle == Some(vehicle));
    of_it
        .map(|e| e.text.clone())
        .filter(|text| text.contains(words))
        .collect()
}

/// Waits until a vehicle is flown over the link that is to be cut. Who was never handed over flies over it from the start.
async fn flown_over_dds(runner: &ScenarioRunner<'_>, vehicle: VehicleId) {
    let until = Instant::now() + BACK_WITHIN;
    let over_dds = || (told(runner, vehicle, FLOWN_OVER).last()).is_none_or(|text| text.contains(TO_DDS));
    while !over_dds() && Instant::now() < until {
        tokio::time::sleep(LOOK).await;
    }
}
