//! Video as RTP at a named address: what arrives there is put together, decoded, and its clock is read.

use super::*;
use skein_config::{RtpQuality, RtpSettings};
use str0m::format::CodecExtra;
use str0m::unversioned::{Depacketizer, H264Depacketizer};
use tokio::net::UdpSocket;

/// What stands at the address.
pub(super) struct Receiver {
    socket: UdpSocket,
    depacketizer: H264Depacketizer,
    decoder: H264Decoder,
    last: Option<u16>,
}

impl Receiver {
    pub(super) async fn at(address: &str) -> Self {
        Self {
            socket: UdpSocket::bind(address).await.unwrap(),
            depacketizer: H264Depacketizer::default(),
            decoder: H264Decoder::new().unwrap(),
            last: None,
        }
    }

    pub(super) fn address(&self) -> SocketAddr {
        self.socket.local_addr().unwrap()
    }

    /// The next access unit and its time stamp, from its first packet to that with the marker; none if packets before it were lost, as they are when
    /// this test is slow.
    async fn access_unit(&mut self) -> Option<(u32, Vec<u8>)> {
        let (mut buffer, mut bytes, mut stamps, mut whole) = ([0; 2048], Vec::new(), Vec::new(), true);
        loop {
            let received = tokio::time::timeout(patience(), self.socket.recv(&mut buffer)).await;
            let packet = &buffer[..received.expect("a packet comes").unwrap()];
            assert!(
                packet.len() <= 1400 && packet[0] == 0x80 && packet[1] & 0x7f == 96,
                "{packet:?}"
            );
            let sequence = u16::from_be_bytes([packet[2], packet[3]]);
            let last = self.last.replace(sequence);
            whole &= last.is_none_or(|last| sequence == last.wrapping_add(1));
            stamps.push(u32::from_be_bytes(packet[4..8].try_into().unwrap()));
            self.depacketizer
                .depacketize(&packet[12..], &mut bytes, &mut CodecExtra::None)
                .unwrap();
            if packet[1] & 0x80 != 0 {
                assert!(!whole || stamps.iter().all(|stamp| *stamp == stamps[0]), "{stamps:?}");
                return whole.then_some((stamps[0], bytes));
            }
        }
    }

    /// The next picture: its time stamp, its size, and the clock in it.
    pub(super) async fn picture(&mut self) -> (u32, (u32, u32), Option<u32>) {
        loop {
            let Some((stamp, bytes)) = self.access_unit().await else {
                // What follows refers to what was lost, until the next key picture.
                self.decoder = H264Decoder::new().unwrap();
                continue;
            };
            if let Ok(Some(planes)) = self.decoder.decode(&bytes) {
                return (stamp, planes.size_px(), clock_ms(&jpeg(&planes, 90).unwrap()));
            }
        }
    }
}

pub(super) fn to(address: SocketAddr, camera: &str, quality: RtpQuality) -> RtpSettings {
    RtpSettings {
        vehicle: 1,
        camera: camera.into(),
        to: address,
        quality,
    }
}

fn told(swarm: &Swarm, address: SocketAddr) -> Vec<String> {
    let events = swarm.node().events_after(0);
    let about = format!("as RTP to {address}");
    let texts = events.iter().map(|event| event.text.clone());
    texts.filter(|text| text.contains(&about)).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_player_at_a_named_address_gets_pictures_goes_and_comes_back() {
    let mut main = Receiver::at("127.0.0.1:0").await;
    let mut small = Receiver::at("127.0.0.1:0").await;
    let (address, nowhere) = (main.address(), Receiver::at("127.0.0.1:0").await.address());
    let rtp = vec![
        to(address, "camera", RtpQuality::Main),
        to(small.address(), "camera", RtpQuality::Sub),
        to(nowhere, "laser", RtpQuality::Main),
    ];
    let swarm = with_camera_and(Isolation::InProcess, |config| config.video.rtp = rtp).await;
    let mut stamps = Vec::new();
    for _ in 0..20 {
        let (stamp, size_px, shown_ms) = main.picture().await;
        assert_eq!(size_px, (480, 360));
        assert_eq!(
            shown_ms,
            Some(stamp / 90),
            "the time stamp is when the picture was taken"
        );
        stamps.push(stamp);
    }
    assert!(stamps.is_sorted() && stamps[0] < stamps[19], "{stamps:?}");
    let (stamp, size_px, shown_ms) = small.picture().await;
    assert_eq!((size_px, shown_ms), ((320, 240), Some(stamp / 90)));

    // nobody receives any more: nothing is encoded for nobody, and it is told once
    drop((main, small));
    eventually(patience(), "nobody looks", async || {
        (stream_of(&swarm).await["viewers"] == 0).then_some(())
    })
    .await;
    let mut main = Receiver::at(&address.to_string()).await;
    let (first, ..) = main.picture().await;
    assert!(first > stamps[19], "it goes on with a new key picture");
    assert_eq!(told(&swarm, address).len(), 1, "{:?}", told(&swarm, address));
    let missing = eventually(patience(), "the camera that is none is told of", async || {
        told(&swarm, nowhere).first().cloned()
    })
    .await;
    assert!(missing.contains("waits for the camera"), "{missing}");
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_camera_of_another_node_is_sent_from_the_ground_station() {
    // The port is known to a function without surroundings by the ground station's configuration alone.
    static PLAYER: std::sync::OnceLock<SocketAddr> = std::sync::OnceLock::new();
    let mut receiver = Receiver::at("127.0.0.1:0").await;
    PLAYER.set(receiver.address()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let flock = with_camera_elsewhere_and(folder.path(), |config| {
        config.adopt.iter_mut().for_each(|rule| rule.payloads = vec![camera()]);
        if config.swarm.node == Some(9) {
            config.video.rtp = vec![to(*PLAYER.get().unwrap(), "camera", RtpQuality::Main)];
        }
    })
    .await;
    for _ in 0..10 {
        let (_, size_px, shown_ms) = receiver.picture().await;
        assert_eq!(size_px, (480, 360));
        assert!(shown_ms.is_some());
    }
    flock.stop().await;
}
