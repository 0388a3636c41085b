//! `px4`: the demonstration with a real PX4 instead of simulated vehicles. Starts instances of the person's own build in PX4's own
//! simulation and flies them; the exit code is the flight's.
//!
//! Must never do: fetch, build or change PX4, or leave an instance behind.

use crate::demo;
use crate::workspace::Workspace;
use anyhow::{Context, Result, bail, ensure};
use std::fs::{self, File};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::Duration;

/// Ports of instance 0, of which instance N has the Nth next: where PX4 sends to and what it binds, of all links of its start-up script.
const PORTS: [u16; 5] = [14540, 14580, 18570, 14280, 13030];
/// From this instance on PX4 sends to the port of the one before.
const LAST_OWN_PORT: u16 = 9;
/// Instances are looked for up to this one: beyond it system ids are not PX4's default any more.
const MOST_INSTANCES: u16 = 250;
/// Distance between two vehicles on the ground in metres, and how many stand in a row.
const SPACING_M: f64 = 5.0;
const IN_A_ROW: u16 = 4;
/// Where the first one stands, in degrees and metres: PX4's own default.
const HOME: (f64, f64, f64) = (47.397_742, 8.545_594, 488.0);
const METRES_PER_DEGREE: f64 = 111_320.0;
/// The simulation that PX4 carries in itself.
const MODEL: &str = "sihsim_quadx";
/// Between two starts: they read their files from the same disk.
const STAGGER: Duration = Duration::from_millis(200);

/// What is to be flown.
#[derive(clap::Args)]
pub struct Px4Arguments {
    /// PX4's source tree in which `make px4_sitl_default` was run, or the `px4` program of such a build.
    #[arg(long, value_name = "PX4_SOURCE")]
    dir: PathBuf,
    /// How many instances.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(2..=100))]
    vehicles: u16,
    /// Arguments that go on to `skein demo`, for example `--report figures.json`.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<String>,
}

/// A build of PX4.
struct Build {
    program: PathBuf,
    etc: PathBuf,
}

/// One running instance; dropping it ends it.
struct Instance {
    number: u16,
    child: Child,
    log: PathBuf,
}

impl Drop for Instance {
    fn drop(&mut self) {
        // It may have ended by itself; there is nothing else to be done then.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Builds the program, starts the instances and flies them.
pub fn run(workspace: &Workspace, arguments: &Px4Arguments) -> Result<ExitCode> {
    let build = Build::find(&arguments.dir)?;
    demo::build_for(workspace, &[])?;
    let folder = workspace.target.join("px4");
    println!(
        "starting {} instances of {}; their logs are in {}",
        arguments.vehicles,
        build.program.display(),
        folder.display()
    );
    let mut instances = Vec::new();
    for number in free_instances(arguments.vehicles)? {
        instances.push(build.start(number, instances.len(), &folder)?);
        std::thread::sleep(STAGGER);
    }
    for instance in &mut instances {
        if let Some(status) = instance.child.try_wait()? {
            bail!(
                "instance {} of PX4 ended at once ({status}); see {}",
                instance.number,
                instance.log.display()
            );
        }
    }
    let binary = workspace.target.join("release/skein");
    let mut flight = Command::new(&binary);
    flight.arg("demo").args(["--vehicles", &arguments.vehicles.to_string()]);
    let mut ports: Vec<u16> = instances
        .iter()
        .map(|i| PORTS[0] + i.number.min(LAST_OWN_PORT))
        .collect();
    ports.dedup();
    for port in ports {
        flight.args(["--listen", &format!("udp-listen://127.0.0.1:{port}")]);
    }
    flight.args(&arguments.rest);
    let status = flight
        .status()
        .with_context(|| format!("cannot start {}", binary.display()))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

impl Build {
    fn find(dir: &Path) -> Result<Self> {
        ensure!(dir.exists(), "{} does not exist", dir.display());
        let candidates = [
            dir.to_path_buf(),
            dir.join("bin/px4"),
            dir.join("build/px4_sitl_default/bin/px4"),
            dir.join("build/px4_sitl_sih/bin/px4"),
        ];
        let Some(program) = candidates.into_iter().find(|path| path.is_file()) else {
            bail!(
                "no PX4 is built in {}: run `make px4_sitl_default` there",
                dir.display()
            );
        };
        let program = program.canonicalize()?;
        let root = program.parent().and_then(Path::parent);
        let etc = root
            .map(|root| root.join("etc"))
            .filter(|etc| etc.join("init.d-posix/rcS").is_file());
        let etc = etc.with_context(|| {
            format!(
                "beside {} there is no etc/init.d-posix/rcS of its build",
                program.display()
            )
        })?;
        Ok(Self { program, etc })
    }

    /// In a folder of its own, which is emptied first: what another run set must not fly along.
    fn start(&self, number: u16, place: usize, folder: &Path) -> Result<Instance> {
        let folder = folder.join(format!("instance-{number}"));
        if folder.exists() {
            fs::remove_dir_all(&folder).with_context(|| format!("cannot empty {}", folder.display()))?;
        }
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let log = folder.join("px4.log");
        let output = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
        let (latitude_deg, longitude_deg) = home(place);
        // `setpriv` of util-linux: an instance ends with this program, however that ends.
        let child = Command::new("setpriv")
            .args(["--pdeathsig", "KILL"])
            .arg(&self.program)
            .args(["-d", "-i", &number.to_string()])
            .arg(&self.etc)
            .current_dir(&folder)
            .env("PX4_SIM_MODEL", MODEL)
            .env("PX4_HOME_LAT", format!("{latitude_deg:.8}"))
            .env("PX4_HOME_LON", format!("{longitude_deg:.8}"))
            .env("PX4_HOME_ALT", format!("{:.1}", HOME.2))
            .stdin(Stdio::null())
            .stdout(output.try_clone()?)
            .stderr(output)
            .spawn()
            .with_context(|| format!("cannot start {}", self.program.display()))?;
        Ok(Instance { number, child, log })
    }
}

/// Where the vehicle of that place in the grid stands, in degrees.
fn home(place: usize) -> (f64, f64) {
    let row = place / usize::from(IN_A_ROW);
    let column = place % usize::from(IN_A_ROW);
    let north_deg = row as f64 * SPACING_M / METRES_PER_DEGREE;
    let east_deg = column as f64 * SPACING_M / (METRES_PER_DEGREE * HOME.0.to_radians().cos());
    (HOME.0 + north_deg, HOME.1 + east_deg)
}

/// Numbers of instances whose ports nobody uses.
fn free_instances(count: u16) -> Result<Vec<u16>> {
    let is_free = |number: &u16| {
        PORTS.iter().all(|first| {
            // Beyond its own ports an instance sends to one that others of this run share.
            let shared = *first == PORTS[0] && *number > LAST_OWN_PORT;
            shared || UdpSocket::bind(("127.0.0.1", first + number)).is_ok()
        })
    };
    let free: Vec<u16> = (0..MOST_INSTANCES).filter(is_free).take(usize::from(count)).collect();
    ensure!(
        free.len() == usize::from(count),
        "the ports of only {} instances are free on this computer",
        free.len()
    );
    Ok(free)
}

#[cfg(test)]
mod tests {
    //! Which build is found, which instances are free, and where they stand.

    use super::*;

    #[test]
    fn a_build_is_found_by_its_source_tree_or_by_its_program() {
        let tree = std::env::temp_dir().join(format!("skein-px4-{}", std::process::id()));
        let build = tree.join("build/px4_sitl_default");
        fs::create_dir_all(build.join("bin")).expect("made");
        let missing = Build::find(&tree).err().expect("nothing is built").to_string();
        assert!(missing.contains("make px4_sitl_default"), "{missing}");
        fs::write(build.join("bin/px4"), "").expect("written");
        let without = Build::find(&tree).err().expect("no start-up script").to_string();
        assert!(without.contains("rcS"), "{without}");
        fs::create_dir_all(build.join("etc/init.d-posix")).expect("made");
        fs::write(build.join("etc/init.d-posix/rcS"), "").expect("written");
        for dir in [tree.clone(), build.clone(), build.join("bin/px4")] {
            let found = Build::find(&dir).expect("found");
            assert!(found.program.ends_with("bin/px4") && found.etc.ends_with("etc"));
        }
        fs::remove_dir_all(&tree).expect("removed");
    }

    #[test]
    fn an_instance_whose_port_is_taken_is_passed_over() {
        let free = free_instances(1).expect("one is free")[0];
        let taken = UdpSocket::bind(("127.0.0.1", PORTS[1] + free)).expect("free");
        let next = free_instances(1).expect("one is free");
        assert_ne!(next, [free]);
        drop(taken);
    }

    #[test]
    fn vehicles_stand_apart() {
        let places: Vec<_> = (0..12).map(home).collect();
        for (i, a) in places.iter().enumerate() {
            for b in &places[..i] {
                let north_m = (a.0 - b.0) * METRES_PER_DEGREE;
                let east_m = (a.1 - b.1) * METRES_PER_DEGREE * a.0.to_radians().cos();
                assert!(north_m.hypot(east_m) > SPACING_M - 0.01);
            }
        }
    }
}
