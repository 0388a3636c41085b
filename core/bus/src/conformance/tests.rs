//! Transports that are wrong in one thing are found.

use super::*;
use crate::local::{Hub, Local};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    TellsEveryone,
    CutsOff,
    MistakesTheClass,
    MistakesTheSender,
    LosesBulk,
    RefusesWhereNobodyIs,
    NeverWakes,
    TakesWhatIsTooLarge,
}

struct Faulty {
    inner: Local,
    fault: Fault,
}

impl Transport for Faulty {
    fn node(&self) -> NodeId {
        self.inner.node()
    }

    fn largest_bytes(&self) -> usize {
        self.inner.largest_bytes()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        let (to, class, bytes) = match self.fault {
            Fault::TellsEveryone => (To::All, class, bytes),
            Fault::CutsOff => (to, class, &bytes[..bytes.len().min(900)]),
            Fault::MistakesTheClass if class == Class::Query => (to, Class::State, bytes),
            Fault::LosesBulk if class == Class::Bulk => return Ok(()),
            Fault::RefusesWhereNobodyIs if to == To::One(NodeId(0xdead)) => {
                return Err(SendError::Down("nobody is there".to_owned()));
            }
            Fault::TakesWhatIsTooLarge => (to, class, &bytes[..bytes.len().min(self.largest_bytes())]),
            _ => (to, class, bytes),
        };
        self.inner.send(now, to, class, bytes)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        let mut datagram = self.inner.receive(now)?;
        if self.fault == Fault::MistakesTheSender {
            datagram.from = C;
        }
        Some(datagram)
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        if self.fault != Fault::NeverWakes {
            self.inner.wake_on_arrival(wake);
        }
    }

    fn overflowed(&self) -> u64 {
        self.inner.overflowed()
    }
}

struct Workshop {
    hub: Hub,
    now: NodeTime,
    fault: Fault,
}

impl Rig for Workshop {
    type Transport = Faulty;

    fn join(&mut self, node: NodeId) -> Faulty {
        let inner = self.hub.join(node);
        let fault = self.fault;
        Faulty { inner, fault }
    }

    fn step(&mut self) -> NodeTime {
        self.now = self.now.plus_seconds(0.01);
        self.now
    }
}

fn passes(fault: Fault) -> bool {
    let rig = || Workshop {
        hub: Hub::default(),
        now: NodeTime(0),
        fault,
    };
    std::panic::catch_unwind(|| all(rig)).is_ok()
}

#[test]
fn a_transport_with_one_fault_does_not_pass() {
    assert!(passes(Fault::None));
    let faults = [
        Fault::TellsEveryone,
        Fault::CutsOff,
        Fault::MistakesTheClass,
        Fault::MistakesTheSender,
        Fault::LosesBulk,
        Fault::RefusesWhereNobodyIs,
        Fault::NeverWakes,
        Fault::TakesWhatIsTooLarge,
    ];
    for fault in faults {
        assert!(!passes(fault), "{fault:?} is not found");
    }
}
