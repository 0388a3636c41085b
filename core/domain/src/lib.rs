//! The words every other crate speaks: identities, frames with units in their types, vehicle state, setpoints,
//! commands, intent, refusals, and the events and effects that cross the plugin boundary.
//!
//! Must never do: I/O, read a clock, spawn, draw random numbers. Time comes in as [`NodeTime`].
#![forbid(unsafe_code)]

pub mod autopilot_log;
pub mod command;
pub mod control;
pub mod energy;
pub mod exchange;
pub mod failsafe;
pub mod fence;
pub mod formation;
pub mod frames;
pub mod ids;
pub mod intent;
pub mod limits;
pub mod link;
pub mod manifest;
pub mod parameter;
pub mod payload;
pub mod preflight;
pub mod refusal;
pub mod setpoint;
pub mod stick;
pub mod telemetry;
pub mod time;
pub mod trajectory;

pub use autopilot_log::{AutopilotLog, LogFetch, LogFetchEnd};
pub use command::{AutopilotCommand, VehicleCommand};
pub use energy::{EnergyLevel, EnergySettings, EnergyState};
pub use failsafe::{
    Alarm, FailsafeEvent, FailsafeEventKind, FailsafeSettings, FailsafeState, Order, Reaction, ReportOnly, Trigger,
};
pub use fence::{
    AltitudeReference, BreachAction, BreachReturn, FencePlan, FenceZone, MapPoint, ZoneError, ZoneKind, ZoneOutline,
};
pub use formation::{FormationAnchor, FormationControl, FormationRequest, HeadingRequest, Shape};
pub use frames::{
    AccelerationNed, Geodetic, LocalFrame, LocalPositionNed, OffsetFrd, PositionNed, SwarmFrame, VelocityNed,
};
pub use ids::{CommandId, Incarnation, NodeId, RequestId, SystemId, VehicleId};
pub use intent::{
    AnchorPlan, AnchorReference, FormationHeading, Intent, Keeping, KeepingLaw, NeighbourPlace, Route, SlotMove, Task,
    Trajectory, TrajectoryPiece, VehicleTask,
};
pub use limits::FlightLimits;
pub use parameter::{
    Parameter, ParameterError, ParameterEvent, ParameterList, ParameterReading, ParameterValue, ReadingAction,
};
pub use preflight::{ItemStatus, PreflightItem, PreflightOverride, PreflightReport, PreflightSettings};
pub use refusal::Refusal;
pub use setpoint::Setpoint;
pub use stick::Stick;
pub use telemetry::{
    Battery, BatteryUse, EstimatorHealth, FlightMode, FlightState, Gnss, GnssFix, HeardTimes, LandedState, LinkHealth,
    Telemetry, VehicleWay,
};
pub use time::{Clock, NodeTime};
pub use trajectory::{
    JourneyPlan, JourneyRequest, RouteUpload, TrajectoryKind, TrajectoryObjection, TrajectoryPlan, TrajectoryProgress,
    TrajectoryRequest, TrajectoryStart, TrajectoryStatus,
};
