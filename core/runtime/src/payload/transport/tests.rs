//! Lines to devices, over real sockets.

use super::*;

#[test]
fn addresses_are_read_and_others_are_told_what_would_be_right() {
    assert_eq!(
        "udp://192.168.144.25:37260".parse(),
        Ok(TransportAddress::Udp(([192, 168, 144, 25], 37260).into()))
    );
    let serial = "serial:///dev/ttyUSB0?baud=115200".parse::<TransportAddress>().unwrap();
    assert!(
        matches!(serial, TransportAddress::Serial { baud: 115_200, .. }),
        "{serial:?}"
    );
    for wrong in ["", "tcp://127.0.0.1:1", "udp://nowhere", "udp-listen://127.0.0.1:5"] {
        assert!(wrong.parse::<TransportAddress>().is_err(), "{wrong}");
    }
}

#[tokio::test]
async fn a_device_is_heard_and_answered_and_strangers_are_not() {
    let device = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let stranger = UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let transport = Transport::open(TransportAddress::Udp(device.local_addr().unwrap()));
    assert!(transport.send(b"hello".to_vec()));
    let mut buffer = [0; 64];
    let (len, ours) = device.recv_from(&mut buffer).await.unwrap();
    assert_eq!(&buffer[..len], b"hello");
    stranger.send_to(b"not me", ours).await.unwrap();
    device.send_to(b"attitude", ours).await.unwrap();
    let mut heard = Vec::new();
    while heard.is_empty() {
        tokio::task::yield_now().await;
        heard = transport.drain();
    }
    assert_eq!(heard, vec![b"attitude".to_vec()]);
    assert_eq!(transport.fault(), "");
}

#[tokio::test(start_paused = true)]
async fn a_line_that_is_not_there_is_told_and_tried_again() {
    let transport = Transport::open(TransportAddress::Serial {
        path: "/dev/no-such-line".into(),
        baud: 9_600,
    });
    while transport.fault().is_empty() {
        tokio::task::yield_now().await;
    }
    assert!(transport.fault().contains("/dev/no-such-line"), "{}", transport.fault());
}
