//! Both sides of a test: the peer with its vehicles, and a node's link with the one who flies by it.
//!
//! Must never do: use a domain of another test; reach beyond loopback.

use anyhow::{Context, Result, bail, ensure};
use parking_lot::Mutex;
use rustdds::DomainParticipantBuilder;
use serde_json::{Value, json};
use skein_domain::link::{LinkEvent, VehicleLink};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, Clock, LocalPositionNed, NodeTime, Refusal, RequestId, Telemetry};
use skein_link_dds::definitions::Release;
use skein_link_dds::{DdsArguments, DdsEvent, DdsLink, DdsLinkTable, DdsNode};
use skein_px4::LinkSettings;
use skein_tests_interop::{CYCLONE, CYCLONE_ON_LOOPBACK, Peer, say};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Longest time anything here may take: far over what it does take, so that a loaded machine fails nothing.
pub const PATIENCE: Duration = Duration::from_secs(40);
/// How often the one who flies looks and says where to.
const PERIOD: Duration = Duration::from_millis(20);
/// Where the vehicles are launched: latitude, longitude in degrees, metres above the sea.
pub const PLACE: [f64; 3] = [47.397_742, 8.545_594, 488.0];
/// A domain for one test.
pub fn domain() -> u16 {
    static GIVEN: AtomicU32 = AtomicU32::new(0);
    let number = GIVEN.fetch_add(1, Ordering::Relaxed);
    u16::try_from((std::process::id() * 17 + number) % 100).unwrap_or(0) + 1
}

/// Cyclone DDS, with no vehicle yet.
pub fn peer() -> Result<Peer> {
    Peer::start("px4_cyclone.py", &CYCLONE, &[("CYCLONEDDS_URI", CYCLONE_ON_LOOPBACK)])
}

/// What a vehicle is switched on with; `more` has the rest.
pub fn vehicle(who: &str, domain: u16, namespace: &str, release: &str, system_id: u8, more: &Value) -> Value {
    let mut start = json!({
        "do": "start", "who": who, "domain": domain, "namespace": namespace, "release": release, "system_id": system_id,
        "place": PLACE,
    });
    if let (Some(start), Some(more)) = (start.as_object_mut(), more.as_object()) {
        start.extend(more.clone());
    }
    start
}

struct WallClock(Instant);

impl Clock for WallClock {
    fn now(&self) -> NodeTime {
        NodeTime(1_000_000 + self.0.elapsed().as_micros() as u64)
    }
}

/// A node's DDS.
pub struct Skein {
    clock: Arc<dyn Clock>,
    events: Arc<Mutex<Vec<DdsEvent>>>,
    node: DdsNode,
}

impl Skein {
    pub fn start(domain: u16) -> Result<Self> {
        let participant = DomainParticipantBuilder::new(domain)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .map_err(|error| anyhow::anyhow!("no participant: {error}"))?;
        let clock: Arc<dyn Clock> = Arc::new(WallClock(Instant::now()));
        let events = Arc::<Mutex<Vec<DdsEvent>>>::default();
        let sink = Arc::clone(&events);
        let node = DdsNode::start(DdsArguments {
            participant,
            clock: Arc::clone(&clock),
            settings: LinkSettings::default(),
            links: Arc::<DdsLinkTable>::default(),
            events: Arc::new(move |event| {
                say(&format!("    ! {event:?}"));
                sink.lock().push(event);
            }),
        })?;
        Ok(Self { clock, events, node })
    }

    /// All events so far.
    pub fn events(&self) -> Vec<DdsEvent> {
        self.events.lock().clone()
    }

    /// Waits until the events give something.
    pub fn wait<T>(&self, what: &str, mut probe: impl FnMut(&DdsEvent) -> Option<T>) -> Result<T> {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = self.events.lock().iter().find_map(&mut probe) {
                return Ok(found);
            }
            ensure!(self.node.goes_on(), "the node's thread has ended");
            ensure!(Instant::now() < end, "waited in vain for {what}: {:?}", self.events());
            std::thread::sleep(PERIOD);
        }
    }

    /// The vehicle of a namespace and id, once it is admitted.
    pub fn vehicle(&self, namespace: &str, id: u8) -> Result<Flown> {
        let found = self.wait(&format!("{id} in {namespace}"), |event| match event {
            DdsEvent::Discovered {
                link,
                system_id,
                releases,
            } if link.namespace().name() == namespace && *system_id == id => Some((Arc::clone(link), releases.clone())),
            _ => None,
        });
        let (link, releases) = found?;
        Ok(Flown {
            link,
            releases,
            clock: Arc::clone(&self.clock),
            events: Vec::new(),
            setpoint: None,
            requests: 0,
        })
    }
}

/// A vehicle under the control of a test, as a vehicle actor has it.
pub struct Flown {
    pub link: Arc<DdsLink>,
    pub releases: Vec<Release>,
    pub events: Vec<LinkEvent>,
    /// What is streamed.
    pub setpoint: Option<LocalSetpoint>,
    clock: Arc<dyn Clock>,
    requests: u32,
}

impl Flown {
    pub fn now(&self) -> NodeTime {
        self.clock.now()
    }

    pub fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock)
    }

    /// One period: looks, listens, says where to.
    pub fn step(&mut self) -> Result<Telemetry> {
        let now = self.now();
        if let Some(setpoint) = self.setpoint {
            self.link.stream(now, setpoint, now.plus_seconds(0.5));
        }
        for event in self.link.take_events() {
            say(&format!("    {} {event:?}", self.link.namespace()));
            self.events.push(event);
        }
        let (telemetry, _) = self.link.read(now);
        let finite = telemetry.local.is_none_or(|local| local.is_finite())
            && telemetry.velocity.is_none_or(|velocity| velocity.is_finite())
            && telemetry.global.is_none_or(|place| place.is_valid())
            && [telemetry.roll_rad, telemetry.pitch_rad, telemetry.yaw_rad]
                .iter()
                .all(|angle| angle.is_finite());
        ensure!(finite, "not a number: {telemetry:?}");
        std::thread::sleep(PERIOD);
        Ok(telemetry)
    }

    /// Goes on until something holds.
    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&Telemetry, &[LinkEvent]) -> bool) -> Result<Telemetry> {
        let end = Instant::now() + PATIENCE;
        loop {
            let telemetry = self.step()?;
            if holds(&telemetry, &self.events) {
                return Ok(telemetry);
            }
            if Instant::now() > end {
                bail!("waited in vain until {what}: {telemetry:?} {:?}", self.events);
            }
        }
    }

    /// Asks for something and goes on until it has ended.
    pub fn ask(&mut self, command: AutopilotCommand) -> Result<Result<(), Refusal>> {
        self.requests += 1;
        let request = RequestId(self.requests);
        self.link.request(self.now(), request, command);
        let outcome = |events: &[LinkEvent]| {
            events.iter().find_map(|event| match event {
                LinkEvent::Result { request: r, outcome } if *r == request => Some(outcome.clone()),
                _ => None,
            })
        };
        self.until(&format!("{command:?} has ended"), |_, events| outcome(events).is_some())?;
        outcome(&self.events).context("an outcome")
    }

    /// Asks for what has to work.
    pub fn order(&mut self, command: AutopilotCommand) -> Result<()> {
        let outcome = self.ask(command)?;
        ensure!(outcome.is_ok(), "{command:?}: {outcome:?}");
        Ok(())
    }

    /// Streams a place in the vehicle's own frame from now on: north, east, down in metres.
    pub fn stream_position(&mut self, [north_m, east_m, down_m]: [f64; 3]) {
        self.setpoint = Some(LocalSetpoint {
            position: Some(LocalPositionNed::new(north_m, east_m, down_m)),
            yaw_rad: Some(1.0),
            ..LocalSetpoint::default()
        });
    }

    /// From the ground into OFFBOARD at five metres above where it stands.
    pub fn enter_offboard(&mut self) -> Result<[f64; 3]> {
        let ready =
            |t: &Telemetry, _: &[LinkEvent]| t.ready_to_arm == Some(true) && t.local.is_some() && t.global.is_some();
        let local = self.until("it is ready", ready)?.local.context("a position")?;
        self.order(AutopilotCommand::Arm)?;
        self.order(AutopilotCommand::TakeOff { height_m: 5.0 })?;
        self.until("it hovers", |t, _| t.local.is_some_and(|local| local.down_m < -4.5))?;
        let over = [local.north_m, local.east_m, -5.0];
        self.stream_position(over);
        self.order(AutopilotCommand::EnterOffboard)?;
        Ok(over)
    }
}

/// A number of the truth.
pub fn number(truth: &Value, key: &str) -> f64 {
    truth[key].as_f64().unwrap_or(f64::NAN)
}

/// Three numbers of the truth.
pub fn triple(truth: &Value, key: &str) -> [f64; 3] {
    [0, 1, 2].map(|i| truth[key][i].as_f64().unwrap_or(f64::NAN))
}

/// Nothing has reached the vehicle that must not: no setpoint without meaning, none that is infinite, no stamp off its clock, no command to
/// another or to nobody, none but these.
pub fn nothing_wrong(peer: &Peer, who: &str, commands: &[u64]) -> Result<()> {
    let truth = peer.truth(who);
    for key in ["infinite", "idle", "stamps_off", "misdirected"] {
        ensure!(truth[key] == 0, "{key}: {truth}");
    }
    for report in peer.reports().iter().filter(|report| report["who"] == who) {
        let command = report["command"].as_u64().context("a number")?;
        ensure!(commands.contains(&command), "{report} was never asked for");
    }
    Ok(())
}
