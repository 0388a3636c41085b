//! The program killed in flight (`kill -9`) and started again: its vehicles fly on, or hold until an operator says so; none is taken from a pilot.

use reqwest::Client;
use serde_json::{Value, json};
use skein_domain::FlightMode;
use skein_sim::{PortPlan, SimSettings, Simulation, VehicleTruth};
use skein_testkit::{Process, eventually, free_tcp_port, free_udp_port, patience, plugins_dir};
use std::net::{Ipv4Addr, SocketAddr};
use std::time::{Duration, Instant};

/// Climbing and forming take their time.
const FLIGHT: Duration = Duration::from_secs(40);

/// Simulated vehicles, and the program that flies them.
pub(crate) struct Field {
    simulation: Simulation,
    folder: tempfile::TempDir,
    client: Client,
    web: u16,
    start: Start,
    pub(crate) node: Process,
}

/// How a program is started with its configuration.
type Start = fn(&std::path::Path) -> Process;

impl Field {
    pub(crate) async fn start(vehicles: usize, then: &str) -> Self {
        Self::start_by(run, vehicles, then).await
    }

    /// The same with a program that is started otherwise.
    pub(crate) async fn start_by(start: Start, vehicles: usize, then: &str) -> Self {
        let (web, port) = (free_tcp_port(), free_udp_port());
        let folder = tempfile::tempdir().expect("a folder");
        let config = format!(
            "[[endpoints]]\naddress = \"udp-listen://127.0.0.1:{port}\"\n[[adopt]]\n[web]\nlisten = \"127.0.0.1:{web}\"\n[plugins]\ndirectories = [{:?}]\n[resume]\nthen = \"{then}\"\n",
            plugins_dir()
        );
        std::fs::write(folder.path().join("node.toml"), config).expect("is written");
        let simulation = Simulation::start(SimSettings {
            vehicles,
            ports: PortPlan::SendTo(SocketAddr::from((Ipv4Addr::LOCALHOST, port))),
            ..SimSettings::default()
        });
        let node = start(folder.path());
        Self {
            simulation: simulation.expect("a simulation"),
            folder,
            client: Client::new(),
            web,
            start,
            node,
        }
    }

    pub(crate) async fn get(&self, path: &str) -> Value {
        let asked = self.client.get(format!("http://127.0.0.1:{}/api/v1/{path}", self.web));
        match asked.send().await {
            Ok(answer) => answer.json().await.unwrap_or_default(),
            // It is being started.
            Err(_) => Value::Null,
        }
    }

    /// Where its configuration is, and what it writes.
    pub(crate) fn folder(&self) -> &std::path::Path {
        self.folder.path()
    }

    /// The same as [`Self::put`], whatever comes of it.
    pub(crate) async fn try_put(&self, method: reqwest::Method, path: &str, body: Value) {
        let url = format!("http://127.0.0.1:{}/api/v1/{path}", self.web);
        let _ = self.client.request(method, url).json(&body).send().await;
    }

    async fn put(&self, method: reqwest::Method, path: &str, body: Value) -> Value {
        let url = format!("http://127.0.0.1:{}/api/v1/{path}", self.web);
        let answer = self
            .client
            .request(method, url)
            .json(&body)
            .send()
            .await
            .expect("is answered");
        let (status, text) = (answer.status(), answer.text().await.unwrap_or_default());
        assert!(status.is_success(), "{path}: {status} {text}");
        serde_json::from_str(&text).unwrap_or_default()
    }

    pub(crate) async fn until(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let deadline = Instant::now() + patience() + FLIGHT;
        loop {
            let fleet = self.get("fleet").await;
            if wanted(&fleet) {
                return fleet;
            }
            assert!(
                Instant::now() < deadline,
                "in vain for {what}; at last:\n{fleet}\n{}",
                self.node.output()
            );
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// All up, in a wedge.
    pub(crate) async fn form(&self) {
        let count = self.simulation.system_ids().len();
        self.until("all ready", |fleet| {
            of(fleet, count, |v| v["ready_to_arm"] == json!(true))
        })
        .await;
        for id in 1..=count {
            // As soon as nothing in its preflight report keeps it from it.
            eventually(patience(), "a take-off", async || {
                let take_off =
                    json!({"targets": {"vehicles": [id]}, "command": {"command": "take_off", "height_m": 8.0}});
                let answer = self.put(reqwest::Method::POST, "commands", take_off).await;
                answer["receipts"][0]["refusal"].is_null().then_some(())
            })
            .await;
        }
        self.until("all up", |fleet| {
            of(fleet, count, |v| v["flight_state"] == json!("holding"))
        })
        .await;
        let wedge = json!({"shape": "wedge", "spacing_m": 6.0});
        self.put(reqwest::Method::PUT, "formation", wedge).await;
        self.until("formed", |fleet| flies(fleet, count)).await;
        // The disk has its own time.
        eventually(patience(), "the formation on the disk", async || {
            let kept = std::fs::read_to_string(self.folder.path().join("node.resume"));
            kept.is_ok_and(|text| text.contains("wedge")).then_some(())
        })
        .await;
    }

    /// The end that nobody can be ready for, and after a while another beginning.
    pub(crate) async fn kill_for(&mut self, away: Duration) {
        self.node.kill().await;
        tokio::time::sleep(away).await;
    }

    pub(crate) fn start_again(&mut self) {
        self.node = (self.start)(self.folder.path());
    }

    pub(crate) fn vehicle(&self, id: u8) -> VehicleTruth {
        self.simulation.truth().vehicle(id).expect("is simulated").clone()
    }
}

fn run(folder: &std::path::Path) -> Process {
    let config = folder.join("node.toml");
    Process::skein(&["run", "--config", config.to_str().expect("is text")])
}

/// Whether there are so many vehicles, all of which are so.
fn of(fleet: &Value, count: usize, are: impl Fn(&Value) -> bool) -> bool {
    let vehicles = fleet["vehicles"].as_array();
    vehicles.is_some_and(|all| all.len() == count && all.iter().all(are))
}

/// Whether a formation of so many is flown.
pub(crate) fn flies(fleet: &Value, count: usize) -> bool {
    let members = fleet["formation"]["members"].as_array().map_or(0, Vec::len);
    let in_it = |v: &&Value| v["flight_state"] == json!("following") || v["flight_state"] == json!("leading");
    let flying = fleet["vehicles"]
        .as_array()
        .map_or(0, |all| all.iter().filter(in_it).count());
    members == count && flying == count
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_that_was_killed_in_formation_takes_all_back_and_flies_on() {
    let mut field = Field::start(8, "fly_on").await;
    field.form().await;
    field.kill_for(Duration::from_millis(300)).await;
    let before: Vec<u64> = (1..=8).map(|id| field.vehicle(id).setpoints).collect();
    let started = Instant::now();
    field.start_again();
    eventually(patience(), "a setpoint for each", async || {
        let all = (1..=8)
            .zip(&before)
            .all(|(id, before)| field.vehicle(id).setpoints > *before);
        all.then_some(())
    })
    .await;
    println!(
        "from the start to the first setpoint of the last of eight: {:.2} s",
        started.elapsed().as_secs_f64()
    );
    let fleet = field.until("all fly on", |fleet| flies(fleet, 8)).await;
    println!("formed again after {:.1} s", started.elapsed().as_secs_f64());
    assert_eq!(fleet["formation"]["request"]["shape"], json!("wedge"), "{fleet}");
    for id in 1..=8 {
        let truth = field.vehicle(id);
        assert_eq!(truth.mode, FlightMode::Offboard, "vehicle {id}");
        assert!(
            truth.armed && truth.height_m > 4.0,
            "vehicle {id} at {} m",
            truth.height_m
        );
    }
    let nearest_m = field.simulation.truth().smallest_distance_m().expect("several fly");
    assert!(nearest_m > 2.0, "{nearest_m}");
    // A stop on purpose leaves nothing to go on with: their autopilots hold, and the next start asks nothing.
    field.node.signal("TERM").await;
    assert_eq!(field.node.exit_code(Duration::from_secs(20)).await, 0);
    assert!(field.node.output().contains("asked to hold"), "{}", field.node.output());
    assert!((1..=8).all(|id| field.vehicle(id).mode == FlightMode::Hold));
    assert!(!field.folder.path().join("node.resume").exists());
    field.simulation.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pilot_who_took_over_while_the_node_was_away_keeps_his_vehicle_and_the_others_ask() {
    let mut field = Field::start(4, "ask").await;
    field.form().await;
    field.node.kill().await;
    eventually(patience(), "the failsafe of all", async || {
        (1..=4).all(|id| field.vehicle(id).failsafe).then_some(())
    })
    .await;
    field
        .simulation
        .pilot_mode(3, FlightMode::Position)
        .expect("has a remote control");
    eventually(patience(), "the pilot's mode", async || {
        (field.vehicle(3).mode == FlightMode::Position).then_some(())
    })
    .await;
    let before = field.vehicle(3).setpoints;
    field.start_again();
    let asked = field.until("the question", |fleet| !fleet["resume"].is_null()).await;
    assert_eq!(asked["resume"]["vehicles"], json!([1, 2, 4]), "{}", asked["resume"]);
    assert_eq!(asked["resume"]["left"][0]["vehicle"], json!(3));
    assert_eq!(asked["resume"]["formation"], json!(true));
    assert!(
        asked["formation"].is_null(),
        "nobody flies on before he is asked: {}",
        asked["formation"]
    );
    field
        .put(reqwest::Method::POST, "resume", json!({"fly_on": true}))
        .await;
    let fleet = field.until("three fly on", |fleet| flies(fleet, 3)).await;
    assert!(fleet["resume"].is_null());
    let pilots = field.vehicle(3);
    assert_eq!((pilots.mode, pilots.setpoints), (FlightMode::Position, before));
    for id in [1, 2, 4] {
        assert_eq!(field.vehicle(id).mode, FlightMode::Offboard, "vehicle {id}");
    }
    field.simulation.stop();
}
