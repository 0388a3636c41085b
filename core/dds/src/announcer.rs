//! Tells peers of the node's participant by unicast, where multicast does not pass.
//!
//! RustDDS announces itself over multicast, to the first participants on this host, and to whom it knows. So the announcer is somebody whom it knows: it
//! calls on the participant over loopback, is told from then on what others are told, and repeats that to the peers, word for word.
//! Whoever hears it answers the participant itself.
//!
//! Must never do: say anything that the participant has not said; listen beyond loopback; outlive the participant by more than a moment.

use crate::DdsSettings;
use crate::announcement::{self, Prefix, Said};
use crate::peer::discovery_port;
use crate::rounds::Rounds;
use rustdds::{DomainParticipant, RTPSEntity};
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

/// The participant is called on so often until it answers, and later so that it does not forget.
const CALL_ON: Duration = Duration::from_millis(100);
const CALL_ON_LATER: Duration = Duration::from_secs(10);
/// The participant announces itself every ten seconds and says when it ends; after so long without a word it has ended all the same.
const SILENT: Duration = Duration::from_secs(45);
/// Largest datagram of UDP.
const DATAGRAM_BYTES: usize = 65_536;

/// One participant's announcer.
struct Announcer {
    of: Prefix,
    /// Where the participant hears of others.
    door: SocketAddrV4,
    /// The announcer's own name, and where it is told.
    name: Prefix,
    ear: UdpSocket,
    at: SocketAddrV4,
    mouth: UdpSocket,
    rounds: Rounds,
    words: Option<Vec<u8>>,
    heard: Duration,
    calls: u32,
    next_call: Duration,
}

/// Begins to tell these peers of a participant. It ends with the participant.
///
/// # Errors
/// There is no socket or thread for it.
pub(crate) fn begin(participant: &DomainParticipant, settings: &DdsSettings) -> io::Result<()> {
    let mut announcer = Announcer::new(participant, settings)?;
    let thread = std::thread::Builder::new().name("dds announcer".to_owned());
    thread.spawn(move || announcer.work()).map(drop)
}

impl Announcer {
    fn new(participant: &DomainParticipant, settings: &DdsSettings) -> io::Result<Self> {
        let [of @ .., _, _, _, _] = participant.guid().to_bytes();
        let port = discovery_port(settings.domain_id, participant.participant_id());
        let ear = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        let SocketAddr::V4(at) = ear.local_addr()? else {
            return Err(io::ErrorKind::AddrNotAvailable.into());
        };
        let mouth = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        mouth.set_nonblocking(true)?;
        // The name is drawn by RustDDS, so that its last octets are as good as dice.
        let [.., high, low] = of;
        let drawn = f64::from(u16::from_be_bytes([high, low])) / f64::from(u16::MAX);
        let is_own = |place: &SocketAddrV4| place.port() == port && is_here(*place.ip(), &settings.interfaces);
        Ok(Self {
            of,
            door: SocketAddrV4::new(Ipv4Addr::LOCALHOST, port),
            name: of.map(|octet| !octet),
            ear,
            at,
            mouth,
            rounds: Rounds::new(&settings.peers, settings.domain_id, drawn, is_own),
            words: None,
            heard: Duration::ZERO,
            calls: 0,
            next_call: Duration::ZERO,
        })
    }

    fn work(&mut self) {
        let began = Instant::now();
        let mut datagram = vec![0; DATAGRAM_BYTES];
        while began.elapsed() < self.heard + SILENT {
            let now = began.elapsed();
            self.call_on(now);
            self.tell(now);
            let next = match &self.words {
                Some(_) => self.rounds.next().min(self.next_call),
                None => self.next_call,
            };
            let wait = next.saturating_sub(began.elapsed()).max(Duration::from_millis(1));
            if self.ear.set_read_timeout(Some(wait)).is_err() {
                return;
            }
            let Ok((length, _)) = self.ear.recv_from(&mut datagram) else {
                continue;
            };
            match datagram.get(..length).and_then(|all| announcement::said(all, &self.of)) {
                Some(Said::Here(words)) => (self.words, self.heard) = (Some(words), began.elapsed()),
                Some(Said::Gone) => return,
                None => {}
            }
        }
    }

    /// Has the participant know the announcer.
    fn call_on(&mut self, now: Duration) {
        if now < self.next_call {
            return;
        }
        self.calls = self.calls.wrapping_add(1);
        let call = announcement::caller(&self.name, self.at, self.calls);
        // What is lost is said again.
        let _ = self.mouth.send_to(&call, self.door);
        self.next_call = now + if self.words.is_some() { CALL_ON_LATER } else { CALL_ON };
    }

    /// Tells whoever is to be told now.
    fn tell(&mut self, now: Duration) {
        let Some(words) = &self.words else {
            return;
        };
        if let Some(place) = self.rounds.call(now) {
            // The network is away, or the queue is full: in the next round again.
            let _ = self.mouth.send_to(words, place);
        }
    }
}

/// Whether this is an address of this host as far as the settings say.
fn is_here(address: Ipv4Addr, interfaces: &[IpAddr]) -> bool {
    address.is_loopback() || interfaces.contains(&IpAddr::V4(address))
}
