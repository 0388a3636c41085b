//! The other end of WebRTC, as a browser has it: it offers to receive video and hands over the pictures.

use crate::patience;
use std::net::{IpAddr, SocketAddr};
use std::time::Instant;
use str0m::change::{SdpAnswer, SdpPendingOffer};
use str0m::media::{Direction, KeyframeRequestKind, MediaData, MediaKind};
use str0m::net::{Protocol, Receive};
use str0m::{Candidate, Event, Input, Output, Rtc};
use tokio::net::UdpSocket;

/// So many packets may come before one that is missing is given up. A browser waits longer: Chromium until the picture has stood for a
/// while, which is not below the way there and back.
const PACKETS_WAITED: usize = 300;

/// A browser's end of one stream.
pub struct Peer {
    rtc: Rtc,
    socket: UdpSocket,
    local: SocketAddr,
    offer: String,
    pending: Option<SdpPendingOffer>,
    /// What came before it is missing: as a browser does, it shows nothing until the next key picture.
    waits: bool,
}

impl Peer {
    /// One on this address of the computer.
    ///
    /// # Panics
    /// If there is no such address.
    pub async fn at(address: IpAddr) -> Self {
        let socket = UdpSocket::bind((address, 0)).await.expect("a socket");
        let local = socket.local_addr().expect("its address");
        let rtc = Rtc::builder().clear_codecs().enable_h264(true);
        let mut rtc = rtc.set_reordering_size_video(PACKETS_WAITED).build(Instant::now());
        let candidate = Candidate::host(local, "udp").expect("an address that others reach");
        rtc.add_local_candidate(candidate);
        let mut changes = rtc.sdp_api();
        changes.add_media(MediaKind::Video, Direction::RecvOnly, None, None, None);
        let (offer, pending) = changes.apply().expect("there is something to offer");
        Self {
            rtc,
            socket,
            local,
            offer: offer.to_sdp_string(),
            pending: Some(pending),
            waits: false,
        }
    }

    /// What it offers, for the body of a request.
    #[must_use]
    pub fn offer(&self) -> String {
        self.offer.clone()
    }

    /// Takes the answer.
    ///
    /// # Panics
    /// If it is no answer to the offer.
    pub fn accept(&mut self, answer: &str) {
        let answer = SdpAnswer::from_sdp_string(answer).expect("an answer");
        let pending = self.pending.take().expect("an answer only once");
        let accepted = self.rtc.sdp_api().accept_answer(pending, answer);
        accepted.expect("an answer to the offer");
    }

    /// The next picture, an access unit of H.264.
    ///
    /// # Panics
    /// If none comes.
    pub async fn picture(&mut self) -> Vec<u8> {
        let next = tokio::time::timeout(patience(), self.next()).await;
        next.expect("a picture over WebRTC")
    }

    async fn next(&mut self) -> Vec<u8> {
        let mut buffer = vec![0; 2000];
        loop {
            let until = match self.rtc.poll_output().expect("the session goes on") {
                Output::Timeout(until) => until,
                Output::Transmit(datagram) => {
                    let sent = self.socket.send_to(&datagram.contents, datagram.destination);
                    sent.await.expect("the network takes it");
                    continue;
                }
                Output::Event(Event::MediaData(data)) => {
                    if self.is_shown(&data) {
                        return data.data.to_vec();
                    }
                    continue;
                }
                Output::Event(_) => continue,
            };
            let arrived = tokio::time::timeout_at(until.into(), self.socket.recv_from(&mut buffer)).await;
            let input = match arrived {
                Ok(received) => {
                    let (len, from) = received.expect("the socket is open");
                    let received = Receive::new(Protocol::Udp, from, self.local, &buffer[..len]);
                    // what is no packet of the session
                    let Ok(received) = received else { continue };
                    Input::Receive(Instant::now(), received)
                }
                Err(_) => Input::Timeout(Instant::now()),
            };
            self.rtc.handle_input(input).expect("the session goes on");
        }
    }

    /// Whether a browser would show this picture; asks for a key picture if not.
    fn is_shown(&mut self, data: &MediaData) -> bool {
        let is_key = |bytes: &[u8]| {
            bytes
                .windows(4)
                .any(|place| place[..3] == [0, 0, 1] && place[3] & 31 == 5)
        };
        self.waits = (self.waits || !data.contiguous) && !is_key(&data.data);
        if self.waits
            && let Some(mut writer) = self.rtc.writer(data.mid)
        {
            // one is on its way already
            let _ = writer.request_keyframe(data.rid, KeyframeRequestKind::Pli);
        }
        !self.waits
    }
}
