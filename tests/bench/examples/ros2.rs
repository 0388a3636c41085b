//! The bench of ROS 2 without the program's own command line: `cargo run -p skein-bench --example ros2 -- ros2 PROGRAM PYTHON SECONDS`.
//! Its children are this example itself.

use skein_bench::{Ros2BenchArgs, run_load_generator, run_ros2_bench};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["bench", "load-generator", settings] => run_load_generator(settings),
        ["ros2", program, python, seconds] => {
            let (Ok(seconds), Ok(helper)) = (seconds.parse(), std::env::current_exe()) else {
                eprintln!("seconds is a number");
                return ExitCode::from(2);
            };
            let args = Ros2BenchArgs {
                helper,
                ..Ros2BenchArgs::new(python.into(), seconds, program.into())
            };
            run_ros2_bench(&args).map(|report| println!("{report}"))
        }
        _ => {
            eprintln!("usage: ros2 PROGRAM PYTHON SECONDS");
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
