//! The port between a vehicle actor and whatever carries it to an autopilot (MAVLink, DDS). The actor cannot tell which.
//!
//! Implementations hold the safety rules that live on the link: OFFBOARD only with the stream already running, setpoint
//! expiry (hold, then stop on purpose), pilot wins.

mod silence;

pub use silence::Silence;

use crate::payload::MavlinkMessage;
use crate::setpoint::LocalSetpoint;
use crate::{
    AutopilotCommand, CommandId, FlightMode, Geodetic, LinkHealth, NodeTime, ParameterEvent, ParameterList,
    ParameterValue, ReadingAction, Refusal, RequestId, SystemId, Telemetry, VehicleWay,
};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use std::sync::Weak;

/// What happened on a link since it was last asked; drained by the vehicle actor once per period.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkEvent {
    /// The autopilot answered a request, or all retries ran out.
    Result {
        /// Which request.
        request: RequestId,
        /// Accepted, or why not.
        outcome: Result<(), Refusal>,
    },
    /// The autopilot has not confirmed an emergency stop in the time in which it should have. It is still being repeated.
    StopUnconfirmed {
        /// How long ago it was first sent, in seconds.
        after_s: f64,
    },
    /// The flight mode changed.
    ModeChanged {
        /// Before.
        from: FlightMode,
        /// Now.
        to: FlightMode,
        /// Whether we had asked for it. An unasked change out of OFFBOARD is the pilot's or the autopilot's failsafe.
        commanded: bool,
    },
    /// The motors were armed or disarmed.
    ArmedChanged {
        /// Armed now.
        armed: bool,
    },
    /// Nothing was heard for the configured time.
    Lost,
    /// Heard again after a loss.
    Regained,
    /// The autopilot restarted (its boot time jumped back).
    Rebooted,
    /// A status text of the autopilot, chunks joined.
    StatusText {
        /// Severity as MAVLink counts it: 0 emergency .. 7 debug.
        severity: u8,
        /// The text.
        text: String,
    },
    /// The setpoint stream changed what it does.
    Stream(StreamState),
    /// The autopilot's clock made a step although it did not restart.
    ClockJumped {
        /// By how much, in seconds; forward positive.
        by_s: f64,
    },
    /// The autopilot flies the uploaded route and has reached a point of it.
    RoutePointReached {
        /// Which, counted from zero.
        index: u16,
    },
}

/// One point of a route that the autopilot flies by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoutePoint {
    /// The place.
    #[n(0)]
    pub place: Geodetic,
    /// Speed on the way there in metres per second; as before if left out.
    #[n(1)]
    pub speed_m_s: Option<f64>,
}

/// What a link's setpoint stream is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum StreamState {
    /// Nothing is sent.
    #[default]
    Stopped,
    /// Fresh setpoints are sent.
    Fresh,
    /// The last setpoint expired: a position hold is sent, for a bounded time.
    HoldingExpired,
    /// The bounded time is over: nothing is sent on purpose, the autopilot's own failsafe takes over.
    GivenUp,
}

/// Where the messages that a payload wants to see are put. Called while the link is locked: must return at once, and bounds what it
/// keeps by itself.
pub trait MessageTap: Send + Sync + 'static {
    /// Whether it wants messages with this id.
    fn wants(&self, message_id: u32) -> bool;

    /// Takes one.
    fn take(&self, message: MavlinkMessage);
}

/// One vehicle's link. All calls return at once; nothing waits for the vehicle.
pub trait VehicleLink: Send + Sync + 'static {
    /// The system id the vehicle uses on this link.
    fn system_id(&self) -> SystemId;

    /// Latest telemetry and link health.
    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth);

    /// Both links, where there are two; else none.
    fn ways(&self, _now: NodeTime) -> Vec<VehicleWay> {
        Vec::new()
    }

    /// Whether another vehicle answers to the same system id at the same place, so that what is sent reaches both.
    fn is_shared(&self) -> bool {
        false
    }

    /// Events since the last call, oldest first. Bounded: status texts beyond the bound are dropped oldest first, others never.
    fn take_events(&self) -> Vec<LinkEvent>;

    /// Ask the autopilot for something; the outcome comes as [`LinkEvent::Result`] with the same id.
    fn request(&self, now: NodeTime, request: RequestId, command: AutopilotCommand);

    /// Stops the motors at once, whatever else is the matter with the link: sent now, ahead of everything, and repeated until the motors are
    /// seen stopped. How it ended comes as [`LinkEvent::Result`], and before that [`LinkEvent::StopUnconfirmed`] if it takes long.
    ///
    /// # Errors
    /// [`Refusal::NotSent`] when nothing went out now; it is repeated all the same. Another refusal when it never will.
    fn stop_motors(&self, now: NodeTime, request: RequestId) -> Result<(), Refusal>;

    /// Send a setpoint now and hold it valid until `expires`.
    fn stream(&self, now: NodeTime, setpoint: LocalSetpoint, expires: NodeTime);

    /// The autopilot's failsafe acts because this node's setpoints had ended: they may be sent all the same, and it goes back to OFFBOARD by itself.
    /// Of no avail after an emergency stop, or where the stream was given up.
    fn resume_stream(&self);

    /// End the stream on purpose (after landing, or when the pilot has taken over).
    fn stop_stream(&self, now: NodeTime);

    /// Puts a route on the vehicle in place of the one it has; an empty one takes that away. It is flown when the mode is set to
    /// [`FlightMode::Mission`]. The outcome comes as [`LinkEvent::Result`].
    fn upload_route(&self, now: NodeTime, request: RequestId, route: &[RoutePoint]);

    /// From now on gives messages of all components of the vehicle's system to a tap, until that is dropped.
    fn tap(&self, tap: Weak<dyn MessageTap>);

    /// Sends a payload's message to the vehicle's system. The caller has had it pass the gate.
    ///
    /// # Errors
    /// When it is no message of the dialect, or the link is lost.
    fn send_payload(&self, now: NodeTime, message: &MavlinkMessage) -> Result<(), Refusal>;

    /// What is known of the autopilot's parameters and has changed since a revision; 0 for all.
    ///
    /// # Errors
    /// When there are none over this link.
    fn parameters(&self, since: u64) -> Result<ParameterList, Refusal>;

    /// Begins to read all parameters, or ends that. How far it has come says [`Self::parameters`].
    ///
    /// # Errors
    /// When there are none over this link, or it is lost.
    fn read_parameters(&self, now: NodeTime, action: ReadingAction) -> Result<(), Refusal>;

    /// Writes a parameter. The caller has had it pass the gate. The outcome comes from [`Self::take_parameter_events`]; an armed
    /// vehicle's is not written, also if it is armed while the write waits.
    fn write_parameter(&self, now: NodeTime, id: CommandId, name: &str, value: ParameterValue);

    /// How operations on single parameters ended since the last call, in the order they were asked for.
    fn take_parameter_events(&self) -> Vec<ParameterEvent>;
}
