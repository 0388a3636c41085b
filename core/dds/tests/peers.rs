//! Participants in processes of their own find each other on loopback, which carries no multicast.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use rustdds::policy::{History, Reliability};
use rustdds::{QosPolicyBuilder, RTPSEntity, TopicKind};
use skein_dds::{DdsSettings, Peer};
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read};
use std::net::{Ipv4Addr, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

/// Twenty of them take a second or two.
const PATIENCE: Duration = Duration::from_secs(90);
/// Participants say so often who they are.
const SAID_EVERY: Duration = Duration::from_millis(200);
/// As ROS 2 calls the topic `/numbers` of `std_msgs/UInt32`, so that it can be looked at with its tools.
const TOPIC: &str = "rt/numbers";
const TYPE: &str = "std_msgs::msg::dds_::UInt32_";
/// What a process of this test is to do, for the test below that is no test.
const ROLE: &str = "SKEIN_DDS_TEST_ROLE";

/// A participant says its number to everybody, and writes down whose it hears, until its input ends.
#[test]
#[ignore = "is started by the tests as a process of its own"]
fn a_participant() {
    let role = std::env::var(ROLE).unwrap();
    let [domain, number, interface, peers] = role.split(' ').collect::<Vec<_>>().try_into().unwrap();
    let number: u32 = number.parse().unwrap();
    let peer = |address: &str| {
        let (address, port) = address.split_once(':').unwrap_or((address, ""));
        Peer {
            address: address.parse().unwrap(),
            port: port.parse().ok(),
        }
    };
    let settings = DdsSettings {
        domain_id: domain.parse().unwrap(),
        interfaces: vec![interface.parse().unwrap()],
        peers: peers.split(',').filter(|peer| !peer.is_empty()).map(peer).collect(),
    };
    let participant = skein_dds::join(&settings).unwrap();
    let quality = QosPolicyBuilder::new()
        .reliability(Reliability::BestEffort)
        .history(History::KeepLast { depth: 64 })
        .build();
    let topic = participant.create_topic(TOPIC.into(), TYPE.into(), &quality, TopicKind::NoKey);
    let topic = topic.unwrap();
    let (publisher, subscriber) = (
        participant.create_publisher(&quality).unwrap(),
        participant.create_subscriber(&quality).unwrap(),
    );
    let writer = publisher.create_datawriter_no_key_cdr::<u32>(&topic, None).unwrap();
    let mut reader = subscriber.create_datareader_no_key_cdr::<u32>(&topic, None).unwrap();
    println!("\n{number} met {number}");
    let (open, ended) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        drop(open);
    });
    let mut met = BTreeSet::new();
    while ended.recv_timeout(SAID_EVERY) == Err(RecvTimeoutError::Timeout) {
        writer.write(number, None).unwrap();
        while let Ok(Some(sample)) = reader.take_next_sample() {
            let other = *sample.value();
            if other != number && met.insert(other) {
                println!("\n{number} met {other}");
            }
        }
    }
}

/// Processes with a participant each. They end with this.
struct Participants {
    running: Vec<Child>,
    say: Sender<(u32, u32)>,
    said: Receiver<(u32, u32)>,
    met: BTreeSet<(u32, u32)>,
}

impl Participants {
    fn none() -> Self {
        let (say, said) = mpsc::channel();
        Self {
            running: Vec::new(),
            say,
            said,
            met: BTreeSet::new(),
        }
    }

    /// Starts one that tells these peers.
    fn start(&mut self, domain: u16, number: u32, peers: &str) {
        let mut process = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "a_participant", "--ignored", "--nocapture"])
            .env(ROLE, format!("{domain} {number} {} {peers}", Ipv4Addr::LOCALHOST))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (lines, say) = (BufReader::new(process.stdout.take().unwrap()), self.say.clone());
        self.running.push(process);
        std::thread::spawn(move || {
            for line in lines.lines().map_while(Result::ok) {
                let met = line.split_once(" met ");
                if let Some((one, other)) = met.and_then(|(one, other)| Some((one.parse().ok()?, other.parse().ok()?)))
                {
                    let _ = say.send((one, other));
                }
            }
        });
    }

    /// Ends one without a word.
    fn kill(&mut self, at: usize) {
        let mut process = self.running.remove(at);
        process.kill().unwrap();
        process.wait().unwrap();
    }

    /// Waits until each of these has heard each other one.
    fn meet(&mut self, numbers: &[u32]) {
        let pairs = numbers
            .iter()
            .flat_map(|one| numbers.iter().map(|other| (*one, *other)));
        self.wait_for(pairs.filter(|(one, other)| one != other).collect());
    }

    /// Waits until all of this has been said: who heard whom; of two equal numbers, that this one is there.
    fn wait_for(&mut self, mut missing: BTreeSet<(u32, u32)>) {
        let began = Instant::now();
        missing.retain(|pair| !self.met.contains(pair));
        while !missing.is_empty() {
            let left = PATIENCE.saturating_sub(began.elapsed());
            let Ok(pair) = self.said.recv_timeout(left) else {
                panic!("{} pairs have not met: {missing:?}", missing.len());
            };
            self.met.insert(pair);
            missing.remove(&pair);
        }
        println!("after {:?}", began.elapsed());
    }
}

impl Drop for Participants {
    fn drop(&mut self) {
        for process in &mut self.running {
            drop(process.stdin.take());
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

#[test]
fn twenty_participants_of_one_host_find_each_other() {
    let mut participants = Participants::none();
    for number in 0..20 {
        participants.start(79, number, "127.0.0.1");
    }
    participants.meet(&(0..20).collect::<Vec<u32>>());
}

#[test]
fn one_that_names_a_port_is_enough_and_who_comes_back_is_found_again() {
    let domain = 76;
    // Nothing is there: only so that it leaves multicast alone.
    let nobody = "127.0.0.1:9";
    let mut participants = Participants::none();
    // RustDDS itself finds the first twelve participants of this host: those are taken.
    let port = |id: u16| 7410 + 250 * domain + 2 * id;
    let taken: Vec<UdpSocket> = (0..12)
        .map(|id| UdpSocket::bind((Ipv4Addr::UNSPECIFIED, port(id))).unwrap())
        .collect();
    participants.start(domain, 0, nobody);
    participants.wait_for(BTreeSet::from([(0, 0)]));
    let first = format!("127.0.0.1:{}", port(12));
    participants.start(domain, 1, &first);
    participants.meet(&[0, 1]);
    participants.kill(1);
    participants.start(domain, 2, &first);
    participants.meet(&[0, 2]);
    drop(taken);
}

#[test]
fn the_announcer_ends_with_its_participant() {
    let settings = DdsSettings {
        domain_id: 75,
        peers: vec![Peer {
            address: Ipv4Addr::LOCALHOST,
            port: None,
        }],
        ..DdsSettings::default()
    };
    let participant = skein_dds::join(&settings).unwrap();
    // It has to have met its participant to be told of the end.
    let far = UdpSocket::bind((Ipv4Addr::LOCALHOST, 7410 + 250 * 75 + 2 * 31)).unwrap();
    far.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut told = [0; 2000];
    let length = far.recv(&mut told).unwrap();
    assert!(told[..length].starts_with(b"RTPS"));
    assert_eq!(told[8..20], participant.guid().to_bytes()[..12]);
    assert_eq!(announcers(), 1);
    drop(participant);
    let began = Instant::now();
    while announcers() > 0 {
        assert!(began.elapsed() < Duration::from_secs(30), "the announcer goes on");
        std::thread::yield_now();
    }
}

/// How many threads of this process are announcers.
fn announcers() -> usize {
    let threads = std::fs::read_dir("/proc/self/task").unwrap().map_while(Result::ok);
    let name = |thread: std::fs::DirEntry| std::fs::read_to_string(thread.path().join("comm"));
    threads
        .filter_map(|thread| name(thread).ok())
        .filter(|name| name.trim() == "dds announcer")
        .count()
}
