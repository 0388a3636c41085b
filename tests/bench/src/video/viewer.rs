//! A viewer's process: it looks at some cameras over WebSockets, as a browser with WebCodecs does, and counts the pictures.
//!
//! It says `live` when it has a picture of each. It is told on its standard input when a window begins (`b`) and ends (`e`), and answers an
//! end with one line of JSON. The end of its input ends it.

use super::errors;
use crate::error::BenchError;
use crate::fleet::FleetBenchArgs;
use crate::process::Part;
use futures_util::StreamExt;
use serde::{Deserialize, Serialize};
use std::io::{BufReader, Read, Write};
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio_tungstenite::connect_async;
use tokio_tungstenite::tungstenite::Message;

/// Its name in faults.
pub(super) const NAME: &str = "viewer";
/// How long a camera may take to show its first picture.
const RETRY_EVERY: Duration = Duration::from_millis(300);

/// What a viewer is told.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VideoViewerSettings {
    /// The program's web server.
    pub(super) target: SocketAddr,
    /// The vehicles whose cameras it looks at.
    pub(super) cameras: Vec<u16>,
}

/// What it saw in a window.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct ViewerFigures {
    /// Pictures of each camera per second.
    pub(super) rates_hz: Vec<f64>,
    /// The longest time without a picture of one of them.
    pub(super) longest_gap_ms: f64,
}

/// A picture of a camera, by its place in the settings.
type Picture = (usize, Instant);

/// Starts one.
pub(super) fn start(args: &FleetBenchArgs, settings: &VideoViewerSettings) -> Result<Part, BenchError> {
    let settings = serde_json::to_string(settings).map_err(BenchError::Settings)?;
    let words = ["bench", "video-viewer", &settings];
    Part::start(NAME, &args.helper, &words, args.scheduling, errors())
}

/// Runs a viewer until its standard input ends; the settings are JSON.
///
/// # Errors
/// When the settings do not parse, a system call fails, or the program ends a stream.
pub fn run_video_viewer(settings: &str) -> Result<(), BenchError> {
    let settings: VideoViewerSettings = serde_json::from_str(settings).map_err(BenchError::Settings)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    runtime.block_on(async {
        let (give, pictures) = unbounded_channel();
        for (place, camera) in settings.cameras.iter().enumerate() {
            let url = format!(
                "ws://{}/api/v1/vehicles/{camera}/payloads/camera/video?way=h264",
                settings.target
            );
            tokio::spawn(look(url, place, give.clone()));
        }
        count(settings.cameras.len(), pictures, told()).await
    })
}

/// Looks at one camera, and again where the stream ends.
async fn look(url: String, place: usize, give: UnboundedSender<Picture>) {
    loop {
        if let Ok((mut stream, _)) = connect_async(&url).await {
            while let Some(Ok(message)) = stream.next().await {
                let is_picture = matches!(message, Message::Binary(_));
                if is_picture && give.send((place, Instant::now())).is_err() {
                    return;
                }
            }
        }
        tokio::time::sleep(RETRY_EVERY).await;
    }
}

/// What comes over standard input, letter by letter.
fn told() -> UnboundedReceiver<u8> {
    let (give, told) = unbounded_channel();
    std::thread::spawn(move || {
        let letters = BufReader::new(std::io::stdin()).bytes().map_while(Result::ok);
        // The other end is gone with the process.
        letters.for_each(|letter| {
            let _ = give.send(letter);
        });
    });
    told
}

async fn count(
    cameras: usize,
    mut pictures: UnboundedReceiver<Picture>,
    mut told: UnboundedReceiver<u8>,
) -> Result<(), BenchError> {
    let mut seen = Seen::new(cameras, Instant::now());
    let mut live = false;
    loop {
        tokio::select! {
            Some((place, at)) = pictures.recv() => {
                seen.picture(place, at);
                if !live && seen.is_complete() {
                    live = true;
                    say("live")?;
                }
            }
            letter = told.recv() => match letter {
                Some(b'b') => seen = Seen::new(cameras, Instant::now()),
                Some(b'e') => {
                    let figures = seen.figures(Instant::now());
                    say(&serde_json::to_string(&figures).map_err(BenchError::Settings)?)?;
                }
                Some(_) => {}
                None => return Ok(()),
            },
        }
    }
}

fn say(line: &str) -> Result<(), BenchError> {
    let mut out = std::io::stdout().lock();
    let said = writeln!(out, "{line}").and_then(|()| out.flush());
    said.map_err(BenchError::system("standard output"))
}

/// The pictures of a window.
pub(super) struct Seen {
    begun: Instant,
    /// Of each camera: how many, and when the last came.
    cameras: Vec<(u32, Instant)>,
    longest: Duration,
}

impl Seen {
    pub(super) fn new(cameras: usize, begun: Instant) -> Self {
        Self {
            begun,
            cameras: vec![(0, begun); cameras],
            longest: Duration::ZERO,
        }
    }

    pub(super) fn picture(&mut self, place: usize, at: Instant) {
        let Some((count, last)) = self.cameras.get_mut(place) else {
            return;
        };
        *count += 1;
        let before = std::mem::replace(last, at);
        self.longest = self.longest.max(at.saturating_duration_since(before));
    }

    fn is_complete(&self) -> bool {
        self.cameras.iter().all(|(count, _)| *count > 0)
    }

    /// A camera of which nothing has come for longest counts with that.
    pub(super) fn figures(&self, now: Instant) -> ViewerFigures {
        let window_s = now.saturating_duration_since(self.begun).as_secs_f64();
        let rate = |(count, _): &(u32, Instant)| f64::from(*count) / window_s;
        let waiting = self
            .cameras
            .iter()
            .map(|(_, last)| now.saturating_duration_since(*last));
        let longest = waiting.fold(self.longest, Duration::max);
        ViewerFigures {
            rates_hz: self.cameras.iter().map(rate).collect(),
            longest_gap_ms: longest.as_secs_f64() * 1e3,
        }
    }
}
