//! The load generator's process: one thread, a tick of 1 ms, one socket a vehicle, one datagram a message.
//!
//! It is told on its standard input when a window begins (`b`) and ends (`e`), and answers an end with one line of JSON. The
//! end of its input ends it.

use crate::error::BenchError;
use crate::flyer::{Flyer, STREAMS, Sender};
use crate::gaps::GapLog;
use crate::report::LoadFigures;
use crate::wire::{AUTOPILOT_COMPONENT, DATAGRAM_BYTES, Encoder, Frame};
use mavlink::dialects::common::MavMessage;
use nix::cmsg_space;
use nix::errno::Errno;
use nix::sys::epoll::{Epoll, EpollCreateFlags, EpollEvent, EpollFlags, EpollTimeout};
use nix::sys::socket::{ControlMessageOwned, MsgFlags, SockaddrStorage, recvmsg, setsockopt, sockopt};
use nix::sys::time::{TimeSpec, TimeValLike};
use nix::sys::timerfd::{ClockId, Expiration, TimerFd, TimerFlags, TimerSetTimeFlags};
use serde::{Deserialize, Serialize};
use skein_domain::{Geodetic, LocalFrame, LocalPositionNed};
use std::io::{IoSliceMut, Read, Write};
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsRawFd;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// What the load generator is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadGeneratorSettings {
    /// How many vehicles.
    pub vehicles: u16,
    /// Where they send to.
    pub target: SocketAddr,
    /// System ids that no vehicle has, since the program uses them itself.
    pub reserved_system_ids: Vec<u8>,
}

/// Distance between two vehicles on the ground in metres.
const SPACING_M: f64 = 10.0;
/// Where they stand.
const FIELD: Geodetic = Geodetic {
    latitude_deg: 47.397_742,
    longitude_deg: 8.545_594,
    altitude_amsl_m: 488.0,
};
const TICK: Duration = Duration::from_millis(1);
/// Marks of what is not a vehicle's socket.
const TIMER: u64 = u64::MAX;
const INPUT: u64 = u64::MAX - 1;

/// One vehicle with its socket and when its streams are due.
struct Post {
    flyer: Flyer,
    socket: UdpSocket,
    encoder: Encoder,
    due_s: [f64; STREAMS.len()],
}

/// Runs the load generator until its standard input ends. `settings` is [`LoadGeneratorSettings`] as JSON.
///
/// # Errors
/// When the settings do not parse or a system call fails.
pub fn run_load_generator(settings: &str) -> Result<(), BenchError> {
    let settings: LoadGeneratorSettings = serde_json::from_str(settings).map_err(BenchError::Settings)?;
    let mut generator = Generator::new(&settings)?;
    generator.run()
}

struct Generator {
    posts: Vec<Post>,
    epoll: Epoll,
    timer: TimerFd,
    gaps: GapLog,
    started: Instant,
    window_started: Instant,
    next_tick: Instant,
    sent: u64,
    not_sent: u64,
    misaddressed_before: u64,
    ticks: u64,
    late_ticks: u64,
    control: Vec<u8>,
}

impl Generator {
    fn new(settings: &LoadGeneratorSettings) -> Result<Self, BenchError> {
        let ids: Vec<u8> = (1..=250)
            .filter(|id| !settings.reserved_system_ids.contains(id))
            .collect();
        let count = usize::from(settings.vehicles);
        if count == 0 || count > ids.len() {
            return Err(BenchError::Argument(format!(
                "{count} vehicles: 1 to {} are possible",
                ids.len()
            )));
        }
        let epoll = Epoll::new(EpollCreateFlags::EPOLL_CLOEXEC).map_err(BenchError::system("epoll"))?;
        let watch = |fd: &dyn std::os::fd::AsFd, mark| {
            epoll
                .add(fd.as_fd(), EpollEvent::new(EpollFlags::EPOLLIN, mark))
                .map_err(BenchError::system("epoll"))
        };
        let posts = ids
            .iter()
            .take(count)
            .enumerate()
            .map(|(i, id)| post(i, *id, settings.target));
        let posts: Vec<Post> = posts.collect::<Result<_, _>>()?;
        for (mark, post) in (0..).zip(&posts) {
            watch(&post.socket, mark)?;
        }
        let timer =
            TimerFd::new(ClockId::CLOCK_MONOTONIC, TimerFlags::TFD_NONBLOCK).map_err(BenchError::system("timer"))?;
        let every = Expiration::Interval(TimeSpec::from_duration(TICK));
        timer
            .set(every, TimerSetTimeFlags::empty())
            .map_err(BenchError::system("timer"))?;
        watch(&timer, TIMER)?;
        Ok(Self {
            gaps: GapLog::new(posts.len()),
            posts,
            epoll,
            timer,
            started: Instant::now(),
            window_started: Instant::now(),
            next_tick: Instant::now() + TICK,
            sent: 0,
            not_sent: 0,
            misaddressed_before: 0,
            ticks: 0,
            late_ticks: 0,
            control: cmsg_space!(TimeSpec),
        })
    }

    fn run(&mut self) -> Result<(), BenchError> {
        let input = EpollEvent::new(EpollFlags::EPOLLIN, INPUT);
        self.epoll
            .add(std::io::stdin(), input)
            .map_err(BenchError::system("epoll"))?;
        while self.turn()? {}
        Ok(())
    }

    /// Waits for what comes next and does it; false at the end of the input.
    fn turn(&mut self) -> Result<bool, BenchError> {
        let mut events = [EpollEvent::empty(); 64];
        let ready = match self.epoll.wait(&mut events, EpollTimeout::NONE) {
            Err(Errno::EINTR) => 0,
            other => other.map_err(BenchError::system("epoll"))?,
        };
        for event in events.iter().take(ready) {
            match event.data() {
                TIMER => {
                    self.timer.wait().map_err(BenchError::system("timer"))?;
                    let now = Instant::now();
                    self.ticks += 1;
                    self.late_ticks += u64::from(now > self.next_tick + TICK);
                    self.next_tick = now + TICK;
                    self.send_due();
                }
                INPUT if !self.input()? => return Ok(false),
                INPUT => {}
                vehicle => self.receive(vehicle as usize)?,
            }
        }
        Ok(true)
    }

    /// Sends everything that is due by now: a late tick is made up for at once.
    fn send_due(&mut self) {
        let now_s = self.started.elapsed().as_secs_f64();
        for post in &mut self.posts {
            for ((stream, rate_hz), due_s) in STREAMS.iter().zip(&mut post.due_s) {
                while *due_s <= now_s {
                    *due_s += 1.0 / rate_hz;
                    post.flyer.move_to(now_s);
                    let message = post.flyer.telemetry(*stream, now_s);
                    let taken = post.encoder.encode(&message, |bytes| post.socket.send(bytes)).is_ok();
                    self.sent += u64::from(taken);
                    self.not_sent += u64::from(!taken);
                }
            }
        }
    }

    /// Reads all that has come for a vehicle.
    fn receive(&mut self, vehicle: usize) -> Result<(), BenchError> {
        let Some(post) = self.posts.get_mut(vehicle) else {
            return Ok(());
        };
        let mut bytes = [0; DATAGRAM_BYTES];
        loop {
            let mut parts = [IoSliceMut::new(&mut bytes)];
            let fd = post.socket.as_raw_fd();
            let received = recvmsg::<SockaddrStorage>(fd, &mut parts, Some(&mut self.control), MsgFlags::MSG_DONTWAIT);
            let (length, stamp_ns) = match received {
                Ok(message) => {
                    let stamps = message.cmsgs().map_err(BenchError::system("receive stamp"))?;
                    let stamp_ns = stamps.into_iter().find_map(|part| match part {
                        ControlMessageOwned::ScmTimestampns(stamp) => Some(stamp.num_nanoseconds()),
                        _ => None,
                    });
                    (message.bytes, stamp_ns)
                }
                Err(Errno::EAGAIN) => return Ok(()),
                // Nobody listens at the target (yet, or any more): the error of an earlier send.
                Err(Errno::ECONNREFUSED | Errno::EINTR) => continue,
                Err(other) => return Err(BenchError::system("receive")(other)),
            };
            let Some(frame) = bytes.get(..length).and_then(Frame::of) else {
                continue;
            };
            match frame.message() {
                Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(setpoint)) if post.flyer.setpoint(&setpoint) => {
                    self.gaps.received(vehicle, stamp_ns.unwrap_or_else(wall_ns));
                }
                Some(message) => {
                    let from = Sender {
                        system_id: frame.system_id,
                        component_id: frame.component_id,
                    };
                    let now_s = self.started.elapsed().as_secs_f64();
                    for answer in post.flyer.on_message(&message, from, now_s) {
                        // An answer that is lost is asked for again.
                        let _ = post.encoder.encode(&answer, |bytes| post.socket.send(bytes));
                    }
                }
                None => {}
            }
        }
    }

    /// Reads orders; false at the end of the input.
    fn input(&mut self) -> Result<bool, BenchError> {
        let mut bytes = [0; 64];
        let length = std::io::stdin()
            .read(&mut bytes)
            .map_err(BenchError::system("standard input"))?;
        for order in bytes.iter().take(length) {
            match order {
                b'b' => self.begin(),
                b'e' => self.end()?,
                _ => {}
            }
        }
        Ok(length > 0)
    }

    fn misaddressed(&self) -> u64 {
        self.posts.iter().map(|post| post.flyer.misaddressed()).sum()
    }

    fn begin(&mut self) {
        self.gaps.begin();
        self.window_started = Instant::now();
        (self.sent, self.not_sent, self.ticks, self.late_ticks) = (0, 0, 0, 0);
        self.misaddressed_before = self.misaddressed();
    }

    fn end(&self) -> Result<(), BenchError> {
        let line = serde_json::to_string(&self.figures()).map_err(BenchError::Settings)?;
        let mut out = std::io::stdout().lock();
        writeln!(out, "{line}")
            .and_then(|()| out.flush())
            .map_err(BenchError::system("standard output"))
    }

    /// The figures of the window up to now.
    fn figures(&self) -> LoadFigures {
        let window_s = self.window_started.elapsed().as_secs_f64();
        let per_vehicle = |count: f64| count / window_s / self.posts.len() as f64;
        LoadFigures {
            window_s,
            telemetry_hz_per_vehicle: per_vehicle(self.sent as f64),
            setpoint_hz_per_vehicle: per_vehicle(self.gaps.count() as f64),
            vehicles_streaming: self.gaps.streaming(),
            misaddressed: self.misaddressed() - self.misaddressed_before,
            not_sent: self.not_sent,
            late_ticks_percent: 100.0 * self.late_ticks as f64 / (self.ticks.max(1)) as f64,
            gaps: self.gaps.figures(wall_ns()),
        }
    }
}

/// The clock of receive stamps.
fn wall_ns() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(now.as_nanos()).unwrap_or(i64::MAX)
}

fn post(index: usize, system_id: u8, target: SocketAddr) -> Result<Post, BenchError> {
    let socket = UdpSocket::bind((target.ip(), 0)).map_err(BenchError::system("bind"))?;
    socket.connect(target).map_err(BenchError::system("connect"))?;
    setsockopt(&socket, sockopt::ReceiveTimestampns, &true).map_err(BenchError::system("receive stamps"))?;
    let (row, column) = (index / 16, index % 16);
    let field = LocalFrame { origin: FIELD };
    let place = field.geodetic(&LocalPositionNed::new(
        row as f64 * SPACING_M,
        column as f64 * SPACING_M,
        0.0,
    ));
    // Golden-ratio steps spread the vehicles and their streams evenly over time.
    let phase = |stream: usize| ((index * STREAMS.len() + stream) as f64 * 0.618_033_988_75).fract();
    let mut due_s = [0.0; STREAMS.len()];
    for (stream, (due_s, (_, rate_hz))) in due_s.iter_mut().zip(STREAMS).enumerate() {
        *due_s = phase(stream) / rate_hz;
    }
    Ok(Post {
        flyer: Flyer::new(system_id, place),
        socket,
        encoder: Encoder::new(system_id, AUTOPILOT_COMPONENT),
        due_s,
    })
}

#[cfg(test)]
mod tests;
