//! Video over a WebSocket: one task per viewer, which owns its socket.
//!
//! Each picture is followed by a ping. While too many pings are not answered no further picture is taken, so that neither the node nor the sockets on
//! the way pile them up; what the viewer is not in time for it leaves out, whole groups of pictures at a time.
//!
//! Must never do: make anything else wait. A viewer that does not read, or does not answer, is closed.

use super::{Of, WantedQuality, admit, view};
use crate::app::{App, Closing};
use crate::error::ApiError;
use crate::protocol::{VideoMessage, VideoRequest};
use axum::Extension;
use axum::body::Bytes;
use axum::extract::rejection::QueryRejection;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Query, State};
use axum::response::Response;
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::{NodeTime, VehicleId};
use skein_state::video::Viewer;
use skein_video::{Coding, Given};
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

/// Version of the header before each picture.
const VERSION: u8 = 1;
/// Length of that header, in bytes.
const HEADER_BYTES: usize = 32;
/// So many pictures may be on their way unanswered: a third of a second at 30/s.
const MOST_UNANSWERED: u32 = 10;
/// How often the viewer is told how the stream is.
const TELL_EVERY: Duration = Duration::from_secs(1);
/// One message has to be out within this time.
const SEND_WITHIN: Duration = Duration::from_secs(5);
/// A viewer of whom nothing is heard for so long is gone: it owes an answer to every ping.
const HEARD_WITHIN: Duration = Duration::from_secs(10);
/// Largest message a viewer may send, in bytes.
const MAX_MESSAGE_BYTES: usize = 512;

/// Which way the pictures go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub(crate) enum Way {
    /// H.264 access units in Annex B's byte stream.
    #[default]
    H264,
    /// JPEG files.
    Jpeg,
    /// None: only what is told as text, beside another way.
    None,
}

/// What may be said when a video is opened.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SocketQuery {
    /// What the binary messages hold.
    #[serde(default)]
    way: Way,
    /// How large the pictures are wanted.
    #[serde(default)]
    quality: WantedQuality,
}

/// Opens a video.
///
/// # Errors
/// When there is no such camera, the request is no WebSocket handshake, or too many look already.
pub(crate) async fn open(
    State(app): State<App>,
    closing: Option<Extension<Closing>>,
    of: Of,
    query: Result<Query<SocketQuery>, QueryRejection>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, ApiError> {
    let (Path((vehicle, payload)), Query(query)) = (of?, query?);
    // Refused before the upgrade, so that the reason can be read.
    app.node.streams().video(vehicle, &payload)?;
    let upgrade = upgrade.map_err(|rejection| ApiError::NotAnUpgrade {
        problem: rejection.body_text(),
    })?;
    let permit = admit(&app)?;
    let rendition = match query.way {
        Way::H264 => Some(query.quality.of(Coding::H264)),
        Way::Jpeg => Some(query.quality.of(Coding::Jpeg)),
        Way::None => None,
    };
    let watch = |rendition| app.node.streams().watch_video(vehicle, &payload, rendition);
    let viewer = rendition.map(watch).transpose()?;
    let closing = closing.map(|Extension(closing)| closing);
    let upgrade = upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES);
    Ok(upgrade.on_upgrade(move |socket| async move {
        let mut client = Client {
            socket,
            app,
            vehicle,
            payload,
            viewer,
            sent: 0,
            answered: 0,
            heard: Instant::now(),
        };
        let _gone = client.serve(closing).await;
        // The counterpart may be gone already.
        let _ = timeout(Duration::from_secs(1), client.socket.send(Message::Close(None))).await;
        drop(permit);
    }))
}

/// The viewer is gone, does not take what is sent, or says what nobody understands; or the node ends.
struct Gone;

struct Client {
    socket: WebSocket,
    app: App,
    vehicle: VehicleId,
    payload: String,
    viewer: Option<Viewer>,
    /// Pictures sent, and the last of them whose ping was answered.
    sent: u32,
    answered: u32,
    heard: Instant,
}

impl Client {
    async fn serve(&mut self, mut closing: Option<Closing>) -> Result<std::convert::Infallible, Gone> {
        let mut tell = interval(TELL_EVERY);
        tell.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let may_send = self.sent.wrapping_sub(self.answered) < MOST_UNANSWERED;
            tokio::select! {
                () = closed(closing.as_mut()) => return Err(Gone),
                received = self.socket.recv() => self.received(received).await?,
                given = next(self.viewer.as_mut()), if may_send => self.send_picture(&given).await?,
                _ = tell.tick() => self.tell().await?,
            }
        }
    }

    async fn tell(&mut self) -> Result<(), Gone> {
        if self.heard.elapsed() > HEARD_WITHIN {
            return Err(Gone);
        }
        // A camera that was taken off has no stream any more.
        let video = self
            .app
            .node
            .streams()
            .video(self.vehicle, &self.payload)
            .map_err(|_| Gone)?;
        self.say(&VideoMessage::State(view(video))).await?;
        if self.viewer.is_none() {
            self.send(Message::Ping(Bytes::new())).await?;
        }
        Ok(())
    }

    async fn send_picture(&mut self, given: &Given) -> Result<(), Gone> {
        let left_out = self.viewer.as_ref().map_or(0, Viewer::left_out);
        let message = picture(given, left_out, self.app.node.now());
        self.send(Message::Binary(message)).await?;
        self.sent = self.sent.wrapping_add(1);
        let ping = Bytes::copy_from_slice(&self.sent.to_be_bytes());
        self.send(Message::Ping(ping)).await
    }

    async fn received(&mut self, received: Option<Result<Message, axum::Error>>) -> Result<(), Gone> {
        let Some(Ok(message)) = received else { return Err(Gone) };
        self.heard = Instant::now();
        match message {
            Message::Pong(payload) => {
                if let Ok(number) = <[u8; 4]>::try_from(payload.as_ref()) {
                    self.note_answer(u32::from_be_bytes(number));
                }
                Ok(())
            }
            Message::Ping(_) => Ok(()),
            Message::Text(text) => self.obey(&text).await,
            Message::Binary(_) | Message::Close(_) => Err(Gone),
        }
    }

    /// An answer to a ping answers all before it. One to a ping that was never sent is no answer.
    fn note_answer(&mut self, number: u32) {
        let unanswered = self.sent.wrapping_sub(self.answered);
        if number.wrapping_sub(self.answered) <= unanswered {
            self.answered = number;
        }
    }

    async fn obey(&mut self, text: &str) -> Result<(), Gone> {
        match serde_json::from_str::<VideoRequest>(text) {
            Ok(VideoRequest::Ping { id }) => {
                let time_us = self.app.node.now().0;
                self.say(&VideoMessage::Pong { id, time_us }).await
            }
            Ok(VideoRequest::Key) => {
                self.viewer.iter().for_each(Viewer::ask_for_key);
                Ok(())
            }
            Ok(VideoRequest::Seen { p50_s, p99_s }) => {
                self.app
                    .node
                    .streams()
                    .note_seen(self.vehicle, &self.payload, p50_s, p99_s);
                Ok(())
            }
            Err(error) => {
                let reason = error.to_string();
                self.say(&VideoMessage::Error { reason }).await
            }
        }
    }

    async fn say(&mut self, message: &VideoMessage) -> Result<(), Gone> {
        // These have no map with keys that are no text.
        let text = serde_json::to_string(message).map_err(|_| Gone)?;
        self.send(Message::text(text)).await
    }

    async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(SEND_WITHIN, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(Gone),
        }
    }
}

async fn next(viewer: Option<&mut Viewer>) -> Given {
    match viewer {
        Some(viewer) => viewer.next().await,
        None => std::future::pending().await,
    }
}

async fn closed(closing: Option<&mut Closing>) {
    match closing {
        Some(closing) => closing.wait().await,
        None => std::future::pending().await,
    }
}

/// A picture as it goes over the socket: the header, little endian, then the bytes.
fn picture(given: &Given, left_out: u64, now: NodeTime) -> Bytes {
    let frame = &given.frame;
    let kind = match frame.coding {
        Coding::H264 => 1,
        Coding::Jpeg => 2,
    };
    let side = |pixels: u32| u16::try_from(pixels).unwrap_or(u16::MAX).to_le_bytes();
    let age_us = now.0.saturating_sub(frame.taken.0);
    let mut message = Vec::with_capacity(HEADER_BYTES + frame.bytes.len());
    message.extend([VERSION, kind, u8::from(frame.key) | u8::from(given.after_gap) << 1, 0]);
    message.extend(side(frame.width_px));
    message.extend(side(frame.height_px));
    message.extend((frame.sequence as u32).to_le_bytes());
    message.extend(u32::try_from(age_us).unwrap_or(u32::MAX).to_le_bytes());
    message.extend((frame.taken.0 as f64).to_le_bytes());
    message.extend(u32::try_from(left_out).unwrap_or(u32::MAX).to_le_bytes());
    message.extend([0; 4]);
    message.extend(frame.bytes.as_ref());
    message.into()
}

#[cfg(test)]
mod tests;
