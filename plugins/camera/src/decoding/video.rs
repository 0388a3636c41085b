//! A video: H.264 in an MP4 file, again and again, at its own speed.

use super::{DecodeError, Outlet, Picture};
use skein_video::{CodecError, H264Decoder, Mp4Reader, Rgb};
use std::path::Path;

pub(super) fn read(path: &Path, rate_hz: f64, taken: u64, outlet: &Outlet) -> Result<(), DecodeError> {
    let mut video = Mp4Reader::open(path)?;
    let wanted = pick(video.shown_s(), rate_hz);
    let count = u64::try_from(wanted.len()).unwrap_or(u64::MAX).max(1);
    let mut first = usize::try_from(taken % count).unwrap_or(0);
    loop {
        let given = play(&mut video, path, wanted.get(first..).unwrap_or_default(), outlet)?;
        if !outlet.is_wanted() {
            return Ok(());
        }
        if given == 0 {
            return Err(DecodeError::Damaged {
                path: path.to_owned(),
                reason: "no picture can be decoded".to_owned(),
            });
        }
        first = 0;
    }
}

/// Which pictures are given so that there are `rate_hz` for each second of the video: by their place in the order of showing.
fn pick(shown_s: &[f64], rate_hz: f64) -> Vec<usize> {
    let begin_s = shown_s.first().copied().unwrap_or_default();
    let mut next_s = begin_s;
    let mut wanted = Vec::new();
    for (index, time_s) in shown_s.iter().enumerate() {
        if *time_s + 1e-9 >= next_s {
            wanted.push(index);
            let passed = ((time_s - begin_s) * rate_hz + 1e-6).floor() + 1.0;
            next_s = begin_s + passed / rate_hz;
        }
    }
    wanted
}

/// Decodes the file from its beginning and gives the wanted pictures. Returns how many.
fn play(video: &mut Mp4Reader, path: &Path, wanted: &[usize], outlet: &Outlet) -> Result<usize, DecodeError> {
    let failed = |error: CodecError| DecodeError::Damaged {
        path: path.to_owned(),
        reason: error.to_string(),
    };
    let mut decoder = H264Decoder::for_files().map_err(failed)?;
    let mut choice = Choice {
        shown: 0,
        given: 0,
        wanted,
    };
    for index in 0..video.len() {
        if !outlet.is_wanted() || choice.is_over() {
            return Ok(choice.given);
        }
        let raw = video.coded(index)?;
        // A picture that cannot be decoded is passed over: the next whole one sets things right.
        if let Ok(Some(picture)) = decoder.decode_rgb(&raw)
            && !choice.look(picture, outlet)
        {
            return Ok(choice.given);
        }
    }
    for picture in decoder.remaining_rgb() {
        if !choice.look(picture, outlet) {
            break;
        }
    }
    Ok(choice.given)
}

/// Which of the decoded pictures are given.
struct Choice<'a> {
    shown: usize,
    given: usize,
    wanted: &'a [usize],
}

impl Choice<'_> {
    fn is_over(&self) -> bool {
        self.given >= self.wanted.len()
    }

    /// Gives the next decoded picture if it is wanted. False when nobody wants more.
    fn look(&mut self, picture: Rgb, outlet: &Outlet) -> bool {
        let this = self.shown;
        self.shown += 1;
        if self.wanted.get(self.given) != Some(&this) {
            return outlet.is_wanted();
        }
        self.given += 1;
        outlet.give(Ok(Picture {
            width_px: picture.width_px,
            height_px: picture.height_px,
            rgb: picture.rgb,
        }))
    }
}

#[cfg(test)]
mod tests;
