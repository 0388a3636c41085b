//! Commands as services. Each is handed to the node like one that comes over the API, and so passes the safety gate; the answer says whether it
//! was taken up, or why not.
//!
//! Must never do: wait in one service for another, answer before the node has, or let who asks too often through.

mod commands;

pub use commands::{of_swarm, of_vehicle};

use crate::interfaces::Service;
use crate::limit::Limit;
use futures_util::StreamExt;
use ros2_client::Server;
use skein_runtime::NodeHandle;
use skein_view::Audit;
use tokio::time::Instant;

/// So many requests at once are answered by one service, then so many per second.
const BURST: u32 = 20;
const PER_S: f64 = 10.0;

/// Reason of a refusal because of too many requests.
pub const TOO_OFTEN: &str = "too_many_requests";

/// An answer that can be a refusal.
pub trait Refusable {
    /// The refusal.
    fn refused(code: &str, message: &str) -> Self;

    /// What came of it, in words: `accepted`, or why not.
    fn outcome(&self) -> String;
}

/// What came of a request.
fn outcome(success: bool, why: &str) -> String {
    if success { "accepted".to_owned() } else { why.to_owned() }
}

impl Refusable for crate::interfaces::standard::Outcome {
    fn refused(code: &str, message: &str) -> Self {
        Self {
            success: false,
            message: format!("{code}: {message}"),
        }
    }

    fn outcome(&self) -> String {
        outcome(self.success, &self.message)
    }
}

impl Refusable for crate::interfaces::skein::CommandOutcome {
    fn refused(code: &str, message: &str) -> Self {
        Self {
            success: false,
            code: code.to_owned(),
            message: message.to_owned(),
            command: 0,
        }
    }

    fn outcome(&self) -> String {
        outcome(self.success, &format!("{}: {}", self.code, self.message))
    }
}

impl Refusable for crate::interfaces::skein::FormationOutcome {
    fn refused(code: &str, message: &str) -> Self {
        Self {
            success: false,
            code: code.to_owned(),
            message: message.to_owned(),
            ..Self::default()
        }
    }

    fn outcome(&self) -> String {
        outcome(self.success, &format!("{}: {}", self.code, self.message))
    }
}

/// Answers requests one after the other, as long as it is polled. Each is recorded with what came of it; who asked, ROS 2 does not tell.
pub async fn answer<S: Service>(
    node: NodeHandle,
    server: Server<S::Request, S::Response>,
    what: String,
    carry_out: impl AsyncFn(S::Request) -> S::Response,
) where
    S::Response: Refusable,
{
    let (began, mut limit) = (Instant::now(), Limit::new(BURST, PER_S));
    let mut requests = server.receive_request_stream();
    while let Some(request) = requests.next().await {
        // What cannot be read has nobody who could be answered.
        let Ok((from, request)) = request else { continue };
        let with = serde_json::to_string(&request).unwrap_or_default();
        let response = if limit.permits(began.elapsed().as_secs_f64()) {
            carry_out(request).await
        } else {
            S::Response::refused(TOO_OFTEN, "this service is asked too often")
        };
        node.audit(|| Audit {
            time: node.now(),
            who: String::new(),
            over: "ros2".to_owned(),
            what: what.clone(),
            with,
            outcome: response.outcome(),
        });
        if let Err(error) = server.send_response(from, response) {
            tracing::warn!("{what} cannot be answered: {error:?}");
        }
    }
}
