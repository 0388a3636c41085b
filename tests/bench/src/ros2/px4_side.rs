//! The PX4 side of DDS: simulated vehicles behind an agent, of which the first one's samples are marked, and a participant of its own that sees the
//! setpoints come.
//!
//! Must never do: know of the program more than what comes over DDS.

use super::marks::{Marked, Marks};
use crate::error::BenchError;
use parking_lot::Mutex;
use rustdds::no_key::SimpleDataReader;
use rustdds::{DomainParticipant, DomainParticipantBuilder, TopicKind};
use skein_domain::{LocalFrame, LocalPositionNed};
use skein_link_dds::messages::Message;
use skein_link_dds::messages::incoming::TrajectorySetpoint;
use skein_link_dds::naming::{Direction, TopicName, type_name};
use skein_link_dds::raw;
use skein_sim::topics::{Asked, CarrierError, LocalReport, Published, TopicCarrier};
use skein_sim::{Faces, SimSettings, Simulation};
use skein_sim_dds::{DdsCarrier, DdsSettings};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::task::{Wake, Waker};
use std::thread::{JoinHandle, Thread};
use std::time::{Duration, Instant};

/// The vehicle with marks.
const MARKED: u8 = 1;
/// Distance between two vehicles on the ground in metres.
const SPACING_M: f64 = 10.0;
/// The longest sleep: under load RustDDS may drop a notice.
const SLEEP: Duration = Duration::from_millis(100);

/// Vehicles on DDS, until it is dropped.
pub(crate) struct Px4Side {
    marks: Arc<Mutex<Marks>>,
    _watch: Watch,
    _simulation: Simulation,
}

impl Px4Side {
    /// So many vehicles in a domain.
    pub fn start(vehicles: u16, domain_id: u16) -> Result<Self, BenchError> {
        let dds = DdsSettings {
            domain_id,
            ..DdsSettings::default()
        };
        let marks = Arc::<Mutex<Marks>>::default();
        let carrier = Marking {
            inner: DdsCarrier::open(&dds).map_err(failed)?,
            marked: AtomicU64::new(u64::MAX),
            marks: Arc::clone(&marks),
        };
        let settings = SimSettings {
            vehicles: usize::from(vehicles),
            spacing_m: SPACING_M,
            faces: Faces::Dds,
            ..SimSettings::default()
        };
        let watch = Watch::start(&dds, Arc::clone(&marks))?;
        let simulation = Simulation::start_with(settings, Some(Arc::new(carrier))).map_err(failed)?;
        Ok(Self {
            marks,
            _watch: watch,
            _simulation: simulation,
        })
    }

    /// Begins a window; the vehicles hold their places.
    pub fn begin(&self) -> Result<(), BenchError> {
        if self.marks.lock().begin(Instant::now()) {
            return Ok(());
        }
        Err(BenchError::Program("no setpoint came over DDS".to_owned()))
    }

    /// What the window held.
    pub fn end(&self) -> Marked {
        self.marks.lock().end()
    }
}

fn failed(error: impl std::fmt::Display) -> BenchError {
    BenchError::Child {
        part: "PX4 side of DDS",
        detail: error.to_string(),
    }
}

/// Hands everything on, and marks one vehicle's positions.
struct Marking {
    inner: DdsCarrier,
    /// The simulation's number of the vehicle.
    marked: AtomicU64,
    marks: Arc<Mutex<Marks>>,
}

impl Marking {
    fn is_marked(&self, vehicle: u64) -> bool {
        self.marked.load(Ordering::Relaxed) == vehicle
    }
}

impl TopicCarrier for Marking {
    fn enter(&self, vehicle: u64, system_id: u8) -> Result<(), CarrierError> {
        if system_id == MARKED {
            self.marked.store(vehicle, Ordering::Relaxed);
        }
        self.inner.enter(vehicle, system_id)
    }

    fn leave(&self, vehicle: u64) {
        self.inner.leave(vehicle);
    }

    fn publish(&self, vehicle: u64, published: &Published) {
        match published {
            Published::Local(report) if self.is_marked(vehicle) => {
                let north_m = self.marks.lock().publish(Instant::now());
                self.inner.publish(vehicle, &Published::Local(moved(report, north_m)));
            }
            other => self.inner.publish(vehicle, other),
        }
    }

    fn take(&self, vehicle: u64) -> Option<Asked> {
        let mut asked = self.inner.take(vehicle)?;
        if let Asked::Setpoint(setpoint) = &mut asked
            && self.is_marked(vehicle)
        {
            // The simulation knows nothing of steps.
            let north_m = self.marks.lock().origin_of(setpoint.position_m.x);
            setpoint.position_m.x += north_m;
        }
        Some(asked)
    }

    fn step_done(&self) {
        self.inner.step_done();
    }
}

/// The same place in a frame whose origin lies so much further north.
fn moved(report: &LocalReport, north_m: f64) -> LocalReport {
    let mut moved = *report;
    if let Some(origin) = report.origin
        && north_m != 0.0
    {
        moved.origin = Some(LocalFrame { origin }.geodetic(&LocalPositionNed::new(north_m, 0.0, 0.0)));
        moved.position_m.x -= north_m;
    }
    moved
}

/// Sees the marked vehicle's setpoints come, on a thread of its own.
struct Watch {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    // Last: the reader goes before it does.
    _participant: DomainParticipant,
}

struct Notice(Thread);

impl Wake for Notice {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

impl Watch {
    fn start(dds: &DdsSettings, marks: Arc<Mutex<Marks>>) -> Result<Self, BenchError> {
        let participant = DomainParticipantBuilder::new(dds.domain_id)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .map_err(failed)?;
        let name = TopicName {
            namespace: dds.namespaces.of(MARKED),
            direction: Direction::In,
            base: "trajectory_setpoint".to_owned(),
            version: 0,
        };
        let quality = raw::quality();
        let topic = participant
            .create_topic(
                name.dds_name(),
                type_name(TrajectorySetpoint::NAME),
                &quality,
                TopicKind::NoKey,
            )
            .map_err(failed)?;
        let subscriber = participant.create_subscriber(&quality).map_err(failed)?;
        let reader: SimpleDataReader<TrajectorySetpoint> = subscriber
            .create_simple_datareader_no_key(&topic, None)
            .map_err(failed)?;
        let ends = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ends);
        let thread = std::thread::Builder::new()
            .name("bench setpoints".to_owned())
            .spawn(move || watch(&reader, &marks, &told));
        Ok(Self {
            ends,
            thread: Some(thread.map_err(BenchError::system("thread"))?),
            _participant: participant,
        })
    }
}

fn watch(reader: &SimpleDataReader<TrajectorySetpoint>, marks: &Mutex<Marks>, ends: &AtomicBool) {
    let waker = Waker::from(Arc::new(Notice(std::thread::current())));
    while !ends.load(Ordering::Acquire) {
        // In this order nothing that comes meanwhile is missed: the waker is there before it is looked.
        reader.set_waker(Some(waker.clone()));
        reader.drain_read_notifications();
        loop {
            match reader.try_take_one() {
                Ok(Some(sample)) => {
                    let [north_m, ..] = sample.into_value().position;
                    marks.lock().setpoint(Instant::now(), north_m.into());
                }
                Ok(None) => break,
                // None of its messages.
                Err(_) => {}
            }
        }
        std::thread::park_timeout(SLEEP);
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It ended by a panic of DDS, or as it should: either way it is gone.
            let _gone = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    //! A mark is another frame, not another place.

    use super::*;
    use nalgebra::Vector3;
    use skein_domain::Geodetic;

    #[test]
    fn a_moved_origin_leaves_the_vehicle_where_it_is() {
        let origin = Geodetic {
            latitude_deg: 47.397_742,
            longitude_deg: 8.545_594,
            altitude_amsl_m: 489.4,
        };
        let report = LocalReport {
            stamp_us: 1,
            horizontal_valid: true,
            vertical_valid: true,
            position_m: Vector3::new(12.0, -8.0, -10.0),
            velocity_m_s: Vector3::zeros(),
            acceleration_m_s2: Vector3::zeros(),
            yaw_rad: 0.0,
            origin: Some(origin),
            origin_us: 1,
            height_m: 10.0,
            accuracy_horizontal_m: 0.3,
            accuracy_vertical_m: 0.3,
            dead_reckoning: false,
        };
        let other = moved(&report, 1.0);
        assert_eq!(other.position_m.x, 11.0);
        let place = |report: &LocalReport| {
            LocalFrame {
                origin: report.origin.expect("an origin"),
            }
            .geodetic(&report.position_m.into())
        };
        let apart = LocalFrame { origin: place(&report) }.position(&place(&other));
        assert!(apart.norm() < 1e-3, "{apart:?}");
        assert_eq!(moved(&report, 0.0), report);
        let without = LocalReport { origin: None, ..report };
        assert_eq!(moved(&without, 1.0), without);
    }
}
