//! Makes the pictures of one rendition for as long as somebody looks at it.

use crate::CameraStreams;
use crate::streams::Looked;
use skein_domain::NodeTime;
use skein_domain::payload::PixelFormat;
use skein_plugin_host::Frame;
use skein_state::video::{Quality, Rendition, Video, VideoStream, Viewer};
use skein_video::{Coding, EncodedFrame, H264Decoder, H264Encoder, Planes, h264, jpeg};
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

/// The largest picture of [`Quality::Sub`], in pixels.
const VIDEO_SUB_PX: (u32, u32) = (320, 240);
/// Pictures per second of [`Quality::Sub`], at most.
const SUB_RATE_HZ: f64 = 10.0;
/// JPEG pictures per second, at most: each costs five times the bytes that H.264 takes.
const JPEG_RATE_HZ: f64 = 15.0;
/// What an encoder reckons with; cameras with fewer pictures get more bits for each.
const ENCODED_RATE_HZ: f64 = 30.0;
const JPEG_QUALITY: u8 = 75;
/// How often it is looked whether somebody still wants the pictures; so long they are made for nobody.
const LOOK_EVERY: Duration = Duration::from_secs(2);
/// Key pictures that are asked for come no closer, in seconds: each costs ten others.
const KEYS_APART_S: f64 = 0.5;
/// A picture that comes this much before its time is in time: cameras do not keep their rate to the millisecond.
const EARLY: f64 = 0.25;

/// Makes one rendition.
pub(crate) struct Maker {
    node: CameraStreams,
    camera: Looked,
    video: Arc<Video>,
    /// Of which H.264 it is made, if there is any.
    source: Rendition,
    rendition: Rendition,
    stream: Arc<VideoStream>,
    codecs: Codecs,
    last_taken: Option<NodeTime>,
    last_key: Option<NodeTime>,
    sequence: u64,
}

/// What a picture is made of.
enum Input {
    Pixels(Arc<Frame>),
    Encoded(Arc<EncodedFrame>),
}

/// Encoder and decoder of one rendition, on whichever thread computes.
#[derive(Default)]
struct Codecs {
    decoder: Option<H264Decoder>,
    encoder: Option<H264Encoder>,
}

struct Made {
    bytes: Vec<u8>,
    key: bool,
    size_px: (u32, u32),
}

impl Maker {
    pub(crate) fn new(
        node: CameraStreams,
        camera: Looked,
        video: Arc<Video>,
        source: Rendition,
        rendition: Rendition,
        stream: Arc<VideoStream>,
    ) -> Self {
        Self {
            node,
            camera,
            video,
            source,
            rendition,
            stream,
            codecs: Codecs::default(),
            last_taken: None,
            last_key: None,
            sequence: 0,
        }
    }

    /// Runs until nobody looks any more.
    pub(crate) async fn run(mut self) {
        let is_elsewhere = self.node.shared().host(self.camera.vehicle).is_some();
        let mut pixels = self.video.pixels();
        // The last frame is not new, but better than to wait for the next one.
        pixels.mark_changed();
        let mut encoded: Option<Viewer> = None;
        let mut look = interval(LOOK_EVERY);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        look.reset();
        loop {
            let encodes = is_elsewhere || self.video.encodes(self.node.now());
            if encodes && self.rendition != self.source {
                if encoded.is_none() {
                    let camera = &self.camera;
                    // Gone: whoever looks is told by the state.
                    encoded = self.node.watch_video(camera.vehicle, &camera.payload, self.source).ok();
                }
            } else {
                encoded = None;
            }
            tokio::select! {
                _ = look.tick() => if self.stream.viewers() == 0 {
                    return;
                },
                changed = pixels.changed() => {
                    if changed.is_err() {
                        return;
                    }
                    let newest = pixels.borrow_and_update().clone();
                    if let Some(frame) = newest.filter(|_| !encodes) {
                        self.make(Input::Pixels(frame)).await;
                    }
                }
                given = next(encoded.as_mut()) => self.make(Input::Encoded(given)).await,
            }
        }
    }

    fn rate_hz(&self) -> f64 {
        match (self.rendition.quality, self.rendition.coding) {
            (Quality::Sub, _) => SUB_RATE_HZ,
            (Quality::Main, Coding::Jpeg) => JPEG_RATE_HZ,
            (Quality::Main, Coding::H264) => f64::INFINITY,
        }
    }

    /// Makes a picture if it is time for one, on a thread where that may take its time.
    async fn make(&mut self, input: Input) {
        let taken = input.taken();
        let period_s = (1.0 - EARLY) / self.rate_hz();
        let due = self
            .last_taken
            .is_none_or(|last| taken.seconds_since(last) >= period_s || taken < last);
        let rendition = self.rendition;
        let key_may_come = self
            .last_key
            .is_none_or(|last| taken.seconds_since(last) >= KEYS_APART_S);
        let wants_key = due && key_may_come && self.stream.take_wish_for_key();
        let mut codecs = std::mem::take(&mut self.codecs);
        let work = move || {
            let made = codecs.make(&input, rendition, due, wants_key);
            (codecs, made)
        };
        let Ok((codecs, made)) = tokio::task::spawn_blocking(work).await else {
            // It panicked: the next one begins anew.
            return;
        };
        self.codecs = codecs;
        match made {
            Ok(Some(made)) => self.push(taken, made),
            Ok(None) => {}
            Err(reason) => tracing::debug!(camera = %self.camera.payload, "no picture made: {reason}"),
        }
    }

    fn push(&mut self, taken: NodeTime, made: Made) {
        self.last_taken = Some(taken);
        self.sequence += 1;
        if made.key {
            self.last_key = Some(taken);
        }
        if made.key
            && self.rendition.coding == Coding::H264
            && let Ok(found) = h264::contents(&made.bytes)
            && let Some(format) = found.format
        {
            self.stream.set_format(format);
        }
        self.stream.push(EncodedFrame {
            coding: self.rendition.coding,
            sequence: self.sequence,
            taken,
            width_px: made.size_px.0,
            height_px: made.size_px.1,
            key: made.key,
            bytes: made.bytes.into(),
        });
    }
}

async fn next(viewer: Option<&mut Viewer>) -> Arc<EncodedFrame> {
    match viewer {
        Some(viewer) => viewer.next().await.frame,
        None => std::future::pending().await,
    }
}

impl Input {
    fn taken(&self) -> NodeTime {
        match self {
            Self::Pixels(frame) => frame.header.time,
            Self::Encoded(frame) => frame.taken,
        }
    }
}

impl Codecs {
    /// The picture in the wanted rendition; none if it is not due, or the codec has none ready.
    fn make(&mut self, input: &Input, wanted: Rendition, due: bool, wants_key: bool) -> Result<Option<Made>, String> {
        let planes = match input {
            Input::Pixels(_) if !due => return Ok(None),
            Input::Pixels(frame) => {
                let header = &frame.header;
                if header.format == PixelFormat::Jpeg && wanted == Rendition::FILES {
                    return Ok(Some(Made {
                        bytes: frame.bytes().to_vec(),
                        key: true,
                        size_px: (header.width_px, header.height_px),
                    }));
                }
                Planes::of_frame(header, frame.bytes()).map_err(|error| error.to_string())?
            }
            // Each has to be decoded, since the next one refers to it.
            Input::Encoded(frame) => match self.decoded(&frame.bytes)? {
                Some(planes) if due => planes,
                _ => return Ok(None),
            },
        };
        let planes = match wanted.quality {
            Quality::Main => planes,
            Quality::Sub => planes.fitted(VIDEO_SUB_PX.0, VIDEO_SUB_PX.1),
        };
        let size_px = planes.size_px();
        if wanted.coding == Coding::Jpeg {
            let bytes = jpeg(&planes, JPEG_QUALITY).map_err(|error| error.to_string())?;
            let key = true;
            return Ok(Some(Made { bytes, key, size_px }));
        }
        let rate_hz = match wanted.quality {
            Quality::Main => ENCODED_RATE_HZ,
            Quality::Sub => SUB_RATE_HZ,
        };
        let encoded = self.encoded(input.taken(), &planes, rate_hz, wants_key)?;
        Ok(encoded.map(|(bytes, key)| Made { bytes, key, size_px }))
    }

    fn decoded(&mut self, bytes: &[u8]) -> Result<Option<Planes>, String> {
        let decoder = match &mut self.decoder {
            Some(decoder) => decoder,
            none => none.insert(H264Decoder::new().map_err(|error| error.to_string())?),
        };
        decoder.decode(bytes).map_err(|error| error.to_string())
    }

    fn encoded(
        &mut self,
        taken: NodeTime,
        planes: &Planes,
        rate_hz: f64,
        wants_key: bool,
    ) -> Result<Option<(Vec<u8>, bool)>, String> {
        let size_px = planes.size_px();
        self.encoder.take_if(|encoder| !encoder.fits(size_px));
        let encoder = match &mut self.encoder {
            Some(encoder) => encoder,
            none => none.insert(H264Encoder::new(size_px, rate_hz).map_err(|error| error.to_string())?),
        };
        let encoded = encoder.encode(taken, planes, wants_key);
        let encoded = encoded.map_err(|error| error.to_string())?;
        Ok(encoded.map(|encoded| (encoded.bytes, encoded.key)))
    }
}
