//! The simulation's thread: keeps step with real time, moves datagrams and topics, obeys orders, publishes the truth.

use super::air::{Air, Delayed, Parcel, take_due};
use super::ports::{Sockets, Voice};
use crate::faces::{Face, Faces};
use crate::faults::Fault;
use crate::movers::Scripted;
use crate::settings::{Impairment, SimSettings, WindSettings};
use crate::stalls::{self, StallProbe};
use crate::topics::TopicCarrier;
use crate::truth::{TruthFrame, VehicleTruth};
use crate::vehicle::{Outbox, SimVehicle, VehicleIdentity};
use crate::wind::Wind;
use nalgebra::Vector3;
use parking_lot::Mutex;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::FlightMode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

/// A referee.
pub(super) type Observer = Box<dyn FnMut(&TruthFrame) + Send>;

/// What the thread is told to do.
pub(super) enum Order {
    Add(Box<VehicleIdentity>, Faces, Sockets),
    Kill(u8),
    PilotMode(u8, FlightMode),
    Reboot(u8),
    Impair(u8, Face, Impairment),
    Inflict(u8, Fault),
    Wind(WindSettings),
    Observe(Observer),
    Stop,
}

/// Length of a step in seconds, with few vehicles and with many.
const STEP_S: f64 = 0.004;
const STEP_OF_MANY_S: f64 = 0.008;
const MANY: usize = 24;
/// The truth is published this often, in seconds.
const PUBLISH_S: f64 = 0.02;
/// When real time has run away by more than this, the simulation lets it go, in seconds.
const GIVE_UP_S: f64 = 1.0;
/// Datagrams read from one link, and what is taken from one vehicle's topics, in one step at most: a flood must not stop the others.
const READ_LIMIT: usize = 64;

/// One vehicle on the thread.
struct Slot {
    vehicle: SimVehicle,
    /// Gone once killed.
    sockets: Option<Sockets>,
    last_truth: Option<VehicleTruth>,
    of_mavlink: Impairment,
    of_topics: Impairment,
    delayed: Vec<Delayed>,
}

/// What the vehicles of one step have in common.
struct Around<'a> {
    carrier: Option<&'a dyn TopicCarrier>,
    rng: &'a mut ChaCha8Rng,
    outbox: &'a mut Outbox,
    buffer: &'a mut [u8],
    now_s: f64,
}

/// The thread's state.
pub(super) struct Runner {
    settings: SimSettings,
    inbox: Receiver<Order>,
    truth: Arc<Mutex<Arc<TruthFrame>>>,
    slots: Vec<Slot>,
    movers: Vec<(Scripted, Voice)>,
    carrier: Option<Arc<dyn TopicCarrier>>,
    observers: Vec<Observer>,
    wind: Wind,
    rng: ChaCha8Rng,
    time_s: f64,
    /// When the simulation's time was zero, had it always kept step since.
    zero: Instant,
    published_s: f64,
    sequence: u64,
    stalls: StallProbe,
    stalled_s: f64,
    /// Part of the stalls that is no part of the simulation's time, in seconds.
    let_go_s: f64,
    stopped: bool,
    outbox: Outbox,
    buffer: Vec<u8>,
}

impl Runner {
    pub(super) fn new(
        settings: &SimSettings,
        movers: Vec<(Scripted, Voice)>,
        carrier: Option<Arc<dyn TopicCarrier>>,
        inbox: Receiver<Order>,
        truth: Arc<Mutex<Arc<TruthFrame>>>,
        stalls: StallProbe,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        Self {
            wind: Wind::new(&settings.wind, &mut rng),
            settings: settings.clone(),
            inbox,
            truth,
            slots: Vec::new(),
            movers,
            carrier,
            observers: Vec::new(),
            rng,
            time_s: 0.0,
            zero: Instant::now(),
            published_s: 0.0,
            sequence: 0,
            stalls,
            stalled_s: 0.0,
            let_go_s: 0.0,
            stopped: false,
            outbox: Outbox::default(),
            buffer: vec![0; 2048],
        }
    }

    /// Runs until told to stop.
    pub(super) fn run(mut self) {
        self.zero = Instant::now() - Duration::from_secs_f64(self.time_s);
        while !self.stopped {
            let step_s = self.step_s();
            let woke = Instant::now();
            let late_s = (woke - self.zero).as_secs_f64() - self.time_s - step_s;
            if late_s < 0.0 {
                std::thread::sleep(Duration::from_secs_f64(-late_s));
                continue;
            }
            let late = Duration::from_secs_f64(late_s);
            let stalled = late > stalls::LATE;
            if stalled {
                self.stalls.add(woke - late, woke);
            }
            if late_s > GIVE_UP_S {
                self.let_go(late);
            }
            self.take_orders();
            // The first step reads all that came in the meantime.
            self.step(step_s);
            if stalled {
                let behind_s = self.zero.elapsed().as_secs_f64() - self.time_s;
                self.catch_up(behind_s.min(GIVE_UP_S));
            }
        }
    }

    /// With many vehicles a longer step saves half of the work and is still ten times shorter than any of their lags.
    fn step_s(&self) -> f64 {
        if self.slots.len() > MANY {
            STEP_OF_MANY_S
        } else {
            STEP_S
        }
    }

    /// Time that is never caught up on. A gap of the simulation's time has none of it, so a stall in it is not taken off the gap either.
    fn let_go(&mut self, late: Duration) {
        let before_s = self.stalled_until_now_s();
        self.zero += late;
        self.let_go_s += self.stalled_until_now_s() - before_s;
    }

    /// The stalls until the moment that the simulation has come to, in seconds. While it catches up that moment is not now: setpoints
    /// that came during a stall of its own are taken at the stall's beginning, and the gap that follows has the stall in it.
    fn stalled_until_now_s(&self) -> f64 {
        let at = self.zero + Duration::from_secs_f64(self.time_s);
        self.stalls.until(at).as_secs_f64() - self.let_go_s
    }

    /// Real time goes on by more or less than the step, where the simulation has a pace of its own.
    fn keep_pace(&mut self, dt_s: f64) {
        let more_s = dt_s * (1.0 / self.settings.pace - 1.0);
        if more_s > 0.0 {
            self.zero += Duration::from_secs_f64(more_s);
        } else {
            self.zero -= Duration::from_secs_f64(-more_s);
        }
    }

    fn catch_up(&mut self, behind_s: f64) {
        let step_s = self.step_s();
        for _ in 0..(behind_s / step_s) as usize {
            self.step(step_s);
        }
    }

    /// One step of everything.
    fn step(&mut self, dt_s: f64) {
        let wind = self.wind.step(dt_s, &mut self.rng);
        self.time_s += dt_s;
        self.keep_pace(dt_s);
        self.stalled_s = self.stalled_until_now_s();
        let mut around = Around {
            carrier: self.carrier.as_deref(),
            rng: &mut self.rng,
            outbox: &mut self.outbox,
            buffer: &mut self.buffer,
            now_s: self.time_s,
        };
        for slot in &mut self.slots {
            slot.vehicle.note_stalls(self.stalled_s);
            slot.step(&mut around, dt_s, &wind);
        }
        if let Some(carrier) = &self.carrier {
            carrier.step_done();
        }
        for (mover, voice) in &mut self.movers {
            if let Some(frame) = mover.report(self.time_s) {
                voice.send(&frame);
            }
        }
        if self.time_s - self.published_s >= PUBLISH_S - 1e-9 {
            self.published_s = self.time_s;
            self.publish();
        }
    }

    /// Makes the truth known.
    pub(super) fn publish(&mut self) {
        self.sequence += 1;
        let vehicles = self
            .slots
            .iter()
            .map(|slot| slot.last_truth.clone().unwrap_or_else(|| slot.vehicle.truth()))
            .collect();
        let frame = Arc::new(TruthFrame {
            time_s: self.time_s,
            sequence: self.sequence,
            vehicles,
            movers: self.movers.iter().map(|(mover, _)| mover.truth(self.time_s)).collect(),
            longest_stall_s: self.stalls.longest().as_secs_f64(),
        });
        for slot in &mut self.slots {
            slot.vehicle.forget_recent_gap();
        }
        *self.truth.lock() = frame.clone();
        for observer in &mut self.observers {
            observer(&frame);
        }
    }

    /// Does what has been ordered.
    pub(super) fn take_orders(&mut self) {
        loop {
            match self.inbox.try_recv() {
                Ok(order) => self.obey(order),
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.stopped = true;
                    return;
                }
            }
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Add(mut identity, faces, sockets) => {
                identity.started_s = self.time_s;
                let settings = SimSettings {
                    faces,
                    ..self.settings.clone()
                };
                let mut vehicle = SimVehicle::new(*identity, &settings);
                vehicle.note_stalls(self.stalled_s);
                self.slots.push(Slot {
                    vehicle,
                    sockets: Some(sockets),
                    last_truth: None,
                    of_mavlink: Impairment::default(),
                    of_topics: Impairment::default(),
                    delayed: Vec::new(),
                });
            }
            Order::Kill(id) => self.each_with(id, |slot, carrier| {
                slot.sockets = None;
                if let Some(carrier) = carrier {
                    carrier.leave(slot.vehicle.number());
                }
                slot.last_truth = Some(VehicleTruth {
                    alive: false,
                    ..slot.vehicle.truth()
                });
            }),
            Order::PilotMode(id, mode) => self.each(id, |slot| slot.vehicle.pilot_mode(mode)),
            Order::Reboot(id) => self.each(id, |slot| slot.vehicle.reboot()),
            Order::Impair(id, Face::Mavlink, impairment) => self.each(id, |slot| slot.of_mavlink = impairment),
            Order::Impair(id, Face::Dds, impairment) => self.each(id, |slot| slot.of_topics = impairment),
            Order::Inflict(id, fault) => self.each(id, |slot| slot.vehicle.inflict(fault)),
            Order::Wind(wind) => self.wind.change(&wind),
            Order::Observe(observer) => self.observers.push(observer),
            Order::Stop => self.stopped = true,
        }
    }

    /// Every living vehicle with this system id: as a rule one.
    fn each(&mut self, system_id: u8, mut work: impl FnMut(&mut Slot)) {
        self.each_with(system_id, |slot, _| work(slot));
    }

    fn each_with(&mut self, system_id: u8, mut work: impl FnMut(&mut Slot, Option<&dyn TopicCarrier>)) {
        let carrier = self.carrier.as_deref();
        self.slots
            .iter_mut()
            .filter(|slot| slot.sockets.is_some() && slot.vehicle.system_id() == system_id)
            .for_each(|slot| work(slot, carrier));
    }
}

impl Slot {
    /// Lets the vehicle hear, fly and speak for one step.
    fn step(&mut self, around: &mut Around<'_>, dt_s: f64, wind_m_s: &Vector3<f64>) {
        let Some(sockets) = &self.sockets else { return };
        let kept = (1.0 - self.of_mavlink.loss) * (1.0 - self.vehicle.radio_loss());
        let now_s = around.now_s;
        let mavlink = Air {
            impairment: Impairment {
                loss: 1.0 - kept,
                ..self.of_mavlink
            },
            now_s,
        };
        let topics = Air {
            impairment: self.of_topics,
            now_s,
        };
        let number = self.vehicle.number();
        for (link, wire) in sockets.links() {
            for _ in 0..READ_LIMIT {
                let Some(datagram) = wire.receive(around.buffer) else {
                    break;
                };
                let parcel = || Parcel::Inbound(link, datagram.to_vec());
                if mavlink.passes(parcel, &mut self.delayed, around.rng) {
                    self.vehicle.receive(link, datagram, around.outbox);
                }
            }
        }
        if let Some(carrier) = around.carrier {
            for _ in 0..READ_LIMIT {
                let Some(asked) = carrier.take(number) else { break };
                if topics.passes(|| Parcel::Asked(asked), &mut self.delayed, around.rng) {
                    self.vehicle.receive_topic(&asked, around.outbox);
                }
            }
        }
        for late in take_due(&mut self.delayed, now_s) {
            match (late, around.carrier) {
                (Parcel::Inbound(link, bytes), _) => self.vehicle.receive(link, &bytes, around.outbox),
                (Parcel::Outbound(link, bytes), _) => sockets.send(link, &bytes),
                (Parcel::Asked(asked), _) => self.vehicle.receive_topic(&asked, around.outbox),
                (Parcel::Published(published), Some(carrier)) => carrier.publish(number, &published),
                (Parcel::Published(_), None) => {}
            }
        }
        self.vehicle.step(dt_s, wind_m_s, around.outbox);
        for (link, frame) in around.outbox.frames() {
            let parcel = || Parcel::Outbound(link, frame.to_vec());
            if mavlink.passes(parcel, &mut self.delayed, around.rng) {
                sockets.send(link, frame);
            }
        }
        for published in around.outbox.published() {
            if let Some(carrier) = around.carrier
                && topics.passes(|| Parcel::Published(*published), &mut self.delayed, around.rng)
            {
                carrier.publish(number, published);
            }
        }
        around.outbox.clear();
    }
}

#[cfg(test)]
mod tests;
