//! The one place where errors become HTTP: every answer that is not a success has a status, a code for programs, a sentence for
//! people and the facts that go with it.
//!
//! Must never do: leak what only the log should have (paths, backtraces).

use crate::protocol::{CommandReceipts, ErrorBody, ErrorDetail};
use axum::Json;
use axum::extract::rejection::{JsonRejection, PathRejection, QueryRejection};
use axum::http::{Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use skein_domain::{ParameterError, Refusal, TrajectoryObjection};
use skein_runtime::{Detected, PluginRefusal};
use skein_view::UpgradeRefusal;
use thiserror::Error;

/// Everything that can go wrong with a request.
#[derive(Debug, Error)]
pub enum ApiError {
    /// The node refused.
    #[error("{0}")]
    Refused(#[from] Refusal),
    /// The node refused something about a plugin.
    #[error("{0}")]
    Plugin(#[from] PluginRefusal),
    /// The node refused something about another version of the program.
    #[error("{0}")]
    Upgrade(#[from] UpgradeRefusal),
    /// A parameter was not written.
    #[error("{0}")]
    Parameter(ParameterError),
    /// The node refused trajectories, item by item.
    #[error("{}", sentences(.0))]
    Trajectories(Vec<TrajectoryObjection>),
    /// Not one of the vehicles a command was for is known.
    #[error("none of these vehicles is known here")]
    NoneKnown(CommandReceipts),
    /// The body is not JSON, or not of the right shape.
    #[error("{}", .0.body_text())]
    Body(#[from] JsonRejection),
    /// The body does not say that it is JSON.
    #[error("the body has to be JSON, with the header `content-type: application/json`")]
    NotJson,
    /// The body did not arrive in time.
    #[error("the body did not arrive in time")]
    TooSlow,
    /// The body is JSON, but not of the published shape.
    #[error("{problem}")]
    Shape {
        /// What is wrong, and where.
        problem: String,
    },
    /// The body has a field that means nothing here.
    #[error("unknown field `{field}`")]
    UnknownField {
        /// Where, as in `command.height`.
        field: String,
    },
    /// A number is outside of its range, a list is empty or too long.
    #[error("`{field}`: {problem}")]
    OutOfRange {
        /// Where, as in `route.waypoints[3]`.
        field: String,
        /// What is wrong and what would be right.
        problem: String,
    },
    /// The body is not one that is taken here.
    #[error("{problem}")]
    Unfit {
        /// Why not.
        problem: Box<ApiError>,
        /// One that would be taken.
        example: Value,
    },
    /// The query does not say what it should.
    #[error("{}", .0.body_text())]
    Query(#[from] QueryRejection),
    /// A part of the path is not what it should be.
    #[error("{}", .0.body_text())]
    Path(#[from] PathRejection),
    /// There is nothing of that name.
    #[error("there is nothing at {path}")]
    NotFound {
        /// The path asked for.
        path: String,
    },
    /// It is there, but not for this method.
    #[error("{path} does not take {method}")]
    MethodNotAllowed {
        /// The path asked for.
        path: String,
        /// The method used.
        method: Method,
    },
    /// The request came under a host name that is not ours.
    #[error("this node does not answer to the host name `{host}`")]
    ForeignHost {
        /// The name.
        host: String,
    },
    /// The request says nothing of which host it is for.
    #[error("the request has no usable Host header")]
    NoHost,
    /// A page of another origin tries to act here.
    #[error("pages of `{origin}` may not do this")]
    ForeignOrigin {
        /// Where the page comes from.
        origin: String,
    },
    /// Only a configured operator may do this.
    #[error("this needs an operator of the configuration: show the secret as `Authorization: Bearer SECRET`")]
    NoOperator,
    /// A stream was asked for without the headers that make it one.
    #[error("this is a WebSocket: {problem}")]
    NotAnUpgrade {
        /// What is missing.
        problem: String,
    },
    /// There is no recording of this name.
    #[error("there is no recording {file}")]
    UnknownRecording {
        /// The name asked for.
        file: String,
    },
    /// There is one, but nothing of it can be read.
    #[error("{file} cannot be read as a recording; `skein log check` says why")]
    UnreadableRecording {
        /// The name asked for.
        file: String,
    },
    /// What is shown is a recorded flight.
    #[error("this is a recorded flight: nothing can be commanded or changed in it")]
    Replaying,
    /// What is shown is no recorded flight.
    #[error("this node flies: what it shows is no recorded flight")]
    NotReplaying,
    /// As many recorded flights are looked at as can be at once.
    #[error("{limit} recorded flights are looked at already")]
    TooManyReplays {
        /// How many.
        limit: usize,
    },
    /// There is and was no session of WebRTC of this name.
    #[error("there is no session {session}")]
    UnknownSession {
        /// The name asked for.
        session: String,
    },
    /// The body is no offer of WebRTC.
    #[error("the body has to be an SDP offer, with the header `content-type: application/sdp`")]
    NotSdp,
    /// There is no socket for WebRTC.
    #[error("no socket for WebRTC: {reason}")]
    NoSocket {
        /// Why.
        reason: String,
    },
    /// More was seen than is worked on.
    #[error("{} of {} detections were taken: too many wait already", .0.taken, .0.taken + .0.refused)]
    TooManyDetections(Detected),
    /// As many streams as are served at once are open.
    #[error("{limit} streams are open already")]
    TooManyStreams {
        /// How many.
        limit: usize,
    },
}

impl ApiError {
    /// For a path that nothing answers to.
    #[must_use]
    pub fn not_found(uri: &Uri) -> Self {
        Self::NotFound {
            path: uri.path().to_owned(),
        }
    }

    /// The HTTP status.
    #[must_use]
    pub fn status(&self) -> StatusCode {
        match self {
            Self::Refused(refusal) => refusal_status(refusal),
            Self::Plugin(refusal) => plugin_refusal(refusal).0,
            Self::Parameter(error) => parameter_status(error),
            Self::Upgrade(refusal) => upgrade_status(refusal),
            // Of several the status of what they have in common, which is a conflict with the state of things.
            Self::Trajectories(against) => match against.as_slice() {
                [one] => refusal_status(&one.refusal),
                _ => StatusCode::CONFLICT,
            },
            Self::NoneKnown(_)
            | Self::NotFound { .. }
            | Self::UnknownRecording { .. }
            | Self::UnknownSession { .. } => StatusCode::NOT_FOUND,
            Self::Body(rejection) => rejection.status(),
            Self::Unfit { problem, .. } => problem.status(),
            Self::TooSlow => StatusCode::REQUEST_TIMEOUT,
            Self::NotJson | Self::NotSdp => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::Shape { .. } | Self::UnknownField { .. } | Self::OutOfRange { .. } => {
                StatusCode::UNPROCESSABLE_ENTITY
            }
            Self::Query(_) | Self::Path(_) | Self::NoHost => StatusCode::BAD_REQUEST,
            Self::MethodNotAllowed { .. } => StatusCode::METHOD_NOT_ALLOWED,
            Self::ForeignHost { .. } | Self::ForeignOrigin { .. } => StatusCode::FORBIDDEN,
            Self::Replaying | Self::NotReplaying | Self::UnreadableRecording { .. } => StatusCode::CONFLICT,
            Self::NoOperator => StatusCode::UNAUTHORIZED,
            Self::NotAnUpgrade { .. } => StatusCode::UPGRADE_REQUIRED,
            Self::TooManyDetections(_) => StatusCode::TOO_MANY_REQUESTS,
            Self::TooManyStreams { .. } | Self::TooManyReplays { .. } | Self::NoSocket { .. } => {
                StatusCode::SERVICE_UNAVAILABLE
            }
        }
    }

    /// The word for programs.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Refused(refusal) => refusal.code(),
            Self::Parameter(error) => error.code(),
            Self::Upgrade(refusal) => refusal.code(),
            Self::Plugin(refusal) => plugin_refusal(refusal).1,
            Self::Trajectories(_) => "trajectories_refused",
            Self::NoneKnown(_) => "unknown_vehicle",
            Self::Body(rejection) => body_code(rejection),
            Self::Unfit { problem, .. } => problem.code(),
            Self::TooSlow => "too_slow",
            Self::NotJson => "not_json",
            Self::NotSdp => "not_sdp",
            Self::UnknownRecording { .. } => "unknown_recording",
            Self::UnreadableRecording { .. } => "unreadable_recording",
            Self::Replaying => "replaying",
            Self::NotReplaying => "not_replaying",
            Self::TooManyReplays { .. } => "too_many_replays",
            Self::UnknownSession { .. } => "unknown_session",
            Self::NoSocket { .. } => "no_socket",
            Self::Shape { .. } => "invalid_body",
            Self::UnknownField { .. } => "unknown_field",
            Self::OutOfRange { .. } => "invalid_value",
            Self::Query(_) => "invalid_query",
            Self::Path(_) => "invalid_path",
            Self::NotFound { .. } => "not_found",
            Self::MethodNotAllowed { .. } => "method_not_allowed",
            Self::ForeignHost { .. } => "foreign_host",
            Self::NoHost => "no_host",
            Self::ForeignOrigin { .. } => "foreign_origin",
            Self::NoOperator => "no_operator",
            Self::NotAnUpgrade { .. } => "not_a_websocket",
            Self::TooManyDetections(_) => "too_many_detections",
            Self::TooManyStreams { .. } => "too_many_streams",
        }
    }

    /// The facts that go with the code.
    fn facts(&self) -> Value {
        match self {
            Self::Refused(refusal) => json!(refusal),
            Self::Parameter(error) => json!(error),
            Self::Upgrade(refusal) => json!(refusal),
            Self::NoneKnown(receipts) => json!(receipts),
            Self::Trajectories(against) => json!({ "against": against }),
            Self::UnknownField { field } => json!({ "field": field }),
            Self::Unfit { problem, .. } => problem.facts(),
            Self::OutOfRange { field, problem } => json!({ "field": field, "problem": problem }),
            Self::TooManyDetections(detected) => json!(detected),
            Self::TooManyStreams { limit } | Self::TooManyReplays { limit } => json!({ "limit": limit }),
            Self::UnknownRecording { file } | Self::UnreadableRecording { file } => json!({ "file": file }),
            Self::UnknownSession { session } => json!({ "session": session }),
            _ => Value::Null,
        }
    }

    /// As it goes over the wire.
    #[must_use]
    pub fn detail(&self) -> ErrorDetail {
        ErrorDetail {
            code: self.code().to_owned(),
            message: self.to_string(),
            detail: self.facts(),
            example: match self {
                Self::Unfit { example, .. } => Some(example.clone()),
                _ => None,
            },
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let status = self.status();
        tracing::debug!(status = status.as_u16(), code = self.code(), "refused: {self}");
        (status, Json(ErrorBody { error: self.detail() })).into_response()
    }
}

/// What is against trajectories, as one sentence.
fn sentences(against: &[TrajectoryObjection]) -> String {
    against.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Which status a refusal is: a conflict with the state of things, unless it is something else. That a body is not of the published shape
/// (422) is said before the node is asked.
fn refusal_status(refusal: &Refusal) -> StatusCode {
    match refusal {
        Refusal::UnknownVehicle { .. }
        | Refusal::UnknownPayload { .. }
        | Refusal::UnknownTrack { .. }
        | Refusal::UnknownReference { .. } => StatusCode::NOT_FOUND,
        Refusal::NotPermitted { .. } => StatusCode::FORBIDDEN,
        _ => StatusCode::CONFLICT,
    }
}

impl From<ParameterError> for ApiError {
    fn from(error: ParameterError) -> Self {
        match error {
            ParameterError::Refused(refusal) => Self::Refused(refusal),
            error => Self::Parameter(error),
        }
    }
}

fn parameter_status(error: &ParameterError) -> StatusCode {
    match error {
        ParameterError::Unknown { .. } => StatusCode::NOT_FOUND,
        ParameterError::InvalidName { .. } => StatusCode::UNPROCESSABLE_ENTITY,
        ParameterError::Refused(refusal) => refusal_status(refusal),
        ParameterError::WrongType { .. }
        | ParameterError::OutOfRange { .. }
        | ParameterError::NoAnswer { .. }
        | ParameterError::NotTaken { .. }
        | ParameterError::Armed { .. }
        | ParameterError::Busy
        | ParameterError::BrokenOff { .. } => StatusCode::CONFLICT,
    }
}

/// Which status a refusal about another version is.
fn upgrade_status(refusal: &UpgradeRefusal) -> StatusCode {
    match refusal {
        UpgradeRefusal::Unknown { .. } | UpgradeRefusal::UnknownNode { .. } => StatusCode::NOT_FOUND,
        UpgradeRefusal::NotAccepted | UpgradeRefusal::NoStateFolder => StatusCode::FORBIDDEN,
        _ => StatusCode::CONFLICT,
    }
}

/// Status and code of a refusal about a plugin.
fn plugin_refusal(refusal: &PluginRefusal) -> (StatusCode, &'static str) {
    match refusal {
        PluginRefusal::Unknown { .. } => (StatusCode::NOT_FOUND, "unknown_plugin"),
        PluginRefusal::NothingNewer { .. } => (StatusCode::CONFLICT, "nothing_newer"),
        PluginRefusal::NothingBefore { .. } => (StatusCode::CONFLICT, "nothing_before"),
        PluginRefusal::InUse { .. } => (StatusCode::CONFLICT, "in_use"),
        PluginRefusal::NotPermitted { .. } => (StatusCode::FORBIDDEN, "not_permitted"),
        PluginRefusal::BadUpload { .. } => (StatusCode::CONFLICT, "bad_upload"),
    }
}

fn body_code(rejection: &JsonRejection) -> &'static str {
    match rejection.status() {
        StatusCode::UNPROCESSABLE_ENTITY => "invalid_body",
        StatusCode::PAYLOAD_TOO_LARGE => "too_large",
        _ => "bad_json",
    }
}

#[cfg(test)]
mod tests;
