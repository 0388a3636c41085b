//! The vehicles' sockets: which ports they bind and where they send to.

use super::{SimError, VehiclePorts};
use crate::settings::{PortPlan, Px4Ports};
use crate::vehicle::LinkKind;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

/// From this instance on all onboard links of the PX4 plan share one partner port.
const LAST_PARTNER: u32 = 9;

/// One link's socket and its fixed partner.
#[derive(Debug)]
pub(super) struct Wire {
    socket: UdpSocket,
    local: SocketAddr,
    partner: SocketAddr,
}

/// One vehicle's sockets.
#[derive(Debug)]
pub(super) struct Sockets {
    onboard: Option<Wire>,
    ground: Option<Wire>,
}

impl Sockets {
    /// Of a vehicle without MAVLink.
    pub(super) const NONE: Self = Self {
        onboard: None,
        ground: None,
    };

    /// Binds what the plan says for this vehicle.
    pub(super) fn bind(plan: &PortPlan, system_id: u8) -> Result<Self, SimError> {
        let base = match plan {
            PortPlan::Px4 => Px4Ports::default(),
            PortPlan::Px4At(base) => *base,
            PortPlan::SendTo(partner) => {
                return Ok(Self {
                    onboard: Some(Wire::bind(0, *partner, system_id)?),
                    ground: None,
                });
            }
        };
        let instance = u32::from(system_id.saturating_sub(1));
        let port = |base: u16, add: u32| {
            // Zero stays zero: any free port.
            let port = if base == 0 { 0 } else { u32::from(base) + add };
            u16::try_from(port).map_err(|_| SimError::NoSuchPort { system_id, port })
        };
        let partner = port(base.onboard_partner, instance.min(LAST_PARTNER))?;
        let onboard = Wire::bind(port(base.onboard_local, instance)?, loopback(partner), system_id)?;
        let ground = Wire::bind(
            port(base.ground_local, instance)?,
            loopback(base.ground_partner),
            system_id,
        )?;
        Ok(Self {
            onboard: Some(onboard),
            ground: Some(ground),
        })
    }

    /// How the vehicle is reached, if it is by MAVLink.
    pub(super) fn ports(&self, system_id: u8) -> Option<VehiclePorts> {
        let onboard = self.onboard.as_ref()?;
        Some(VehiclePorts {
            system_id,
            onboard: onboard.local,
            onboard_partner: onboard.partner,
            ground: self.ground.as_ref().map(|g| (g.local, g.partner)),
        })
    }

    /// The links that there are.
    pub(super) fn links(&self) -> impl Iterator<Item = (LinkKind, &Wire)> {
        let onboard = self.onboard.as_ref().map(|wire| (LinkKind::Onboard, wire));
        let ground = self.ground.as_ref().map(|wire| (LinkKind::GroundStation, wire));
        onboard.into_iter().chain(ground)
    }

    /// Sends one frame.
    pub(super) fn send(&self, link: LinkKind, frame: &[u8]) {
        if let Some((_, wire)) = self.links().find(|(kind, _)| *kind == link) {
            // Nobody need listen: like a radio, it sends all the same.
            let _ = wire.socket.send_to(frame, wire.partner);
        }
    }
}

impl Wire {
    fn bind(port: u16, partner: SocketAddr, system_id: u8) -> Result<Self, SimError> {
        let address = match partner {
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::LOCALHOST, port)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::LOCALHOST, port)),
        };
        let bound = UdpSocket::bind(address).and_then(|socket| {
            socket.set_nonblocking(true)?;
            let local = socket.local_addr()?;
            Ok(Self { socket, local, partner })
        });
        bound.map_err(|source| SimError::Bind {
            system_id,
            address,
            source,
        })
    }

    /// The next datagram that has come, from anyone: the partner of a link is fixed for sending only.
    pub(super) fn receive<'a>(&self, buffer: &'a mut [u8]) -> Option<&'a [u8]> {
        match self.socket.recv_from(buffer) {
            Ok((length, _)) => buffer.get(..length),
            Err(_) => None,
        }
    }
}

/// A mover's way out.
#[derive(Debug)]
pub(super) struct Voice {
    socket: UdpSocket,
    partner: SocketAddr,
}

impl Voice {
    /// Speaks to an address, or where the first vehicle of the plan sends its onboard link to.
    pub(super) fn open(plan: &PortPlan, to: Option<SocketAddr>) -> Result<Self, SimError> {
        let partner = to.unwrap_or_else(|| match plan {
            PortPlan::Px4 => loopback(Px4Ports::default().onboard_partner),
            PortPlan::Px4At(base) => loopback(base.onboard_partner),
            PortPlan::SendTo(partner) => *partner,
        });
        let Wire { socket, .. } = Wire::bind(0, partner, 0)?;
        Ok(Self { socket, partner })
    }

    /// Sends one frame.
    pub(super) fn send(&self, frame: &[u8]) {
        // Nobody need listen.
        let _ = self.socket.send_to(frame, self.partner);
    }
}

fn loopback(port: u16) -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, port))
}
