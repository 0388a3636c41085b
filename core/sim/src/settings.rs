//! What a simulation is made of: how many vehicles, where they stand, how they are reached, and what disturbs them.

use crate::airframe::Airframe;
use crate::faces::Faces;
use crate::movers::Mover;
use crate::parameter_value::ParameterValue;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::{Geodetic, PositionNed};
use skein_sim_payloads::PayloadPlan;
use std::net::SocketAddr;

/// A simulation as it is started. The default is six vehicles, 5 m apart, on the ports of PX4's own simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimSettings {
    /// How many vehicles to place on the grid; ignored when `starts` is not empty.
    pub vehicles: usize,
    /// System id of the first vehicle; the others follow.
    pub first_system_id: u8,
    /// Everything random is drawn from this.
    pub seed: u64,
    /// Where the swarm frame lies, and the ground altitude about which the vehicles stand.
    pub origin: Geodetic,
    /// Distance between neighbours on the grid in metres.
    pub spacing_m: f64,
    /// Each place's ground is up to this much higher or lower than the origin, in metres (drawn from the seed).
    pub ground_relief_m: f64,
    /// Explicit places instead of the grid.
    pub starts: Vec<VehicleStart>,
    /// Which ways there are to reach the vehicles: with topics, a carrier has to be given to the simulation.
    pub faces: Faces,
    /// How they are reached over MAVLink.
    pub ports: PortPlan,
    /// Wind.
    pub wind: WindSettings,
    /// Errors of the position estimate.
    pub noise: NoiseSettings,
    /// Battery.
    pub battery: BatterySettings,
    /// Parameters that differ from the defaults, for every vehicle.
    pub parameters: Vec<(String, ParameterValue)>,
    /// Seconds of the simulation per second of this computer: PX4's own goes at some 0.98, and slower where the computer is busy.
    pub pace: f64,
    /// The autopilots say over MAVLink that they are a simulation, as PX4's software in the loop does; else they pass for hardware.
    pub says_simulated: bool,
    /// Seconds after its start at which a vehicle is ready to be armed (about; each differs a little).
    pub ready_after_s: f64,
    /// What kind of vehicles stand on the grid.
    pub airframe: Airframe,
    /// What each vehicle carries.
    pub payloads: PayloadPlan,
    /// Whether each vehicle has a second satellite receiver, which it tells of by GPS2_RAW.
    pub second_gnss: bool,
    /// Others that move about and tell of themselves, or are told of.
    pub movers: Vec<Mover>,
}

impl Default for SimSettings {
    fn default() -> Self {
        Self {
            vehicles: 6,
            first_system_id: 1,
            seed: 1,
            origin: Geodetic {
                latitude_deg: 47.397_742,
                longitude_deg: 8.545_594,
                altitude_amsl_m: 489.4,
            },
            spacing_m: 5.0,
            ground_relief_m: 0.0,
            starts: Vec::new(),
            faces: Faces::Mavlink,
            ports: PortPlan::Px4,
            wind: WindSettings::default(),
            noise: NoiseSettings::default(),
            battery: BatterySettings::default(),
            parameters: Vec::new(),
            pace: 1.0,
            says_simulated: false,
            ready_after_s: 3.9,
            airframe: Airframe::default(),
            payloads: PayloadPlan::default(),
            second_gnss: false,
            movers: Vec::new(),
        }
    }
}

impl SimSettings {
    /// As PX4's software in the loop has it with SIH and stock parameters: its pace, its airframe, and a battery that is half empty
    /// after 30 s of being armed and stays so.
    #[must_use]
    pub fn as_software_in_the_loop(self) -> Self {
        Self {
            pace: 0.98,
            says_simulated: true,
            airframe: Airframe::Sih,
            battery: BatterySettings {
                endurance_s: 60.0,
                floor: 0.5,
                full_when_disarmed: true,
                ..BatterySettings::default()
            },
            ..self
        }
    }

    /// The places the vehicles start from: the given ones, or a grid as near to a square as the number allows. For a mixed swarm,
    /// change what this gives and put it in [`Self::starts`].
    #[must_use]
    pub fn places(&self) -> Vec<VehicleStart> {
        if !self.starts.is_empty() {
            return self.starts.clone();
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let columns = (self.vehicles as f64).sqrt().ceil().max(1.0) as usize;
        (0..self.vehicles)
            .map(|i| {
                let (row, column) = (i / columns, i % columns);
                let relief = rng.random_range(-1.0..=1.0) * self.ground_relief_m;
                VehicleStart {
                    position: PositionNed::new(row as f64 * self.spacing_m, column as f64 * self.spacing_m, relief),
                    airframe: self.airframe,
                    ..VehicleStart::default()
                }
            })
            .collect()
    }
}

/// Where one vehicle stands when it is started.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleStart {
    /// Its system id; the next free one if left out. Two vehicles may be given the same one, as it happens in the field.
    pub system_id: Option<u8>,
    /// Its place about the simulation's origin; its height is that of the ground there.
    pub position: PositionNed,
    /// Yaw in radians, clockwise from north.
    pub yaw_rad: f64,
    /// What kind of vehicle it is.
    pub airframe: Airframe,
    /// Charge of its battery, 0..=1; that of the simulation's settings if left out.
    pub battery: Option<f64>,
    /// How it is reached; as the simulation's settings have it if left out.
    pub faces: Option<Faces>,
}

/// How vehicles are reached over MAVLink. Everything is on the loopback interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PortPlan {
    /// The ports of PX4's own simulation. Instance N is system id minus one. Onboard link: 14580+N sends to 14540+N (N > 9: to
    /// 14549). Ground-station link: 18570+N sends to 14550.
    #[default]
    Px4,
    /// The same with other base ports, so that several simulations can run side by side.
    Px4At(Px4Ports),
    /// Every vehicle binds a port of the system's choice and sends its onboard link to this address; no ground-station link.
    SendTo(SocketAddr),
}

/// Base ports of the PX4 plan: those of instance 0. A local port of 0 lets the system choose one per vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Px4Ports {
    /// Local port of the onboard link; instance N uses this plus N.
    pub onboard_local: u16,
    /// Where the onboard link sends to; instance N uses this plus N, from N = 10 on this plus 9.
    pub onboard_partner: u16,
    /// Local port of the ground-station link; instance N uses this plus N.
    pub ground_local: u16,
    /// Where all ground-station links send to.
    pub ground_partner: u16,
}

impl Default for Px4Ports {
    fn default() -> Self {
        Self {
            onboard_local: 14580,
            onboard_partner: 14540,
            ground_local: 18570,
            ground_partner: 14550,
        }
    }
}

/// Wind: a steady part and gusts about it, the same for all vehicles but for a small part of the gusts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindSettings {
    /// Steady wind along north in metres per second (towards north).
    pub mean_north_m_s: f64,
    /// Steady wind along east in metres per second (towards east).
    pub mean_east_m_s: f64,
    /// Standard deviation of the gusts along each horizontal axis, in metres per second.
    pub gust_m_s: f64,
    /// Time over which a gust dies out, in seconds.
    pub gust_time_s: f64,
}

impl Default for WindSettings {
    fn default() -> Self {
        Self {
            mean_north_m_s: 1.0,
            mean_east_m_s: -1.5,
            gust_m_s: 0.6,
            gust_time_s: 3.0,
        }
    }
}

impl WindSettings {
    /// No wind at all.
    pub const CALM: Self = Self {
        mean_north_m_s: 0.0,
        mean_east_m_s: 0.0,
        gust_m_s: 0.0,
        gust_time_s: 3.0,
    };
}

/// Errors of the position estimate: a slowly wandering offset and a small quick jitter, each vehicle's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseSettings {
    /// Standard deviation of the wandering offset along each horizontal axis in metres.
    pub wander_horizontal_m: f64,
    /// Standard deviation of the wandering offset of the altitude in metres.
    pub wander_vertical_m: f64,
    /// The wandering offset is never longer than this, horizontally and vertically, in metres.
    pub wander_limit_m: f64,
    /// Time over which the offset wanders, in seconds.
    pub wander_time_s: f64,
    /// Standard deviation of the quick jitter of the position along each axis in metres.
    pub jitter_m: f64,
    /// Standard deviation of the jitter of the velocity along each axis in metres per second.
    pub velocity_jitter_m_s: f64,
}

impl Default for NoiseSettings {
    fn default() -> Self {
        Self {
            wander_horizontal_m: 0.05,
            wander_vertical_m: 0.05,
            wander_limit_m: 0.12,
            wander_time_s: 40.0,
            jitter_m: 0.008,
            velocity_jitter_m_s: 0.02,
        }
    }
}

impl NoiseSettings {
    /// A perfect estimate.
    pub const NONE: Self = Self {
        wander_horizontal_m: 0.0,
        wander_vertical_m: 0.0,
        wander_limit_m: 0.0,
        wander_time_s: 40.0,
        jitter_m: 0.0,
        velocity_jitter_m_s: 0.0,
    };
}

/// Battery: drains at a constant rate while armed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatterySettings {
    /// Flight time from full to empty in seconds.
    pub endurance_s: f64,
    /// Charge at the start, 0..=1.
    pub initial: f64,
    /// It never goes below this charge, 0..=1 (PX4's own simulation stops at a half).
    pub floor: f64,
    /// Whoever is disarmed has a full one, as in PX4's own simulation.
    pub full_when_disarmed: bool,
}

impl Default for BatterySettings {
    fn default() -> Self {
        Self {
            endurance_s: 1500.0,
            initial: 1.0,
            floor: 0.05,
            full_when_disarmed: false,
        }
    }
}

/// What is done to one vehicle's datagrams, or to what its topics carry, in both directions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Impairment {
    /// Share of them lost, 0..=1.
    pub loss: f64,
    /// Delay of each in seconds.
    pub delay_s: f64,
    /// Further delay of each, drawn evenly from zero to this, in seconds.
    pub jitter_s: f64,
}
