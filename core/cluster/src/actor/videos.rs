//! Videos of other nodes that are looked at here: which number stands for which, and where their pictures go.

use super::SwarmState;
use minicbor::{Decode, Encode};
use skein_bus::video::{Pushed, VideoPicture};
use skein_domain::{NodeId, NodeTime};
use skein_state::video::{Quality, RemoteStream, Rendition};
use skein_video::{Coding, EncodedFrame};
use std::collections::BTreeMap;

/// What goes before the bytes of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
struct Head {
    /// When it was taken, in microseconds of the sender's clock.
    #[n(0)]
    taken_us: u64,
    /// Number in its stream.
    #[n(1)]
    sequence: u64,
    /// Width in pixels.
    #[n(2)]
    width_px: u32,
    /// Height in pixels.
    #[n(3)]
    height_px: u32,
}

/// The streams that are looked at here.
#[derive(Debug, Default)]
pub(super) struct Videos {
    last: u32,
    streams: BTreeMap<(NodeId, u32), RemoteStream>,
}

/// A picture as it goes over the bus.
#[must_use]
pub fn packed(frame: &EncodedFrame) -> Vec<u8> {
    let head = Head {
        taken_us: frame.taken.0,
        sequence: frame.sequence,
        width_px: frame.width_px,
        height_px: frame.height_px,
    };
    // Writing into memory does not fail.
    let mut body = minicbor::to_vec(head).unwrap_or_default();
    body.extend_from_slice(&frame.bytes);
    body
}

fn unpacked(picture: &VideoPicture) -> Option<EncodedFrame> {
    let mut decoder = minicbor::Decoder::new(&picture.body);
    let head: Head = decoder.decode().ok()?;
    let bytes = picture.body.get(decoder.position()..)?;
    Some(EncodedFrame {
        coding: Coding::H264,
        sequence: head.sequence,
        taken: NodeTime(head.taken_us),
        width_px: head.width_px,
        height_px: head.height_px,
        key: picture.key,
        bytes: bytes.into(),
    })
}

impl SwarmState {
    /// A stream of another node is to come here. Gives its number.
    pub(super) fn expect_video(&mut self, from: NodeId, stream: RemoteStream) -> u32 {
        self.videos.last = self.videos.last.wrapping_add(1);
        let number = self.videos.last;
        self.bus.expect_video(from, number);
        self.videos.streams.insert((from, number), stream);
        number
    }

    /// It is not looked at any more.
    pub(super) fn forget_video(&mut self, from: NodeId, number: u32) {
        self.bus.forget_video(from, number);
        self.videos.streams.remove(&(from, number));
    }

    /// A picture has come.
    pub(super) fn show_video(&mut self, now: NodeTime, from: NodeId, picture: &VideoPicture) {
        let ahead_us = self.ahead_us(from).unwrap_or_default();
        let Some(remote) = self.videos.streams.get(&(from, picture.stream)) else {
            return;
        };
        let Some(mut frame) = unpacked(picture) else { return };
        frame.taken = frame.taken.on_clock_ahead_by(ahead_us).min(now);
        let counted = remote.rendition.quality == Quality::Main || !remote.video.is_watched(Rendition::OF_CAMERA);
        remote.video.take_remote(now, &frame, counted);
        remote.stream.push(frame);
    }

    /// Sends a picture to a node that wants it.
    pub(super) fn send_video(&mut self, now: NodeTime, to: NodeId, number: u32, frame: &EncodedFrame) -> bool {
        let body = packed(frame);
        self.bus.send_video(now, to, number, frame.key, &body) == Pushed::Taken
    }
}

#[cfg(test)]
mod tests;
