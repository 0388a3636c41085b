//! The settings themselves, one struct per table of the file. `default.toml` says what each key is for.

use crate::{
    DdsSettings, LinkKind, OperatorSettings, RecorderSettings, ResumeSettings, Ros2Settings, SwarmSettings,
    SystemIdSet, TrackingSettings, UpgradeSettings, VideoSettings,
};
use serde::{Deserialize, Serialize};
use skein_domain::{EnergySettings, FailsafeSettings, FenceZone, PreflightSettings};
use std::net::SocketAddr;
use std::path::PathBuf;

/// The whole configuration of a node.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NodeConfig {
    /// The node itself.
    pub node: NodeSettings,
    /// The swarm it is part of, and its common frame.
    pub swarm: SwarmSettings,
    /// Where vehicles are heard.
    pub endpoints: Vec<EndpointSettings>,
    /// Where this node is in DDS.
    pub dds: DdsSettings,
    /// How links behave.
    pub link: LinkSettings,
    /// What a newly seen vehicle becomes; the first rule that fits is taken.
    pub adopt: Vec<AdoptionRule>,
    /// What a newly seen vehicle must show while others fly.
    pub newcomers: NewcomerSettings,
    /// Where plugins come from and how long they may take.
    pub plugins: PluginSettings,
    /// The safety gate.
    pub safety: SafetySettings,
    /// How the coordinator moves the swarm.
    pub coordinator: CoordinatorSettings,
    /// What is done with its vehicles in the air after it was killed.
    pub resume: ResumeSettings,
    /// Other versions of the program, from the swarm.
    pub upgrade: UpgradeSettings,
    /// The web API and dashboard.
    pub web: WebSettings,
    /// Videos of cameras.
    pub video: VideoSettings,
    /// What is recorded of flights.
    pub recorder: RecorderSettings,
    /// How tracks are made of what detectors find.
    pub tracking: TrackingSettings,
    /// The swarm on ROS 2.
    pub ros2: Ros2Settings,
    /// Who may do what an ordinary client of the API may not.
    pub operators: Vec<OperatorSettings>,
    /// Fault injection.
    pub faults: FaultSettings,
}

/// `[node]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NodeSettings {
    /// Name shown to people.
    pub name: String,
    /// Control periods per second.
    pub control_rate_hz: f64,
    /// Snapshots per second for screens and metrics.
    pub snapshot_rate_hz: f64,
    /// All vehicles of this node are simulated. It is said on every screen, and changes nothing of how they are flown.
    pub simulated: bool,
    /// What the autopilots of vehicles in the air are asked for when the node stops.
    pub on_stop: OnStop,
}

/// What the autopilots of vehicles in the air are asked for when the node stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnStop {
    /// To hold where they are.
    #[default]
    Hold,
    /// To land where they are.
    Land,
    /// To return to where they took off.
    Return,
    /// Nothing: their setpoints end, and their own failsafe acts.
    Leave,
}

impl Default for NodeSettings {
    fn default() -> Self {
        Self {
            name: "skein".into(),
            control_rate_hz: 50.0,
            snapshot_rate_hz: 20.0,
            simulated: false,
            on_stop: OnStop::default(),
        }
    }
}

/// `[[endpoints]]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndpointSettings {
    /// Name shown to people; the address if left out.
    #[serde(default)]
    pub name: Option<String>,
    /// For example `udp-listen://127.0.0.1:14540`.
    pub address: String,
}

/// `[link]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkSettings {
    /// Our MAVLink system id.
    pub own_system_id: u8,
    /// Our MAVLink component id.
    pub own_component_id: u8,
    /// A vehicle not heard for so long is lost, in seconds.
    pub lost_after_s: f64,
    /// How long a setpoint is good, in seconds.
    pub setpoint_valid_s: f64,
    /// How long the link holds position after its setpoint has expired, in seconds.
    pub hold_for_s: f64,
    /// Rate asked for LOCAL_POSITION_NED.
    pub position_rate_hz: f64,
}

impl Default for LinkSettings {
    fn default() -> Self {
        Self {
            own_system_id: 245,
            own_component_id: 190,
            lost_after_s: 1.5,
            setpoint_valid_s: 0.1,
            hold_for_s: 5.0,
            position_rate_hz: 50.0,
        }
    }
}

/// `[newcomers]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NewcomerSettings {
    /// How long a vehicle that is heard for the first time while others fly must tell its position without a pause, in seconds.
    pub probation_s: f64,
    /// How many of them are taken in within a minute, at most.
    pub most_per_min: u32,
}

impl Default for NewcomerSettings {
    fn default() -> Self {
        Self {
            probation_s: 3.0,
            most_per_min: 12,
        }
    }
}

/// `[[adopt]]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdoptionRule {
    /// System ids it fits; every one if left out.
    #[serde(default = "SystemIdSet::all")]
    pub system_ids: SystemIdSet,
    /// Name of the endpoint it fits; every one if left out.
    #[serde(default)]
    pub endpoint: Option<String>,
    /// What it is flown over: the first, or the other one while that is not heard.
    #[serde(default = "AdoptionRule::default_links")]
    pub links: Vec<LinkKind>,
    /// Vehicle name; `{system_id}` and `{vehicle_id}` are filled in.
    #[serde(default = "AdoptionRule::default_name")]
    pub name: String,
    /// Its autopilot runs in a simulation. One that says so over MAVLink, as PX4's does, need not be told of here.
    #[serde(default)]
    pub simulated: bool,
    /// Added to the system id to make the vehicle id, so that several networks can use the same system ids.
    #[serde(default)]
    pub vehicle_id_offset: u16,
    /// UAV-model plugin.
    #[serde(default = "AdoptionRule::default_model")]
    pub model: String,
    /// Configuration handed to the plugin.
    #[serde(default)]
    pub model_config: toml::Table,
    /// Where the plugin runs.
    #[serde(default)]
    pub model_isolation: Isolation,
    /// What the vehicle carries.
    #[serde(default)]
    pub payloads: Vec<PayloadRule>,
}

/// Where a plugin instance runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Isolation {
    /// In the node's own process: quickest; a panic or a hang is contained, a wild pointer is not.
    #[default]
    InProcess,
    /// In a child process with limits: whatever it does, the node goes on.
    Child,
}

/// What becomes of a vehicle when one of its payloads has failed too often.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Escalation {
    /// It is shown as degraded and flies on.
    #[default]
    Degrade,
    /// It is shown as degraded, leaves the formation and holds.
    Hold,
    /// It is shown as degraded, leaves the formation and returns.
    Return,
}

/// `[[adopt.payloads]]`, and what the API takes to attach one at run time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadRule {
    /// Its name on the vehicle.
    #[schemars(regex(pattern = "^[A-Za-z0-9_-]{1,32}$"))]
    pub name: String,
    /// Payload plugin.
    #[schemars(length(min = 1))]
    pub plugin: String,
    /// Where the plugin runs.
    #[serde(default)]
    pub isolation: Isolation,
    /// How its device is reached if not over the vehicle's MAVLink: `udp://ADDRESS:PORT` or `serial:///dev/ttyUSB0?baud=115200`.
    #[serde(default)]
    pub transport: Option<String>,
    /// What happens when it has failed too often.
    #[serde(default)]
    pub on_failure: Escalation,
    /// Configuration handed to the plugin.
    #[serde(default = "empty_object")]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    #[ts(type = "Record<string, unknown>")]
    pub config: serde_json::Value,
}

fn empty_object() -> serde_json::Value {
    serde_json::Value::Object(serde_json::Map::new())
}

impl AdoptionRule {
    fn default_name() -> String {
        "uav-{system_id}".into()
    }

    fn default_links() -> Vec<LinkKind> {
        vec![LinkKind::Mavlink]
    }

    fn default_model() -> String {
        "generic-uav".into()
    }

    /// The plugin configuration as JSON text.
    #[must_use]
    pub fn model_config_json(&self) -> String {
        serde_json::to_string(&self.model_config).unwrap_or_else(|_| "{}".into())
    }
}

impl Default for AdoptionRule {
    fn default() -> Self {
        Self {
            system_ids: SystemIdSet::all(),
            endpoint: None,
            links: Self::default_links(),
            name: Self::default_name(),
            simulated: false,
            vehicle_id_offset: 0,
            model: Self::default_model(),
            model_config: toml::Table::new(),
            model_isolation: Isolation::default(),
            payloads: Vec::new(),
        }
    }
}

/// `[plugins]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PluginSettings {
    /// Directories searched for plugins, in order; relative ones from the folder of the configuration file.
    pub directories: Vec<PathBuf>,
    /// Longest time one call may take, in seconds.
    pub call_deadline_s: f64,
    /// Threads the calls run on.
    pub runner_threads: usize,
    /// SHA-256 of the only libraries that are taken, beside signed ones; empty, and no key: any in the directories.
    pub allow_sha256: Vec<String>,
    /// Minisign public key; with one, only libraries with a good signature beside them are taken, and those on the list.
    pub minisign_public_key: Option<String>,
    /// Where libraries uploaded over the API go; unset: none are taken.
    pub upload_directory: Option<PathBuf>,
    /// Memory of a plugin in a child process, in mebibytes of address space.
    pub child_memory_mib: u64,
    /// Share of one core that a child process may use over ten seconds.
    pub child_cpu_share: f64,
    /// Files that a child process may have open.
    pub child_open_files: u64,
}

impl Default for PluginSettings {
    fn default() -> Self {
        Self {
            directories: vec![PathBuf::from("plugins")],
            call_deadline_s: 0.05,
            runner_threads: 2,
            allow_sha256: Vec::new(),
            minisign_public_key: None,
            upload_directory: None,
            child_memory_mib: 512,
            child_cpu_share: 0.8,
            child_open_files: 64,
        }
    }
}

/// `[safety]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SafetySettings {
    /// Horizontal speed limit in metres per second.
    pub max_speed_m_s: f64,
    /// Climb limit in metres per second.
    pub max_climb_m_s: f64,
    /// Descent limit in metres per second.
    pub max_descent_m_s: f64,
    /// No setpoint leads lower than this in flight, in metres above the place the vehicle took off from. Landings are the autopilot's own.
    pub min_height_m: f64,
    /// Smallest distance between two vehicles in the air, in metres.
    pub min_separation_m: f64,
    /// How far ahead the separation check looks, in seconds.
    pub separation_horizon_s: f64,
    /// Files with zones, GeoJSON or QGroundControl's `.plan`; relative ones from the folder of the configuration file.
    pub fence_files: Vec<PathBuf>,
    /// The fence; none if left out. It is one inclusion zone.
    pub fence: Option<FenceSettings>,
    /// More zones to stay in or keep out of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub zones: Vec<FenceZone>,
    /// How several vehicles return at once.
    pub returning: ReturningSettings,
    /// What is done when something goes wrong in flight.
    pub failsafe: FailsafeSettings,
    /// How the way home is reckoned.
    pub energy: EnergySettings,
    /// What is looked at before arming.
    pub preflight: PreflightSettings,
}

impl Default for SafetySettings {
    fn default() -> Self {
        Self {
            max_speed_m_s: 12.0,
            max_climb_m_s: 4.0,
            max_descent_m_s: 3.0,
            min_height_m: 1.0,
            min_separation_m: 2.0,
            separation_horizon_s: 6.0,
            fence_files: Vec::new(),
            fence: None,
            zones: Vec::new(),
            returning: ReturningSettings::default(),
            failsafe: FailsafeSettings::default(),
            energy: EnergySettings::default(),
            preflight: PreflightSettings::default(),
        }
    }
}

/// `[safety.returning]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReturningSettings {
    /// Height of the lowest above the highest launch place, in metres.
    pub height_m: f64,
    /// Vertical distance between two of them, in metres.
    pub layer_gap_m: f64,
    /// Distance between two landing places, in metres.
    pub landing_spacing_m: f64,
}

impl Default for ReturningSettings {
    fn default() -> Self {
        Self {
            height_m: 12.0,
            layer_gap_m: 4.0,
            landing_spacing_m: 3.0,
        }
    }
}

/// `[safety.fence]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FenceSettings {
    /// Corners as [north_m, east_m] in the swarm frame.
    pub polygon_m: Vec<[f64; 2]>,
    /// Lowest height above the swarm origin in metres.
    pub floor_m: f64,
    /// Greatest height above the swarm origin in metres.
    pub ceiling_m: f64,
}

/// `[coordinator]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoordinatorSettings {
    /// Time between the take-offs of two vehicles that were told to take off together, in seconds.
    pub take_off_stagger_s: f64,
    /// Horizontal speed limit within the formation while it changes shape, in metres per second.
    pub transition_speed_m_s: f64,
    /// Acceleration limit within the formation while it changes shape, in metres per second squared.
    pub transition_acceleration_m_s2: f64,
    /// Climb limit within the formation while it changes shape, in metres per second.
    pub transition_climb_m_s: f64,
    /// Smallest distance that a planned change may bring about, in metres.
    pub transition_min_distance_m: f64,
    /// A leader not heard for so long is replaced, in seconds.
    pub leader_lost_after_s: f64,
    /// Ids of vehicles that lead before others, in this order. The rest follow by health.
    pub leader_order: Vec<u16>,
}

impl Default for CoordinatorSettings {
    fn default() -> Self {
        Self {
            take_off_stagger_s: 0.4,
            transition_speed_m_s: 6.0,
            transition_acceleration_m_s2: 3.0,
            transition_climb_m_s: 2.5,
            transition_min_distance_m: 2.8,
            leader_lost_after_s: 0.6,
            leader_order: Vec::new(),
        }
    }
}

/// `[web]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WebSettings {
    /// Whether dashboard and API are served. A node of a swarm may leave that to others.
    pub enabled: bool,
    /// Address the dashboard and API listen on; loopback unless changed here.
    pub listen: SocketAddr,
    /// Host names, beside addresses and `localhost`, under which browsers may reach it.
    pub allowed_hosts: Vec<String>,
}

impl Default for WebSettings {
    fn default() -> Self {
        Self {
            enabled: true,
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            allowed_hosts: Vec::new(),
        }
    }
}

/// `[faults]`
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultSettings {
    /// Whether faults may be injected through the API.
    pub enabled: bool,
}

impl NodeConfig {
    /// Whether vehicles are looked for on DDS.
    #[must_use]
    pub fn flies_over_dds(&self) -> bool {
        self.adopt.iter().any(|rule| rule.links.contains(&LinkKind::Dds))
    }

    /// Whether there is no way over which a vehicle could be heard.
    #[must_use]
    pub fn hears_nobody(&self) -> bool {
        self.endpoints.is_empty() && !self.flies_over_dds()
    }
}
