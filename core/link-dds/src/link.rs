//! One vehicle's link as the vehicle actor sees it: the session behind a lock, and the writers of its topics.
//!
//! Must never do: wait. Writers are best effort: they wait for no reader.

use crate::messages::incoming::{OffboardControlMode, TrajectorySetpoint, VehicleCommand};
use crate::naming::Namespace;
use crate::raw::Writers;
use crate::sample::Sample;
use crate::session::VehicleSession;
use crate::session::setpoint::Outgoing;
use parking_lot::Mutex;
use skein_domain::link::{LinkEvent, MessageTap, RoutePoint, StreamState, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, CommandId, LinkHealth, NodeTime, ParameterError, ParameterEvent, ParameterList, ParameterValue,
    ReadingAction, Refusal, RequestId, SystemId, Telemetry,
};
use skein_px4::LinkSettings;
use skein_px4::emergency::TRY_FOR_S;
use std::fmt;
use std::sync::Weak;

/// More of them are not kept until somebody looks.
const REFUSED_MAX: usize = 64;

struct Inner {
    session: VehicleSession,
    /// Writes of parameters that were asked for.
    refused: Vec<ParameterEvent>,
    writers: Writers,
    due: NodeTime,
    unsent: u64,
}

impl Inner {
    /// Sends what waits; gives how many messages DDS took.
    fn flush(&mut self) -> usize {
        let mut taken = 0;
        // Whatever was asked may have something due before the next look.
        self.due = NodeTime::default();
        for outgoing in self.session.take_outgoing() {
            let sent = match outgoing {
                Outgoing::Command(command) => self.writers.command(command),
                Outgoing::Setpoint(mode, setpoint) => self.writers.setpoint(mode, setpoint),
            };
            self.unsent += u64::from(!sent);
            taken += usize::from(sent);
        }
        taken
    }
}

/// One PX4 vehicle's link over DDS. What stands at `Px4Link` about take-overs and giving up holds here as well.
///
/// There is no way for a route, for a payload's MAVLink or for parameters over PX4's topics: all are refused as not supported.
pub struct DdsLink {
    system_id: u8,
    namespace: Namespace,
    inner: Mutex<Inner>,
}

impl fmt::Debug for DdsLink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (system_id, namespace) = (self.system_id, &self.namespace);
        f.debug_struct("DdsLink")
            .field("system_id", &system_id)
            .field("namespace", namespace)
            .finish_non_exhaustive()
    }
}

impl DdsLink {
    pub(crate) fn new(
        settings: &LinkSettings,
        system_id: u8,
        namespace: Namespace,
        writers: Writers,
        now: NodeTime,
    ) -> Self {
        let inner = Inner {
            session: VehicleSession::new(settings, system_id, now),
            refused: Vec::new(),
            writers,
            due: now,
            unsent: 0,
        };
        Self {
            system_id,
            namespace,
            inner: Mutex::new(inner),
        }
    }

    pub(crate) fn receive(&self, now: NodeTime, sample: &Sample) {
        let mut inner = self.inner.lock();
        inner.session.on_sample(now, sample);
        inner.flush();
    }

    /// Does what is due.
    pub(crate) fn tick(&self, now: NodeTime) {
        let mut inner = self.inner.lock();
        if now >= inner.due {
            let due = inner.session.on_tick(now);
            inner.flush();
            inner.due = due;
        }
    }

    pub(crate) fn set_duplicate(&self, now: NodeTime, duplicate: bool) {
        let mut inner = self.inner.lock();
        inner.session.set_duplicate(now, duplicate);
        inner.flush();
    }

    pub(crate) fn refuse_all(&self, now: NodeTime, refusal: Refusal) {
        let mut inner = self.inner.lock();
        inner.session.refuse_all(now, refusal);
        inner.flush();
    }

    pub(crate) fn doubt_clock(&self) {
        self.inner.lock().session.doubt_clock();
    }

    pub(crate) fn is_duplicate(&self) -> bool {
        self.inner.lock().session.is_duplicate()
    }

    pub(crate) fn notice(&self, severity: u8, text: String) {
        self.inner.lock().session.notice(severity, text);
    }

    pub(crate) fn system_id_number(&self) -> u8 {
        self.system_id
    }

    /// Where its topics are.
    #[must_use]
    pub fn namespace(&self) -> &Namespace {
        &self.namespace
    }

    /// Whether the autopilot's own failsafe is acting. Tells a failsafe from a pilot when OFFBOARD was left unasked.
    #[must_use]
    pub fn in_failsafe(&self) -> bool {
        self.inner.lock().session.in_failsafe()
    }

    /// What the setpoint stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.inner.lock().session.stream_state()
    }

    /// When a sample was last heard.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        self.inner.lock().session.last_heard()
    }

    /// Messages that DDS did not take, since the start.
    #[must_use]
    pub fn unsent(&self) -> u64 {
        self.inner.lock().unsent
    }
}

impl VehicleLink for DdsLink {
    fn system_id(&self) -> SystemId {
        SystemId(self.system_id)
    }

    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth) {
        self.inner.lock().session.read(now)
    }

    fn is_shared(&self) -> bool {
        self.is_duplicate()
    }

    fn take_events(&self) -> Vec<LinkEvent> {
        self.inner.lock().session.take_events()
    }

    fn request(&self, now: NodeTime, request: RequestId, command: AutopilotCommand) {
        let mut inner = self.inner.lock();
        inner.session.request(now, request, command);
        inner.flush();
    }

    fn stop_motors(&self, now: NodeTime, request: RequestId) -> Result<(), Refusal> {
        let mut inner = self.inner.lock();
        // What waits from before does not count as sent now.
        inner.flush();
        inner.session.stop_motors(now, request)?;
        if inner.flush() > 0 {
            return Ok(());
        }
        let detail = format!(
            "DDS takes nothing for {} now; it is tried again for {TRY_FOR_S:.0} s",
            self.namespace
        );
        Err(Refusal::NotSent { detail })
    }

    fn stream(&self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime) {
        let mut inner = self.inner.lock();
        inner.session.stream(now, setpoint, expires);
        inner.flush();
    }

    fn resume_stream(&self) {
        self.inner.lock().session.resume_stream();
    }

    fn stop_stream(&self, now: NodeTime) {
        let mut inner = self.inner.lock();
        inner.session.stop_stream(now);
        inner.flush();
    }

    fn upload_route(&self, _now: NodeTime, request: RequestId, _route: &[RoutePoint]) {
        self.inner.lock().session.not_supported(request, "a route");
    }

    /// Gets nothing: there is no MAVLink on this link.
    fn tap(&self, _tap: Weak<dyn MessageTap>) {}

    fn send_payload(&self, _now: NodeTime, message: &MavlinkMessage) -> Result<(), Refusal> {
        let what = format!("MAVLink message {} of a payload over DDS", message.message_id);
        Err(Refusal::not_supported(what))
    }

    fn parameters(&self, _since: u64) -> Result<ParameterList, Refusal> {
        Err(no_parameters())
    }

    fn read_parameters(&self, _now: NodeTime, _action: ReadingAction) -> Result<(), Refusal> {
        Err(no_parameters())
    }

    fn write_parameter(&self, _now: NodeTime, id: CommandId, name: &str, _value: ParameterValue) {
        let refused = &mut self.inner.lock().refused;
        if refused.len() < REFUSED_MAX {
            refused.push(ParameterEvent {
                id: Some(id),
                name: name.to_owned(),
                before: None,
                outcome: Err(ParameterError::Refused(no_parameters())),
            });
        }
    }

    fn take_parameter_events(&self) -> Vec<ParameterEvent> {
        std::mem::take(&mut self.inner.lock().refused)
    }
}

fn no_parameters() -> Refusal {
    Refusal::not_supported("parameters over DDS")
}

impl Writers {
    fn command(&self, command: VehicleCommand) -> bool {
        self.commands.write(command, None).is_ok()
    }

    /// What of a setpoint counts goes before it.
    fn setpoint(&self, mode: OffboardControlMode, setpoint: TrajectorySetpoint) -> bool {
        self.modes.write(mode, None).is_ok() && self.setpoints.write(setpoint, None).is_ok()
    }
}
