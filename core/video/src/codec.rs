//! H.264 encoded and decoded by the library OpenH264, which is built from the source that its crate carries.

use crate::planes::{Planes, PlanesError};
use openh264::decoder::{DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::encoder::{
    BitRate, Complexity, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, UsageType,
};
use openh264::formats::YUVSource;
use openh264::{OpenH264API, Timestamp};
use skein_domain::NodeTime;
use thiserror::Error;

/// Bits that a pixel of one picture gets: 0.9 Mbit/s at 640x480 and 30/s.
const BITS_PER_PIXEL: f64 = 0.1;
const LEAST_BITS_PER_S: f64 = 100_000.0;
const MOST_BITS_PER_S: f64 = 8_000_000.0;
/// A key picture comes so often, in seconds, though nobody asks for one.
const KEY_EVERY_S: f64 = 2.0;

/// Why a picture is not encoded or decoded.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum CodecError {
    /// The library says no.
    #[error("{0}")]
    Library(String),
    /// What it decoded is nothing to work with.
    #[error(transparent)]
    Planes(#[from] PlanesError),
}

impl From<openh264::Error> for CodecError {
    fn from(error: openh264::Error) -> Self {
        Self::Library(error.to_string())
    }
}

/// An encoded picture: constrained baseline, without pictures that refer to later ones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// In Annex B's byte stream, parameter sets before each key picture.
    pub bytes: Vec<u8>,
    /// A decoder can begin with it.
    pub key: bool,
}

/// Encodes the pictures of one stream.
pub struct H264Encoder {
    encoder: Encoder,
    size_px: (u32, u32),
    next_key: Option<NodeTime>,
}

impl H264Encoder {
    /// For pictures of this size, so many a second.
    ///
    /// # Errors
    ///
    /// The library cannot be made ready.
    pub fn new(size_px: (u32, u32), rate_hz: f64) -> Result<Self, CodecError> {
        let bits_per_s = f64::from(size_px.0) * f64::from(size_px.1) * rate_hz * BITS_PER_PIXEL;
        let config = EncoderConfig::new()
            .bitrate(BitRate::from_bps(
                bits_per_s.clamp(LEAST_BITS_PER_S, MOST_BITS_PER_S) as u32
            ))
            .max_frame_rate(FrameRate::from_hz(rate_hz as f32))
            .usage_type(UsageType::CameraVideoRealTime)
            .complexity(Complexity::Low)
            .scene_change_detect(false)
            // Without that the library cannot keep the rate: it leaves a picture out instead.
            .skip_frames(true)
            // When one is due is decided by time: cameras do not keep their rate.
            .intra_frame_period(IntraFramePeriod::auto())
            .num_threads(1);
        Ok(Self {
            encoder: Encoder::with_api_config(OpenH264API::from_source(), config)?,
            size_px,
            next_key: None,
        })
    }

    /// Whether it is made for such pictures.
    #[must_use]
    pub fn fits(&self, size_px: (u32, u32)) -> bool {
        self.size_px == size_px
    }

    /// Encodes a picture; as a key picture if one is wanted or due. None if the library leaves it out.
    ///
    /// # Errors
    ///
    /// The library says no.
    pub fn encode(&mut self, taken: NodeTime, planes: &Planes, wants_key: bool) -> Result<Option<Encoded>, CodecError> {
        if wants_key || self.next_key.is_none_or(|due| taken >= due) {
            self.encoder.force_intra_frame();
        }
        let stream = self
            .encoder
            .encode_at(planes, Timestamp::from_millis((taken.as_seconds() * 1e3) as u64))?;
        let key = matches!(stream.frame_type(), FrameType::IDR);
        let bytes = stream.to_vec();
        if key {
            self.next_key = Some(taken.plus_seconds(KEY_EVERY_S));
        }
        Ok((!bytes.is_empty()).then_some(Encoded { bytes, key }))
    }
}

/// A picture in red, green and blue, one byte each, without gaps between rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rgb {
    /// Width in pixels.
    pub width_px: u32,
    /// Height in pixels.
    pub height_px: u32,
    /// The pixels, row by row from the top.
    pub rgb: Vec<u8>,
}

impl Rgb {
    fn of(picture: &DecodedYUV<'_>) -> Self {
        let (width, height) = picture.dimensions();
        let mut rgb = vec![0; picture.rgb8_len()];
        picture.write_rgb8(&mut rgb);
        Self {
            width_px: u32::try_from(width).unwrap_or(0),
            height_px: u32::try_from(height).unwrap_or(0),
            rgb,
        }
    }
}

/// Decodes the pictures of one stream.
pub struct H264Decoder {
    decoder: Decoder,
}

impl H264Decoder {
    /// A decoder that waits for a key picture.
    ///
    /// # Errors
    ///
    /// The library cannot be made ready.
    pub fn new() -> Result<Self, CodecError> {
        let decoder = Decoder::with_api_config(OpenH264API::from_source(), DecoderConfig::new())?;
        Ok(Self { decoder })
    }

    /// A decoder for files, whose pictures may be coded in another order than they are shown in: it keeps some back, and
    /// [`H264Decoder::remaining_rgb`] gives the last.
    ///
    /// # Errors
    ///
    /// The library cannot be made ready.
    pub fn for_files() -> Result<Self, CodecError> {
        let config = DecoderConfig::new().flush_after_decode(Flush::NoFlush);
        let decoder = Decoder::with_api_config(OpenH264API::from_source(), config)?;
        Ok(Self { decoder })
    }

    /// Decodes an access unit to red, green and blue. None if no picture is ready yet.
    ///
    /// # Errors
    ///
    /// It cannot be decoded; the next key picture can be.
    pub fn decode_rgb(&mut self, bytes: &[u8]) -> Result<Option<Rgb>, CodecError> {
        Ok(self.decoder.decode(bytes)?.as_ref().map(Rgb::of))
    }

    /// The pictures that were kept back.
    pub fn remaining_rgb(&mut self) -> Vec<Rgb> {
        let remaining = self.decoder.flush_remaining().unwrap_or_default();
        remaining.iter().map(Rgb::of).collect()
    }

    /// Decodes an access unit. None if no picture is ready yet.
    ///
    /// # Errors
    ///
    /// It cannot be decoded; the next key picture can be.
    pub fn decode(&mut self, bytes: &[u8]) -> Result<Option<Planes>, CodecError> {
        match self.decoder.decode(bytes)? {
            Some(picture) => Ok(Some(Planes::of_yuv(&picture)?)),
            None => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests;
