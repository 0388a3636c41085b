//! `skein run` and its versions: which one is started, how one on trial confirms itself, how the process ends for another one.
//!
//! Must never do: end for another version while a vehicle is armed; keep a node from running because of its versions.

use skein_config::NodeConfig;
use skein_node::plugins_beside_program;
use skein_runtime::NodeHandle;
use skein_upgrade::{Chosen, HangGuard, Running, Slots, Swap, Upgrader, Version, cannot_start, choose};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

/// Choices at one start: the one on trial, the one confirmed, the package.
const MOST_CHOICES: usize = 3;

/// What this process runs, and where versions are kept.
pub struct Kept {
    state: PathBuf,
    running: Running,
    guard: Option<HangGuard>,
}

/// Chooses the version. Does not return if it is another program than this one; gives nothing where there is no place to keep versions in.
#[must_use]
pub fn start(state: Option<PathBuf>) -> Option<Kept> {
    let state = state?;
    let slots = Slots::under(&state);
    let program = std::env::current_exe().ok()?;
    for _ in 0..MOST_CHOICES {
        match choose(
            &slots,
            |key| std::env::var(key).ok(),
            &program,
            &plugins_beside_program(),
        ) {
            Chosen::GoOn { running, problem } => {
                if let Some(problem) = problem {
                    eprintln!("skein: {problem}");
                }
                let guard = running.on_trial.then(HangGuard::start);
                return Some(Kept { state, running, guard });
            }
            Chosen::Become {
                program,
                environment,
                start,
            } => {
                let mut chosen = Command::new(&program);
                let error = chosen.args(std::env::args_os().skip(1)).envs(environment).exec();
                eprintln!("skein: {} cannot be started: {error}", program.display());
                cannot_start(&slots, &start, &error);
            }
        }
    }
    let running = Running {
        version: Version::Package,
        on_trial: false,
        package_plugins: None,
    };
    Some(Kept {
        state,
        running,
        guard: None,
    })
}

impl Kept {
    /// It has to confirm itself.
    #[must_use]
    pub fn is_on_trial(&self) -> bool {
        self.running.on_trial
    }

    /// The plugins of this version take the place of those of the package, where the configuration names the package's.
    pub fn use_own_plugins(&self, config: &mut NodeConfig) {
        let Some(package) = &self.running.package_plugins else {
            return;
        };
        let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let package = whole(package);
        for directory in &mut config.plugins.directories {
            if whole(directory) == package {
                *directory = plugins_beside_program();
            }
        }
    }

    /// The version on trial did not come up.
    pub fn did_not_come_up(&self, why: &str) {
        if self.running.on_trial
            && let Err(error) = Upgrader::did_not_come_up(&Slots::under(&self.state), why)
        {
            eprintln!("skein: {error}");
        }
    }

    /// Watches over the version while the node runs; returns when the process is to end for another one.
    pub async fn watch(self, node: &NodeHandle) -> Swap {
        let upgrader: Arc<Upgrader> = match node.keep_versions(&self.state, self.running) {
            Ok(upgrader) => upgrader,
            Err(error) => {
                tracing::error!("versions are not exchanged: {error}");
                return std::future::pending().await;
            }
        };
        upgrader.run(self.guard).await
    }
}
