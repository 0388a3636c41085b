//! Imports only point down: the order of the crates of `core`, and what plugins may know.

use super::Finding;
use crate::workspace::{Package, Workspace};

/// The crates of `core` from the binary to the words; each may depend on what stands below it.
/// Names of crates that are not built yet keep their place.
const ORDER: [&str; 41] = [
    "skein",
    "skein-demo",
    "skein-node",
    "skein-api",
    "skein-replay",
    "skein-recorder",
    "skein-ros2",
    "skein-runtime",
    "skein-cluster",
    "skein-streaming",
    "skein-tracking",
    "skein-upgrade",
    "skein-state",
    "skein-report",
    "skein-export",
    "skein-ros2-messages",
    "skein-recording",
    "skein-coordination",
    "skein-view",
    "skein-video",
    "skein-sim-dds",
    "skein-link-dds",
    "skein-link-mavlink",
    "skein-px4",
    "skein-bus-zenoh",
    "skein-bus-dds",
    "skein-dds",
    "skein-bus",
    "skein-plugin-host",
    "skein-plugin-sdk",
    "skein-plugin-abi",
    "skein-sim",
    "skein-sim-payloads",
    "skein-config",
    "skein-realtime",
    "skein-telemetry",
    "skein-failover",
    "skein-vision",
    "skein-flight",
    "skein-safety",
    "skein-domain",
];
/// What of ours a plugin may know: how to be one, the words, and what is pure: flight, sight and encoded pictures; beside these, other plugins' logic, of
/// which it may be composed.
const PLUGINS_MAY_USE: [&str; 5] = [
    "skein-plugin-sdk",
    "skein-domain",
    "skein-flight",
    "skein-vision",
    "skein-video",
];

/// Checks every dependency between members that ships.
pub fn check(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in &workspace.packages {
        if package.folder.starts_with("core/") && place(&package.name).is_none() {
            findings.push(finding(
                package,
                format!("{} has no place in the order of tidy/layers.rs", package.name),
            ));
        }
        let ours = package
            .dependencies
            .iter()
            .filter(|on| on.ships() && workspace.package(&on.name).is_some());
        for on in ours {
            let composed = package.folder.starts_with("plugins/")
                && workspace
                    .package(&on.name)
                    .is_some_and(|of| of.folder.starts_with("plugins/") && !of.is_plugin_library());
            if let Some(what) = breach(package, &on.name).filter(|_| !composed) {
                findings.push(finding(package, what));
            }
        }
    }
    findings
}

fn finding(package: &Package, what: String) -> Finding {
    Finding::of(format!("{}/Cargo.toml", package.folder), "layers", what)
}

fn place(name: &str) -> Option<usize> {
    ORDER.iter().position(|known| *known == name)
}

/// Why `package` must not depend on `on`, if it must not.
pub fn breach(package: &Package, on: &str) -> Option<String> {
    if package.folder.starts_with("core/") {
        return match (place(&package.name), place(on)) {
            (Some(from), Some(to)) if to > from => None,
            (Some(_), Some(_)) => Some(format!("depends on {on}, which does not stand below it")),
            _ => Some(format!("depends on {on}, which is no crate of core")),
        };
    }
    if package.folder.starts_with("plugins/") {
        let own_logic = package.folder.ends_with("/cdylib") && package.name == format!("{on}-plugin");
        let allowed = own_logic || PLUGINS_MAY_USE.contains(&on);
        return (!allowed).then(|| format!("depends on {on}; a plugin knows {} only", PLUGINS_MAY_USE.join(", ")));
    }
    None
}
