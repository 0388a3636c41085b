//! What is in an MP4 file with H.264, plain or in fragments, also one that was cut off.
//!
//! Must never do: believe a length before what it counts is there.

mod fragments;

use mp4parse::unstable::{CheckedInteger, create_sample_table};
use mp4parse::{CodecType, SampleEntry, Track, TrackType, VideoCodecSpecific, VideoSampleEntry};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What stands before each unit of a raw stream.
const START_CODE: [u8; 4] = [0, 0, 0, 1];
/// A sample larger than this is not believed, in bytes.
const LARGEST_SAMPLE: u64 = 32 << 20;
/// Larger pictures are not believed, in pixels.
const MOST_PIXELS: u64 = 64 << 20;

/// Why a file cannot be read as a video.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Mp4ReadError {
    /// The system does not give it.
    #[error("{} cannot be read: {reason}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// It is a video without a picture.
    #[error("there is no picture in {}", path.display())]
    Empty {
        /// Which file.
        path: PathBuf,
    },
    /// It is something else.
    #[error("{} is no H.264 video in an MP4 file", path.display())]
    NoVideo {
        /// Which file.
        path: PathBuf,
    },
    /// It contradicts itself.
    #[error("{} is damaged: {reason}", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// How.
        reason: String,
    },
}

/// One coded picture in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample {
    start: u64,
    len: usize,
    /// A decoder can begin with it.
    sync: bool,
    /// When it is to be decoded, in seconds from the first.
    decode_s: f64,
}

/// When each picture is shown, in seconds, in the order of showing.
type Shown = Vec<f64>;

/// Reads the pictures of one file, as they are encoded.
pub struct Mp4Reader {
    path: PathBuf,
    file: BufReader<File>,
    samples: Vec<Sample>,
    shown_s: Shown,
    /// Parameter sets, as they stand in a raw stream.
    head: Vec<u8>,
    /// Bytes of the number before each unit.
    len_size: usize,
}

impl Mp4Reader {
    /// Reads where the pictures are.
    ///
    /// # Errors
    ///
    /// The file cannot be read, or is no such video.
    pub fn open(path: &Path) -> Result<Self, Mp4ReadError> {
        let unreadable = |error: std::io::Error| Mp4ReadError::Unreadable {
            path: path.to_owned(),
            reason: error.to_string(),
        };
        let damaged = |reason: &str| Mp4ReadError::Damaged {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        let file = File::open(path).map_err(unreadable)?;
        let size = file.metadata().map_err(unreadable)?.len();
        let mut file = BufReader::new(file);
        let whole = fragments::whole_boxes(&mut file, size).map_err(unreadable)?;
        let context =
            mp4parse::read_mp4(&mut file.by_ref().take(whole)).map_err(|error| damaged(&format!("{error:?}")))?;
        let mut tracks = context
            .tracks
            .iter()
            .filter(|track| track.track_type == TrackType::Video);
        let no_video = || Mp4ReadError::NoVideo { path: path.to_owned() };
        let (track, entry) = tracks
            .find_map(|track| Some((track, h264(track)?)))
            .ok_or_else(no_video)?;
        let VideoCodecSpecific::AVCConfig(config) = &entry.codec_specific else {
            return Err(no_video());
        };
        if u64::from(entry.width) * u64::from(entry.height) > MOST_PIXELS {
            return Err(damaged("the pictures are too large"));
        }
        let (len_size, head) = parameter_sets(config).ok_or_else(|| damaged("no parameter sets"))?;
        let wrong = || damaged("its table of pictures is wrong");
        let (mut samples, mut shown_s) = samples(track, size).ok_or_else(wrong)?;
        if let (true, Some(id)) = (samples.is_empty(), track.track_id) {
            let ticks_per_s = ticks_per_s(track).ok_or_else(wrong)?;
            (samples, shown_s) = fragments::samples(&mut file, size, id, ticks_per_s);
        }
        shown_s.sort_by(f64::total_cmp);
        if samples.is_empty() {
            return Err(Mp4ReadError::Empty { path: path.to_owned() });
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            samples,
            shown_s,
            head,
            len_size,
        })
    }

    /// How many pictures there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is none; a file that was opened has one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// When each picture is shown, in seconds, in the order of showing.
    #[must_use]
    pub fn shown_s(&self) -> &[f64] {
        &self.shown_s
    }

    /// A picture as it is encoded, in Annex B's byte stream; with the parameter sets if a decoder can begin with it.
    ///
    /// # Errors
    ///
    /// The file gives it no more.
    pub fn coded(&mut self, index: usize) -> Result<Vec<u8>, Mp4ReadError> {
        let Some(sample) = self.samples.get(index).copied() else {
            return Ok(Vec::new());
        };
        let (mut coded, mut raw) = (Vec::new(), Vec::new());
        self.load(sample, &mut coded)
            .map_err(|error| Mp4ReadError::Unreadable {
                path: self.path.clone(),
                reason: error.to_string(),
            })?;
        if sample.sync {
            raw.extend_from_slice(&self.head);
        }
        append_units(&coded, self.len_size, &mut raw);
        Ok(raw)
    }

    /// When a picture is to be decoded, in seconds from the first.
    #[must_use]
    pub fn decoded_at_s(&self, index: usize) -> f64 {
        self.samples.get(index).map_or(0.0, |sample| sample.decode_s)
    }

    /// From the first picture to the end of the last, in seconds. One picture alone is shown for a second.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let last_s = self.decoded_at_s(self.samples.len().saturating_sub(1));
        let steps = self.samples.len().saturating_sub(1).max(1) as f64;
        if last_s > 0.0 { last_s + last_s / steps } else { 1.0 }
    }

    fn load(&mut self, sample: Sample, into: &mut Vec<u8>) -> std::io::Result<()> {
        into.resize(sample.len, 0);
        self.file.seek(SeekFrom::Start(sample.start))?;
        self.file.read_exact(into)
    }
}

fn h264(track: &Track) -> Option<&VideoSampleEntry> {
    let descriptions = &track.stsd.as_ref()?.descriptions;
    descriptions.iter().find_map(|description| match description {
        SampleEntry::Video(entry) if entry.codec_type == CodecType::H264 => Some(entry),
        _ => None,
    })
}

/// Where the samples are, and when their pictures are shown; `None` if that cannot be.
fn samples(track: &Track, size: u64) -> Option<(Vec<Sample>, Shown)> {
    // Every sample has a byte at least: a table that claims more would only fill the memory.
    let claimed = track
        .stts
        .as_ref()?
        .samples
        .iter()
        .try_fold(0_u64, |sum, entry| sum.checked_add(u64::from(entry.sample_count)))?;
    if claimed > size {
        return None;
    }
    let ticks_per_s = ticks_per_s(track)?;
    let table = create_sample_table(track, CheckedInteger(0))?;
    let mut samples = Vec::with_capacity(table.len());
    let mut shown_s = Vec::with_capacity(table.len());
    let first_ticks = table.iter().next().map_or(0, |entry| entry.start_decode.0);
    for entry in table.iter() {
        let (start, end) = (entry.start_offset.0, entry.end_offset.0);
        let len = end.checked_sub(start).filter(|len| *len <= LARGEST_SAMPLE)?;
        if end > size {
            // The file was cut off: what is there can be shown.
            break;
        }
        samples.push(Sample {
            start,
            len: usize::try_from(len).ok()?,
            sync: entry.sync,
            decode_s: entry.start_decode.0.saturating_sub(first_ticks).max(0) as f64 / ticks_per_s,
        });
        shown_s.push(entry.start_composition.0 as f64 / ticks_per_s);
    }
    Some((samples, shown_s))
}

fn ticks_per_s(track: &Track) -> Option<f64> {
    let ticks = track.timescale.map(|scale| scale.0).filter(|ticks| *ticks > 0);
    ticks.map(|ticks| ticks as f64)
}

/// Reads the decoder's configuration: how long the number before each unit is, and the parameter sets.
fn parameter_sets(config: &[u8]) -> Option<(usize, Vec<u8>)> {
    let len_size = usize::from(config.get(4)? & 0b11) + 1;
    let mut rest = config.get(5..)?;
    let mut head = Vec::new();
    for mask in [0b1_1111, 0xff] {
        let (count, after) = rest.split_first()?;
        rest = after;
        for _ in 0..count & mask {
            let (unit, after) = unit(rest, 2)?;
            head.extend(START_CODE);
            head.extend(unit);
            rest = after;
        }
    }
    (!head.is_empty()).then_some((len_size, head))
}

/// The first unit of some bytes, and what follows it.
fn unit(bytes: &[u8], len_size: usize) -> Option<(&[u8], &[u8])> {
    let (len, rest) = bytes.split_at_checked(len_size)?;
    let len = len.iter().fold(0_usize, |sum, byte| sum << 8 | usize::from(*byte));
    rest.split_at_checked(len)
}

fn append_units(mut coded: &[u8], len_size: usize, raw: &mut Vec<u8>) {
    while let Some((this, rest)) = unit(coded, len_size) {
        raw.extend(START_CODE);
        raw.extend(this);
        coded = rest;
    }
}

#[cfg(test)]
mod tests;
