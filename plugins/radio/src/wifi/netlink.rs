//! Questions to the kernel's nl80211, and its answers.

use netlink_sys::protocols::NETLINK_GENERIC;
use netlink_sys::{Socket, SocketAddr};
use skein_domain::Refusal;
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};
use thiserror::Error;
use wl_nl80211::Nl80211Message;
use wl_nl80211::packet_core::{
    NLM_F_ACK, NLM_F_DUMP, NLM_F_REQUEST, NetlinkDeserializable, NetlinkMessage, NetlinkPayload, NetlinkSerializable,
};
use wl_nl80211::packet_generic::GenlMessage;
use wl_nl80211::packet_generic::ctrl::nlas::GenlCtrlAttrs;
use wl_nl80211::packet_generic::ctrl::{GenlCtrl, GenlCtrlCmd};

/// The kernel answers within microseconds; a driver that hangs must not hold the thread for ever.
const ANSWER_WAIT: Duration = Duration::from_secs(1);
const LOOK_PAUSE: Duration = Duration::from_millis(2);
/// Longer than any datagram of the kernel's dumps.
const DATAGRAM_LEN: usize = 64 * 1024;
/// More answers than interfaces, stations and channels there can be.
const MOST_ANSWERS: usize = 4096;

/// What went wrong with Wi-Fi.
#[derive(Debug, Error)]
pub(crate) enum WifiError {
    /// The kernel has no wireless subsystem.
    #[error("this computer has no Wi-Fi")]
    NoWifi,
    /// There is no such interface.
    #[error("there is no Wi-Fi interface{}", if name.is_empty() { String::new() } else { format!(" {name}") })]
    NoInterface {
        /// Its name; empty if any would do.
        name: String,
    },
    /// Nobody is at the other end.
    #[error("{name} is not connected")]
    NotConnected {
        /// The interface.
        name: String,
    },
    /// The kernel refused.
    #[error("the kernel says: {0}")]
    Kernel(io::Error),
    /// It did not answer.
    #[error("the kernel does not answer")]
    Silent,
    /// Its answer cannot be read.
    #[error("the kernel's answer cannot be read: {0}")]
    Unreadable(String),
}

impl WifiError {
    /// How a change that failed so is refused.
    pub(crate) fn refusal(&self) -> Refusal {
        let detail = self.to_string();
        match self {
            Self::Kernel(error) if error.kind() == ErrorKind::PermissionDenied => {
                Refusal::not_permitted(format!("{detail}; CAP_NET_ADMIN is needed"))
            }
            Self::Silent => Refusal::timed_out("the kernel's answer", ANSWER_WAIT.as_secs_f64()),
            _ => Refusal::NotSupported { detail },
        }
    }
}

/// A connection to nl80211.
#[derive(Debug)]
pub(crate) struct Connection {
    socket: Socket,
    family: u16,
    sequence: u32,
}

impl Connection {
    pub(crate) fn open() -> Result<Self, WifiError> {
        let mut socket = Socket::new(NETLINK_GENERIC).map_err(WifiError::Kernel)?;
        socket.bind_auto().map_err(WifiError::Kernel)?;
        socket.connect(&SocketAddr::new(0, 0)).map_err(WifiError::Kernel)?;
        socket.set_non_blocking(true).map_err(WifiError::Kernel)?;
        let mut connection = Self {
            socket,
            family: 0,
            sequence: 0,
        };
        let question = GenlMessage::from_payload(GenlCtrl {
            cmd: GenlCtrlCmd::GetFamily,
            nlas: vec![GenlCtrlAttrs::FamilyName("nl80211".to_owned())],
        });
        let answers = connection.exchange(question, NLM_F_ACK).map_err(|error| match error {
            WifiError::Kernel(error) if error.kind() == ErrorKind::NotFound => WifiError::NoWifi,
            error => error,
        })?;
        let mut nlas = answers.into_iter().flat_map(|answer| answer.payload.nlas);
        connection.family = nlas
            .find_map(|nla| match nla {
                GenlCtrlAttrs::FamilyId(id) => Some(id),
                _ => None,
            })
            .ok_or(WifiError::NoWifi)?;
        Ok(connection)
    }

    /// Everything of a kind.
    pub(crate) fn dump(&mut self, question: Nl80211Message) -> Result<Vec<Nl80211Message>, WifiError> {
        self.ask(question, NLM_F_DUMP)
    }

    /// Has something done.
    pub(crate) fn set(&mut self, order: Nl80211Message) -> Result<(), WifiError> {
        self.ask(order, NLM_F_ACK).map(drop)
    }

    fn ask(&mut self, question: Nl80211Message, flags: u16) -> Result<Vec<Nl80211Message>, WifiError> {
        let mut question = GenlMessage::from_payload(question);
        question.set_resolved_family_id(self.family);
        let answers = self.exchange(question, flags)?;
        Ok(answers.into_iter().map(|answer| answer.payload).collect())
    }

    fn exchange<M>(&mut self, question: M, flags: u16) -> Result<Vec<M>, WifiError>
    where
        M: NetlinkSerializable + NetlinkDeserializable + std::fmt::Debug,
        NetlinkPayload<M>: From<M>,
    {
        self.sequence = self.sequence.wrapping_add(1);
        let mut message = NetlinkMessage::from(question);
        message.header.flags = NLM_F_REQUEST | flags;
        message.header.sequence_number = self.sequence;
        message.finalize();
        let mut bytes = vec![0; message.buffer_len()];
        message.serialize(&mut bytes);
        self.socket.send(&bytes, 0).map_err(WifiError::Kernel)?;
        let begun = Instant::now();
        let mut answers = Vec::new();
        let mut datagram = Vec::with_capacity(DATAGRAM_LEN);
        loop {
            datagram.clear();
            match self.socket.recv(&mut datagram, 0) {
                Ok(_) if read(&datagram, self.sequence, &mut answers)? => return Ok(answers),
                Ok(_) if answers.len() > MOST_ANSWERS => {
                    return Err(WifiError::Unreadable("it does not end".to_owned()));
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock && begun.elapsed() < ANSWER_WAIT => {
                    std::thread::sleep(LOOK_PAUSE);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Err(WifiError::Silent),
                Err(error) => return Err(WifiError::Kernel(error)),
            }
        }
    }
}

/// Reads the messages of a datagram that answer the question of this number. True when the answer is complete.
pub(super) fn read<M>(mut datagram: &[u8], sequence: u32, answers: &mut Vec<M>) -> Result<bool, WifiError>
where
    M: NetlinkDeserializable + std::fmt::Debug,
{
    let unreadable = |what: &dyn std::fmt::Display| WifiError::Unreadable(what.to_string());
    while !datagram.is_empty() {
        let message = NetlinkMessage::<M>::deserialize(datagram).map_err(|error| unreadable(&error))?;
        let len = usize::try_from(message.header.length).unwrap_or(usize::MAX);
        // Messages begin at multiples of four.
        datagram = datagram.get(len.max(1).next_multiple_of(4)..).unwrap_or_default();
        if message.header.sequence_number != sequence {
            continue;
        }
        match message.payload {
            NetlinkPayload::InnerMessage(answer) => answers.push(answer),
            NetlinkPayload::Done(done) if done.code < 0 => {
                return Err(WifiError::Kernel(io::Error::from_raw_os_error(-done.code)));
            }
            NetlinkPayload::Done(_) => return Ok(true),
            NetlinkPayload::Error(error) if error.code.is_none() => return Ok(true),
            NetlinkPayload::Error(error) => return Err(WifiError::Kernel(error.to_io())),
            NetlinkPayload::Overrun(_) => return Err(unreadable(&"it was too long")),
            _ => {}
        }
    }
    Ok(false)
}
