//! At the program's start, before anything else: which version is to run. The service manager starts the installed package each time; it becomes
//! another program by `exec`, so that it is still the one process that the service manager knows.
//!
//! Must never do: try a version whose try was not stored first; end because nothing could be stored: a vehicle in the air needs its node.

use crate::manifest::PROGRAM;
use crate::rules::{Package, Start, Version, Versions};
use crate::slots::Slots;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// In the environment of what was chosen: as what it runs.
const CHOSEN: &str = "SKEIN_VERSION_CHOSEN";
/// The plugins of the package, whose place those of the chosen version take.
const PACKAGE_PLUGINS: &str = "SKEIN_PACKAGE_PLUGINS";

/// As what this process runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Running {
    /// Which version.
    pub version: Version,
    /// It has to confirm itself.
    pub on_trial: bool,
    /// The folder of the package's plugins, if this is not the package.
    pub package_plugins: Option<PathBuf>,
}

/// What is to be done at the start.
#[derive(Debug)]
pub enum Chosen {
    /// This process goes on.
    GoOn {
        /// As what.
        running: Running,
        /// What could not be read or stored, for the operator.
        problem: Option<String>,
    },
    /// This process becomes another program.
    Become {
        /// Which.
        program: PathBuf,
        /// What is added to the environment.
        environment: [(&'static str, String); 2],
        /// As what it will run.
        start: Start,
    },
}

/// Chooses. `environment` reads the environment, `program` is this process's own, `plugins` the folder of its plugins.
#[must_use]
pub fn choose(slots: &Slots, environment: impl Fn(&str) -> Option<String>, program: &Path, plugins: &Path) -> Chosen {
    let as_package = |problem: Option<String>| Chosen::GoOn {
        running: Running {
            version: Version::Package,
            on_trial: false,
            package_plugins: None,
        },
        problem,
    };
    if let Some(chosen) = environment(CHOSEN) {
        return as_chosen(&chosen, environment(PACKAGE_PLUGINS)).unwrap_or_else(|| as_package(None));
    }
    let mut versions = match slots.load() {
        Ok(Some(versions)) => versions,
        Ok(None) => return as_package(None),
        Err(error) => return as_package(Some(format!("the installed package runs: {error}"))),
    };
    let package = match package_of(program) {
        Ok(package) => package,
        Err(error) => {
            return as_package(Some(format!(
                "the installed package runs, for it cannot be looked at: {error}"
            )));
        }
    };
    let before = versions.clone();
    let mut start = versions.start(package);
    if versions != before
        && let Err(error) = slots.save(&versions)
    {
        tracing::error!("{error}");
        // A try that is not noted could be made again and again.
        start = Start {
            version: before.confirmed,
            on_trial: false,
        };
    }
    let become_it = slots.folder_of(&start.version).map(|folder| folder.join(PROGRAM));
    let chosen = serde_json::to_string(&(&start.version, start.on_trial)).unwrap_or_default();
    Chosen::Become {
        program: become_it.unwrap_or_else(|| program.to_owned()),
        environment: [
            (CHOSEN, chosen),
            (PACKAGE_PLUGINS, plugins.to_string_lossy().into_owned()),
        ],
        start,
    }
}

fn as_chosen(chosen: &str, plugins: Option<String>) -> Option<Chosen> {
    let (version, on_trial): (Version, bool) = serde_json::from_str(chosen).ok()?;
    let package_plugins = plugins.map(PathBuf::from).filter(|_| version != Version::Package);
    Some(Chosen::GoOn {
        running: Running {
            version,
            on_trial,
            package_plugins,
        },
        problem: None,
    })
}

/// The chosen version cannot be started at all: the next choice is another one.
pub fn cannot_start(slots: &Slots, start: &Start, error: &io::Error) {
    let why = format!("it cannot be started: {error}");
    let noted = slots.change(|versions: &mut Versions| match start.on_trial {
        true => versions.give_up(&why),
        false => versions.fall_back(&why),
    });
    if let Err(error) = noted {
        tracing::error!("{error}");
    }
}

/// How this program is known again.
pub(crate) fn package_of(program: &Path) -> io::Result<Package> {
    let metadata = std::fs::metadata(program)?;
    Ok(Package {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        bytes: metadata.len(),
        changed_ns: i128::from(metadata.mtime()) * 1_000_000_000 + i128::from(metadata.mtime_nsec()),
    })
}

#[cfg(test)]
mod tests {
    //! What is started, in which order, whatever happens to the disk.

    use super::*;
    use crate::archive::tests::archive;
    use crate::rules::Expectations;
    use std::collections::BTreeMap;

    fn nothing(_: &str) -> Option<String> {
        None
    }

    struct Computer {
        state: tempfile::TempDir,
        slots: Slots,
        slot: Version,
    }

    fn computer() -> Computer {
        let state = tempfile::tempdir().unwrap();
        let slots = Slots::under(state.path());
        let (_built, path, info) = archive("x86_64", "0.2.0");
        let slot = slots.unpack(&path, &info.digest, &Versions::default()).unwrap();
        Computer { state, slots, slot }
    }

    impl Computer {
        fn package(&self) -> PathBuf {
            self.state.path().join("package")
        }

        fn starts(&self) -> (PathBuf, Start, BTreeMap<&'static str, String>) {
            match choose(
                &self.slots,
                nothing,
                &self.package(),
                Path::new("/usr/lib/skein/plugins"),
            ) {
                Chosen::Become {
                    program,
                    environment,
                    start,
                } => (program, start, environment.into_iter().collect()),
                Chosen::GoOn { .. } => panic!("nothing was chosen"),
            }
        }
    }

    #[test]
    fn without_another_version_the_process_goes_on() {
        let computer = computer();
        let chosen = choose(&computer.slots, nothing, &computer.package(), Path::new("p"));
        assert!(matches!(
            chosen,
            Chosen::GoOn {
                running: Running {
                    version: Version::Package,
                    on_trial: false,
                    ..
                },
                problem: None
            }
        ));
    }

    #[test]
    fn a_trial_is_begun_once_and_noted_first() {
        let computer = computer();
        std::fs::write(computer.package(), "1").unwrap();
        let wanted = computer.slot.clone();
        assert!(
            computer
                .slots
                .change(|v| v.try_next(wanted, Expectations::default()))
                .unwrap()
        );
        let (program, start, environment) = computer.starts();
        assert_eq!((start.on_trial, &start.version), (true, &computer.slot));
        assert!(program.starts_with(computer.state.path()) && program.is_file());
        assert!(computer.slots.load().unwrap().unwrap().trial.unwrap().begun);
        // The program that was chosen looks at its environment, not at the disk.
        let chosen = choose(
            &computer.slots,
            |key| environment.get(key).cloned(),
            &program,
            Path::new("p"),
        );
        let Chosen::GoOn { running, .. } = chosen else {
            panic!("it chooses again")
        };
        assert_eq!((running.version, running.on_trial), (computer.slot.clone(), true));
        assert_eq!(running.package_plugins, Some(PathBuf::from("/usr/lib/skein/plugins")));
        // It ended without a word.
        let (program, start, _) = computer.starts();
        assert_eq!((program, start.version), (computer.package(), Version::Package));
        assert!(computer.slots.load().unwrap().unwrap().gone_back.is_some());
    }

    #[test]
    fn a_version_that_cannot_be_started_is_not_started_for_ever() {
        let computer = computer();
        std::fs::write(computer.package(), "1").unwrap();
        let wanted = computer.slot.clone();
        assert!(
            computer
                .slots
                .change(|v| v.try_next(wanted, Expectations::default()))
                .unwrap()
        );
        let _ = computer.starts();
        computer.slots.change(Versions::confirm).unwrap();
        let (_, start, _) = computer.starts();
        assert_eq!(start.version, computer.slot);
        cannot_start(&computer.slots, &start, &io::Error::from(io::ErrorKind::NotFound));
        assert_eq!(
            computer.starts().1,
            Start {
                version: Version::Package,
                on_trial: false
            }
        );
    }

    #[test]
    fn a_package_that_was_installed_meanwhile_wins() {
        let computer = computer();
        std::fs::write(computer.package(), "1").unwrap();
        let wanted = computer.slot.clone();
        assert!(
            computer
                .slots
                .change(|v| v.try_next(wanted, Expectations::default()))
                .unwrap()
        );
        let _ = computer.starts();
        computer.slots.change(Versions::confirm).unwrap();
        std::fs::write(computer.package(), "another one").unwrap();
        let (program, start, _) = computer.starts();
        assert_eq!((program, start.version), (computer.package(), Version::Package));
        let versions = computer.slots.load().unwrap().unwrap();
        assert_eq!(versions.before, Some(computer.slot.clone()), "it can be gone back to");
    }

    #[test]
    fn what_cannot_be_read_or_stored_costs_no_vehicle_its_node() {
        let computer = computer();
        std::fs::write(computer.package(), "1").unwrap();
        computer.slots.save(&Versions::default()).unwrap();
        std::fs::write(computer.state.path().join("versions/versions.json"), "{").unwrap();
        let chosen = choose(&computer.slots, nothing, &computer.package(), Path::new("p"));
        assert!(matches!(
            chosen,
            Chosen::GoOn {
                running: Running {
                    version: Version::Package,
                    ..
                },
                problem: Some(_)
            }
        ));
        // Where a try cannot be noted, it is not made.
        let wanted = computer.slot.clone();
        let mut versions = Versions::default();
        assert!(versions.try_next(wanted, Expectations::default()));
        computer.slots.save(&versions).unwrap();
        std::fs::create_dir(computer.state.path().join("versions/versions.new")).unwrap();
        assert_eq!(
            computer.starts().1,
            Start {
                version: Version::Package,
                on_trial: false
            }
        );
    }
}
