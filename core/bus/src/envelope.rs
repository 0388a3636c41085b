//! Sealed datagrams: only who has the swarm's secret can read or make one, and each is taken in once.
//!
//! Must never do: hand out a byte that was not authenticated; take a datagram of a run of its sender that has not proven to be going on
//! now; use a nonce twice.
//!
//! XChaCha20-Poly1305 with one key of the swarm (HKDF-SHA-256 of its secret, bound to its id). The nonce is sender, boot and number, so no
//! two are alike while boots are drawn at random. A window per sender refuses what was there before. What was recorded of an *earlier run* can't be told from
//! the present by that: so a node asks every run it does not know yet for a proof, an answer to a number that it never used before.

use crate::transport::{Class, To};
use chacha20poly1305::aead::{Aead, Payload};
use chacha20poly1305::{KeyInit, XChaCha20Poly1305, XNonce};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;
use thiserror::Error;

mod window;

use window::Window;

/// One run of a node: drawn at random when it starts, never used again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[derive(Serialize, Deserialize, Encode, Decode)]
#[cbor(transparent)]
#[serde(transparent)]
pub struct Boot(#[n(0)] pub u64);

/// What a sealed datagram has more bytes than what is in it: header and tag.
pub const ENVELOPE_BYTES: usize = HEADER_BYTES + 16;
/// The shortest secret, in bytes. It is no password: nothing here makes a guessable one hard to guess.
pub const SHORTEST_SECRET_BYTES: usize = 16;

const VERSION: u8 = 1;
const HEADER_BYTES: usize = 27;
/// More runs of nodes than any swarm has; strangers make no entries.
const MOST_PEERS: usize = 512;
/// A proof is asked for, and given, so often at most, in seconds; asked for again after twice as long each time.
const PROOF_PAUSE_S: f64 = 0.15;
/// So often that time is doubled: many who ask at once on a slow link must not keep it full.
const PROOF_PAUSE_DOUBLES: u8 = 4;

/// The secret is too short to protect anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("a swarm's secret needs {SHORTEST_SECRET_BYTES} bytes or more, this one has {bytes}")]
pub struct WeakSecret {
    /// How many it has.
    pub bytes: usize,
}

/// The key of a swarm.
#[derive(Clone)]
pub struct SwarmKey(XChaCha20Poly1305);

impl std::fmt::Debug for SwarmKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SwarmKey")
    }
}

impl SwarmKey {
    /// The key of the swarm of this id and secret.
    ///
    /// # Errors
    ///
    /// The secret is too short.
    pub fn derive(swarm: &str, secret: &[u8]) -> Result<Self, WeakSecret> {
        let weak = WeakSecret { bytes: secret.len() };
        if secret.len() < SHORTEST_SECRET_BYTES {
            return Err(weak);
        }
        let mut key = [0; 32];
        let expanded =
            hkdf::Hkdf::<sha2::Sha256>::new(Some(b"skein swarm bus 1"), secret).expand(swarm.as_bytes(), &mut key);
        // Thirty-two bytes are always less than what HKDF can give.
        expanded.map_err(|_| weak)?;
        Ok(Self(XChaCha20Poly1305::new(&key.into())))
    }
}

/// What was not taken in, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Refused {
    /// Too short, or of another version.
    pub malformed: u64,
    /// Not sealed with this swarm's key, changed on the way, or meant for another node.
    pub strangers: u64,
    /// There before, or too old to tell.
    pub replayed: u64,
    /// Of a run that has not proven to be going on now; it has been asked to.
    pub unproven: u64,
    /// This node's own, sent back.
    pub own: u64,
    /// Of more nodes than any swarm has.
    pub crowded: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Content,
    Challenge,
    Proof,
}

#[derive(Debug, Clone, Copy)]
struct Header {
    kind: Kind,
    to_all: bool,
    class: Class,
    from: NodeId,
    boot: Boot,
    number: u64,
}

/// What was in a datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Opened {
    /// Something of a run that is going on.
    Content {
        /// Who sent it.
        from: NodeId,
        /// Its run.
        boot: Boot,
        /// Its kind.
        class: Class,
        /// It was sent to all, not to this node alone.
        to_all: bool,
        /// What it says.
        bytes: Vec<u8>,
    },
    /// A node has proven that this run of it is going on now; it was not known before.
    Joined {
        /// Which node.
        from: NodeId,
        /// Its run.
        boot: Boot,
    },
    /// Nothing to be handed on.
    Nothing,
}

#[derive(Debug)]
struct Peer {
    proven: Option<(Boot, Window)>,
    /// The number that the next proof must answer, when it was last asked for, and how often before.
    asked: Option<(u64, NodeTime, u8)>,
    answered: Option<NodeTime>,
}

/// Seals and opens for one run of one node.
#[derive(Debug)]
pub struct SecureEnvelope {
    key: SwarmKey,
    me: NodeId,
    boot: Boot,
    sent: u64,
    sent_to_all: u64,
    asked: u64,
    peers: BTreeMap<NodeId, Peer>,
    replies: Vec<(NodeId, Vec<u8>)>,
    refused: Refused,
}

impl SecureEnvelope {
    /// For a run of the node `me`; `boot` must be drawn at random.
    #[must_use]
    pub fn new(key: SwarmKey, me: NodeId, boot: Boot) -> Self {
        Self {
            key,
            me,
            boot,
            sent: 0,
            sent_to_all: 0,
            asked: 0,
            peers: BTreeMap::new(),
            replies: Vec::new(),
            refused: Refused::default(),
        }
    }

    /// What was not taken in so far.
    #[must_use]
    pub fn refused(&self) -> Refused {
        self.refused
    }

    /// How many datagrams were sealed for all so far.
    #[must_use]
    pub fn sent_to_all(&self) -> u64 {
        self.sent_to_all
    }

    /// The run of a node that has proven to be going on.
    #[must_use]
    pub fn run_of(&self, node: NodeId) -> Option<Boot> {
        let proven = self.peers.get(&node)?.proven.as_ref();
        proven.map(|(boot, _)| *boot)
    }

    /// What is to be sent because of what was opened: challenges and proofs, sealed already.
    pub fn take_replies(&mut self) -> Vec<(NodeId, Vec<u8>)> {
        std::mem::take(&mut self.replies)
    }

    /// Seals something.
    pub fn seal(&mut self, to: To, class: Class, content: &[u8]) -> Vec<u8> {
        self.sealed(Kind::Content, to, class, content)
    }

    fn sealed(&mut self, kind: Kind, to: To, class: Class, content: &[u8]) -> Vec<u8> {
        self.sent += 1;
        self.sent_to_all += u64::from(to == To::All);
        let header = Header {
            kind,
            to_all: to == To::All,
            class,
            from: self.me,
            boot: self.boot,
            number: self.sent,
        };
        let mut bytes = header.bytes().to_vec();
        let receiver = match to {
            To::One(node) => node,
            To::All => NodeId(0),
        };
        let aad = header.bound_to(receiver);
        let payload = Payload {
            msg: content,
            aad: &aad,
        };
        // It fails for more than 256 GiB only; then nothing that opens is sent.
        let sealed = self.key.0.encrypt(&header.nonce(), payload).unwrap_or_default();
        bytes.extend(sealed);
        bytes
    }

    /// Opens a datagram that arrived.
    pub fn open(&mut self, now: NodeTime, bytes: &[u8]) -> Opened {
        let Some((header, sealed)) = Header::parse(bytes) else {
            self.refused.malformed += 1;
            return Opened::Nothing;
        };
        if header.from == self.me {
            self.refused.own += 1;
            return Opened::Nothing;
        }
        let receiver = if header.to_all { NodeId(0) } else { self.me };
        let aad = header.bound_to(receiver);
        let Ok(content) = self.key.0.decrypt(&header.nonce(), Payload { msg: sealed, aad: &aad }) else {
            self.refused.strangers += 1;
            return Opened::Nothing;
        };
        if self.peers.len() >= MOST_PEERS && !self.peers.contains_key(&header.from) {
            self.refused.crowded += 1;
            return Opened::Nothing;
        }
        match header.kind {
            Kind::Content => self.content(now, header, content),
            Kind::Challenge => self.challenged(now, header, &content),
            Kind::Proof => self.proven(header, &content),
        }
    }

    fn peer(&mut self, node: NodeId) -> &mut Peer {
        self.peers.entry(node).or_insert(Peer {
            proven: None,
            asked: None,
            answered: None,
        })
    }

    fn content(&mut self, now: NodeTime, header: Header, bytes: Vec<u8>) -> Opened {
        let Header {
            from,
            boot,
            class,
            to_all,
            ..
        } = header;
        let known = self.peer(from).proven.as_mut().filter(|(known, _)| *known == boot);
        match known.map(|(_, window)| window.take(header.number)) {
            Some(true) => Opened::Content {
                from,
                boot,
                class,
                to_all,
                bytes,
            },
            Some(false) => {
                self.refused.replayed += 1;
                Opened::Nothing
            }
            None => {
                self.refused.unproven += 1;
                self.ask(now, from);
                Opened::Nothing
            }
        }
    }

    /// Asks a node to prove that it is running now. The number stays the same until it is answered: an answer may take longer than the pause.
    fn ask(&mut self, now: NodeTime, node: NodeId) {
        let next = self.asked + 1;
        let peer = self.peer(node);
        let pause_s = |before: u8| PROOF_PAUSE_S * f64::from(1_u8 << before.min(PROOF_PAUSE_DOUBLES));
        let (number, before) = match peer.asked {
            Some((_, at, before)) if now.seconds_since(at) < pause_s(before) => return,
            Some((number, _, before)) => (number, before.saturating_add(1)),
            None => (next, 0),
        };
        peer.asked = Some((number, now, before));
        self.asked = self.asked.max(number);
        let content = [self.boot.0.to_be_bytes(), number.to_be_bytes()].concat();
        let challenge = self.sealed(Kind::Challenge, To::One(node), Class::Command, &content);
        self.replies.push((node, challenge));
    }

    /// Somebody asks whether this run is going on. The question itself proves nothing of who asks.
    fn challenged(&mut self, now: NodeTime, header: Header, content: &[u8]) -> Opened {
        let peer = self.peer(header.from);
        let unknown = peer.proven.as_ref().is_none_or(|(boot, _)| *boot != header.boot);
        let lately = peer
            .answered
            .is_some_and(|at| now.seconds_since(at) < PROOF_PAUSE_S / 3.0);
        if !lately {
            peer.answered = Some(now);
            let proof = self.sealed(Kind::Proof, To::One(header.from), Class::Command, content);
            self.replies.push((header.from, proof));
        }
        if unknown {
            self.ask(now, header.from);
        }
        Opened::Nothing
    }

    fn proven(&mut self, header: Header, content: &[u8]) -> Opened {
        let me = self.boot.0.to_be_bytes();
        let peer = self.peer(header.from);
        let answers = peer
            .asked
            .is_some_and(|(number, ..)| content == [me, number.to_be_bytes()].concat());
        if !answers {
            self.refused.replayed += 1;
            return Opened::Nothing;
        }
        peer.asked = None;
        if peer.proven.as_ref().is_some_and(|(boot, _)| *boot == header.boot) {
            return Opened::Nothing;
        }
        peer.proven = Some((header.boot, Window::after(header.number)));
        Opened::Joined {
            from: header.from,
            boot: header.boot,
        }
    }
}

impl Header {
    fn bytes(self) -> [u8; HEADER_BYTES] {
        let kind = match self.kind {
            Kind::Content => 0,
            Kind::Challenge => 1,
            Kind::Proof => 2,
        };
        let mut bytes = [0; HEADER_BYTES];
        let parts = [VERSION, kind | u8::from(self.to_all) << 7, self.class as u8].into_iter();
        let numbers = [self.from.0, self.boot.0, self.number];
        let all = parts.chain(numbers.into_iter().flat_map(u64::to_be_bytes));
        for (byte, value) in bytes.iter_mut().zip(all) {
            *byte = value;
        }
        bytes
    }

    fn parse(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (header, sealed) = bytes.split_first_chunk::<HEADER_BYTES>()?;
        let [version, kind, class, numbers @ ..] = header;
        let kind_of = match kind & 0x7f {
            0 => Kind::Content,
            1 => Kind::Challenge,
            2 => Kind::Proof,
            _ => return None,
        };
        let class = *crate::transport::CLASSES.get(usize::from(*class))?;
        let mut numbers = numbers
            .chunks_exact(8)
            .map(|chunk| chunk.iter().fold(0_u64, |value, byte| value << 8 | u64::from(*byte)));
        let header = Self {
            kind: kind_of,
            to_all: kind & 0x80 != 0,
            class,
            from: NodeId(numbers.next()?),
            boot: Boot(numbers.next()?),
            number: numbers.next()?,
        };
        (*version == VERSION).then_some((header, sealed))
    }

    /// Sender, run and number: never the same twice under one key.
    fn nonce(self) -> XNonce {
        let mut nonce = XNonce::default();
        let all = [self.from.0, self.boot.0, self.number]
            .into_iter()
            .flat_map(u64::to_be_bytes);
        for (byte, value) in nonce.iter_mut().zip(all) {
            *byte = value;
        }
        nonce
    }

    /// What is authenticated with it: all of the header, and whom it is for, so that it is of no use to another.
    fn bound_to(self, receiver: NodeId) -> Vec<u8> {
        let mut bound = self.bytes().to_vec();
        bound.extend(receiver.0.to_be_bytes());
        bound
    }
}

#[cfg(test)]
mod tests;
