//! Processor time and memory of the program with so many vehicles in the air, with and without ROS 2.
//!
//! Must never do: charge the program with what vehicles and readers take.

use super::peers::{self, Heard, Ros2Python};
use super::px4_side::Px4Side;
use super::{Ros2BenchArgs, SETTLE, fresh_domain};
use crate::error::BenchError;
use crate::generator::LoadGeneratorSettings;
use crate::process::{Machine, Part, Scheduling};
use crate::program::{Program, VehicleLink};
use serde::Serialize;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// The identity of the program on the wire.
const OWN_SYSTEM_ID: u8 = 245;

/// What ROS 2 sees of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// Nothing: it is off.
    Off,
    /// Everything, but nobody listens.
    Unheard,
    /// Everything, and an rclpy program takes all poses.
    Heard,
}

/// One window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CostFigures {
    /// What the vehicles are flown over.
    pub link: VehicleLink,
    /// How many there are.
    pub vehicles: u16,
    /// What ROS 2 sees.
    pub ros2: Shown,
    /// Processor time of the program, 100 = one core.
    pub cpu_percent: f64,
    /// Resident memory at the end.
    pub rss_mib: f64,
    /// Threads at the end.
    pub threads: u32,
    /// Poses per second and vehicle that the rclpy program took.
    pub poses_hz: Option<f64>,
    /// Processor time of everything else on the machine: vehicles, reader, and whatever else runs.
    pub other_cpu_percent: f64,
}

/// Measures all of them.
pub(crate) struct Costs<'a> {
    args: &'a Ros2BenchArgs,
    ros2: &'a Ros2Python,
}

/// Whoever plays the vehicles, as long as it is held.
enum Vehicles {
    Mavlink(Box<Part>),
    Dds(Box<Px4Side>),
}

impl<'a> Costs<'a> {
    pub fn new(args: &'a Ros2BenchArgs, ros2: &'a Ros2Python) -> Self {
        Self { args, ros2 }
    }

    /// One window each.
    pub async fn measure(&self) -> Result<Vec<CostFigures>, BenchError> {
        let over = |link, counts: &[u16]| -> Vec<_> { counts.iter().map(|count| (link, *count)).collect() };
        let mut all = over(VehicleLink::Mavlink, &self.args.vehicles);
        all.extend(over(VehicleLink::Dds, &self.args.dds_vehicles));
        let mut found = Vec::new();
        for (link, vehicles) in all {
            for shown in [Shown::Off, Shown::Unheard, Shown::Heard] {
                eprintln!("cost: {vehicles} vehicles over {link:?}, ROS 2 {shown:?}");
                found.push(self.window(link, vehicles, shown).await?);
            }
        }
        Ok(found)
    }

    async fn window(&self, link: VehicleLink, vehicles: u16, shown: Shown) -> Result<CostFigures, BenchError> {
        let domain = fresh_domain();
        let setup = self.args.setup(link, domain, shown != Shown::Off);
        let program = Program::start(&setup).await?;
        let played = match link {
            VehicleLink::Mavlink => Vehicles::Mavlink(Box::new(self.generator(&program, vehicles)?)),
            VehicleLink::Dds => Vehicles::Dds(Box::new(Px4Side::start(vehicles, domain)?)),
        };
        let mut listener = None;
        if shown == Shown::Heard {
            let names: Vec<String> = (1..=vehicles).map(|id| format!("uav_{id}")).collect();
            listener = Some(self.ros2.start("listen", &names, domain)?);
        }
        program.take_off(vehicles).await?;
        if let Some(listener) = &mut listener {
            peers::ready(listener).await?;
        }
        tokio::time::sleep(SETTLE).await;
        let figures = self.charged(&program, link, vehicles, shown, &mut listener).await;
        program.part.stop().await;
        if let Some(listener) = listener {
            listener.stop().await;
        }
        match played {
            Vehicles::Mavlink(generator) => generator.stop().await,
            Vehicles::Dds(side) => drop(side),
        }
        figures
    }

    /// The window itself.
    async fn charged(
        &self,
        program: &Program,
        link: VehicleLink,
        vehicles: u16,
        ros2: Shown,
        listener: &mut Option<Part>,
    ) -> Result<CostFigures, BenchError> {
        if let Some(listener) = listener {
            listener.tell(b"b\n").await?;
        }
        let (begun, machine, before) = (Instant::now(), Machine::now(), program.part.usage()?);
        tokio::time::sleep(Duration::from_secs_f64(f64::from(self.args.seconds) / 3.0)).await;
        let (window_s, after) = (begun.elapsed().as_secs_f64(), program.part.usage()?);
        let busy_s = Machine::now().busy_s - machine.busy_s;
        let mut poses_hz = None;
        if let Some(listener) = listener {
            listener.tell(b"e\n").await?;
            let heard: Heard = peers::told(listener).await?;
            poses_hz = Some(heard.poses as f64 / window_s / f64::from(vehicles));
        }
        let percent = |seconds: f64| 100.0 * seconds / window_s;
        let cpu_percent = percent(after.cpu_s - before.cpu_s);
        Ok(CostFigures {
            link,
            vehicles,
            ros2,
            cpu_percent,
            rss_mib: after.rss_mib,
            threads: after.threads,
            poses_hz,
            other_cpu_percent: (percent(busy_s) - cpu_percent).max(0.0),
        })
    }

    fn generator(&self, program: &Program, vehicles: u16) -> Result<Part, BenchError> {
        let settings = LoadGeneratorSettings {
            vehicles,
            target: program.endpoint,
            reserved_system_ids: vec![OWN_SYSTEM_ID],
        };
        let settings = serde_json::to_string(&settings).map_err(BenchError::Settings)?;
        Part::start(
            "load generator",
            &self.args.helper,
            &["bench", "load-generator", &settings],
            Scheduling::Ordinary,
            Stdio::inherit(),
        )
    }
}
