//! One vehicle over two links, of which one flies it and the other stands by.
//!
//! Must never do: send setpoints over both, for an older one on the slower link would pull the vehicle back; hand over while neither is
//! heard; take what the link that stands by notices for news.

use parking_lot::Mutex;
use skein_config::LinkKind;
use skein_domain::link::{LinkEvent, MessageTap, RoutePoint, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, CommandId, FlightMode, LinkHealth, NodeTime, ParameterEvent, ParameterList, ParameterValue,
    ReadingAction, Refusal, RequestId, SystemId, Telemetry, VehicleId, VehicleWay,
};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Weak};

/// A link hands over when this many of its messages in succession are missing.
const MISSING: f64 = 4.0;
/// But not before it has been silent for so long, in seconds: the setpoints of a busy computer come no more evenly.
const SILENT_AT_LEAST_S: f64 = 0.12;
/// And at the latest after so long, in seconds: less than the half second after which PX4 leaves OFFBOARD for want of setpoints.
const SILENT_AT_MOST_S: f64 = 0.4;
/// The other link has been heard for so long without a silence, in seconds: after a pause of this program one link is read before the other.
const HEARD_S: f64 = 0.1;
/// The first link takes over again when it has been heard for so long without a silence, in seconds: a link that comes and goes is
/// changed to no more often than that.
const STEADY_S: f64 = 5.0;
/// After a hand-over the flight mode of the new link may be this old, in seconds; MAVLink tells it once a second.
const MODE_AGE_S: f64 = 1.5;
/// Both links tell of one restart of the autopilot within so long, in seconds.
const ONE_REBOOT_S: f64 = 10.0;
/// `MAV_SEVERITY_WARNING` and `MAV_SEVERITY_INFO`.
const WARNING: u8 = 4;
const INFO: u8 = 6;

/// A request whose outcome is open.
#[derive(Debug)]
struct Pending {
    /// What to ask over the other link as well, if that takes over.
    command: Option<AutopilotCommand>,
    /// Whom it was asked over and who has not answered yet.
    asked: Vec<LinkKind>,
}

struct One {
    kind: LinkKind,
    link: Arc<dyn VehicleLink>,
    /// Since when it is heard without a silence.
    steady_since: Option<NodeTime>,
}

struct Inner {
    /// As the link numbers it, for what is refused.
    vehicle: VehicleId,
    /// The first flies, if it can.
    order: [LinkKind; 2],
    links: Vec<One>,
    active: LinkKind,
    connected: bool,
    pending: BTreeMap<RequestId, Pending>,
    events: VecDeque<LinkEvent>,
    taps: Vec<Weak<dyn MessageTap>>,
    /// What was told last of mode and arming.
    mode: Option<FlightMode>,
    armed: Option<bool>,
    /// When what the new link says of mode and arming counts.
    look_again: Option<NodeTime>,
    rebooted: Option<NodeTime>,
    now: NodeTime,
}

/// Flies a vehicle over the first of two links that is heard.
///
/// The setpoint stream goes over one link at a time. When four messages in succession are missing on that (not before 0.12 s, and after 0.4 s at the latest) and the other one is
/// heard, the other one takes over within the same control period: the vehicle stays in OFFBOARD. Requests whose outcome is open are asked again over it. The emergency stop goes over
/// both. Only silence is noticed: a link that hears and is not heard is not told from a good one.
pub struct PairedLink {
    system_id: SystemId,
    inner: Mutex<Inner>,
}

impl PairedLink {
    /// Two links in this order, of which one is there.
    #[must_use]
    pub fn new(order: [LinkKind; 2], kind: LinkKind, link: Arc<dyn VehicleLink>) -> Self {
        let system_id = link.system_id();
        let inner = Inner {
            vehicle: VehicleId(u16::from(system_id.0)),
            order,
            links: vec![One {
                kind,
                link,
                steady_since: None,
            }],
            active: kind,
            connected: true,
            pending: BTreeMap::new(),
            events: VecDeque::new(),
            taps: Vec::new(),
            mode: None,
            armed: None,
            look_again: None,
            rebooted: None,
            now: NodeTime::default(),
        };
        Self {
            system_id,
            inner: Mutex::new(inner),
        }
    }

    /// Takes in the other link, or a new one of this kind in place of the one there was. False if the kind is none of the two, or the one that
    /// is there is heard: two vehicles have one system id.
    pub fn attach(&self, now: NodeTime, kind: LinkKind, link: Arc<dyn VehicleLink>) -> bool {
        let mut inner = self.inner.lock();
        let there = inner.links.iter().position(|one| one.kind == kind);
        let heard = there.and_then(|at| inner.links.get(at));
        if !inner.order.contains(&kind) || heard.is_some_and(|one| one.link.read(now).1.connected) {
            return false;
        }
        for tap in &inner.taps {
            link.tap(Weak::clone(tap));
        }
        if let Some(at) = there {
            inner.links.remove(at);
            inner.nobody_answers(kind);
        }
        inner.links.push(One {
            kind,
            link,
            steady_since: None,
        });
        inner.tell(INFO, format!("it is heard over {kind} as well"));
        true
    }

    /// The link that flies the vehicle now.
    #[must_use]
    pub fn active(&self) -> LinkKind {
        self.inner.lock().active
    }
}

/// After how long a link counts as silent, in seconds.
fn silent_s(health: &LinkHealth) -> f64 {
    let period_s = 1.0 / f64::from(health.receive_rate_hz.max(1.0));
    (MISSING * period_s).clamp(SILENT_AT_LEAST_S, SILENT_AT_MOST_S)
}

impl Inner {
    fn of(&self, kind: LinkKind) -> Option<&Arc<dyn VehicleLink>> {
        self.links.iter().find(|one| one.kind == kind).map(|one| &one.link)
    }

    /// There is always one that is active.
    fn active(&self) -> Option<Arc<dyn VehicleLink>> {
        self.of(self.active).cloned()
    }

    /// The link for what only MAVLink has.
    fn mavlink(&self) -> Option<Arc<dyn VehicleLink>> {
        self.of(LinkKind::Mavlink).cloned().or_else(|| self.active())
    }

    fn tell(&mut self, severity: u8, text: String) {
        self.events.push_back(LinkEvent::StatusText { severity, text });
    }

    /// The link of this kind is gone, and with it the answers that it owed.
    fn nobody_answers(&mut self, kind: LinkKind) {
        let owed: Vec<RequestId> = self
            .pending
            .iter()
            .filter(|(_, pending)| pending.asked.contains(&kind))
            .map(|(request, _)| *request)
            .collect();
        for request in owed {
            let lost = Refusal::LinkLost { vehicle: self.vehicle };
            self.on_result(kind, request, Err(lost));
        }
    }

    /// Looks who is heard, and hands over if it has to be.
    fn look(&mut self, now: NodeTime) {
        self.now = self.now.max(now);
        let mut connected = false;
        for one in &mut self.links {
            let health = one.link.read(now).1;
            connected |= health.connected;
            let heard = health.connected && now.seconds_since(health.last_heard) <= silent_s(&health);
            one.steady_since = heard.then(|| one.steady_since.unwrap_or(now));
        }
        if connected != self.connected {
            self.connected = connected;
            let event = if connected {
                LinkEvent::Regained
            } else {
                LinkEvent::Lost
            };
            self.events.push_back(event);
        }
        if let Some(next) = self.better(now) {
            self.hand_over(now, next);
        }
        self.look_at_mode(now);
    }

    /// Which link should fly instead, if one should.
    fn better(&self, now: NodeTime) -> Option<LinkKind> {
        let heard_s = |kind: LinkKind| {
            let one = self.links.iter().find(|one| one.kind == kind);
            one.and_then(|one| one.steady_since)
                .map(|since| now.seconds_since(since))
        };
        let [first, second] = self.order;
        let other = if self.active == first { second } else { first };
        let silent = heard_s(self.active).is_none();
        let other_heard_s = heard_s(other)?;
        let steady = other == first && other_heard_s >= STEADY_S;
        (steady || (silent && other_heard_s >= HEARD_S)).then_some(other)
    }

    fn hand_over(&mut self, now: NodeTime, to: LinkKind) {
        let from = std::mem::replace(&mut self.active, to);
        // Whatever of it still gets through must not hold a place that the vehicle has left.
        if let Some(link) = self.of(from) {
            link.stop_stream(now);
        }
        if let Some(link) = self.of(to).cloned() {
            for (request, pending) in &mut self.pending {
                if let Some(command) = pending.command.filter(|_| !pending.asked.contains(&to)) {
                    pending.asked.push(to);
                    link.request(now, *request, command);
                }
            }
        }
        self.look_again = Some(now.plus_seconds(MODE_AGE_S));
        self.tell(WARNING, format!("flown over {to} from now on, no more over {from}"));
    }

    /// What changed while one link was silent and the other only stood by is news all the same.
    fn look_at_mode(&mut self, now: NodeTime) {
        if self.look_again.is_none_or(|at| now < at) {
            return;
        }
        self.look_again = None;
        let Some(link) = self.active() else { return };
        let telemetry = link.read(now).0;
        let (to, armed) = (telemetry.mode, telemetry.armed);
        if self.armed.replace(armed).is_some_and(|before| before != armed) {
            self.events.push_back(LinkEvent::ArmedChanged { armed });
        }
        if let Some(from) = self.mode.replace(to).filter(|from| *from != to) {
            self.events.push_back(LinkEvent::ModeChanged {
                from,
                to,
                commanded: false,
            });
        }
    }

    fn collect(&mut self) {
        let news: Vec<_> = self
            .links
            .iter()
            .map(|one| (one.kind, one.link.take_events()))
            .collect();
        for (kind, events) in news {
            for event in events {
                self.take(kind, event);
            }
        }
    }

    fn take(&mut self, kind: LinkKind, event: LinkEvent) {
        match event {
            LinkEvent::Result { request, outcome } => self.on_result(kind, request, outcome),
            LinkEvent::Lost => self.tell(WARNING, format!("not heard over {kind}")),
            LinkEvent::Regained => self.tell(INFO, format!("heard over {kind} again")),
            LinkEvent::Rebooted => {
                let told = self
                    .rebooted
                    .is_some_and(|at| self.now.seconds_since(at) < ONE_REBOOT_S);
                if !told {
                    self.rebooted = Some(self.now);
                    (self.mode, self.armed) = (None, None);
                    self.events.push_back(LinkEvent::Rebooted);
                }
            }
            LinkEvent::StatusText { .. } | LinkEvent::RoutePointReached { .. } => self.events.push_back(event),
            LinkEvent::ModeChanged { to, .. } if kind == self.active => {
                self.mode = Some(to);
                self.events.push_back(event);
            }
            LinkEvent::ArmedChanged { armed } if kind == self.active => {
                self.armed = Some(armed);
                self.events.push_back(event);
            }
            LinkEvent::Stream(_) | LinkEvent::ClockJumped { .. } | LinkEvent::StopUnconfirmed { .. }
                if kind == self.active =>
            {
                self.events.push_back(event);
            }
            // The link that stands by sees the same changes.
            LinkEvent::ModeChanged { .. }
            | LinkEvent::ArmedChanged { .. }
            | LinkEvent::Stream(_)
            | LinkEvent::StopUnconfirmed { .. }
            | LinkEvent::ClockJumped { .. } => {}
        }
    }

    /// Accepted over one is accepted; refused is what all have refused that were asked.
    fn on_result(&mut self, kind: LinkKind, request: RequestId, outcome: Result<(), Refusal>) {
        let Some(pending) = self.pending.get_mut(&request) else {
            return;
        };
        pending.asked.retain(|asked| *asked != kind);
        if outcome.is_ok() || pending.asked.is_empty() {
            self.pending.remove(&request);
            self.events.push_back(LinkEvent::Result { request, outcome });
        }
    }
}

impl VehicleLink for PairedLink {
    fn system_id(&self) -> SystemId {
        self.system_id
    }

    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth) {
        let mut inner = self.inner.lock();
        inner.look(now);
        let read = inner.active().map(|link| link.read(now));
        let (mut telemetry, mut health) = read.unwrap_or_default();
        // Over MAVLink it is told again and again, over DDS only when it changes.
        if let Some(mavlink) = inner.of(LinkKind::Mavlink)
            && inner.active != LinkKind::Mavlink
        {
            let (standing_by, heard) = mavlink.read(now);
            let told = standing_by.home.filter(|_| heard.connected);
            telemetry.home = told.or(telemetry.home);
        }
        health.connected = inner.connected;
        (telemetry, health)
    }

    fn ways(&self, now: NodeTime) -> Vec<VehicleWay> {
        let inner = self.inner.lock();
        let way = |one: &One| VehicleWay {
            name: one.kind.to_string(),
            flies: one.kind == inner.active,
            link: one.link.read(now).1,
        };
        let there = |kind: &LinkKind| inner.links.iter().find(|one| one.kind == *kind).map(way);
        inner.order.iter().filter_map(there).collect()
    }

    fn is_shared(&self) -> bool {
        self.inner.lock().links.iter().any(|one| one.link.is_shared())
    }

    fn take_events(&self) -> Vec<LinkEvent> {
        let mut inner = self.inner.lock();
        inner.collect();
        inner.events.drain(..).collect()
    }

    fn request(&self, now: NodeTime, request: RequestId, command: AutopilotCommand) {
        let mut inner = self.inner.lock();
        inner.look(now);
        let active = inner.active;
        let is_asked = |one: &&One| one.kind == active;
        let asked: Vec<(LinkKind, Arc<dyn VehicleLink>)> = inner
            .links
            .iter()
            .filter(is_asked)
            .map(|one| (one.kind, Arc::clone(&one.link)))
            .collect();
        let pending = Pending {
            command: Some(command),
            asked: asked.iter().map(|(kind, _)| *kind).collect(),
        };
        inner.pending.insert(request, pending);
        for (_, link) in asked {
            link.request(now, request, command);
        }
    }

    fn stop_motors(&self, now: NodeTime, request: RequestId) -> Result<(), Refusal> {
        let mut inner = self.inner.lock();
        inner.look(now);
        let links: Vec<(LinkKind, Arc<dyn VehicleLink>)> = inner
            .links
            .iter()
            .map(|one| (one.kind, Arc::clone(&one.link)))
            .collect();
        let pending = Pending {
            command: Some(AutopilotCommand::EmergencyStop),
            asked: links.iter().map(|(kind, _)| *kind).collect(),
        };
        inner.pending.insert(request, pending);
        // Over both before anything is said of either.
        let sent: Vec<Result<(), Refusal>> = links.iter().map(|(_, link)| link.stop_motors(now, request)).collect();
        sent.into_iter().reduce(Result::or).unwrap_or(Ok(()))
    }

    fn stream(&self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        let mut inner = self.inner.lock();
        inner.look(now);
        if let Some(link) = inner.active() {
            link.stream(now, setpoint, expires);
        }
    }

    fn resume_stream(&self) {
        for one in &self.inner.lock().links {
            one.link.resume_stream();
        }
    }

    fn stop_stream(&self, now: NodeTime) {
        for one in &self.inner.lock().links {
            one.link.stop_stream(now);
        }
    }

    fn upload_route(&self, now: NodeTime, request: RequestId, route: &[RoutePoint]) {
        let mut inner = self.inner.lock();
        let Some(link) = inner.mavlink() else { return };
        let asked = inner.links.iter().filter(|one| Arc::ptr_eq(&one.link, &link));
        let pending = Pending {
            // The other one has no routes.
            command: None,
            asked: asked.map(|one| one.kind).collect(),
        };
        inner.pending.insert(request, pending);
        link.upload_route(now, request, route);
    }

    fn tap(&self, tap: Weak<dyn MessageTap>) {
        let mut inner = self.inner.lock();
        inner.taps.retain(|known| known.strong_count() > 0);
        for one in &inner.links {
            one.link.tap(Weak::clone(&tap));
        }
        inner.taps.push(tap);
    }

    fn send_payload(&self, now: NodeTime, message: &MavlinkMessage) -> Result<(), Refusal> {
        let inner = self.inner.lock();
        let lost = Refusal::LinkLost { vehicle: inner.vehicle };
        inner.mavlink().ok_or(lost)?.send_payload(now, message)
    }

    fn parameters(&self, since: u64) -> Result<ParameterList, Refusal> {
        let inner = self.inner.lock();
        let lost = Refusal::LinkLost { vehicle: inner.vehicle };
        inner.mavlink().ok_or(lost)?.parameters(since)
    }

    fn read_parameters(&self, now: NodeTime, action: ReadingAction) -> Result<(), Refusal> {
        let inner = self.inner.lock();
        let lost = Refusal::LinkLost { vehicle: inner.vehicle };
        inner.mavlink().ok_or(lost)?.read_parameters(now, action)
    }

    fn write_parameter(&self, now: NodeTime, id: CommandId, name: &str, value: ParameterValue) {
        let inner = self.inner.lock();
        // There is always one; it says itself if it has none.
        if let Some(link) = inner.mavlink() {
            link.write_parameter(now, id, name, value);
        }
    }

    fn take_parameter_events(&self) -> Vec<ParameterEvent> {
        let inner = self.inner.lock();
        let events = inner.links.iter().map(|one| one.link.take_parameter_events());
        events.flatten().collect()
    }
}

#[cfg(test)]
mod tests;
