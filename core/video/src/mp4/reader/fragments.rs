//! The pictures of an MP4 file in fragments (ISO/IEC 14496-12, 8.8), as recordings are that may be cut off at any moment.
//!
//! Must never do: believe a length before what it counts is there.

use super::{LARGEST_SAMPLE, Sample, Shown};
use mp4_atom::{Atom, Decode, FourCC, Header, Moof, Moov, Mvex, ReadFrom, Traf, Trex, TrunEntry};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

/// A box with a table larger than this is not believed, in bytes.
const LARGEST_TABLE: u64 = 16 << 20;
/// Set in a sample's flags when a decoder cannot begin with it.
const IS_NON_SYNC: u32 = 0x1_0000;

/// What is known of the file so far.
struct Reading {
    track_id: u32,
    ticks_per_s: f64,
    file_bytes: u64,
    defaults: Trex,
    /// The next picture's time where a fragment does not say it.
    next_ticks: u64,
    first_ticks: Option<u64>,
    samples: Vec<Sample>,
    shown_s: Vec<f64>,
}

/// How much of a file consists of whole boxes, in bytes; the file then stands at its beginning. What follows was cut off.
pub(super) fn whole_boxes(file: &mut (impl Read + Seek), file_bytes: u64) -> io::Result<u64> {
    let mut start = 0;
    while let Some((_, content)) = box_at(file, start, file_bytes) {
        start = content.end;
    }
    file.rewind()?;
    Ok(start)
}

/// The box that begins there: its kind, and where its content stands.
fn box_at(file: &mut (impl Read + Seek), start: u64, file_bytes: u64) -> Option<(FourCC, Range<u64>)> {
    file.seek(SeekFrom::Start(start)).ok()?;
    let header = Header::read_from(file).ok()?;
    let begin = file.stream_position().ok()?;
    let end = match header.size {
        Some(len) => begin.checked_add(u64::try_from(len).ok()?)?,
        // It is all the rest.
        None => file_bytes,
    };
    (end <= file_bytes).then_some((header.kind, begin..end))
}

/// Where the samples are, and when their pictures are shown. What comes after a fragment that is not whole is left out.
pub(super) fn samples(
    file: &mut (impl Read + Seek),
    file_bytes: u64,
    track_id: u32,
    ticks_per_s: f64,
) -> (Vec<Sample>, Shown) {
    let mut reading = Reading {
        track_id,
        ticks_per_s,
        file_bytes,
        defaults: Trex::default(),
        next_ticks: 0,
        first_ticks: None,
        samples: Vec::new(),
        shown_s: Vec::new(),
    };
    let mut start = 0;
    while let Some(next) = reading.read_box(file, start) {
        start = next;
    }
    (reading.samples, reading.shown_s)
}

impl Reading {
    /// Reads the box that begins there; gives where the next one does, unless the file ends or is damaged here.
    fn read_box(&mut self, file: &mut (impl Read + Seek), start: u64) -> Option<u64> {
        let (kind, content) = box_at(file, start, self.file_bytes)?;
        let len = content.end - content.start;
        if [Moov::KIND, Moof::KIND].contains(&kind) {
            let mut body = vec![0; usize::try_from(len).ok().filter(|_| len <= LARGEST_TABLE)?];
            file.read_exact(&mut body).ok()?;
            match kind {
                Moov::KIND => self.learn_defaults(&body),
                _ => self.take_fragment(start, &body)?,
            }
        }
        Some(content.end)
    }

    /// What samples of the track are like where their fragment does not say it.
    fn learn_defaults(&mut self, moov: &[u8]) {
        let extends = child(moov, Mvex::KIND).and_then(|mut body| Mvex::decode_body(&mut body).ok());
        let mut all = extends.map(|extends| extends.trex).unwrap_or_default().into_iter();
        if let Some(defaults) = all.find(|defaults| defaults.track_id == self.track_id) {
            self.defaults = defaults;
        }
    }

    fn take_fragment(&mut self, start: u64, mut body: &[u8]) -> Option<()> {
        let mut runs = Moof::decode_body(&mut body).ok()?.traf;
        runs.retain(|traf| traf.tfhd.track_id == self.track_id);
        runs.iter().try_for_each(|traf| self.take_run(start, traf))
    }

    fn take_run(&mut self, start: u64, traf: &Traf) -> Option<()> {
        let base = traf.tfhd.base_data_offset.unwrap_or(start);
        let mut ticks = traf
            .tfdt
            .as_ref()
            .map_or(self.next_ticks, |at| at.base_media_decode_time);
        let mut at = base;
        for run in &traf.trun {
            if let Some(offset) = run.data_offset {
                at = base.checked_add_signed(offset.into())?;
            }
            for entry in run.samples.iter() {
                at = self.take_sample(at, ticks, traf, &entry)?;
                let duration = entry.duration.or(traf.tfhd.default_sample_duration);
                ticks = ticks.checked_add(duration.unwrap_or(self.defaults.default_sample_duration).into())?;
            }
        }
        self.next_ticks = ticks;
        Some(())
    }

    /// One picture that begins at this byte; gives where it ends.
    fn take_sample(&mut self, start: u64, ticks: u64, traf: &Traf, entry: &TrunEntry) -> Option<u64> {
        let len = entry.size.or(traf.tfhd.default_sample_size);
        let len = u64::from(len.unwrap_or(self.defaults.default_sample_size));
        // Every sample has a byte at least: a table that claims more would only fill the memory.
        let end = start.checked_add(len).filter(|end| *end <= self.file_bytes)?;
        if len == 0 || len > LARGEST_SAMPLE {
            return None;
        }
        let flags = entry.flags.or(traf.tfhd.default_sample_flags);
        let flags = flags.unwrap_or(self.defaults.default_sample_flags);
        let first = *self.first_ticks.get_or_insert(ticks);
        self.samples.push(Sample {
            start,
            len: usize::try_from(len).ok()?,
            sync: flags & IS_NON_SYNC == 0,
            decode_s: ticks.saturating_sub(first) as f64 / self.ticks_per_s,
        });
        let shown_ticks = ticks as f64 + entry.cts.unwrap_or(0) as f64;
        self.shown_s.push(shown_ticks / self.ticks_per_s);
        Some(end)
    }
}

/// What is in the first box of this kind.
fn child(mut body: &[u8], kind: FourCC) -> Option<&[u8]> {
    loop {
        let header = Header::decode(&mut body).ok()?;
        let (content, rest) = body.split_at_checked(header.size?)?;
        if header.kind == kind {
            return Some(content);
        }
        body = rest;
    }
}
