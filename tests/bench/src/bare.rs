//! The bare loop's process: receive, parse, remember who sent it, and send a setpoint to each vehicle 50 times a second. No logic,
//! no state machine, no safety: the least that a program with this protocol crate and this runtime can cost.

use crate::error::BenchError;
use crate::wire::{AUTOPILOT_COMPONENT, DATAGRAM_BYTES, Encoder, Frame};
use mavlink::dialects::common::{MavFrame, MavMessage, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA};
use parking_lot::Mutex;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::net::UdpSocket;
use tokio::time::MissedTickBehavior;

/// What the bare loop is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BareLoopSettings {
    /// Setpoints per second and vehicle.
    pub setpoint_rate_hz: f64,
    /// Its own MAVLink identity.
    pub own_system_id: u8,
    /// Threads of the runtime.
    pub workers: usize,
}

impl Default for BareLoopSettings {
    fn default() -> Self {
        Self {
            setpoint_rate_hz: 50.0,
            own_system_id: 245,
            workers: 2,
        }
    }
}

/// Who was heard, and where.
type Senders = Arc<Mutex<BTreeMap<u8, SocketAddr>>>;

/// Runs the bare loop until it is killed; prints the address it listens on first. `settings` is [`BareLoopSettings`] as JSON.
///
/// # Errors
/// When the settings do not parse or a system call fails.
pub fn run_bare_loop(settings: &str) -> Result<(), BenchError> {
    let settings: BareLoopSettings = serde_json::from_str(settings).map_err(BenchError::Settings)?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(settings.workers)
        .enable_all()
        .build()
        .map_err(BenchError::system("runtime"))?;
    runtime.block_on(async {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))
            .await
            .map_err(BenchError::system("bind"))?;
        println!("{}", socket.local_addr().map_err(BenchError::system("bind"))?);
        serve(socket, settings).await
    })
}

/// The loop itself, on a socket.
pub(crate) async fn serve(socket: UdpSocket, settings: BareLoopSettings) -> Result<(), BenchError> {
    let (socket, senders) = (Arc::new(socket), Senders::default());
    let receiving = tokio::spawn(receive(Arc::clone(&socket), Arc::clone(&senders)));
    let sending = tokio::spawn(send(socket, senders, settings));
    let ended = tokio::select! { ended = receiving => ended, ended = sending => ended };
    ended.unwrap_or_else(|e| {
        Err(BenchError::Child {
            part: "bare loop",
            detail: e.to_string(),
        })
    })
}

async fn receive(socket: Arc<UdpSocket>, senders: Senders) -> Result<(), BenchError> {
    let mut bytes = [0; DATAGRAM_BYTES];
    loop {
        let Ok((length, from)) = socket.recv_from(&mut bytes).await else {
            continue;
        };
        let Some(frame) = bytes.get(..length).and_then(Frame::of) else {
            continue;
        };
        // Parsed and looked at, so that no compiler leaves it out.
        let Some(message) = frame.message() else { continue };
        if !matches!(message, MavMessage::HEARTBEAT(_)) && senders.lock().contains_key(&frame.system_id) {
            std::hint::black_box(&message);
            continue;
        }
        senders.lock().insert(frame.system_id, from);
    }
}

async fn send(socket: Arc<UdpSocket>, senders: Senders, settings: BareLoopSettings) -> Result<(), BenchError> {
    let mut ticks = tokio::time::interval(Duration::from_secs_f64(1.0 / settings.setpoint_rate_hz));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let started = Instant::now();
    let mut encoder = Encoder::new(settings.own_system_id, 190);
    loop {
        ticks.tick().await;
        let vehicles: Vec<(u8, SocketAddr)> = senders.lock().iter().map(|(id, address)| (*id, *address)).collect();
        for (system_id, address) in vehicles {
            let message = setpoint(system_id, started.elapsed().as_millis() as u32);
            let mut frame = [0; DATAGRAM_BYTES];
            let length = encoder.encode(&message, |bytes| {
                let length = bytes.len();
                if let Some(room) = frame.get_mut(..length) {
                    room.copy_from_slice(bytes);
                }
                length
            });
            // A vehicle that is gone is not the loop's business.
            let _ = socket.send_to(frame.get(..length).unwrap_or_default(), address).await;
        }
    }
}

fn setpoint(target_system: u8, time_boot_ms: u32) -> MavMessage {
    MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms,
        x: 1.0,
        y: 2.0,
        z: -10.0,
        vx: 0.1,
        vy: 0.1,
        vz: 0.1,
        yaw: 0.5,
        type_mask: PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AX_IGNORE
            | PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AY_IGNORE
            | PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AZ_IGNORE
            | PositionTargetTypemask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE,
        target_system,
        target_component: AUTOPILOT_COMPONENT,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
    })
}
