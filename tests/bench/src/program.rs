//! The side of the program under test: its configuration, its start, and all vehicles in the air by its own API.

use crate::error::BenchError;
use crate::process::{Part, Scheduling};
use http_body_util::{BodyExt, Full};
use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST};
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use serde::Serialize;
use serde_json::{Value, json};
use std::fs::File;
use std::net::SocketAddr;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::net::TcpStream;

/// How long the fleet may take to be ready, and then to be in the air.
const PATIENCE: Duration = Duration::from_secs(120);
const LOOK_EVERY: Duration = Duration::from_millis(500);
const HEIGHT_M: f64 = 10.0;
/// What its own log may show of the reason of a failure, in bytes from its end.
const LOG_TAIL: usize = 2000;

/// The running program.
pub(crate) struct Program {
    pub part: Part,
    /// Where it hears vehicles over MAVLink.
    pub endpoint: SocketAddr,
    /// Its web server.
    pub web: SocketAddr,
    files: TempDir,
}

/// What vehicles are flown over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VehicleLink {
    /// MAVLink over UDP.
    Mavlink,
    /// PX4's topics behind its agent.
    Dds,
}

/// How the program is set up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup<'a> {
    /// Which file.
    pub program: &'a Path,
    /// Where its plugins are.
    pub plugins: &'a Path,
    /// How it is scheduled.
    pub scheduling: Scheduling,
    /// What its vehicles are flown over.
    pub link: VehicleLink,
    /// Its domain in DDS, if it is to be there.
    pub dds_domain: u16,
    /// Whether it shows itself to ROS 2.
    pub ros2: bool,
    /// Whether it records.
    pub recorder: bool,
    /// Ports of cameras that send RTP, the first for vehicle 1, the next for vehicle 2.
    pub cameras: &'a [u16],
}

impl<'a> Setup<'a> {
    /// Vehicles over MAVLink, no ROS 2.
    pub fn plain(program: &'a Path, plugins: &'a Path, scheduling: Scheduling) -> Self {
        Self {
            program,
            plugins,
            scheduling,
            link: VehicleLink::Mavlink,
            dds_domain: 0,
            ros2: false,
            recorder: false,
            cameras: &[],
        }
    }

    /// The vehicles that have a camera.
    fn with_cameras(&self) -> String {
        let numbered = (1..).zip(self.cameras);
        let rules = numbered.map(|(system_id, port)| {
            format!(
                "[[adopt]]\nsystem_ids = \"{system_id}\"\nmodel = \"generic-uav\"\n\
                 [[adopt.payloads]]\nname = \"camera\"\nplugin = \"camera\"\n\
                 config = {{ source = \"rtp\", listen = \"127.0.0.1:{port}\" }}\n\n"
            )
        });
        rules.collect()
    }

    fn configuration(&self) -> String {
        let plugins = self.plugins.display().to_string();
        let vehicles = match self.link {
            VehicleLink::Mavlink => {
                "[[endpoints]]\nname = \"bench\"\naddress = \"udp-listen://127.0.0.1:0\"\n\n".to_owned()
                    + &self.with_cameras()
                    + "[[adopt]]\nmodel = \"generic-uav\"\n"
            }
            VehicleLink::Dds => "[[adopt]]\nmodel = \"generic-uav\"\nlinks = [\"dds\"]\n".to_owned(),
        };
        let (domain, ros2, recorder) = (self.dds_domain, self.ros2, self.recorder);
        format!(
            "[plugins]\ndirectories = [{plugins:?}]\n\n\
             [coordinator]\ntake_off_stagger_s = 0.02\n\n\
             [dds]\ndomain_id = {domain}\n\n\
             [ros2]\nenabled = {ros2}\n\n\
             [recorder]\nenabled = {recorder}\n\n\
             [web]\nlisten = \"127.0.0.1:0\"\n\n\
             {vehicles}"
        )
    }
}

impl Program {
    /// What it has recorded until now, in bytes.
    pub fn recorded_bytes(&self) -> u64 {
        let files = std::fs::read_dir(self.files.path().join("flights"))
            .into_iter()
            .flatten();
        let sizes = files.filter_map(|entry| Some(entry.ok()?.metadata().ok()?.len()));
        sizes.sum()
    }

    /// Starts it and reads from its first lines where it listens.
    pub async fn start(setup: &Setup<'_>) -> Result<Self, BenchError> {
        let files = TempDir::with_prefix("skein-bench-").map_err(BenchError::system("temporary directory"))?;
        let config = files.path().join("node.toml");
        std::fs::write(&config, setup.configuration()).map_err(BenchError::system("temporary file"))?;
        let log = File::create(files.path().join("log")).map_err(BenchError::system("temporary file"))?;
        let config = config.display().to_string();
        let part = Part::start(
            "program under test",
            setup.program,
            &["run", "--config", &config],
            setup.scheduling,
            Stdio::from(log),
        )?;
        let nowhere = SocketAddr::from(([0, 0, 0, 0], 0));
        let mut program = Self {
            part,
            endpoint: nowhere,
            web: nowhere,
            files,
        };
        let has_endpoint = setup.link == VehicleLink::Mavlink;
        while program.web == nowhere || (has_endpoint && program.endpoint == nowhere) {
            let line = match program.part.line().await {
                Ok(line) => line,
                Err(e) => return Err(program.failed(&e.to_string())),
            };
            let last = line.split_whitespace().next_back().unwrap_or_default();
            if line.starts_with("Dashboard:") {
                program.web = last
                    .trim_start_matches("http://")
                    .trim_end_matches('/')
                    .parse()
                    .unwrap_or(nowhere);
            } else if line.starts_with("Endpoint:") {
                program.endpoint = last.parse().unwrap_or(nowhere);
            }
        }
        Ok(program)
    }

    /// A failure with the end of the program's log.
    fn failed(&self, what: &str) -> BenchError {
        let log = std::fs::read(self.files.path().join("log")).unwrap_or_default();
        let tail = log.get(log.len().saturating_sub(LOG_TAIL)..).unwrap_or_default();
        BenchError::Program(
            format!("{what}\n{}", String::from_utf8_lossy(tail))
                .trim_end()
                .to_owned(),
        )
    }

    /// Takes all vehicles off and returns when each of them holds in the air.
    pub async fn take_off(&self, vehicles: u16) -> Result<(), BenchError> {
        self.wait(vehicles, "ready to arm", |vehicle| {
            vehicle["ready_to_arm"] == true && vehicle["kinematics"].is_object() && vehicle["home"].is_object()
        })
        .await?;
        let order = json!({ "targets": "all", "command": { "command": "take_off", "height_m": HEIGHT_M } });
        let (status, receipts) = self.call(Method::POST, "/api/v1/commands", order.to_string()).await?;
        let refused = receipts["receipts"].as_array().map(|all| {
            all.iter()
                .filter(|receipt| !receipt["refusal"].is_null())
                .cloned()
                .collect::<Vec<_>>()
        });
        match refused {
            Some(none) if none.is_empty() && status.is_success() => {}
            _ => return Err(self.failed(&format!("take-off refused ({status}): {receipts}"))),
        }
        self.wait(vehicles, "holding in the air", |vehicle| {
            vehicle["flight_state"] == "holding" && vehicle["mode"] == "offboard"
        })
        .await
    }

    /// One call of its API: status and JSON.
    async fn call(&self, method: Method, path: &str, body: String) -> Result<(StatusCode, Value), BenchError> {
        let stream = TcpStream::connect(self.web)
            .await
            .map_err(BenchError::system("connect"))?;
        let (mut sender, connection) = hyper::client::conn::http1::handshake(TokioIo::new(stream)).await?;
        let driven = tokio::spawn(connection);
        let request = Request::builder()
            .method(method)
            .uri(path)
            .header(HOST, self.web.to_string())
            .header(CONTENT_TYPE, "application/json")
            .body(Full::new(Bytes::from(body)))
            .map_err(|e| BenchError::Argument(e.to_string()))?;
        let answer = sender.send_request(request).await?;
        let status = answer.status();
        let bytes = answer.into_body().collect().await?.to_bytes();
        driven.abort();
        let json = serde_json::from_slice(&bytes);
        json.map(|json| (status, json))
            .map_err(|e| self.failed(&format!("{path} answered {status}, not JSON: {e}")))
    }

    /// Waits until the vehicles are all there and `ready`.
    async fn wait(&self, vehicles: u16, what: &str, ready: impl Fn(&Value) -> bool) -> Result<(), BenchError> {
        let begun = Instant::now();
        loop {
            let (_, fleet) = self.call(Method::GET, "/api/v1/fleet", String::new()).await?;
            let all = fleet["vehicles"].as_array().cloned().unwrap_or_default();
            let count = all.iter().filter(|vehicle| ready(vehicle)).count();
            if count == usize::from(vehicles) {
                return Ok(());
            }
            if begun.elapsed() > PATIENCE {
                let other = all.iter().find(|vehicle| !ready(vehicle)).cloned().unwrap_or_default();
                let seconds = PATIENCE.as_secs();
                return Err(self.failed(&format!(
                    "{count} of {vehicles} vehicles {what} after {seconds} s; one that is not: {other}"
                )));
            }
            tokio::time::sleep(LOOK_EVERY).await;
        }
    }
}
