//! The preflight report of vehicles and swarm: what is on the board, put into the pure checks; what plugins add; who overrode what.
//!
//! Must never do: judge. What is red is `skein-safety`'s and the plugins' to say.

use skein_domain::preflight::PreflightItem;

/// Most items that one plugin may add.
const MOST_ITEMS: usize = 64;

/// A plugin's items under its own name, so that none passes for one of ours or of another plugin.
pub fn own_items(plugin: &str, items: Vec<PreflightItem>) -> Vec<PreflightItem> {
    let prefix = format!("{plugin}/");
    items
        .into_iter()
        .take(MOST_ITEMS)
        .map(|mut item| {
            if !item.id.starts_with(&prefix) {
                item.id = format!("{prefix}{}", item.id);
            }
            item
        })
        .collect()
}
