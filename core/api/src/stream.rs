//! The telemetry stream: one task per client, which owns its socket.
//!
//! A client gets the newest frame at its own rate, never a queue of old ones: each frame is followed by a ping, and while pings are
//! not answered no further frame is sent, so that neither we nor the sockets on the way pile them up. Events come in order from the
//! node's bounded log; a client that was away for longer than the log reaches is told how many it missed.
//!
//! Must never do: make anything else wait. A client that does not read, or does not answer, is closed.

mod replay;
mod slow;
mod sticks;

use crate::app::{App, Closing};
use crate::error::ApiError;
use crate::protocol::{ClientMessage, ErrorDetail, PROTOCOL_VERSION, ServerMessage};
use crate::view;
use axum::extract::rejection::QueryRejection;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::extract::{Query, State};
use axum::response::Response;
use axum::{Extension, body::Bytes};
use metrics::{counter, gauge};
use replay::Shown;
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::control::LONGEST_CONSOLE_TEXT;
use skein_domain::{Refusal, Stick, VehicleId};
use skein_view::EventRecord;
use slow::Told;
use std::sync::Arc;
use std::time::Duration;
use sticks::Sticks;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, Interval, MissedTickBehavior, interval, timeout};

/// Frames per second until the client asks for another rate.
const DEFAULT_RATE_HZ: f64 = 10.0;
/// Slowest and fastest rate a client may ask for.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=50.0;
/// Unanswered frames stand for at most so long: what a client on a slow line sees is not older than this plus the line's delay.
const UNANSWERED_S: f64 = 0.5;
/// Fewest unanswered frames at which we wait, so that a slow rate does not stutter.
const UNANSWERED_AT_LEAST: u32 = 2;
/// Time between two pictures of the swarm's nodes.
const SWARM_EVERY: Duration = Duration::from_millis(500);
/// The slow state is looked at so often.
const FLEET_EVERY: Duration = Duration::from_millis(200);
/// One message has to be out within this time.
const SEND_WITHIN: Duration = Duration::from_secs(5);
/// A client of whom nothing is heard for so long is gone: it owes an answer to every ping.
const HEARD_WITHIN: Duration = Duration::from_secs(10);
/// How often that is looked at.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Largest message a client may send. What it may say has under two hundred bytes.
const MAX_MESSAGE_BYTES: usize = 4096;

/// What may be said when a stream is opened.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StreamQuery {
    /// Number of the last event that is known already; those after it come first. New ones only if left out.
    pub after: Option<u64>,
    /// The id of the console that looks at it. While its stream is open and answers, it is there.
    pub console: Option<String>,
}

/// Opens a stream.
///
/// # Errors
/// When the request is no WebSocket handshake, or too many streams are open.
pub async fn open(
    State(app): State<App>,
    closing: Option<Extension<Closing>>,
    query: Result<Query<StreamQuery>, QueryRejection>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Result<Response, ApiError> {
    let Query(query) = query?;
    let upgrade = upgrade.map_err(|rejection| ApiError::NotAnUpgrade {
        problem: rejection.body_text(),
    })?;
    let too_many = |_| ApiError::TooManyStreams {
        limit: crate::app::MAX_STREAMS,
    };
    let permit = app.streams.clone().try_acquire_owned().map_err(too_many)?;
    let closing = closing.map(|Extension(closing)| closing);
    let upgrade = upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES);
    Ok(upgrade.on_upgrade(move |socket| async move {
        let open = OpenStream::count();
        let end = Client::new(socket, app, query).run(closing).await;
        tracing::debug!("a stream has ended: {end:?}");
        drop((open, permit));
    }))
}

/// Counts open streams for the metrics, also when a task is dropped.
struct OpenStream;

impl OpenStream {
    fn count() -> Self {
        gauge!("skein_streams_open").increment(1.0);
        Self
    }
}

impl Drop for OpenStream {
    fn drop(&mut self) {
        gauge!("skein_streams_open").decrement(1.0);
    }
}

/// Why a stream ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The client closed it, or its connection broke.
    Gone,
    /// The client did not read, or did not answer pings.
    TooSlow,
    /// The client broke the protocol.
    Unusable,
    /// The server or the node ends.
    Closing,
}

struct Client {
    socket: WebSocket,
    app: App,
    events: broadcast::Receiver<Arc<EventRecord>>,
    /// Number of the last event that was sent or is known to the client.
    last_event: u64,
    /// The console behind it, if it says so.
    console: Option<String>,
    /// The slow state as it was last sent.
    told: Told,
    rate_hz: f64,
    frames: Interval,
    /// What is shown, if it is a recorded flight.
    shown: Option<Shown>,
    /// Of a vehicle that it steers by hand.
    sticks: Sticks,
    /// Frames sent, and the last of them whose ping was answered.
    sent: u32,
    answered: u32,
    heard: Instant,
}

impl Client {
    fn new(socket: WebSocket, app: App, query: StreamQuery) -> Self {
        // Subscribed before the log is looked at: nothing falls between the two.
        let events = app.node.subscribe();
        let newest = app.node.events_after(0).last().map_or(0, |event| event.seq);
        // A number that was never given out comes from an earlier run of the node: all of this run is news then.
        let last_event = query
            .after
            .map_or(newest, |after| if after > newest { 0 } else { after });
        Self {
            shown: app.replay.as_deref().map(Shown::of),
            socket,
            app,
            events,
            last_event,
            console: query.console.filter(|id| id.len() <= LONGEST_CONSOLE_TEXT),
            told: Told::default(),
            rate_hz: DEFAULT_RATE_HZ,
            frames: ticks(Duration::from_secs_f64(1.0 / DEFAULT_RATE_HZ)),
            sticks: Sticks::new(),
            sent: 0,
            answered: 0,
            heard: Instant::now(),
        }
    }

    async fn run(mut self, mut closing: Option<Closing>) -> End {
        let end = match self.serve(closing.as_mut()).await {
            Ok(never) => match never {},
            Err(end) => end,
        };
        let (code, reason) = match end {
            End::Gone | End::TooSlow => return end,
            End::Unusable => (close_code::POLICY, "not understood"),
            End::Closing => (close_code::AWAY, "the node is stopping"),
        };
        // Best effort: whoever does not take it within a moment sees the connection end.
        let farewell = Message::Close(Some(CloseFrame {
            code,
            reason: reason.into(),
        }));
        let _ = timeout(Duration::from_secs(1), self.socket.send(farewell)).await;
        end
    }

    async fn serve(&mut self, closing: Option<&mut Closing>) -> Result<std::convert::Infallible, End> {
        let hello = ServerMessage::Hello {
            protocol: PROTOCOL_VERSION,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            node: self.app.node.name().to_owned(),
        };
        self.say(&hello).await?;
        self.send_replay().await?;
        self.send_fleet().await?;
        self.send_safety().await?;
        self.send_events().await?;
        let mut closed = std::pin::pin!(closed(closing));
        let (mut fleet, mut look, mut swarm) = (ticks(FLEET_EVERY), ticks(LOOK_EVERY), ticks(SWARM_EVERY));
        loop {
            let may_send = self.may_send();
            tokio::select! {
                () = &mut closed => return Err(End::Closing),
                received = self.socket.recv() => self.received(received).await?,
                () = replay::step(self.shown.as_mut()) => self.send_replay().await?,
                (vehicle, stick) = self.sticks.due() => self.steer(vehicle, stick).await?,
                event = self.events.recv() => match event {
                    // Only a wake-up: what is sent comes from the log, so that falling behind loses nothing it still keeps.
                    Ok(event) if event.seq <= self.last_event => {}
                    Ok(_) | Err(RecvError::Lagged(_)) => self.send_events().await?,
                    Err(RecvError::Closed) => return Err(End::Closing),
                },
                _ = self.frames.tick(), if may_send => self.send_frame().await?,
                _ = fleet.tick() => {
                    self.send_fleet().await?;
                    self.send_safety().await?;
                    self.send_control().await?;
                    self.send_tracks().await?;
                }
                _ = swarm.tick() => if let Some(swarm) = self.app.node.swarm() {
                    self.say(&ServerMessage::Swarm(Box::new(swarm))).await?;
                },
                _ = look.tick() => self.look()?,
            }
        }
    }

    /// Whether somebody is still there; then its console is.
    fn look(&self) -> Result<(), End> {
        let silent = self.heard.elapsed();
        if silent > HEARD_WITHIN {
            return Err(End::TooSlow);
        }
        if let Some(console) = self.console.as_ref().filter(|_| silent < LOOK_EVERY * 2) {
            self.app.node.hear_console(console);
        }
        Ok(())
    }

    /// Whether so few frames are unanswered that another one may go.
    fn may_send(&self) -> bool {
        let most = ((self.rate_hz * UNANSWERED_S).ceil() as u32).max(UNANSWERED_AT_LEAST);
        self.sent.wrapping_sub(self.answered) < most
    }

    async fn send_frame(&mut self) -> Result<(), End> {
        self.send_replay().await?;
        let frame = self.app.view.frame(&self.app.node);
        self.send(Message::Binary(frame)).await?;
        self.sent = self.sent.wrapping_add(1);
        self.send(Message::Ping(Bytes::copy_from_slice(&self.sent.to_be_bytes())))
            .await
    }

    async fn send_events(&mut self) -> Result<(), End> {
        self.send_replay().await?;
        self.send_new_events().await
    }

    async fn send_new_events(&mut self) -> Result<(), End> {
        for event in self.app.node.events_after(self.last_event) {
            let missed = event.seq.saturating_sub(self.last_event + 1);
            if missed > 0 {
                counter!("skein_stream_events_missed_total").increment(missed);
                self.say(&ServerMessage::Gap { missed }).await?;
            }
            self.last_event = event.seq;
            self.say(&ServerMessage::Event(Box::new(event.as_ref().clone())))
                .await?;
        }
        Ok(())
    }

    async fn received(&mut self, received: Option<Result<Message, axum::Error>>) -> Result<(), End> {
        let message = match received {
            Some(Ok(message)) => message,
            Some(Err(error)) => {
                tracing::debug!("a stream broke: {error}");
                return Err(End::Gone);
            }
            None => return Err(End::Gone),
        };
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
            Message::Binary(_) => Err(End::Unusable),
            Message::Close(_) => Err(End::Gone),
        }
    }

    /// An answer to a ping answers all before it. One to a ping that was never sent is no answer.
    fn note_answer(&mut self, number: u32) {
        let unanswered = self.sent.wrapping_sub(self.answered);
        if number.wrapping_sub(self.answered) <= unanswered {
            self.answered = number;
        }
    }

    /// Passes a stick on to the vehicle.
    async fn steer(&mut self, vehicle: VehicleId, stick: Stick) -> Result<(), End> {
        let steered = match &self.shown {
            Some(_) => Err(Refusal::not_permitted("this is a recorded flight")),
            None => self.app.node.stick(self.console.as_deref(), vehicle, stick),
        };
        match steered {
            Ok(()) => self.sticks.taken(),
            Err(refusal) => {
                if let Some(error) = self.sticks.refused(vehicle, refusal) {
                    return self.say(&ServerMessage::Error { error }).await;
                }
            }
        }
        Ok(())
    }

    async fn obey(&mut self, text: &str) -> Result<(), End> {
        let error = match serde_json::from_str::<ClientMessage>(text) {
            Ok(ClientMessage::Stick {
                vehicle,
                forward_m_s,
                right_m_s,
                up_m_s,
                yaw_rate_rad_s,
            }) => {
                let stick = Stick {
                    forward_m_s,
                    right_m_s,
                    up_m_s,
                    yaw_rate_rad_s,
                };
                self.sticks.put(vehicle, stick);
                return Ok(());
            }
            Ok(ClientMessage::Rate { rate_hz }) if RATES_HZ.contains(&rate_hz) => {
                self.rate_hz = rate_hz;
                self.frames = ticks(Duration::from_secs_f64(1.0 / rate_hz));
                return self.say(&ServerMessage::Rate { rate_hz }).await;
            }
            Ok(ClientMessage::Rate { rate_hz }) => ErrorDetail {
                code: "invalid_value".to_owned(),
                message: format!(
                    "`rate_hz`: {rate_hz} is not within {} to {}",
                    RATES_HZ.start(),
                    RATES_HZ.end()
                ),
                detail: serde_json::Value::Null,
                example: None,
            },
            Err(error) => ErrorDetail {
                code: "invalid_message".to_owned(),
                message: error.to_string(),
                detail: serde_json::Value::Null,
                example: None,
            },
        };
        self.say(&ServerMessage::Error { error }).await
    }

    async fn say(&mut self, message: &ServerMessage) -> Result<(), End> {
        self.send(Message::Text(view::text(message))).await
    }

    async fn send(&mut self, message: Message) -> Result<(), End> {
        match timeout(SEND_WITHIN, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(End::Gone),
            Err(_) => Err(End::TooSlow),
        }
    }
}

/// Waits until the server is to end; for ever if nobody will say so.
async fn closed(closing: Option<&mut Closing>) {
    match closing {
        Some(closing) => closing.wait().await,
        None => std::future::pending().await,
    }
}

/// Ticks that are late are not made up for.
fn ticks(every: Duration) -> Interval {
    let mut ticks = interval(every);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    ticks
}
