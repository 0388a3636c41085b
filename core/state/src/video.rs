//! The video of a payload: what its camera gives, the streams that are made of it, and who looks at them.
//!
//! Must never do: make a camera wait for a viewer, or one viewer for another.
//!
//! A camera gives pixels, or H.264 that is passed on as it is. What viewers want beside that is a [`Rendition`]; whoever makes it pushes it here.

mod elsewhere;

use parking_lot::Mutex;
use skein_domain::NodeTime;
use skein_domain::payload::PixelFormat;
use skein_plugin_host::Frame;
use skein_video::{Coding, Cursor, EncodedFrame, Given, Intake, Measured, Meter, Relay, StreamFormat};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use tokio::sync::watch;

pub use elsewhere::{RemoteStream, VideosElsewhere};

/// A camera that encodes is taken for one that does so for so long after its last picture, in seconds.
const ENCODES_FOR_S: f64 = 5.0;
/// A camera of which nothing came is starting for so long, in seconds.
const STARTING_S: f64 = 5.0;
/// Pictures that fail for so long, with none that does not, are a failure of the camera, in seconds.
const FAILED_AFTER_S: f64 = 1.0;
/// What a viewer told of the time from glass to glass is good for so long, in seconds; and a longer one is not believed.
const SEEN_FOR_S: f64 = 10.0;
const LONGEST_SEEN_S: f64 = 60.0;
/// A stream stands when nothing came for so many of its periods, and for so long, in seconds.
const STALLED_AFTER: (f64, f64) = (3.0, 0.5);

/// How large a viewer wants the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quality {
    /// As the camera gives them.
    Main,
    /// At most 320x240 and 10/s, for walls of many and thin links.
    Sub,
}

/// What a viewer wants of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Rendition {
    /// How the pictures are encoded.
    pub coding: Coding,
    /// How large they are.
    pub quality: Quality,
}

impl Rendition {
    /// What a camera that encodes gives by itself.
    pub const OF_CAMERA: Self = Self {
        coding: Coding::H264,
        quality: Quality::Main,
    };

    /// Its pictures as files, each for itself.
    pub const FILES: Self = Self {
        coding: Coding::Jpeg,
        quality: Quality::Main,
    };
}

/// How the video of a camera is, in one word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VideoState {
    /// Pictures come.
    Live,
    /// None came yet; it has just begun.
    Starting,
    /// None come any more.
    Stalled,
    /// They come, but none that a decoder can begin with.
    NoKeyPicture,
    /// None ever came.
    NoPictures,
    /// What comes cannot be used.
    Failed(String),
}

/// How the video of a camera is.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoHealth {
    /// In one word.
    pub state: VideoState,
    /// The format, if it is known: of a camera that encodes, or of what is encoded of it.
    pub format: Option<StreamFormat>,
    /// Size of the pictures in pixels; zeros if it is not known.
    pub size_px: (u32, u32),
    /// Rate and loss, as the camera gives; bytes only of one that encodes.
    pub measured: Measured,
    /// How long ago the last picture came, in seconds.
    pub age_s: Option<f64>,
    /// Viewers of all renditions.
    pub viewers: usize,
    /// From glass to glass as a viewer told it last, of late: median and 99th percentile in seconds.
    pub glass_to_glass_s: Option<(f64, f64)>,
}

/// The video of one payload.
#[derive(Debug)]
pub struct Video {
    streams: Mutex<BTreeMap<Rendition, Arc<VideoStream>>>,
    source: Mutex<Source>,
    /// The last frame of pixels.
    pixels: watch::Sender<Option<Arc<Frame>>>,
}

#[derive(Debug, Default)]
struct Source {
    intake: Intake,
    meter: Meter,
    size_px: (u32, u32),
    /// When the camera last gave H.264, and a key picture.
    encoded_at: Option<NodeTime>,
    key_seen: bool,
    /// Number of the last picture that came encoded and whole.
    sequence: Option<u64>,
    /// A picture was lost since the last key picture: what follows it would be shown damaged.
    broken: bool,
    /// Of another node's camera.
    remote_format: Option<StreamFormat>,
    fault: Option<(NodeTime, String)>,
    began: Option<NodeTime>,
    /// What a viewer told last of the time from glass to glass, and when.
    seen: Option<(NodeTime, (f64, f64))>,
}

impl Default for Video {
    fn default() -> Self {
        Self {
            streams: Mutex::default(),
            source: Mutex::default(),
            pixels: watch::Sender::new(None),
        }
    }
}

impl Video {
    /// A frame that the camera gave.
    pub fn take(&self, now: NodeTime, frame: &Arc<Frame>) {
        let (header, mut source) = (&frame.header, self.source.lock());
        if header.format != PixelFormat::H264 {
            source.size_px = (header.width_px, header.height_px);
            source.count_pixels(now, frame);
            drop(source);
            self.pixels.send_replace(Some(frame.clone()));
            return;
        }
        source.encoded_at = Some(now);
        match source.intake.take(header.sequence, header.time, frame.bytes()) {
            Ok(encoded) => {
                source.size_px = (encoded.width_px, encoded.height_px);
                source.key_seen |= encoded.key;
                source.fault = None;
                source.meter.count(now, &encoded);
                let broken = source.breaks_off(&encoded);
                drop(source);
                if !broken {
                    self.stream(Rendition::OF_CAMERA).push(encoded);
                }
            }
            Err(fault) => {
                source.fault.get_or_insert((now, fault.to_string()));
            }
        }
    }

    /// A picture of another node's camera that has come here. Of several renditions only one is counted.
    pub fn take_remote(&self, now: NodeTime, frame: &EncodedFrame, counted: bool) {
        let mut source = self.source.lock();
        source.encoded_at = Some(now);
        source.key_seen |= frame.key;
        source.fault = None;
        if frame.key
            && let Ok(found) = skein_video::h264::contents(&frame.bytes)
        {
            source.remote_format = found.format;
        }
        if counted {
            source.size_px = (frame.width_px, frame.height_px);
            source.meter.count(now, frame);
        }
    }

    /// Why another node does not send its camera's video; none if it does.
    pub fn note_refusal(&self, now: NodeTime, refusal: Option<String>) {
        let mut source = self.source.lock();
        source.began.get_or_insert(now);
        match refusal {
            Some(refusal) => drop(source.fault.get_or_insert((now, refusal))),
            None => source.fault = None,
        }
    }

    /// Somebody looks at this rendition.
    pub fn is_watched(&self, rendition: Rendition) -> bool {
        let streams = self.streams.lock();
        streams.get(&rendition).is_some_and(|stream| stream.viewers() > 0)
    }

    /// The payload's plugin begins, for the first time or anew.
    pub fn begin(&self, now: NodeTime) {
        let mut source = self.source.lock();
        source.began = Some(now);
        source.fault = None;
    }

    /// The stream of a rendition.
    pub fn stream(&self, rendition: Rendition) -> Arc<VideoStream> {
        let mut streams = self.streams.lock();
        streams.entry(rendition).or_default().clone()
    }

    /// The camera encodes by itself.
    pub fn encodes(&self, now: NodeTime) -> bool {
        let encoded_at = self.source.lock().encoded_at;
        encoded_at.is_some_and(|at| now.seconds_since(at) < ENCODES_FOR_S)
    }

    /// Follows the frames of pixels that the camera gives.
    pub fn pixels(&self) -> watch::Receiver<Option<Arc<Frame>>> {
        self.pixels.subscribe()
    }

    /// How it is.
    pub fn health(&self, now: NodeTime) -> VideoHealth {
        let (viewers, made) = {
            let streams = self.streams.lock();
            let viewers = streams.values().map(|stream| stream.viewers()).sum();
            let made = streams.get(&Rendition::OF_CAMERA).and_then(|stream| stream.format());
            (viewers, made)
        };
        let source = self.source.lock();
        let last_at = source.meter.last_at();
        VideoHealth {
            state: source.state(now),
            format: source.intake.format().or(source.remote_format).or(made),
            size_px: source.size_px,
            measured: source.meter.measured(now),
            age_s: last_at.map(|at| now.seconds_since(at).max(0.0)),
            viewers,
            glass_to_glass_s: source
                .seen
                .filter(|(at, _)| now.seconds_since(*at) < SEEN_FOR_S)
                .map(|(_, seen)| seen),
        }
    }

    /// A viewer tells the time from glass to glass: median and 99th percentile in seconds. What cannot be is not taken.
    pub fn note_seen(&self, now: NodeTime, p50_s: f64, p99_s: f64) {
        let can_be = |time_s: f64| (0.0..LONGEST_SEEN_S).contains(&time_s);
        if can_be(p50_s) && can_be(p99_s) {
            self.source.lock().seen = Some((now, (p50_s, p99_s)));
        }
    }
}

impl Source {
    /// Whether a picture cannot be shown because one before it, that it may refer to, is missing.
    fn breaks_off(&mut self, encoded: &EncodedFrame) -> bool {
        let before = self.sequence.replace(encoded.sequence);
        let follows = before.is_none_or(|before| before.checked_add(1) == Some(encoded.sequence));
        self.broken = !encoded.key && (self.broken || !follows);
        self.broken
    }

    fn count_pixels(&mut self, now: NodeTime, frame: &Frame) {
        let header = &frame.header;
        let of_meter = EncodedFrame {
            coding: Coding::Jpeg,
            sequence: header.sequence,
            taken: header.time,
            width_px: header.width_px,
            height_px: header.height_px,
            key: true,
            // Pixels are not what goes over a link.
            bytes: Arc::default(),
        };
        self.meter.count(now, &of_meter);
    }

    fn state(&self, now: NodeTime) -> VideoState {
        if let Some((since, fault)) = &self.fault
            && now.seconds_since(*since) >= FAILED_AFTER_S
        {
            return VideoState::Failed(fault.clone());
        }
        let Some(last_at) = self.meter.last_at() else {
            let starting = self.began.is_none_or(|began| now.seconds_since(began) < STARTING_S);
            return if starting {
                VideoState::Starting
            } else {
                VideoState::NoPictures
            };
        };
        let (periods, least_s) = STALLED_AFTER;
        let period_s = 1.0 / self.meter.measured(last_at).rate_hz.max(0.1);
        if now.seconds_since(last_at) > (periods * period_s).max(least_s) {
            VideoState::Stalled
        } else if self.encoded_at.is_some() && !self.key_seen {
            VideoState::NoKeyPicture
        } else {
            VideoState::Live
        }
    }
}

/// One stream: the newest pictures, and those who look at it.
#[derive(Debug)]
pub struct VideoStream {
    relay: Mutex<Relay>,
    format: Mutex<Option<StreamFormat>>,
    news: watch::Sender<u64>,
    viewers: AtomicUsize,
    wants_key: AtomicBool,
    /// Somebody makes its pictures.
    made: AtomicBool,
}

impl Default for VideoStream {
    fn default() -> Self {
        Self {
            relay: Mutex::default(),
            format: Mutex::default(),
            news: watch::Sender::new(0),
            viewers: AtomicUsize::new(0),
            wants_key: AtomicBool::new(false),
            made: AtomicBool::new(false),
        }
    }
}

impl VideoStream {
    /// Takes the next picture.
    pub fn push(&self, frame: EncodedFrame) {
        self.relay.lock().push(Arc::new(frame));
        self.news.send_modify(|count| *count += 1);
    }

    /// Its format, if it is made of pixels here.
    pub fn format(&self) -> Option<StreamFormat> {
        *self.format.lock()
    }

    /// Whoever makes it tells its format.
    pub fn set_format(&self, format: StreamFormat) {
        *self.format.lock() = Some(format);
    }

    /// Keeps none of its pictures: they were made for those who looked before.
    pub fn forget_pictures(&self) {
        self.relay.lock().forget();
    }

    /// How many look at it.
    pub fn viewers(&self) -> usize {
        self.viewers.load(Ordering::SeqCst)
    }

    /// Whether somebody needs a key picture; it counts as given after that.
    pub fn take_wish_for_key(&self) -> bool {
        self.wants_key.swap(false, Ordering::Relaxed)
    }

    /// Whoever makes its pictures says so; false if somebody does already. The guard ends it.
    pub fn begin_making(self: &Arc<Self>) -> Option<Making> {
        let free = !self.made.swap(true, Ordering::SeqCst);
        free.then(|| Making(self.clone()))
    }

    /// Looks at it from now on.
    pub fn view(self: &Arc<Self>) -> Viewer {
        self.viewers.fetch_add(1, Ordering::SeqCst);
        Viewer {
            news: self.news.subscribe(),
            stream: self.clone(),
            cursor: Cursor::default(),
        }
    }
}

/// Somebody makes the pictures of a stream.
#[derive(Debug)]
pub struct Making(Arc<VideoStream>);

impl Drop for Making {
    fn drop(&mut self) {
        self.0.made.store(false, Ordering::SeqCst);
    }
}

/// One who looks at a stream.
#[derive(Debug)]
pub struct Viewer {
    stream: Arc<VideoStream>,
    cursor: Cursor,
    news: watch::Receiver<u64>,
}

impl Viewer {
    /// The next picture, as soon as there is one that it can decode. Nothing is lost if it is dropped while it waits.
    pub async fn next(&mut self) -> Given {
        loop {
            // Seen before it is looked at: what comes in between wakes it again.
            self.news.mark_unchanged();
            if let Some(given) = self.try_next() {
                return given;
            }
            if self.news.changed().await.is_err() {
                // The stream is held by this viewer, so that it does not end.
                std::future::pending::<()>().await;
            }
        }
    }

    /// The next picture, if one is there.
    pub fn try_next(&mut self) -> Option<Given> {
        let relay = self.stream.relay.lock();
        let given = relay.next(&mut self.cursor);
        if relay.waits_for_key(&self.cursor) {
            self.stream.wants_key.store(true, Ordering::Relaxed);
        }
        given
    }

    /// Its decoder cannot go on without a key picture.
    pub fn ask_for_key(&self) {
        self.stream.wants_key.store(true, Ordering::Relaxed);
    }

    /// Whether both look at one stream.
    pub fn sees_the_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.stream, &other.stream)
    }

    /// Pictures that it was not in time for.
    pub fn left_out(&self) -> u64 {
        self.cursor.left_out
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.stream.viewers.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests;
