//! What the transports are measured beside: sockets, and nothing else. Who is there is known beforehand.
//!
//! Must never do: find anybody, or mend anything. It is no transport for a swarm.

use crate::error::BenchError;
use skein_bus::arrivals::Arrivals;
use skein_bus::transport::{CLASSES, Class, Datagram, SendError, To, Transport, Wake};
use skein_domain::{NodeId, NodeTime};
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

const LARGEST_BYTES: usize = 1400;
/// The thread that receives looks so often whether it is to end.
const LOOKS_EVERY: Duration = Duration::from_millis(200);

struct BareUdp {
    node: NodeId,
    socket: UdpSocket,
    others: Vec<(NodeId, SocketAddr)>,
    arrivals: Arc<Arrivals>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// One for each node.
pub(super) fn open(nodes: &[NodeId]) -> Result<Vec<Box<dyn Transport>>, BenchError> {
    let failed = || BenchError::system("a UDP socket");
    let mut sockets = Vec::new();
    for node in nodes {
        let socket = UdpSocket::bind("127.0.0.1:0").map_err(failed())?;
        socket.set_read_timeout(Some(LOOKS_EVERY)).map_err(failed())?;
        let address = socket.local_addr().map_err(failed())?;
        sockets.push((*node, address, socket));
    }
    let all: Vec<(NodeId, SocketAddr)> = sockets.iter().map(|(node, address, _)| (*node, *address)).collect();
    let mut opened: Vec<Box<dyn Transport>> = Vec::new();
    for (node, _, socket) in sockets {
        let others = all.iter().copied().filter(|(other, _)| *other != node).collect();
        opened.push(Box::new(BareUdp::new(node, socket, others)?));
    }
    Ok(opened)
}

impl BareUdp {
    fn new(node: NodeId, socket: UdpSocket, others: Vec<(NodeId, SocketAddr)>) -> Result<Self, BenchError> {
        let (arrivals, ends) = (Arc::new(Arrivals::default()), Arc::new(AtomicBool::new(false)));
        let receiving = socket.try_clone().map_err(BenchError::system("a UDP socket"))?;
        let (to, told, known) = (Arc::clone(&arrivals), Arc::clone(&ends), others.clone());
        let thread = std::thread::spawn(move || {
            let mut buffer = [0; LARGEST_BYTES + 1];
            while !told.load(Ordering::Acquire) {
                let Ok((length, from)) = receiving.recv_from(&mut buffer) else {
                    continue;
                };
                let sender = known.iter().find(|(_, address)| *address == from);
                let came = buffer.get(..length).and_then(<[u8]>::split_first);
                if let (Some((sender, _)), Some((class, bytes))) = (sender, came)
                    && let Some(class) = CLASSES.get(usize::from(*class))
                {
                    to.put(*sender, *class, bytes.to_vec());
                }
            }
        });
        Ok(Self {
            node,
            socket,
            others,
            arrivals,
            ends,
            thread: Some(thread),
        })
    }
}

impl Drop for BareUdp {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ended = thread.join();
        }
    }
}

impl Transport for BareUdp {
    fn node(&self) -> NodeId {
        self.node
    }

    fn largest_bytes(&self) -> usize {
        LARGEST_BYTES
    }

    fn send(&mut self, _now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        let mut datagram = vec![class as u8];
        datagram.extend_from_slice(bytes);
        for (node, address) in &self.others {
            if to == To::All || to == To::One(*node) {
                // What does not fit into the system's buffer is lost, as on the way.
                let _sent = self.socket.send_to(&datagram, address);
            }
        }
        Ok(())
    }

    fn receive(&mut self, _now: NodeTime) -> Option<Datagram> {
        self.arrivals.next()
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.arrivals.wake_on(wake);
    }

    fn overflowed(&self) -> u64 {
        self.arrivals.overflowed()
    }
}
