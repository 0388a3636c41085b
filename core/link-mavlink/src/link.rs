//! One vehicle's link as the vehicle actor sees it: the core behind a lock, and the way out.
//!
//! Must never do: wait. Everything that is asked comes back as an event.

use crate::decode::{Heartbeat, Inbound, decode};
use crate::frame::Frame;
use crate::outlet::Outlet;
use crate::source::Source;
use crate::taps::Taps;
use crate::vehicle::cameras::ToldCamera;
use crate::vehicle::{AUTOPILOT_COMPONENT, AutopilotIdentity, VehicleCore};
use parking_lot::Mutex;
use skein_domain::link::{LinkEvent, MessageTap, RoutePoint, StreamState, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, CommandId, LinkHealth, NodeTime, ParameterEvent, ParameterList, ParameterValue, ReadingAction,
    Refusal, RequestId, SystemId, Telemetry,
};
use skein_px4::LinkSettings;
use skein_px4::emergency::TRY_FOR_S;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};

/// Where a vehicle is heard and answered. Two are the same place if endpoint and address are.
#[derive(Debug, Clone)]
pub(crate) struct Route {
    /// Name of the endpoint.
    pub endpoint: Arc<str>,
    /// The endpoint's number in the node.
    pub number: usize,
    /// The way out.
    pub outlet: Arc<Outlet>,
    /// Where to, behind a UDP socket.
    pub address: Option<SocketAddr>,
}

impl Route {
    /// Whether a frame from `address` at endpoint `number` comes from here.
    pub fn is(&self, number: usize, address: Option<SocketAddr>) -> bool {
        self.number == number && self.address == address
    }

    /// For events.
    pub fn source(&self) -> Source {
        Source {
            endpoint: Arc::clone(&self.endpoint),
            address: self.address,
        }
    }
}

/// Whether another sender uses the vehicle's system id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Contest {
    /// None does.
    #[default]
    Nobody,
    /// One does elsewhere: what is sent goes to the vehicle alone.
    Elsewhere,
    /// One does at the vehicle's own place: what is sent reaches both.
    Here,
}

/// What became of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Received {
    /// Read, or given to a payload that wants it.
    Read,
    /// Of a message nobody reads, or of another component.
    Ignored,
    /// A field holds a value the protocol description does not know.
    Undecodable,
    /// From another place than the vehicle's.
    Foreign,
}

/// What a tick found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Ticked {
    /// When to come again.
    pub due: NodeTime,
    /// The link was declared lost in this tick.
    pub lost: bool,
    /// Two autopilots were heard with this system id from one place, at this time.
    pub interleaved: Option<NodeTime>,
    /// Whether another sender uses its system id, or did lately.
    pub contested: bool,
}

#[derive(Debug)]
struct Inner {
    core: VehicleCore,
    route: Route,
    taps: Taps,
}

impl Inner {
    /// Sends what waits; gives how many frames the line took.
    fn flush(&mut self) -> usize {
        let Self { core, route, .. } = self;
        let mut sent = 0;
        if !core.outbox().is_empty() {
            core.outbox()
                .drain(|frame| sent += usize::from(route.outlet.send(route.address, frame)));
        }
        sent
    }
}

/// One PX4 vehicle's link. Shared by the endpoint (frames in, ticks) and the vehicle actor (requests, setpoints).
///
/// Nothing is sent to it after it was taken over (its autopilot left OFFBOARD though nobody here asked for it) or after its
/// stream was given up, until OFFBOARD is asked for by [`AutopilotCommand::EnterOffboard`]: PX4 would go back to OFFBOARD by
/// itself. Setpoints that are offered meanwhile are dropped. That request waits by itself until the stream has run long enough.
#[derive(Debug)]
pub struct Px4Link {
    system_id: u8,
    inner: Mutex<Inner>,
    /// Another sender uses its system id, at its own place or elsewhere.
    contested: AtomicBool,
}

impl Px4Link {
    pub(crate) fn new(
        settings: Arc<LinkSettings>,
        system_id: u8,
        first: &Heartbeat,
        route: Route,
        now: NodeTime,
    ) -> Self {
        let core = VehicleCore::new(settings, system_id, first, now);
        Self {
            system_id,
            inner: Mutex::new(Inner {
                core,
                route,
                taps: Taps::default(),
            }),
            contested: AtomicBool::new(false),
        }
    }

    /// Takes in a frame of this system id that came from `address` at endpoint `number`.
    pub(crate) fn receive(
        &self,
        now: NodeTime,
        number: usize,
        address: Option<SocketAddr>,
        frame: &Frame<'_>,
    ) -> Received {
        let mut inner = self.inner.lock();
        let of_autopilot = frame.header.component_id == AUTOPILOT_COMPONENT;
        inner.core.cameras().hear(now, frame);
        if !inner.route.is(number, address) {
            // A camera or a second computer of the same vehicle may well sit elsewhere; with two senders of one system id
            // nobody can tell whose it is.
            if !of_autopilot && !self.is_contested() {
                inner.taps.give(frame);
            }
            return Received::Foreign;
        }
        let tapped = inner.taps.give(frame);
        let (read, received): (Option<Inbound>, _) = if of_autopilot && frame.known {
            match decode(frame) {
                Some(Ok(message)) => (Some(message), Received::Read),
                Some(Err(_)) => (None, Received::Undecodable),
                None => (None, Received::Ignored),
            }
        } else {
            (None, Received::Ignored)
        };
        if tapped {
            inner.core.on_wanted_frame(now, &frame.header, read);
        } else {
            inner.core.on_frame(now, &frame.header, read);
        }
        inner.flush();
        if tapped && received == Received::Ignored {
            Received::Read
        } else {
            received
        }
    }

    /// Takes in what the radio says that the vehicle is heard through, if it is heard at this place. True if somebody wanted it.
    pub(crate) fn receive_radio(&self, number: usize, address: Option<SocketAddr>, frame: &Frame<'_>) -> bool {
        let mut inner = self.inner.lock();
        inner.route.is(number, address) && inner.taps.give(frame)
    }

    /// Takes in a command of whomever to a component of its system. True if it is for a camera that this node speaks for.
    pub(crate) fn ask_cameras(&self, now: NodeTime, frame: &Frame<'_>) -> bool {
        self.inner.lock().core.cameras().ask(now, frame)
    }

    /// Speaks for these cameras from now on, in place of those before: they are told to ground stations that the autopilot passes messages on to.
    pub fn tell_cameras(&self, now: NodeTime, cameras: Vec<ToldCamera>) {
        self.inner.lock().core.cameras().tell(now, cameras);
    }

    /// Does what is due, if the vehicle is heard at endpoint `number`.
    pub(crate) fn tick(&self, now: NodeTime, number: usize) -> Option<Ticked> {
        let mut inner = self.inner.lock();
        if inner.route.number != number {
            return None;
        }
        let lost = inner.core.check_lost(now);
        let due = inner.core.on_tick(now);
        inner.flush();
        Some(Ticked {
            due,
            lost,
            interleaved: inner.core.interleaved(),
            contested: self.is_contested(),
        })
    }

    /// Where it is heard.
    pub(crate) fn route(&self) -> Route {
        self.inner.lock().route.clone()
    }

    /// It is heard elsewhere from now on.
    pub(crate) fn reroute(&self, route: Route) {
        self.inner.lock().route = route;
    }

    /// Where another sender uses its system id, if one does.
    pub(crate) fn contest(&self, now: NodeTime, contest: Contest) {
        self.contested.store(contest != Contest::Nobody, Ordering::Relaxed);
        let mut inner = self.inner.lock();
        inner.core.set_duplicate(now, contest == Contest::Here);
        inner.flush();
    }

    /// Whether its motors are armed, as its last heartbeat says.
    pub(crate) fn is_armed(&self) -> bool {
        self.inner.lock().core.is_armed()
    }

    /// For how long its autopilot has not been heard, in seconds, without the time in which this node did not listen.
    pub(crate) fn silent_s(&self, now: NodeTime) -> f64 {
        self.inner.lock().core.silent_s(now)
    }

    /// When its autopilot was last heard.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        self.inner.lock().core.last_heard()
    }

    /// Where it is heard.
    #[must_use]
    pub fn source(&self) -> Source {
        self.inner.lock().route.source()
    }

    /// Who its autopilot is.
    #[must_use]
    pub fn identity(&self) -> AutopilotIdentity {
        self.inner.lock().core.identity().clone()
    }

    /// Whether the autopilot's own failsafe is acting, as its last heartbeat says. Tells a failsafe from a pilot when OFFBOARD
    /// was left unasked.
    #[must_use]
    pub fn in_failsafe(&self) -> bool {
        self.inner.lock().core.in_failsafe()
    }

    /// What the setpoint stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.inner.lock().core.stream_state()
    }

    /// Whether another sender uses its system id. Elsewhere: what is sent goes to this vehicle alone, as before. At the same place: nothing
    /// is begun with it that would reach both.
    #[must_use]
    pub fn is_contested(&self) -> bool {
        self.contested.load(Ordering::Relaxed)
    }
}

impl VehicleLink for Px4Link {
    fn system_id(&self) -> SystemId {
        SystemId(self.system_id)
    }

    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth) {
        self.inner.lock().core.read(now)
    }

    fn is_shared(&self) -> bool {
        self.inner.lock().core.is_duplicate()
    }

    fn take_events(&self) -> Vec<LinkEvent> {
        self.inner.lock().core.take_events()
    }

    fn request(&self, now: NodeTime, request: RequestId, command: AutopilotCommand) {
        let mut inner = self.inner.lock();
        inner.core.request(now, request, command);
        inner.flush();
    }

    fn stop_motors(&self, now: NodeTime, request: RequestId) -> Result<(), Refusal> {
        let mut inner = self.inner.lock();
        // What waits from before does not count as sent now.
        inner.flush();
        inner.core.stop_motors(now, request);
        if inner.flush() > 0 {
            return Ok(());
        }
        let detail = format!(
            "{} takes nothing now; it is tried again for {TRY_FOR_S:.0} s",
            inner.route.source()
        );
        Err(Refusal::NotSent { detail })
    }

    fn stream(&self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        let mut inner = self.inner.lock();
        inner.core.stream(now, setpoint, expires);
        inner.flush();
    }

    fn resume_stream(&self) {
        self.inner.lock().core.resume_stream();
    }

    fn stop_stream(&self, now: NodeTime) {
        let mut inner = self.inner.lock();
        inner.core.stop_stream(now);
        inner.flush();
    }

    fn upload_route(&self, now: NodeTime, request: RequestId, route: &[RoutePoint]) {
        let mut inner = self.inner.lock();
        inner.core.upload_route(now, request, route);
        inner.flush();
    }

    /// Of messages that the protocol description here does not know none is given: their checksum cannot be looked at.
    fn tap(&self, tap: Weak<dyn MessageTap>) {
        let mut inner = self.inner.lock();
        if let Some(tap) = tap.upgrade() {
            inner.core.want(|message_id| tap.wants(message_id));
        }
        inner.taps.add(tap);
    }

    fn send_payload(&self, now: NodeTime, message: &MavlinkMessage) -> Result<(), Refusal> {
        let mut inner = self.inner.lock();
        let sent = inner.core.send_payload(now, message);
        inner.flush();
        sent
    }

    fn parameters(&self, since: u64) -> Result<ParameterList, Refusal> {
        Ok(self.inner.lock().core.parameters().list(since))
    }

    fn read_parameters(&self, now: NodeTime, action: ReadingAction) -> Result<(), Refusal> {
        let mut inner = self.inner.lock();
        let begun = inner.core.read_parameters(now, action);
        inner.flush();
        begun
    }

    /// It is read first where its type is not known: PX4 stores an integer sent as another type as nonsense.
    fn write_parameter(&self, now: NodeTime, id: CommandId, name: &str, value: ParameterValue) {
        let mut inner = self.inner.lock();
        inner.core.write_parameter(now, id, name, value);
        inner.flush();
    }

    fn take_parameter_events(&self) -> Vec<ParameterEvent> {
        self.inner.lock().core.parameters().take_events()
    }
}
