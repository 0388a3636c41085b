//! From a configuration to the parts of a node: everything that can be found wrong before a socket opens is found here.

use crate::board::Board;
use skein_config::NodeConfig;
use skein_domain::Clock;
use skein_link_px4::{EndpointAddress, EndpointSettings, LinkSettings, MessageRates};
use skein_plugin_host::{Catalog, Runners};
use skein_safety::{Fence, Gate, Limits};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
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
    /// The fence cannot be one.
    #[error("safety.fence: {reason}")]
    Fence {
        /// What is wrong with it.
        reason: String,
    },
    /// A plugin that a rule names was not found.
    #[error("the UAV model \"{model}\" that an adoption rule names was not found in {searched}{}", problems.iter().map(|p| format!("\n  {p}")).collect::<String>())]
    MissingPlugin {
        /// Its name.
        model: String,
        /// Where it was looked for.
        searched: String,
        /// Files there that could not be taken, and why.
        problems: Vec<String>,
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
                    .map_err(|e: skein_link_px4::AddressError| WiringError::Address {
                        address: endpoint.address.clone(),
                        reason: e.to_string(),
                    })?;
            let name = endpoint.name.clone().unwrap_or_else(|| endpoint.address.clone());
            let link = LinkSettings {
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
            };
            Ok(EndpointSettings {
                link,
                ..EndpointSettings::new(name, address)
            })
        })
        .collect()
}

/// The safety gate.
///
/// # Errors
/// When the fence cannot be one.
pub fn gate(config: &NodeConfig) -> Result<Gate, WiringError> {
    let safety = &config.safety;
    let fence = match &safety.fence {
        None => None,
        Some(fence) => Some(
            Fence::new(fence.polygon_m.clone(), fence.floor_m, fence.ceiling_m)
                .map_err(|e| WiringError::Fence { reason: e.to_string() })?,
        ),
    };
    let limits = Limits {
        max_speed_m_s: safety.max_speed_m_s,
        max_climb_m_s: safety.max_climb_m_s,
        max_descent_m_s: safety.max_descent_m_s,
        min_separation_m: safety.min_separation_m,
        separation_horizon_s: safety.separation_horizon_s,
    };
    Ok(Gate::new(limits, fence))
}

/// The board, with plugins loaded.
///
/// # Errors
/// When the fence cannot be one or a plugin is missing.
pub fn board(config: NodeConfig, clock: Arc<dyn Clock>) -> Result<Board, WiringError> {
    let gate = gate(&config)?;
    let catalog = Catalog::discover(&config.plugins.directories);
    let models: BTreeSet<&str> = config.adopt.iter().map(|rule| rule.model.as_str()).collect();
    for model in models {
        if catalog.get(model).is_none() {
            return Err(WiringError::MissingPlugin {
                model: model.into(),
                searched: config
                    .plugins
                    .directories
                    .iter()
                    .map(|d| d.display().to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
                problems: catalog
                    .problems()
                    .iter()
                    .map(|p| format!("{}: {}", p.path.display(), p.error))
                    .collect(),
            });
        }
    }
    let runners = Runners::new(
        config.plugins.runner_threads,
        Duration::from_secs_f64(config.plugins.call_deadline_s),
    );
    Ok(Board::new(config, clock, gate, catalog, runners))
}
