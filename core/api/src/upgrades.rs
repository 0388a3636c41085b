//! Routes about other versions of the program on the swarm's nodes. Whoever changes anything must be an operator who may.
//!
//! Must never do: begin anything for somebody who is no such operator, or hold an archive in memory.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::operators::Operator;
use axum::Json;
use axum::body::Body as Stream;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, Refusal};
use skein_upgrade::{Ground, MOST_ARCHIVE_BYTES, RolloutRequest};
use skein_view::{ArchiveInfo, RolloutKind, UpgradeRefusal, UpgradeReport};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::fs::File;
use tokio::io::AsyncWriteExt;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use ts_rs::TS;

/// An archive of which nothing has come for so long is given up.
const NEXT_WITHIN: Duration = Duration::from_secs(30);
/// One archive comes in at a time: it has one place.
static COMING_IN: Semaphore = Semaphore::const_new(1);

/// Which nodes a roll-out is for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RolloutBody {
    /// Their numbers; all others of the swarm if left out.
    #[serde(default)]
    #[schemars(length(max = 512), extend("uniqueItems" = true))]
    pub nodes: Option<Vec<NodeId>>,
    /// The node that is asked too, as the last one.
    #[serde(default)]
    pub this_node: bool,
}

/// The operator's name, if he may.
fn may_upgrade(Operator(operator): Operator) -> Result<String, Refusal> {
    match operator.may_upgrade {
        true => Ok(operator.name),
        false => Err(Refusal::not_permitted(format!(
            "{} may not give the swarm another version (operators.may_upgrade)",
            operator.name
        ))),
    }
}

pub(crate) async fn report(State(app): State<App>) -> Result<Json<UpgradeReport>, ApiError> {
    Ok(Json(app.node.versions()?.report()))
}

pub(crate) async fn take_archive(
    State(app): State<App>,
    operator: Operator,
    headers: HeaderMap,
    body: Stream,
) -> Result<Json<ArchiveInfo>, ApiError> {
    may_upgrade(operator)?;
    let ground = app.node.versions()?.clone();
    let busy = |_| UpgradeRefusal::Busy {
        what: "another archive is coming in".into(),
    };
    let _alone = COMING_IN.try_acquire().map_err(busy)?;
    let length = headers
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok());
    let bytes = length.and_then(|text| text.parse().ok()).unwrap_or(MOST_ARCHIVE_BYTES);
    let path = ground.incoming(bytes)?;
    if let Err(error) = receive(body, &path).await {
        // The next one takes its place otherwise.
        let _ = tokio::fs::remove_file(&path).await;
        return Err(error);
    }
    // A slow disk must not hold up what flies.
    let kept = tokio::task::spawn_blocking(move || ground.keep(&path)).await;
    let kept = kept.unwrap_or_else(|error| Err(storage(&error)));
    Ok(Json(kept?))
}

async fn receive(body: Stream, path: &Path) -> Result<(), ApiError> {
    let mut file = File::create(path).await.map_err(|e| storage(&e))?;
    let (mut parts, mut received) = (body.into_data_stream(), 0_u64);
    while let Some(part) = timeout(NEXT_WITHIN, parts.next())
        .await
        .map_err(|_| ApiError::TooSlow)?
    {
        let part = part.map_err(|error| ApiError::Shape {
            problem: error.to_string(),
        })?;
        received += part.len() as u64;
        if received > MOST_ARCHIVE_BYTES {
            let detail = format!("it is larger than {MOST_ARCHIVE_BYTES} bytes");
            return Err(UpgradeRefusal::Damaged { detail }.into());
        }
        file.write_all(&part).await.map_err(|e| storage(&e))?;
    }
    file.sync_all().await.map_err(|e| storage(&e))?;
    Ok(())
}

fn storage(error: &dyn std::error::Error) -> UpgradeRefusal {
    UpgradeRefusal::Storage {
        detail: error.to_string(),
    }
}

pub(crate) async fn begin(
    State(app): State<App>,
    operator: Operator,
    Body(body): Body<RolloutBody>,
) -> Result<Response, ApiError> {
    begin_one(app.node.versions()?, may_upgrade(operator)?, body, RolloutKind::Upgrade)
}

pub(crate) async fn back(
    State(app): State<App>,
    operator: Operator,
    Body(body): Body<RolloutBody>,
) -> Result<Response, ApiError> {
    begin_one(app.node.versions()?, may_upgrade(operator)?, body, RolloutKind::Back)
}

fn begin_one(
    ground: &Arc<Ground>,
    operator: String,
    body: RolloutBody,
    kind: RolloutKind,
) -> Result<Response, ApiError> {
    let request = RolloutRequest {
        kind,
        operator,
        nodes: body.nodes,
        this_node: body.this_node,
    };
    let report = skein_upgrade::begin(ground, request)?;
    Ok((StatusCode::ACCEPTED, Json(report)).into_response())
}

pub(crate) async fn stop(State(app): State<App>, operator: Operator) -> Result<Json<UpgradeReport>, ApiError> {
    may_upgrade(operator)?;
    let ground = app.node.versions()?;
    ground.stop();
    Ok(Json(ground.report()))
}
