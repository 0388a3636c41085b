//! Many vehicles in real time on their own thread, each behind its own UDP ports on the loopback interface, or behind the carrier of its
//! topics.
//!
//! Must never do: decide anything about a flight; that is [`crate::vehicle`]'s.

mod air;
mod ports;
mod runner;

use crate::faces::Face;
use crate::faults::Fault;
use crate::movers::{Mover, Scripted};
use crate::settings::{Impairment, SimSettings, VehicleStart, WindSettings};
use crate::stalls::StallProbe;
use crate::topics::{CarrierError, TopicCarrier};
use crate::truth::TruthFrame;
use crate::vehicle::VehicleIdentity;
use parking_lot::Mutex;
use ports::{Sockets, Voice};
use runner::{Observer, Order, Runner};
use skein_domain::FlightMode;
use skein_realtime::Precedence;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::thread::JoinHandle;

/// Why a simulation could not be started, or what was asked of it could not be done.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// A port could not be had.
    #[error("cannot bind {address} for simulated vehicle {system_id}: {source}")]
    Bind {
        /// The vehicle it is for.
        system_id: u8,
        /// The port.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// There are only 255 system ids.
    #[error("no system id is left for another vehicle: 1 to 255 are taken")]
    NoSystemIdLeft,
    /// The vehicle's port number would not fit.
    #[error("system id {system_id} leads to port {port}, which does not exist")]
    NoSuchPort {
        /// The vehicle.
        system_id: u8,
        /// The number.
        port: u32,
    },
    /// A vehicle is to have topics, but nobody was given that would carry them.
    #[error("simulated vehicle {0} has topics, and nobody carries them")]
    NoCarrier(u8),
    /// A vehicle's topics cannot be had.
    #[error("simulated vehicle {system_id} has no topics: {source}")]
    Topics {
        /// The vehicle.
        system_id: u8,
        /// Why.
        source: CarrierError,
    },
    /// The thread could not be started.
    #[error("cannot start the simulation's thread: {0}")]
    Thread(std::io::Error),
    /// No living vehicle has this system id.
    #[error("no simulated vehicle has system id {0}")]
    UnknownVehicle(u8),
    /// The simulation has ended.
    #[error("the simulation has ended")]
    Ended,
}

/// How one vehicle is reached over MAVLink.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VehiclePorts {
    /// Its system id.
    pub system_id: u8,
    /// Its own end of the onboard link.
    pub onboard: SocketAddr,
    /// Where the onboard link sends to.
    pub onboard_partner: SocketAddr,
    /// Its own end of the ground-station link and where that sends to.
    pub ground: Option<(SocketAddr, SocketAddr)>,
}

/// What the caller's side knows of the vehicles.
#[derive(Debug, Default)]
struct Roll {
    vehicles: Vec<Enlisted>,
    started: u64,
}

impl Roll {
    fn has(&self, system_id: u8) -> bool {
        self.vehicles.iter().any(|v| v.system_id == system_id)
    }
}

/// A living vehicle.
#[derive(Debug, Clone, Copy)]
struct Enlisted {
    system_id: u8,
    ports: Option<VehiclePorts>,
}

/// A running simulation. Dropping it stops it.
pub struct Simulation {
    settings: SimSettings,
    truth: Arc<Mutex<Arc<TruthFrame>>>,
    roll: Mutex<Roll>,
    orders: Sender<Order>,
    carrier: Option<Arc<dyn TopicCarrier>>,
    thread: Option<JoinHandle<()>>,
    utc_at_zero_us: u64,
}

impl std::fmt::Debug for Simulation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Simulation")
            .field("vehicles", &self.roll.lock().vehicles.len())
            .finish_non_exhaustive()
    }
}

impl Simulation {
    /// Binds all ports and starts the vehicles on a thread of their own.
    ///
    /// # Errors
    /// When a port is taken, or there are more vehicles than system ids.
    pub fn start(settings: SimSettings) -> Result<Self, SimError> {
        Self::start_with(settings, None)
    }

    /// The same with somebody who carries the topics of those vehicles that have any.
    ///
    /// # Errors
    /// As [`Self::start`]; and when topics cannot be had, or there is nobody who would carry them.
    pub fn start_with(settings: SimSettings, carrier: Option<Arc<dyn TopicCarrier>>) -> Result<Self, SimError> {
        let truth = Arc::new(Mutex::new(Arc::default()));
        let (orders, inbox) = std::sync::mpsc::channel();
        let utc = std::time::SystemTime::now()
            .duration_since(std::time::UNIX_EPOCH)
            .unwrap_or_default();
        let mut simulation = Self {
            truth: truth.clone(),
            roll: Mutex::default(),
            orders,
            carrier,
            thread: None,
            utc_at_zero_us: utc.as_micros() as u64,
            settings,
        };
        for start in simulation.settings.places() {
            simulation.enlist(start)?;
        }
        let movers = voices(&simulation.settings)?;
        let stalls = StallProbe::start().map_err(SimError::Thread)?;
        let carrier = simulation.carrier.clone();
        let mut runner = Runner::new(&simulation.settings, movers, carrier, inbox, truth, stalls);
        runner.take_orders();
        runner.publish();
        let thread = std::thread::Builder::new().name("skein-sim".to_owned()).spawn(move || {
            skein_realtime::ask(Precedence::Control);
            runner.run();
        });
        simulation.thread = Some(thread.map_err(SimError::Thread)?);
        Ok(simulation)
    }

    /// Binds a vehicle's ports, has its topics carried, and hands it to the thread.
    fn enlist(&self, start: VehicleStart) -> Result<u8, SimError> {
        let mut roll = self.roll.lock();
        let system_id = match start.system_id {
            Some(id) => id,
            None => free_system_id(|id| roll.has(id), self.settings.first_system_id).ok_or(SimError::NoSystemIdLeft)?,
        };
        let faces = start.faces.unwrap_or(self.settings.faces);
        let sockets = if faces.has(Face::Mavlink) {
            Sockets::bind(&self.settings.ports, system_id)?
        } else {
            Sockets::NONE
        };
        if faces.has(Face::Dds) {
            let carrier = self.carrier.as_ref().ok_or(SimError::NoCarrier(system_id))?;
            let entered = carrier.enter(roll.started, system_id);
            entered.map_err(|source| SimError::Topics { system_id, source })?;
        }
        let ports = sockets.ports(system_id);
        let identity = VehicleIdentity {
            system_id,
            position: start.position,
            yaw_rad: start.yaw_rad,
            airframe: start.airframe,
            battery: start.battery,
            number: roll.started,
            ground_link: ports.is_some_and(|p| p.ground.is_some()),
            started_s: 0.0,
            utc_at_zero_us: self.utc_at_zero_us,
        };
        self.order(Order::Add(Box::new(identity), faces, sockets))?;
        roll.started += 1;
        roll.vehicles.push(Enlisted { system_id, ports });
        Ok(system_id)
    }

    fn order(&self, order: Order) -> Result<(), SimError> {
        self.orders.send(order).map_err(|_| SimError::Ended)
    }

    /// For a vehicle that has to exist.
    fn order_for(&self, system_id: u8, order: Order) -> Result<(), SimError> {
        if !self.roll.lock().has(system_id) {
            return Err(SimError::UnknownVehicle(system_id));
        }
        self.order(order)
    }

    /// What is really the case, at most 20 ms old.
    #[must_use]
    pub fn truth(&self) -> Arc<TruthFrame> {
        self.truth.lock().clone()
    }

    /// Has a referee called 50 times a second from the simulation's thread. It should be quick.
    ///
    /// # Errors
    /// When the simulation has ended.
    pub fn observe(&self, observer: Observer) -> Result<(), SimError> {
        self.order(Order::Observe(observer))
    }

    /// How the vehicles with MAVLink are reached, in the order of their start; killed ones are not among them.
    #[must_use]
    pub fn ports(&self) -> Vec<VehiclePorts> {
        self.roll.lock().vehicles.iter().filter_map(|v| v.ports).collect()
    }

    /// System ids of all vehicles, in the order of their start; killed ones are not among them.
    #[must_use]
    pub fn system_ids(&self) -> Vec<u8> {
        self.roll.lock().vehicles.iter().map(|v| v.system_id).collect()
    }

    /// A vehicle vanishes: from now on it sends and answers nothing, and its ports are free.
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn kill(&self, system_id: u8) -> Result<(), SimError> {
        self.order_for(system_id, Order::Kill(system_id))?;
        self.roll.lock().vehicles.retain(|v| v.system_id != system_id);
        Ok(())
    }

    /// Another vehicle is switched on; gives its system id.
    ///
    /// # Errors
    /// When its port is taken or no system id is left.
    pub fn add(&self, start: VehicleStart) -> Result<u8, SimError> {
        self.enlist(start)
    }

    /// The pilot of a vehicle takes a mode by radio control.
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn pilot_mode(&self, system_id: u8, mode: FlightMode) -> Result<(), SimError> {
        self.order_for(system_id, Order::PilotMode(system_id, mode))
    }

    /// A vehicle's autopilot starts anew, wherever it is.
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn reboot(&self, system_id: u8) -> Result<(), SimError> {
        self.order_for(system_id, Order::Reboot(system_id))
    }

    /// What comes from a vehicle and goes to it is lost or delayed from now on, on all its faces.
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn impair(&self, system_id: u8, impairment: Impairment) -> Result<(), SimError> {
        self.impair_face(system_id, Face::Mavlink, impairment)?;
        self.impair_face(system_id, Face::Dds, impairment)
    }

    /// The same on one of its faces alone. To cut a face, inflict [`Fault::Cut`].
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn impair_face(&self, system_id: u8, face: Face, impairment: Impairment) -> Result<(), SimError> {
        self.order_for(system_id, Order::Impair(system_id, face, impairment))
    }

    /// Something goes wrong with a vehicle, or is mended.
    ///
    /// # Errors
    /// When there is no such vehicle.
    pub fn inflict(&self, system_id: u8, fault: Fault) -> Result<(), SimError> {
        self.order_for(system_id, Order::Inflict(system_id, fault))
    }

    /// The wind is another from now on, for all vehicles.
    ///
    /// # Errors
    /// When the simulation has ended.
    pub fn set_wind(&self, wind: WindSettings) -> Result<(), SimError> {
        self.order(Order::Wind(wind))
    }

    /// Ends the simulation and waits for its thread.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        let _ = self.orders.send(Order::Stop);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the simulation's thread panicked");
        }
    }
}

impl Drop for Simulation {
    fn drop(&mut self) {
        self.end();
    }
}

/// The movers, each with its way out.
fn voices(settings: &SimSettings) -> Result<Vec<(Scripted, Voice)>, SimError> {
    let voice = |mover: &Mover| {
        let voice = Voice::open(&settings.ports, mover.to)?;
        Ok((Scripted::new(mover.clone(), settings.origin), voice))
    };
    settings.movers.iter().map(voice).collect()
}

/// The lowest system id from `first` on that no living vehicle has.
fn free_system_id(is_taken: impl Fn(u8) -> bool, first: u8) -> Option<u8> {
    let is_free = |id: &u8| !is_taken(*id);
    (first.max(1)..=u8::MAX)
        .find(is_free)
        .or_else(|| (1..first.max(1)).find(is_free))
}

#[cfg(test)]
mod tests;
