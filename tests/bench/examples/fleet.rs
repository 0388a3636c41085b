//! The fleet bench without the program's own command line:
//! `cargo run --release -p skein-bench --example fleet -- fleet PROGRAM VEHICLES SECONDS [PRIORITY]`.
//! With a real-time priority (1 to 99) other work on the machine does not delay what is measured. Its children are this example itself.

use skein_bench::{FleetBenchArgs, Scheduling, run_bare_loop, run_fleet_bench, run_load_generator};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["bench", "load-generator", settings] => run_load_generator(settings),
        ["bench", "bare-loop", settings] => run_bare_loop(settings),
        ["fleet", program, vehicles, seconds, priority @ ..] => {
            let (Ok(vehicles), Ok(seconds), Ok(helper)) = (vehicles.parse(), seconds.parse(), std::env::current_exe())
            else {
                eprintln!("vehicles and seconds are numbers");
                return ExitCode::from(2);
            };
            let scheduling = match priority {
                [] => Some(Scheduling::Ordinary),
                [word] => word.parse().ok().map(|priority| Scheduling::RealTime { priority }),
                _ => None,
            };
            let Some(scheduling) = scheduling else {
                eprintln!("a priority is one number");
                return ExitCode::from(2);
            };
            let args = FleetBenchArgs {
                scheduling,
                helper,
                ..FleetBenchArgs::new(vehicles, seconds, program.into())
            };
            run_fleet_bench(&args).map(|report| println!("{report}"))
        }
        _ => {
            eprintln!("usage: fleet PROGRAM VEHICLES SECONDS [PRIORITY]");
            return ExitCode::from(2);
        }
    };
    done.map_or_else(
        |e| {
            eprintln!("{e}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}
