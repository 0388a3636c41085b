//! Flown by topics alone: rates, answers, OFFBOARD with what keeps it alive, and cut faces.

use super::rig::{STEP_S, identity, quiet};
use crate::settings::SimSettings;
use crate::topics::{
    Asked, AskedCommand, AskedMode, AskedSetpoint, CommandAnswer, LocalReport, Published, StatusReport,
};
use crate::truth::{ModeCause, VehicleTruth};
use crate::vehicle::{Outbox, SimVehicle};
use crate::{Face, Faces, Fault};
use nalgebra::Vector3;
use skein_domain::FlightMode;

const ACCEPTED: Option<u8> = Some(0);
const REJECTED: Option<u8> = Some(1);
const NAN: Vector3<f64> = Vector3::new(f64::NAN, f64::NAN, f64::NAN);

/// What is streamed, twenty times a second.
#[derive(Debug, Clone, Copy)]
struct Stream {
    mode: Option<AskedMode>,
    setpoint: Option<AskedSetpoint>,
}

struct Bench {
    vehicle: SimVehicle,
    out: Outbox,
    time_s: f64,
    heard: Vec<(f64, Published)>,
    frames: usize,
    stream: Option<Stream>,
    next_stream_s: f64,
}

fn settings(faces: Faces) -> SimSettings {
    SimSettings { faces, ..quiet() }
}

fn to(position_m: Vector3<f64>) -> AskedSetpoint {
    AskedSetpoint {
        position_m,
        velocity_m_s: NAN,
        acceleration_m_s2: NAN,
        yaw_rad: f64::NAN,
        yaw_rate_rad_s: f64::NAN,
    }
}

/// Stamped when it is received.
fn alive() -> AskedMode {
    AskedMode {
        stamp_us: 0,
        follows: true,
    }
}

impl Bench {
    fn of(faces: Faces) -> Self {
        let mut bench = Self {
            vehicle: SimVehicle::new(identity(), &settings(faces)),
            out: Outbox::default(),
            time_s: 0.0,
            heard: Vec::new(),
            frames: 0,
            stream: None,
            next_stream_s: 0.0,
        };
        bench.run(5.0);
        bench
    }

    fn ask(&mut self, asked: Asked) {
        self.vehicle.receive_topic(&asked, &mut self.out);
        self.collect();
    }

    fn step(&mut self) {
        if let Some(stream) = self.stream
            && self.time_s >= self.next_stream_s
        {
            self.next_stream_s = self.time_s + 0.05;
            stream.mode.into_iter().for_each(|mode| self.ask(Asked::Mode(mode)));
            stream.setpoint.into_iter().for_each(|s| self.ask(Asked::Setpoint(s)));
        }
        self.vehicle.step(STEP_S, &Vector3::zeros(), &mut self.out);
        self.time_s += STEP_S;
        self.collect();
    }

    fn collect(&mut self) {
        self.frames += self.out.frames().count();
        self.heard
            .extend(self.out.published().iter().map(|p| (self.time_s, *p)));
        self.out.clear();
    }

    fn run(&mut self, seconds: f64) {
        let end = self.time_s + seconds;
        while self.time_s < end - 1e-9 {
            self.step();
        }
    }

    fn run_until(&mut self, limit_s: f64, done: impl Fn(&VehicleTruth) -> bool) -> Option<f64> {
        let start = self.time_s;
        while self.time_s < start + limit_s {
            self.step();
            if done(&self.vehicle.truth()) {
                return Some(self.time_s - start);
            }
        }
        None
    }

    fn truth(&self) -> VehicleTruth {
        self.vehicle.truth()
    }

    fn command(&mut self, command: u32, param: [f32; 4]) -> Option<u8> {
        self.command_to((1, 1), command, param).map(|answer| answer.result)
    }

    fn command_to(
        &mut self,
        (to_system, to_component): (u8, u8),
        command: u32,
        param: [f32; 4],
    ) -> Option<CommandAnswer> {
        let before = self.heard.len();
        self.ask(Asked::Command(AskedCommand {
            command,
            param,
            place: [f64::NAN; 3],
            to_system,
            to_component,
            from_system: 245,
            from_component: 300,
        }));
        self.run(0.1);
        self.heard
            .iter()
            .skip(before)
            .find_map(|(_, published)| match published {
                Published::CommandAnswer(answer) if answer.command == command => Some(*answer),
                _ => None,
            })
    }

    fn offboard(&mut self) -> Option<u8> {
        self.command(176, [1.0, 6.0, 0.0, 0.0])
    }

    fn local(&self) -> LocalReport {
        let found = self.heard.iter().rev().find_map(|(_, published)| match published {
            Published::Local(local) => Some(*local),
            _ => None,
        });
        found.expect("a position was published")
    }

    fn status(&self) -> StatusReport {
        let found = self.heard.iter().rev().find_map(|(_, published)| match published {
            Published::Status(status) => Some(*status),
            _ => None,
        });
        found.expect("a status was published")
    }

    /// In the air in OFFBOARD, 3 m over where it stood, streaming that place.
    fn flying() -> Self {
        let mut bench = Self::of(Faces::Dds);
        let above = bench.local().position_m - Vector3::new(0.0, 0.0, 3.0);
        bench.stream = Some(Stream {
            mode: Some(alive()),
            setpoint: Some(to(above)),
        });
        bench.run(0.5);
        assert_eq!(bench.offboard(), ACCEPTED);
        assert_eq!(bench.command(400, [1.0, 0.0, 0.0, 0.0]), ACCEPTED);
        bench.run(15.0);
        let height_m = bench.truth().height_m;
        assert!((height_m - 3.0).abs() < 0.2, "{height_m}");
        bench
    }
}

fn count(bench: &Bench, since_s: f64, which: impl Fn(&Published) -> bool) -> usize {
    let all = bench.heard.iter().filter(|(at_s, _)| *at_s > since_s);
    all.filter(|(_, published)| which(published)).count()
}

#[test]
fn each_topic_comes_at_its_rate_and_none_without_that_face() {
    let mut bench = Bench::of(Faces::Both);
    let since_s = bench.time_s;
    bench.run(10.0);
    let rates = [
        (count(&bench, since_s, |p| matches!(p, Published::Local(_))), 500),
        (count(&bench, since_s, |p| matches!(p, Published::Attitude(_))), 500),
        (count(&bench, since_s, |p| matches!(p, Published::Global(_))), 500),
        (count(&bench, since_s, |p| matches!(p, Published::Gnss(_))), 50),
        (count(&bench, since_s, |p| matches!(p, Published::Status(_))), 20),
        (count(&bench, since_s, |p| matches!(p, Published::Landed(_))), 10),
        (count(&bench, since_s, |p| matches!(p, Published::Battery(_))), 10),
        (count(&bench, since_s, |p| matches!(p, Published::Timesync(_))), 10),
        // It has been told before.
        (count(&bench, since_s - 1.0, |p| matches!(p, Published::Home(_))), 0),
    ];
    assert!(rates.iter().all(|(got, want)| got.abs_diff(*want) <= 1), "{rates:?}");
    assert!(bench.frames > 1000);
    let (mavlink, dds) = (Bench::of(Faces::Mavlink), Bench::of(Faces::Dds));
    assert!(mavlink.heard.is_empty() && mavlink.frames > 1000);
    assert!(dds.frames == 0 && !dds.heard.is_empty());
}

#[test]
fn a_change_is_told_at_once_and_a_command_answered_to_who_gave_it() {
    let mut bench = Bench::of(Faces::Dds);
    let status = bench.status();
    assert_eq!(
        (status.armed, status.mode, status.checks_pass),
        (false, FlightMode::Hold, true)
    );
    let answer = bench
        .command_to((1, 1), 400, [1.0, 0.0, 0.0, 0.0])
        .expect("is answered");
    assert_eq!((answer.result, answer.to_system, answer.to_component), (0, 245, 300));
    assert!(bench.status().armed && bench.status().armed_us > 0);
    let (at_s, _) = bench
        .heard
        .iter()
        .find(|(_, p)| matches!(p, Published::Status(s) if s.armed))
        .expect("is told");
    assert!(bench.time_s - at_s > 0.08, "not with the next half second");
    assert_eq!(bench.command_to((0, 0), 70_000, [0.0; 4]).map(|a| a.result), Some(3));
    assert_eq!(bench.command_to((1, 1), 31_999, [0.0; 4]).map(|a| a.result), Some(3));
    assert_eq!(bench.command_to((2, 1), 400, [0.0; 4]), None, "for another");
    assert_eq!(bench.command_to((1, 1), 511, [0.0; 4]), None, "about a link's messages");
}

#[test]
fn offboard_needs_setpoints_and_what_keeps_it_alive() {
    let mut bench = Bench::flying();
    let stream = bench.stream;
    assert_eq!(bench.command(176, [1.0, 4.0, 3.0, 0.0]), ACCEPTED);
    let setpoint = stream.expect("streams").setpoint;
    for half in [
        Stream { mode: None, setpoint },
        Stream {
            mode: Some(alive()),
            setpoint: None,
        },
        // Asks for nothing that it follows.
        Stream {
            mode: Some(AskedMode {
                follows: false,
                ..alive()
            }),
            setpoint,
        },
        // Stamped on another clock, long ago.
        Stream {
            mode: Some(AskedMode {
                stamp_us: 1,
                follows: true,
            }),
            setpoint,
        },
    ] {
        bench.stream = Some(half);
        bench.run(2.0);
        assert_eq!(bench.offboard(), REJECTED, "{half:?}");
    }
    bench.stream = stream;
    bench.run(0.5);
    assert_eq!(bench.offboard(), ACCEPTED);
}

#[test]
fn its_end_leads_to_the_failsafe_and_its_return_back() {
    let mut bench = Bench::flying();
    let stream = bench.stream.take().expect("streams");
    let lost_s = bench
        .run_until(3.0, |t| t.mode != FlightMode::Offboard)
        .expect("is lost");
    assert!((1.0..1.2).contains(&lost_s), "{lost_s}");
    bench.run(0.1);
    let status = bench.status();
    assert_eq!((status.mode, status.failsafe), (FlightMode::Return, true));
    assert_eq!(status.intention, FlightMode::Offboard);
    // Setpoints alone do not bring it back.
    bench.stream = Some(Stream { mode: None, ..stream });
    assert_eq!(bench.run_until(2.0, |t| t.mode == FlightMode::Offboard), None);
    bench.stream = Some(stream);
    let back_s = bench
        .run_until(3.0, |t| t.mode == FlightMode::Offboard)
        .expect("is back");
    assert!(back_s < 1.0, "{back_s}");
    let causes: Vec<_> = bench
        .truth()
        .mode_changes
        .iter()
        .rev()
        .take(2)
        .map(|c| c.cause)
        .collect();
    assert_eq!(causes, [ModeCause::Recovered, ModeCause::Failsafe]);
}

#[test]
fn what_is_not_a_number_is_not_controlled() {
    let mut bench = Bench::flying();
    let before = bench.local().position_m;
    let mut north = to(Vector3::new(f64::NAN, f64::NAN, before.z));
    north.velocity_m_s = Vector3::new(2.0, 0.0, f64::NAN);
    bench.stream = Some(Stream {
        mode: Some(alive()),
        setpoint: Some(north),
    });
    bench.run(5.0);
    let moved = bench.local().position_m - before;
    assert!((6.0..11.0).contains(&moved.x) && moved.yz().norm() < 0.3, "{moved}");
    let refused = bench.truth().setpoints_refused;
    bench.ask(Asked::Setpoint(to(NAN)));
    assert_eq!(bench.truth().setpoints_refused, refused + 1, "asks for nothing");
}

#[test]
fn its_faces_are_cut_one_by_one() {
    let mut bench = Bench::of(Faces::Both);
    let spoke = |bench: &mut Bench| {
        let (frames, heard) = (bench.frames, bench.heard.len());
        bench.run(1.0);
        (bench.frames > frames, bench.heard.len() > heard)
    };
    let fault = |face, cut| Fault::Cut { face, cut };
    bench.vehicle.inflict(fault(Face::Dds, true));
    assert_eq!(spoke(&mut bench), (true, false));
    assert_eq!(bench.command(400, [1.0, 0.0, 0.0, 0.0]), None, "it hears nothing there");
    assert!(!bench.truth().armed);
    bench.vehicle.inflict(fault(Face::Mavlink, true));
    assert_eq!(spoke(&mut bench), (false, false));
    bench.vehicle.inflict(fault(Face::Dds, false));
    assert_eq!(spoke(&mut bench), (false, true));
    assert_eq!(bench.command(400, [1.0, 0.0, 0.0, 0.0]), ACCEPTED);
    bench.vehicle.inflict(fault(Face::Mavlink, false));
    assert_eq!(spoke(&mut bench), (true, true));
    bench.vehicle.inflict(Fault::Silent(true));
    assert_eq!(spoke(&mut bench), (false, false));
}

#[test]
fn stamps_are_on_its_own_clock_and_its_way_to_the_worlds_is_told() {
    let mut bench = Bench::of(Faces::Dds);
    bench.run(2.0);
    bench.vehicle.reboot();
    bench.run(3.0);
    let stamp_us = bench.local().stamp_us;
    assert!(stamp_us.abs_diff(3_000_000) < 30_000, "{stamp_us}");
    let sync = bench.heard.iter().rev().find_map(|(_, published)| match published {
        Published::Timesync(sync) => Some(*sync),
        _ => None,
    });
    // It was started anew seven seconds after the world's clock stood at zero.
    let offset_us = sync.expect("is told").offset_us;
    assert!(offset_us.abs_diff(-7_000_000) < 10_000, "{offset_us}");
}

#[test]
fn how_it_is_reached_makes_no_other_flight() {
    let flights: Vec<_> = [Faces::Mavlink, Faces::Dds, Faces::Both]
        .into_iter()
        .map(|faces| {
            let settings = SimSettings {
                faces,
                ..SimSettings::default()
            };
            let (mut vehicle, mut out) = (SimVehicle::new(identity(), &settings), Outbox::default());
            for _ in 0..2500 {
                vehicle.step(STEP_S, &Vector3::new(1.0, 0.5, 0.0), &mut out);
                out.clear();
            }
            vehicle.truth()
        })
        .collect();
    assert!(flights.windows(2).all(|pair| pair[0] == pair[1]));
}
