//! What an H.264 access unit holds (ITU-T H.264, Annex B): whether a decoder can begin with it, and the format that its parameter sets tell.

use h264_reader::annexb::AnnexBReader;
use h264_reader::nal::sps::SeqParameterSet;
use h264_reader::nal::{Nal, RefNal, UnitType};
use h264_reader::push::NalInterest;
use std::io::Read;
use thiserror::Error;

/// What stands before each NAL unit.
pub const START_CODE: [u8; 4] = [0, 0, 0, 1];
/// A picture with longer sides is not believed, in pixels: the largest that level 6.2 knows.
const LONGEST_SIDE_PX: u32 = 16_880;

/// Why bytes are no picture.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum H264Error {
    /// There is nothing.
    #[error("an empty picture")]
    Empty,
    /// No NAL unit of a picture is in it.
    #[error("no slice of a picture is in it")]
    NoSlice,
    /// A sequence parameter set cannot be read.
    #[error("its parameter set cannot be read: {0}")]
    BadParameterSet(String),
}

/// What a sequence parameter set tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamFormat {
    /// `profile_idc`: 66 baseline, 77 main, 100 high.
    pub profile_idc: u8,
    /// The byte of constraint flags.
    pub constraints: u8,
    /// `level_idc`: ten times the level.
    pub level_idc: u8,
    /// Width in pixels after cropping.
    pub width_px: u32,
    /// Height in pixels after cropping.
    pub height_px: u32,
}

impl StreamFormat {
    /// The codec's name after RFC 6381, as browsers want it.
    #[must_use]
    pub fn codec(&self) -> String {
        format!(
            "avc1.{:02x}{:02x}{:02x}",
            self.profile_idc, self.constraints, self.level_idc
        )
    }
}

/// What was found in an access unit.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Contents {
    /// It has an IDR picture: nothing before it is needed to decode what follows.
    pub idr: bool,
    /// It has a slice of any picture.
    pub slices: bool,
    /// Its sequence parameter set.
    pub format: Option<StreamFormat>,
    /// Its parameter sets, as they stand in a byte stream; empty if it has none.
    pub parameter_sets: Vec<u8>,
}

/// Looks into an access unit in Annex B's byte stream.
///
/// # Errors
///
/// It is empty, has no slice, or a parameter set that cannot be read.
pub fn contents(bytes: &[u8]) -> Result<Contents, H264Error> {
    if bytes.is_empty() {
        return Err(H264Error::Empty);
    }
    let mut found = Contents::default();
    let mut fault = None;
    let mut reader = AnnexBReader::accumulate(|nal: RefNal<'_>| {
        if !nal.is_complete() {
            return NalInterest::Buffer;
        }
        let Ok(kind) = nal.header().map(|header| header.nal_unit_type()) else {
            return NalInterest::Ignore;
        };
        match kind {
            UnitType::SliceLayerWithoutPartitioningIdr => (found.idr, found.slices) = (true, true),
            UnitType::SliceLayerWithoutPartitioningNonIdr | UnitType::SliceDataPartitionALayer => found.slices = true,
            UnitType::SeqParameterSet => match format(&nal) {
                Ok(format) => {
                    found.format = Some(format);
                    keep(&nal, &mut found.parameter_sets);
                }
                Err(error) => fault = Some(error),
            },
            UnitType::PicParameterSet => keep(&nal, &mut found.parameter_sets),
            _ => {}
        }
        NalInterest::Ignore
    });
    reader.push(bytes);
    reader.reset();
    match fault {
        Some(fault) => Err(fault),
        None if !found.slices => Err(H264Error::NoSlice),
        None => Ok(found),
    }
}

fn keep(nal: &RefNal<'_>, into: &mut Vec<u8>) {
    into.extend(START_CODE);
    append(nal, into);
}

fn append(nal: &RefNal<'_>, into: &mut Vec<u8>) {
    // Reading from memory does not fail.
    let _ = nal.reader().read_to_end(into);
}

/// What a NAL unit is, as far as a file asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitKind {
    /// A sequence parameter set.
    SequenceParameterSet,
    /// A picture parameter set.
    PictureParameterSet,
    /// Anything else.
    Other,
}

/// A NAL unit without its start code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unit {
    /// What it is.
    pub kind: UnitKind,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// The NAL units of an access unit.
#[must_use]
pub fn units(bytes: &[u8]) -> Vec<Unit> {
    let mut units = Vec::new();
    let mut reader = AnnexBReader::accumulate(|nal: RefNal<'_>| {
        if nal.is_complete() {
            let kind = match nal.header().map(|header| header.nal_unit_type()) {
                Ok(UnitType::SeqParameterSet) => UnitKind::SequenceParameterSet,
                Ok(UnitType::PicParameterSet) => UnitKind::PictureParameterSet,
                _ => UnitKind::Other,
            };
            let mut unit = Unit {
                kind,
                bytes: Vec::new(),
            };
            append(&nal, &mut unit.bytes);
            units.push(unit);
        }
        NalInterest::Buffer
    });
    reader.push(bytes);
    reader.reset();
    units
}

/// The access unit as files have it: the length of each NAL unit before it in four bytes, without parameter sets.
#[must_use]
pub fn length_prefixed(bytes: &[u8]) -> Vec<u8> {
    let mut sample = Vec::with_capacity(bytes.len());
    for unit in units(bytes).into_iter().filter(|unit| unit.kind == UnitKind::Other) {
        sample.extend(u32::try_from(unit.bytes.len()).unwrap_or(u32::MAX).to_be_bytes());
        sample.extend(unit.bytes);
    }
    sample
}

fn format(nal: &RefNal<'_>) -> Result<StreamFormat, H264Error> {
    let bad = |reason: String| H264Error::BadParameterSet(reason);
    let set = SeqParameterSet::from_bits(nal.rbsp_bits()).map_err(|error| bad(format!("{error:?}")))?;
    let (width_px, height_px) = set.pixel_dimensions().map_err(|error| bad(format!("{error:?}")))?;
    let sides = 1..=LONGEST_SIDE_PX;
    if !sides.contains(&width_px) || !sides.contains(&height_px) {
        return Err(bad(format!("{width_px} x {height_px} pixels")));
    }
    Ok(StreamFormat {
        profile_idc: set.profile_idc.into(),
        constraints: set.constraint_flags.into(),
        level_idc: set.level_idc,
        width_px,
        height_px,
    })
}

#[cfg(test)]
mod tests;
