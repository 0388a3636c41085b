//! `screenshots`: the pictures in the documents, taken of a real flight in a real browser.
//!
//! Must never do: show something that the demo does not show.

use crate::workspace::Workspace;
use crate::{browser, demo, ui};
use anyhow::{Context, Result, ensure};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// The script that drives the browser; it runs where the dashboard's packages are.
const SCRIPT: &str = include_str!("screenshot.mjs");

/// A program that is built already, with this dashboard in it, and its plugins: as the browser tests take them.
const BINARY: &str = "SKEIN_BINARY";
const PLUGINS: &str = "SKEIN_PLUGINS";

/// Those that the documents show: they are in the repository, in this folder. All others are made when somebody wants to see them.
const KEPT_IN: &str = "web-ui/screenshots";
const KEPT: [&str; 12] = [
    "flight.webp",
    "console.png",
    "pages/1920-dark-formation.webp",
    "pages/1920-dark-space.webp",
    "pages/1920-dark-page-vehicle.webp",
    "pages/1920-dark-page-video.webp",
    "pages/1024-light-commands.webp",
    "pages/1024-light-by-hand.webp",
    "pages/1024-light-fences.webp",
    "pages/1024-light-emergency-stop.webp",
    "pages/1024-light-page-preflight.webp",
    "pages/1024-sunlight-german.webp",
];

/// What `cargo xtask screenshots` may be told.
#[derive(clap::Args)]
pub struct ScreenshotArguments {
    /// The folder they go to [default: screenshots in the build directory].
    #[arg(long, value_name = "FOLDER")]
    into: Option<PathBuf>,
    /// Also renews the twenty that are kept in web-ui/screenshots.
    #[arg(long)]
    keep: bool,
    /// How many vehicles to fly.
    #[arg(long, default_value_t = 8)]
    vehicles: u16,
    /// Seconds after the formation has set off at which the pictures are taken.
    #[arg(long, default_value_t = 20)]
    after_s: u64,
}

/// Takes all pictures, and renews those that are kept if that is asked for.
pub fn take(workspace: &Workspace, arguments: ScreenshotArguments) -> Result<()> {
    let into = arguments.into.unwrap_or_else(|| workspace.target.join("screenshots"));
    run(workspace, &into, arguments.vehicles, arguments.after_s)?;
    if arguments.keep {
        keep(workspace, &into)?;
    }
    Ok(())
}

/// Copies those that are kept to where they are.
fn keep(workspace: &Workspace, from: &Path) -> Result<()> {
    let kept = workspace.root.join(KEPT_IN);
    if kept.exists() {
        std::fs::remove_dir_all(&kept)?;
    }
    std::fs::create_dir_all(kept.join("pages"))?;
    for name in KEPT {
        std::fs::copy(from.join(name), kept.join(name)).with_context(|| format!("{name} was not taken"))?;
    }
    println!("{} of them are kept in {}", KEPT.len(), kept.display());
    Ok(())
}

/// Starts the demo's vehicles and takes the pictures; the script flies them.
fn run(workspace: &Workspace, into: &Path, vehicles: u16, after_s: u64) -> Result<()> {
    let built = std::env::var_os(BINARY);
    if built.is_none() {
        demo::build(workspace)?;
    }
    let chromium = browser::chromium()?;
    let into = workspace.root.join(into);
    std::fs::create_dir_all(&into)?;
    let mut flight = Flight::start(workspace, vehicles)?;
    let address = flight.address()?;
    println!("flying at {address}, pictures {after_s} s after the formation set off");
    let scripts = workspace.target.join("xtask");
    std::fs::create_dir_all(&scripts).with_context(|| format!("cannot make {}", scripts.display()))?;
    let script = scripts.join("screenshot.mjs");
    std::fs::write(&script, SCRIPT)?;
    let mut shoot = Command::new("node");
    shoot
        .arg(&script)
        .current_dir(workspace.web_ui())
        .env(browser::VARIABLE, chromium);
    shoot.args([&address, &after_s.to_string()]).arg(&into);
    ensure!(
        shoot.status().context("cannot start node")?.success(),
        "the browser took no pictures: see above"
    );
    println!("pictures are in {}", into.display());
    Ok(())
}

/// The demo as a child; ended when this goes.
struct Flight(Child);

impl Flight {
    fn start(workspace: &Workspace, vehicles: u16) -> Result<Self> {
        ui::install(workspace)?;
        let binary = std::env::var_os(BINARY).map_or_else(|| workspace.target.join("release/skein"), PathBuf::from);
        let mut command = Command::new(binary);
        if let Some(plugins) = std::env::var_os(PLUGINS) {
            command.arg("demo").arg("--plugins").arg(plugins);
        } else {
            command.arg("demo");
        }
        command
            .args(["--manual", "--port", "0", "--vehicles", &vehicles.to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::piped());
        Ok(Self(command.spawn().context("cannot start the demo")?))
    }

    /// The address it prints. Its further output is shown.
    fn address(&mut self) -> Result<String> {
        let output = self.0.stdout.take().context("the demo's output is piped")?;
        let mut lines = BufReader::new(output).lines().map_while(Result::ok);
        let address = lines.find_map(|line| {
            let at = line.find("http://")?;
            line.get(at..)?.split_whitespace().next().map(str::to_owned)
        });
        std::thread::spawn(move || lines.for_each(|line| println!("{line}")));
        address.context("the demo ended before it printed its address")
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        // it may have ended by itself
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
