//! From a configuration to the parts of a node: everything that can be found wrong before a socket opens is found here.

use crate::fleet::payload_kind;
use skein_config::NodeConfig;
use skein_domain::fence::FencePlan;
use skein_domain::{Clock, SwarmFrame};
use skein_link_mavlink::{EndpointAddress, EndpointSettings};
use skein_plugin_host::{Catalog, Plugin, PluginKind, Trust};
use skein_px4::{LinkSettings, MessageRates};
use skein_safety::{Fences, Gate, Limits};
use skein_state::SharedState;
use skein_state::TransportAddress;
use std::path::PathBuf;
use std::sync::Arc;
use thiserror::Error;

/// Why a configuration cannot be turned into a node.
#[derive(Debug, Error)]
pub enum WiringError {
    /// An endpoint's address has no meaning.
    #[error("endpoints: \"{address}\": {reason}")]
    Address {
        /// As it stands in the configuration.
        address: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The fences cannot be any.
    #[error("safety: {reason}")]
    Fence {
        /// What is wrong with which.
        reason: String,
    },
    /// A plugin that a rule names was not found.
    #[error("the plugin \"{plugin}\" that an adoption rule names was not found in {searched}{}", problems.iter().map(|p| format!("\n  {p}")).collect::<String>())]
    MissingPlugin {
        /// Its name.
        plugin: String,
        /// Where it was looked for.
        searched: String,
        /// Files there that could not be taken, and why.
        problems: Vec<String>,
    },
    /// A plugin is not what a rule uses it for.
    #[error("{key}: the plugin \"{plugin}\" is a {kind}")]
    WrongKind {
        /// Where in the configuration.
        key: String,
        /// Its name.
        plugin: String,
        /// What it is.
        kind: String,
    },
    /// The configuration of a plugin, or the address of its device, is not right.
    #[error("{key}: {reason}")]
    PluginConfig {
        /// Where in the configuration.
        key: String,
        /// What is wrong.
        reason: String,
    },
}

/// Settings of all endpoints.
///
/// # Errors
/// When an address has no meaning.
pub fn endpoints(config: &NodeConfig) -> Result<Vec<EndpointSettings>, WiringError> {
    config
        .endpoints
        .iter()
        .map(|endpoint| {
            let address: EndpointAddress =
                endpoint
                    .address
                    .parse()
                    .map_err(|e: skein_link_mavlink::AddressError| WiringError::Address {
                        address: endpoint.address.clone(),
                        reason: e.to_string(),
                    })?;
            let name = endpoint.name.clone().unwrap_or_else(|| endpoint.address.clone());
            Ok(EndpointSettings {
                link: link_settings(config),
                ..EndpointSettings::new(name, address)
            })
        })
        .collect()
}

/// How links behave, whatever carries them.
#[must_use]
pub fn link_settings(config: &NodeConfig) -> LinkSettings {
    LinkSettings {
        own_system_id: config.link.own_system_id,
        own_component_id: config.link.own_component_id,
        lost_after_s: config.link.lost_after_s,
        hold_for_s: config.link.hold_for_s,
        setpoint_rate_hz: config.node.control_rate_hz,
        rates: MessageRates {
            local_position_hz: config.link.position_rate_hz,
            ..MessageRates::default()
        },
        ..LinkSettings::default()
    }
}

/// The safety gate.
///
/// # Errors
/// When the fence cannot be one.
pub fn gate(config: &NodeConfig, plan: &FencePlan) -> Result<Gate, WiringError> {
    let safety = &config.safety;
    let frame = config.swarm.origin.map(SwarmFrame::new);
    let fences = Fences::from_plan(plan, frame.as_ref()).map_err(|e| WiringError::Fence { reason: e.to_string() })?;
    let limits = Limits {
        max_speed_m_s: safety.max_speed_m_s,
        max_climb_m_s: safety.max_climb_m_s,
        max_descent_m_s: safety.max_descent_m_s,
        min_separation_m: safety.min_separation_m,
        separation_horizon_s: safety.separation_horizon_s,
    };
    Ok(Gate::new(limits, fences).with_min_height(safety.min_height_m))
}

/// The plugins of a configuration, with what it trusts.
#[must_use]
pub fn catalog(config: &NodeConfig) -> Catalog {
    let trust = Trust {
        allow_sha256: config.plugins.allow_sha256.clone(),
        minisign_public_key: config.plugins.minisign_public_key.clone(),
    };
    let uploads = config.plugins.upload_directory.iter();
    let directories: Vec<PathBuf> = config.plugins.directories.iter().chain(uploads).cloned().collect();
    Catalog::discover(&directories, trust)
}

/// The shared state, with plugins loaded.
///
/// # Errors
/// When the fence cannot be one or a plugin is missing.
pub fn shared(config: NodeConfig, clock: Arc<dyn Clock>) -> Result<SharedState, WiringError> {
    let imported = config
        .fence_plan()
        .map_err(|e| WiringError::Fence { reason: e.to_string() })?;
    let gate = gate(&config, &imported.plan)?;
    let catalog = catalog(&config);
    for (i, rule) in config.adopt.iter().enumerate() {
        let key = format!("adopt[{i}].model_config");
        let model = find(&catalog, &config, &rule.model)?;
        if model.manifest().kind != PluginKind::UAV_MODEL {
            return Err(wrong_kind(format!("adopt[{i}].model"), &model));
        }
        check_config(&model, key, &rule.model_config_json())?;
        for (j, payload) in rule.payloads.iter().enumerate() {
            let key = format!("adopt[{i}].payloads[{j}]");
            let plugin = find(&catalog, &config, &payload.plugin)?;
            if payload_kind(plugin.manifest().kind).is_none() {
                return Err(wrong_kind(format!("{key}.plugin"), &plugin));
            }
            if let Some(Err(reason)) = payload.transport.as_ref().map(|text| text.parse::<TransportAddress>()) {
                let key = format!("{key}.transport");
                return Err(WiringError::PluginConfig { key, reason });
            }
            check_config(&plugin, format!("{key}.config"), &payload.config_json())?;
        }
    }
    Ok(SharedState::new(config, clock, gate, imported.plan, catalog))
}

fn find(catalog: &Catalog, config: &NodeConfig, plugin: &str) -> Result<Arc<Plugin>, WiringError> {
    catalog.get(plugin).ok_or_else(|| WiringError::MissingPlugin {
        plugin: plugin.into(),
        searched: config
            .plugins
            .directories
            .iter()
            .map(|d| d.display().to_string())
            .collect::<Vec<_>>()
            .join(", "),
        problems: catalog.problems().iter().map(ToString::to_string).collect(),
    })
}

fn wrong_kind(key: String, plugin: &Plugin) -> WiringError {
    WiringError::WrongKind {
        key,
        plugin: plugin.manifest().name.clone(),
        kind: plugin.manifest().kind.to_string(),
    }
}

fn check_config(plugin: &Plugin, key: String, config_json: &str) -> Result<(), WiringError> {
    plugin
        .manifest()
        .check_config(config_json)
        .map_err(|e| WiringError::PluginConfig {
            key,
            reason: e.to_string(),
        })
}
