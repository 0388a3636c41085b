//! One viewer over WebRTC.

use super::Hub;
use skein_state::video::Viewer;
use skein_video::h264;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Instant;
use str0m::change::SdpOffer;
use str0m::format::{Codec, PayloadParams};
use str0m::media::{MediaTime, Mid, Pt};
use str0m::net::{Protocol, Receive};
use str0m::{Candidate, Event, IceConnectionState, Input, Output, Rtc, RtcError};
use tokio::sync::mpsc;

/// A datagram that arrived.
#[derive(Debug, Clone)]
pub(super) struct Packet {
    pub(super) from: SocketAddr,
    pub(super) bytes: Arc<[u8]>,
}

/// A session that was answered.
pub(crate) struct Session {
    rtc: Rtc,
    viewer: Viewer,
    /// Under which address it is reached.
    local: SocketAddr,
    media: Option<Mid>,
    /// What was negotiated for the stream's profile.
    payload_type: Option<Pt>,
    connected: bool,
}

/// It has ended.
struct Ended;

impl Session {
    /// Answers an offer.
    pub(crate) fn answer(
        hub: &Hub,
        local: SocketAddr,
        offer: SdpOffer,
        viewer: Viewer,
    ) -> Result<(Self, String), String> {
        let local = SocketAddr::new(local.ip().to_canonical(), hub.port);
        let mut rtc = Rtc::builder()
            .set_ice_lite(true)
            .clear_codecs()
            .enable_h264(true)
            .build(Instant::now());
        let candidate = Candidate::host(local, "udp").map_err(|error| error.to_string())?;
        rtc.add_local_candidate(candidate);
        let answer = rtc.sdp_api().accept_offer(offer).map_err(|error| error.to_string())?;
        let answer = answer.to_sdp_string();
        let session = Self {
            rtc,
            viewer,
            local,
            media: None,
            payload_type: None,
            connected: false,
        };
        Ok((session, answer))
    }

    /// Runs until the viewer is gone, or nobody holds the other end of `packets`.
    pub(super) async fn run(mut self, hub: &Hub, id: &str, mut packets: mpsc::Receiver<Packet>) {
        while let Ok(until) = self.drain(hub).await {
            let input = tokio::select! {
                packet = packets.recv() => match packet {
                    Some(packet) => self.hear(hub, id, &packet),
                    None => {
                        self.rtc.disconnect();
                        return;
                    }
                },
                given = self.viewer.next(), if self.connected => self.write(&given.frame),
                () = tokio::time::sleep_until(until.into()) => self.rtc.handle_input(Input::Timeout(Instant::now())),
            };
            if let Err(error) = input {
                tracing::debug!("a session of WebRTC has ended: {error}");
                return;
            }
        }
    }

    /// Sends what is to be sent; until when nothing more is to be done.
    async fn drain(&mut self, hub: &Hub) -> Result<Instant, Ended> {
        loop {
            match self.rtc.poll_output().map_err(|_| Ended)? {
                Output::Timeout(until) => return if self.rtc.is_alive() { Ok(until) } else { Err(Ended) },
                Output::Transmit(datagram) => {
                    let to = hub.as_sent(datagram.destination);
                    // What the system does not take is lost, as on the way.
                    let _ = hub.socket.send_to(&datagram.contents, to).await;
                }
                Output::Event(event) => self.note(&event)?,
            }
        }
    }

    fn note(&mut self, event: &Event) -> Result<(), Ended> {
        match event {
            Event::Connected => self.connected = true,
            Event::MediaAdded(added) => self.media = Some(added.mid),
            Event::KeyframeRequest(_) => self.viewer.ask_for_key(),
            Event::IceConnectionStateChange(IceConnectionState::Disconnected) => return Err(Ended),
            _ => {}
        }
        Ok(())
    }

    fn hear(&mut self, hub: &Hub, id: &str, packet: &Packet) -> Result<(), RtcError> {
        let from = SocketAddr::new(packet.from.ip().to_canonical(), packet.from.port());
        // What is none of WebRTC is nobody's.
        let Ok(received) = Receive::new(Protocol::Udp, from, self.local, &packet.bytes) else {
            return Ok(());
        };
        let input = Input::Receive(Instant::now(), received);
        if !self.rtc.accepts(&input) {
            return Ok(());
        }
        hub.learn(packet.from, id);
        self.rtc.handle_input(input)
    }

    fn write(&mut self, frame: &skein_video::EncodedFrame) -> Result<(), RtcError> {
        let Some(media) = self.media else { return Ok(()) };
        let Some(writer) = self.rtc.writer(media) else {
            return Ok(());
        };
        if frame.key || self.payload_type.is_none() {
            self.payload_type = payload_type(writer.payload_params(), &frame.bytes);
        }
        let Some(payload_type) = self.payload_type else {
            return Ok(());
        };
        let time = MediaTime::from_micros(frame.taken.0);
        writer.write(payload_type, Instant::now(), time, frame.bytes.clone())
    }
}

/// What was negotiated for the profile of these bytes; else anything, since decoders take more than they say.
fn payload_type<'p>(negotiated: impl Iterator<Item = &'p PayloadParams>, bytes: &[u8]) -> Option<Pt> {
    let format = h264::contents(bytes).ok().and_then(|contents| contents.format);
    let h264: Vec<&PayloadParams> = negotiated
        .filter(|params| params.spec().codec == Codec::H264)
        .filter(|params| params.spec().format.packetization_mode == Some(1))
        .collect();
    let profile_of = |params: &&&PayloadParams| params.spec().format.profile_level_id.map(|id| id >> 16);
    let same = |params: &&&PayloadParams| profile_of(params) == format.map(|format| u32::from(format.profile_idc));
    let chosen = h264.iter().find(same).or(h264.first());
    chosen.map(|params| params.pt())
}

impl Hub {
    /// An address as this socket takes it: one that speaks IPv6 wants those of IPv4 mapped.
    fn as_sent(&self, to: SocketAddr) -> SocketAddr {
        let is_v6 = self.socket.local_addr().is_ok_and(|own| own.is_ipv6());
        match to.ip() {
            IpAddr::V4(address) if is_v6 => SocketAddr::new(address.to_ipv6_mapped().into(), to.port()),
            _ => to,
        }
    }
}
