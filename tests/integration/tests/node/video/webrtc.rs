//! The other end of WebRTC, as a browser has it: it offers to receive video and hands over the pictures.

use skein_testkit::patience;
use std::net::SocketAddr;
use std::time::Instant;
use str0m::change::{SdpAnswer, SdpPendingOffer};
use str0m::media::{Direction, MediaKind};
use str0m::net::{Protocol, Receive};
use str0m::{Candidate, Event, Input, Output, Rtc};
use tokio::net::UdpSocket;

pub(super) struct Peer {
    rtc: Rtc,
    socket: UdpSocket,
    local: SocketAddr,
    offer: String,
    pending: Option<SdpPendingOffer>,
}

impl Peer {
    pub(super) async fn new() -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let local = socket.local_addr().unwrap();
        let mut rtc = Rtc::builder().clear_codecs().enable_h264(true).build(Instant::now());
        rtc.add_local_candidate(Candidate::host(local, "udp").unwrap());
        let mut changes = rtc.sdp_api();
        changes.add_media(MediaKind::Video, Direction::RecvOnly, None, None, None);
        let (offer, pending) = changes.apply().unwrap();
        Self {
            rtc,
            socket,
            local,
            offer: offer.to_sdp_string(),
            pending: Some(pending),
        }
    }

    pub(super) fn offer(&self) -> String {
        self.offer.clone()
    }

    pub(super) fn accept(&mut self, answer: &str) {
        let answer = SdpAnswer::from_sdp_string(answer).unwrap();
        let pending = self.pending.take().unwrap();
        self.rtc.sdp_api().accept_answer(pending, answer).unwrap();
    }

    /// The next picture.
    pub(super) async fn picture(&mut self) -> Vec<u8> {
        let next = tokio::time::timeout(patience(), self.next()).await;
        next.expect("a picture over WebRTC")
    }

    async fn next(&mut self) -> Vec<u8> {
        let mut buffer = vec![0; 2000];
        loop {
            let until = match self.rtc.poll_output().unwrap() {
                Output::Timeout(until) => until,
                Output::Transmit(datagram) => {
                    self.socket
                        .send_to(&datagram.contents, datagram.destination)
                        .await
                        .unwrap();
                    continue;
                }
                Output::Event(Event::MediaData(data)) => return data.data.to_vec(),
                Output::Event(_) => continue,
            };
            let arrived = tokio::time::timeout_at(until.into(), self.socket.recv_from(&mut buffer)).await;
            let input = match arrived {
                Ok(received) => {
                    let (len, from) = received.unwrap();
                    let received = Receive::new(Protocol::Udp, from, self.local, &buffer[..len]).unwrap();
                    Input::Receive(Instant::now(), received)
                }
                Err(_) => Input::Timeout(Instant::now()),
            };
            self.rtc.handle_input(input).unwrap();
        }
    }
}
