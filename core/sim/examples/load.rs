//! What many vehicles cost: runs them in real time with the rates a swarm uses, and prints the processor time of it.
//! `cargo run --release -p skein-sim --example load -- VEHICLES SECONDS [default] [payloads]`

use skein_sim::{PayloadPlan, PortPlan, SimSettings, Simulation};
use std::net::UdpSocket;
use std::time::{Duration, Instant};

/// Messages and the intervals asked for, in microseconds; all others are switched off.
const RATES: &[(u32, f32)] = &[
    (30, 20_000.0),
    (32, 20_000.0),
    (33, 100_000.0),
    (1, 1e6),
    (24, 1e6),
    (147, 1e6),
    (245, 1e6),
];
const OFF: &[u32] = &[2, 31, 36, 42, 74, 83, 85, 105, 111, 141, 230, 241, 242, 331];

fn set_interval(system: u8, id: u32, interval_us: f32) -> Vec<u8> {
    let mut payload: Vec<u8> = [id as f32, interval_us, 0.0, 0.0, 0.0, 0.0, 0.0]
        .iter()
        .flat_map(|p| p.to_le_bytes())
        .collect();
    payload.extend(511_u16.to_le_bytes());
    payload.extend([system, 1, 0]);
    let mut frame = vec![0xFD, payload.len() as u8, 0, 0, 0, 245, 190, 76, 0, 0];
    frame.extend(payload);
    let crc = mavlink::calculate_crc(frame.get(1..).unwrap_or_default(), 152);
    frame.extend(crc.to_le_bytes());
    frame
}

/// Processor time of the simulation's thread so far, in seconds.
fn thread_cpu_s() -> f64 {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    for thread in threads {
        let name = std::fs::read_to_string(thread.path().join("comm")).unwrap_or_default();
        if name.trim() == "skein-sim" {
            let stat = std::fs::read_to_string(thread.path().join("stat")).unwrap_or_default();
            let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
            let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
            return (ticks(11) + ticks(12)) / 100.0;
        }
    }
    0.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let number = |i: usize, otherwise: u64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(otherwise);
    let is_asked = |word: &str| arguments.iter().any(|a| a == word);
    let (vehicles, seconds) = (number(1, 50) as usize, number(2, 10));
    let socket = UdpSocket::bind("127.0.0.1:0")?;
    let simulation = Simulation::start(SimSettings {
        vehicles,
        ports: PortPlan::SendTo(socket.local_addr()?),
        payloads: if is_asked("payloads") {
            PayloadPlan::all()
        } else {
            PayloadPlan::default()
        },
        ..SimSettings::default()
    })?;
    if !is_asked("default") {
        for ports in simulation.ports() {
            let off = OFF.iter().map(|id| (*id, -1.0));
            for (id, interval_us) in RATES.iter().copied().chain(off) {
                socket.send_to(&set_interval(ports.system_id, id, interval_us), ports.onboard)?;
            }
        }
    }
    std::thread::sleep(Duration::from_secs(3));
    socket.set_read_timeout(Some(Duration::from_millis(100)))?;
    let (begin, cpu, mut messages) = (Instant::now(), thread_cpu_s(), 0_u64);
    while begin.elapsed() < Duration::from_secs(seconds) {
        messages += u64::from(socket.recv_from(&mut [0; 512]).is_ok());
    }
    let wall_s = begin.elapsed().as_secs_f64();
    println!(
        "{vehicles} vehicles: {:.1} % of a core, {:.0} messages/s, longest stall {:.0} ms",
        (thread_cpu_s() - cpu) / wall_s * 100.0,
        messages as f64 / wall_s,
        simulation.truth().longest_stall_s * 1e3
    );
    simulation.stop();
    Ok(())
}
