//! Zenoh over loopback passes the suite of every transport, in real time: over TCP, UDP, and over TLS and QUIC with certificates.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, IsCa, KeyPair};
use skein_bus::conformance::{self, Rig};
use skein_bus::transport::{Class, To, Transport};
use skein_bus_zenoh::{OpenError, Zenoh, ZenohSettings};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use std::net::{TcpListener, UdpSocket};
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

/// A meeting point on this host: whoever is first listens there, the others connect to it and find each other by its gossip.
struct Loopback {
    begun: Instant,
    swarm: String,
    protocol: &'static str,
    extra: BTreeMap<String, String>,
    /// Of each node that was there, in its order.
    endpoints: Vec<(NodeId, String)>,
}

impl Loopback {
    fn new(protocol: &'static str) -> Self {
        Self {
            begun: Instant::now(),
            swarm: format!("test-{}", free_port()),
            protocol,
            extra: BTreeMap::new(),
            endpoints: Vec::new(),
        }
    }
}

/// One that is free, for TCP and UDP: Zenoh does not tell which one it took if it is asked for any. None is given twice, and none that the system gives
/// to whoever connects.
fn free_port() -> u16 {
    static GIVEN: AtomicU16 = AtomicU16::new(0);
    loop {
        let offset = std::process::id() % 100 * 100 + u32::from(GIVEN.fetch_add(1, Ordering::Relaxed));
        let port = 20_000 + u16::try_from(offset % 10_000).unwrap();
        if TcpListener::bind(("127.0.0.1", port)).is_ok() && UdpSocket::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}

impl Rig for Loopback {
    type Transport = Zenoh;

    fn join(&mut self, node: NodeId) -> Zenoh {
        // A node that starts again does so at a port of its own: its former one may still be held by the system.
        let listen = format!("{}/127.0.0.1:{}", self.protocol, free_port());
        self.endpoints.retain(|(known, _)| *known != node);
        let settings = ZenohSettings {
            listen: vec![listen.clone()],
            connect: self.endpoints.iter().map(|(_, endpoint)| endpoint.clone()).collect(),
            extra: self.extra.clone(),
            ..ZenohSettings::default()
        };
        self.endpoints.push((node, listen));
        Zenoh::open(&self.swarm, node, &settings).unwrap()
    }

    fn step(&mut self) -> NodeTime {
        // Zenoh lives in real time: a step is a short wait in it. Scenes wait for what they want to see, not for a time.
        std::thread::sleep(Duration::from_millis(5));
        NodeTime::from_seconds(self.begun.elapsed().as_secs_f64())
    }
}

#[test]
fn the_suite_is_passed_over_tcp() {
    conformance::all_at_once(|| Loopback::new("tcp"));
}

#[test]
fn the_suite_is_passed_over_udp() {
    conformance::all_at_once(|| Loopback::new("udp"));
}

/// An authority and one certificate of it for this host, in files.
struct Certificates {
    folder: tempfile::TempDir,
}

impl Certificates {
    fn new() -> Self {
        let mut authority = CertificateParams::new(Vec::new()).unwrap();
        authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let authority = CertifiedIssuer::self_signed(authority, KeyPair::generate().unwrap()).unwrap();
        let key = KeyPair::generate().unwrap();
        let names = vec!["127.0.0.1".to_owned(), "localhost".to_owned()];
        let node = CertificateParams::new(names)
            .unwrap()
            .signed_by(&key, &authority)
            .unwrap();
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
        write("authority.pem", authority.pem());
        write("node.pem", node.pem());
        write("key.pem", key.serialize_pem());
        Self { folder }
    }

    /// Both sides show certificates of this authority, and ask for them.
    fn settings(&self) -> BTreeMap<String, String> {
        let file = |name: &str| format!("{:?}", self.folder.path().join(name).display().to_string());
        let pairs = [
            ("root_ca_certificate", file("authority.pem")),
            ("listen_certificate", file("node.pem")),
            ("listen_private_key", file("key.pem")),
            ("connect_certificate", file("node.pem")),
            ("connect_private_key", file("key.pem")),
            ("enable_mtls", "true".to_owned()),
        ];
        let keyed = pairs.map(|(key, value)| (format!("transport/link/tls/{key}"), value));
        keyed.into_iter().collect()
    }
}

fn passed_with_certificates_over(protocol: &'static str) {
    let certificates = Certificates::new();
    conformance::all_at_once(|| Loopback {
        extra: certificates.settings(),
        ..Loopback::new(protocol)
    });
}

#[test]
#[ignore = "long: part of `cargo xtask test wire`"]
fn the_suite_is_passed_over_tls_with_certificates() {
    passed_with_certificates_over("tls");
}

#[test]
#[ignore = "long: part of `cargo xtask test wire`"]
fn the_suite_is_passed_over_quic_with_certificates() {
    passed_with_certificates_over("quic");
}

#[test]
#[ignore = "long: part of `cargo xtask test wire`"]
fn who_has_a_certificate_of_another_authority_is_not_let_in() {
    let (ours, theirs) = (Certificates::new(), Certificates::new());
    let mut rig = Loopback {
        extra: ours.settings(),
        ..Loopback::new("tls")
    };
    let mut a = rig.join(NodeId(1));
    let mut b = rig.join(NodeId(2));
    rig.extra = theirs.settings();
    let mut stranger = rig.join(NodeId(3));
    let mut got = 0;
    for _ in 0..2000 {
        let now = rig.step();
        for node in [&mut a, &mut stranger] {
            node.send(now, To::All, Class::State, b"here").unwrap();
        }
        let at_b = b.receive(now);
        assert!(at_b.as_ref().is_none_or(|datagram| datagram.from == NodeId(1)));
        got += usize::from(at_b.is_some());
        assert_eq!(stranger.receive(now), None);
        if got > 200 {
            return;
        }
    }
    panic!("only {got} arrived");
}

#[test]
fn a_swarm_does_not_hear_another_one_at_the_same_place() {
    let mut rig = Loopback::new("tcp");
    let mut a = rig.join(NodeId(1));
    let mut b = rig.join(NodeId(2));
    rig.swarm = "another".to_owned();
    let mut other = rig.join(NodeId(3));
    let mut got = 0;
    for _ in 0..2000 {
        let now = rig.step();
        a.send(now, To::All, Class::State, b"here").unwrap();
        got += usize::from(b.receive(now).is_some());
        assert_eq!(other.receive(now), None);
        if got > 50 {
            return;
        }
    }
    panic!("only {got} arrived");
}

#[test]
fn what_zenoh_does_not_know_is_said_before_anything_starts() {
    let mut settings = ZenohSettings::default();
    settings.extra.insert("no/such/key".to_owned(), "1".to_owned());
    let refused = Zenoh::open("swarm", NodeId(1), &settings).unwrap_err();
    assert!(
        matches!(refused, OpenError::Setting { ref key, .. } if key == "no/such/key"),
        "{refused}"
    );
    let refused = Zenoh::open("a/b", NodeId(1), &ZenohSettings::default()).unwrap_err();
    assert_eq!(refused, OpenError::SwarmId("a/b".to_owned()));
}
