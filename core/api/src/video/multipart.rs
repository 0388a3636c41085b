//! Video as a page without scripts or an ordinary player takes it: JPEG files, one after the other, in one answer that does not end.

use super::{Of, QualityQuery, admit};
use crate::app::App;
use crate::error::ApiError;
use axum::body::{Body, Bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use skein_video::Coding;
use std::convert::Infallible;
use tokio::sync::mpsc;

const BOUNDARY: &str = "picture";

/// The last pictures, for as long as they are taken.
///
/// # Errors
/// When there is no such camera, or too many look already.
pub(crate) async fn multipart(
    State(app): State<App>,
    of: Of,
    query: Result<Query<QualityQuery>, QueryRejection>,
) -> Result<Response, ApiError> {
    let (Path((vehicle, payload)), Query(query)) = (of?, query?);
    let permit = admit(&app)?;
    let rendition = query.quality.of(Coding::Jpeg);
    let mut viewer = app.node.streams().watch_video(vehicle, &payload, rendition)?;
    // One waits while one is being sent: who takes them slowly gets fewer of them.
    let (parts, mut taken) = mpsc::channel::<Bytes>(1);
    tokio::spawn(async move {
        let _permit = permit;
        loop {
            let frame = tokio::select! {
                given = viewer.next() => given.frame,
                () = parts.closed() => return,
            };
            let head = format!(
                "--{BOUNDARY}\r\ncontent-type: image/jpeg\r\ncontent-length: {}\r\n\r\n",
                frame.bytes.len()
            );
            let part = [head.as_bytes(), frame.bytes.as_ref(), b"\r\n"].concat();
            if parts.send(part.into()).await.is_err() {
                return;
            }
        }
    });
    let stream = futures_util::stream::poll_fn(move |context| {
        taken.poll_recv(context).map(|part| part.map(Ok::<_, Infallible>))
    });
    let kind = format!("multipart/x-mixed-replace; boundary={BOUNDARY}");
    Ok(([(header::CONTENT_TYPE, kind)], Body::from_stream(stream)).into_response())
}
