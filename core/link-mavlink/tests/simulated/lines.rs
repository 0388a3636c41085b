//! TCP and serial lines: frames cut anywhere, lines that break and come back.

use crate::net::Net;
use crate::puppet::Puppet;
use skein_domain::link::VehicleLink;
use skein_link_mavlink::EndpointEvent;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio_serial::{SerialPort, SerialStream};

/// Speaks a few frames in pieces, hears the node's heartbeat, and sees the vehicle found.
async fn converse(net: &mut Net, line: &mut (impl AsyncRead + AsyncWrite + Unpin), puppet: &mut Puppet, known: bool) {
    let mut heard = vec![0; 21];
    line.read_exact(&mut heard).await.unwrap();
    assert_eq!((heard[0], heard[5]), (0xFD, 245), "something of ours, whole: {heard:?}");
    let mut bytes = vec![0xFD, 1, 2, 3];
    for _ in 0..20 {
        bytes.extend(puppet.position(3.5));
    }
    bytes.extend(puppet.heartbeat());
    for _ in 0..20 {
        bytes.extend(puppet.position(4.5));
    }
    for piece in bytes.chunks(23) {
        line.write_all(piece).await.unwrap();
        line.flush().await.unwrap();
        tokio::task::yield_now().await;
    }
    let link = if known {
        net.links.link(puppet.system_id).unwrap()
    } else {
        net.discovered(puppet.system_id).await
    };
    let expected_m = 4.5;
    net.until("position", |now| {
        link.read(now).0.local.is_some_and(|local| local.north_m == expected_m)
    })
    .await;
}

#[tokio::test]
async fn a_tcp_line_is_opened_again_when_it_breaks() {
    let mut net = Net::new();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    // Nobody is there yet: not an error of the start, it may come.
    net.try_start("sitl", &format!("tcp://{address}")).await.unwrap();
    let down = net
        .event("down", |event| matches!(event, EndpointEvent::Down { .. }))
        .await;
    let EndpointEvent::Down { reason, .. } = down else {
        panic!()
    };
    assert!(reason.contains(&address.to_string()), "{reason}");
    let listener = TcpListener::bind(address).await.unwrap();
    let mut puppet = Puppet::new(5);
    for known in [false, true] {
        let (mut line, _) = tokio::time::timeout(Duration::from_secs(20), listener.accept())
            .await
            .unwrap()
            .unwrap();
        net.event("bound", |event| matches!(event, EndpointEvent::Bound { .. }))
            .await;
        converse(&mut net, &mut line, &mut puppet, known).await;
        drop(line);
        net.event("down", |event| matches!(event, EndpointEvent::Down { .. }))
            .await;
    }
    assert_eq!(net.links.links().len(), 1);
}

#[tokio::test]
async fn a_serial_line() {
    let mut net = Net::new();
    let (mut ours, theirs) = SerialStream::pair().unwrap();
    let path = theirs.name().unwrap();
    net.try_start("radio", &format!("serial://{path}?baud=57600"))
        .await
        .unwrap();
    net.event("bound", |event| {
        matches!(event, EndpointEvent::Bound { local_addr: None, .. })
    })
    .await;
    converse(&mut net, &mut ours, &mut Puppet::new(6), false).await;
    let counters = net.links.metrics()[0].1.read();
    assert_eq!(
        (counters.bad_crc, counters.dropped_full, counters.dropped_error),
        (0, 0, 0)
    );
}
