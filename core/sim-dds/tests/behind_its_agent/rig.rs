//! A simulation on DDS, the node that reads it, and pilots that fly it through its links.

use parking_lot::Mutex;
use rustdds::DomainParticipantBuilder;
use skein_domain::link::{LinkEvent, VehicleLink};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, Clock, FlightMode, LocalPositionNed, NodeTime, Refusal, RequestId, Telemetry};
use skein_link_dds::definitions::Release;
use skein_link_dds::{DdsArguments, DdsEvent, DdsLink, DdsLinkTable, DdsNode};
use skein_px4::LinkSettings;
use skein_sim::{Faces, NoiseSettings, SimSettings, Simulation, VehicleTruth, WindSettings};
use skein_sim_dds::DdsSettings;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

/// How long anything may take. Generous: only a failure ever takes so long.
const PATIENCE: Duration = Duration::from_secs(180);
/// How often pilots look and stream.
const PERIOD: Duration = Duration::from_millis(20);
/// How long a setpoint is valid, in seconds.
const VALID_S: f64 = 1.0;
/// Near enough, in metres, and slow enough, in metres per second.
const NEAR_M: f64 = 0.4;
const SLOW_M_S: f64 = 0.3;

struct SinceStart(Instant);

impl Clock for SinceStart {
    fn now(&self) -> NodeTime {
        NodeTime::from_seconds(self.0.elapsed().as_secs_f64())
    }
}

/// Vehicles on DDS alone, in calm air, with a perfect estimate.
pub fn calm(vehicles: usize) -> SimSettings {
    SimSettings {
        vehicles,
        faces: Faces::Dds,
        wind: WindSettings::CALM,
        noise: NoiseSettings::NONE,
        ..SimSettings::default()
    }
}

/// A domain of this process, as far as there are enough of them.
pub fn fresh_domain() -> DdsSettings {
    static GIVEN: AtomicU16 = AtomicU16::new(0);
    let number = u32::from(GIVEN.fetch_add(1, Ordering::Relaxed));
    let domain_id = u16::try_from((std::process::id() * 17 + number) % 100).unwrap() + 1;
    DdsSettings {
        domain_id,
        ..DdsSettings::default()
    }
}

/// Both sides.
pub struct Rig {
    pub simulation: Simulation,
    links: Arc<DdsLinkTable>,
    events: Arc<Mutex<Vec<DdsEvent>>>,
    clock: Arc<dyn Clock>,
    requests: u32,
    _node: DdsNode,
}

/// Who flies one vehicle.
pub struct Pilot {
    pub system_id: u8,
    pub events: Vec<LinkEvent>,
    goal: Option<LocalPositionNed>,
}

impl Pilot {
    /// What is streamed from now on.
    pub fn stream(&mut self, goal: LocalPositionNed) {
        self.goal = Some(goal);
    }

    fn result(&self, request: RequestId) -> Option<Result<(), Refusal>> {
        self.events.iter().find_map(|event| match event {
            LinkEvent::Result { request: of, outcome } if *of == request => Some(outcome.clone()),
            _ => None,
        })
    }
}

impl Rig {
    pub fn start(settings: SimSettings, change: impl FnOnce(&mut DdsSettings)) -> Self {
        let mut dds = fresh_domain();
        change(&mut dds);
        let clock: Arc<dyn Clock> = Arc::new(SinceStart(Instant::now()));
        let participant = DomainParticipantBuilder::new(dds.domain_id)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .unwrap();
        let links = Arc::new(DdsLinkTable::default());
        let events = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&events);
        let node = DdsNode::start(DdsArguments {
            participant,
            clock: Arc::clone(&clock),
            settings: LinkSettings::default(),
            links: Arc::clone(&links),
            events: Arc::new(move |event| sink.lock().push(event)),
        });
        Self {
            simulation: skein_sim_dds::start(settings, &dds).unwrap(),
            links,
            events,
            clock,
            requests: 0,
            _node: node.unwrap(),
        }
    }

    pub fn links(&self) -> Vec<Arc<DdsLink>> {
        self.links.links()
    }

    pub fn link(&self, system_id: u8) -> Arc<DdsLink> {
        let mut links = self.links().into_iter();
        links.find(|link| link.system_id().0 == system_id).unwrap()
    }

    pub fn events(&self, which: impl Fn(&DdsEvent) -> bool) -> Vec<DdsEvent> {
        self.events
            .lock()
            .iter()
            .filter(|event| which(event))
            .cloned()
            .collect()
    }

    /// What a vehicle was taken for when it was found.
    pub fn releases(&self, of: u8) -> Vec<Release> {
        let found = self.events.lock().iter().find_map(|event| match event {
            DdsEvent::Discovered {
                system_id, releases, ..
            } if *system_id == of => Some(releases.clone()),
            _ => None,
        });
        found.unwrap()
    }

    pub fn telemetry(&self, system_id: u8) -> Telemetry {
        self.link(system_id).read(self.clock.now()).0
    }

    pub fn is_connected(&self, system_id: u8) -> bool {
        self.link(system_id).read(self.clock.now()).1.connected
    }

    pub fn local(&self, system_id: u8) -> LocalPositionNed {
        self.telemetry(system_id).local.unwrap()
    }

    pub fn truth(&self, system_id: u8) -> VehicleTruth {
        self.simulation.truth().vehicle(system_id).unwrap().clone()
    }

    /// Whether everything that the topics tell is there and true.
    pub fn agrees_with_truth(&self, system_id: u8) -> bool {
        let (told, truth) = (self.telemetry(system_id), self.truth(system_id));
        let near = |place: Option<skein_domain::Geodetic>| {
            place.is_some_and(|place| {
                (place.latitude_deg - truth.geodetic.latitude_deg).abs() < 1e-6
                    && (place.longitude_deg - truth.geodetic.longitude_deg).abs() < 1e-6
                    && (place.altitude_amsl_m - truth.geodetic.altitude_amsl_m).abs() < 0.2
            })
        };
        near(told.global)
            && near(told.home)
            && near(told.gnss_place)
            && near(
                told.local_frame
                    .zip(told.local)
                    .map(|(frame, local)| frame.geodetic(&local)),
            )
            && told.mode == truth.mode
            && !told.armed
            && told.ready_to_arm == Some(true)
            && told.landed == truth.landed
            && (f64::from(told.yaw_rad) - truth.yaw_rad).abs() < 0.01
            && told
                .battery
                .remaining
                .is_some_and(|charge| (f64::from(charge) - truth.battery).abs() < 0.01)
            && told
                .estimator
                .is_some_and(|estimator| estimator.is_position_good(false))
    }

    /// Waits until something is so.
    pub fn until(&mut self, what: &str, mut done: impl FnMut(&Self) -> bool) {
        let begun = Instant::now();
        while !done(self) {
            assert!(
                begun.elapsed() < PATIENCE,
                "waited in vain until {what}: {:?}",
                self.events.lock()
            );
            std::thread::sleep(PERIOD);
        }
    }

    /// A pilot for each vehicle, once all are admitted and ready to be armed.
    pub fn pilots(&mut self) -> Vec<Pilot> {
        let ids = self.simulation.system_ids();
        self.until("all are admitted", |rig| rig.links().len() == ids.len());
        self.until("all are ready", |rig| {
            let ready = |id: &u8| rig.telemetry(*id).ready_to_arm == Some(true) && rig.telemetry(*id).home.is_some();
            ids.iter().all(ready)
        });
        let pilot = |system_id| Pilot {
            system_id,
            events: Vec::new(),
            goal: None,
        };
        ids.into_iter().map(pilot).collect()
    }

    /// Ends a vehicle's stream on purpose.
    pub fn stop_stream(&self, pilot: &mut Pilot) {
        pilot.goal = None;
        self.link(pilot.system_id).stop_stream(self.clock.now());
    }

    /// Streams and listens until something is so.
    pub fn fly_until(&mut self, pilots: &mut [Pilot], what: &str, mut done: impl FnMut(&Self) -> bool) {
        self.pursue(pilots, what, |rig, _| done(rig));
    }

    /// The same until one's link has told something.
    pub fn until_told(&mut self, pilots: &mut [Pilot], index: usize, event: &LinkEvent) {
        self.pursue(pilots, "the link tells it", |_, pilots| {
            pilots[index].events.contains(event)
        });
    }

    fn pursue(&mut self, pilots: &mut [Pilot], what: &str, mut done: impl FnMut(&Self, &[Pilot]) -> bool) {
        let begun = Instant::now();
        loop {
            for pilot in pilots.iter_mut() {
                let link = self.link(pilot.system_id);
                let now = self.clock.now();
                if let Some(goal) = pilot.goal {
                    let setpoint = LocalSetpoint {
                        position: Some(goal),
                        ..LocalSetpoint::default()
                    };
                    link.stream(now, setpoint, now.plus_seconds(VALID_S));
                }
                pilot.events.extend(link.take_events());
            }
            if done(self, pilots) {
                return;
            }
            let at: Vec<_> = self.simulation.truth().vehicles.clone();
            assert!(begun.elapsed() < PATIENCE, "waited in vain until {what}: {at:?}");
            std::thread::sleep(PERIOD);
        }
    }

    /// Asks one vehicle for something while all are flown on, and gives the outcome.
    pub fn ask(&mut self, pilots: &mut [Pilot], index: usize, command: AutopilotCommand) -> Result<(), Refusal> {
        let request = self.request(pilots[index].system_id, command);
        self.pursue(pilots, "an answer comes", |_, pilots| {
            pilots[index].result(request).is_some()
        });
        pilots[index].result(request).unwrap()
    }

    fn request(&mut self, system_id: u8, command: AutopilotCommand) -> RequestId {
        self.requests += 1;
        let request = RequestId(self.requests);
        self.link(system_id).request(self.clock.now(), request, command);
        request
    }

    /// Asks all for something, which all have to do.
    fn ask_all(&mut self, pilots: &mut [Pilot], command: AutopilotCommand) {
        let requests: Vec<_> = pilots.iter().map(|p| self.request(p.system_id, command)).collect();
        self.pursue(pilots, "all have answered", |_, pilots| {
            pilots
                .iter()
                .zip(&requests)
                .all(|(pilot, request)| pilot.result(*request).is_some())
        });
        for (pilot, request) in pilots.iter().zip(&requests) {
            assert_eq!(
                pilot.result(*request),
                Some(Ok(())),
                "{command:?} of {}",
                pilot.system_id
            );
        }
    }

    /// Armed, up, and in OFFBOARD where each is then.
    pub fn take_off(&mut self, pilots: &mut [Pilot], height_m: f64) {
        self.ask_all(pilots, AutopilotCommand::Arm);
        self.ask_all(pilots, AutopilotCommand::TakeOff { height_m });
        let ids: Vec<_> = pilots.iter().map(|pilot| pilot.system_id).collect();
        self.fly_until(pilots, "all are up and hold", |rig| {
            let up = |truth: VehicleTruth| truth.mode == FlightMode::Hold && truth.height_m > height_m - 0.5;
            ids.iter()
                .all(|id| up(rig.truth(*id)) && rig.telemetry(*id).mode == FlightMode::Hold)
        });
        for pilot in pilots.iter_mut() {
            pilot.goal = Some(self.local(pilot.system_id));
        }
        self.ask_all(pilots, AutopilotCommand::EnterOffboard);
        assert!(ids.iter().all(|id| self.truth(*id).setpoints > 0));
    }

    /// Flown by setpoints to places in the vehicles' own frames, judged by the truth.
    pub fn fly_to(&mut self, pilots: &mut [Pilot], places: &[LocalPositionNed]) {
        for (pilot, place) in pilots.iter_mut().zip(places) {
            pilot.goal = Some(*place);
        }
        let ids: Vec<_> = pilots.iter().map(|pilot| pilot.system_id).collect();
        self.fly_until(pilots, "all are there", |rig| {
            ids.iter().zip(places).all(|(id, place)| {
                let truth = rig.truth(*id);
                let (here, origin) = (truth.position.vector(), truth.local_origin.vector());
                let off_m = (here - origin - place.vector()).norm();
                truth.mode == FlightMode::Offboard && off_m < NEAR_M && truth.velocity.vector().norm() < SLOW_M_S
            })
        });
    }

    /// Down, and the motors off.
    pub fn land(&mut self, pilots: &mut [Pilot]) {
        self.ask_all(pilots, AutopilotCommand::Land);
        let ids: Vec<_> = pilots.iter().map(|pilot| pilot.system_id).collect();
        for pilot in pilots.iter_mut() {
            self.stop_stream(pilot);
        }
        self.fly_until(pilots, "all are down and disarmed", |rig| {
            ids.iter().all(|id| {
                let truth = rig.truth(*id);
                truth.touches_ground && !truth.armed && !rig.telemetry(*id).armed
            })
        });
    }
}
