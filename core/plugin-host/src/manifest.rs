//! The manifest of a plugin, decoded and found right.

use crate::LoadError;
use serde::Serialize;
use skein_domain::manifest::{EffectKind, PluginManifest};
use skein_plugin_abi::PluginKind;
use std::collections::BTreeSet;

/// No manifest is longer, in bytes.
const MAX_MANIFEST_BYTES: usize = 1 << 20;
/// No name or version is longer, in bytes.
const MAX_NAME_BYTES: usize = 64;

/// What a plugin says of itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manifest {
    /// Its name, by which configurations choose it.
    pub name: String,
    /// Its own version.
    pub version: String,
    /// What it is for.
    #[serde(serialize_with = "kind_word")]
    pub kind: PluginKind,
    /// One or two sentences for people.
    pub description: String,
    /// JSON Schema of its configuration, as text.
    pub config_schema_json: String,
    /// The effects it may return.
    pub effects: BTreeSet<EffectKind>,
}

fn kind_word<S: serde::Serializer>(kind: &PluginKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(kind)
}

impl Manifest {
    /// Decodes and checks.
    pub(crate) fn decode(kind: PluginKind, bytes: &[u8]) -> Result<Self, LoadError> {
        if bytes.len() > MAX_MANIFEST_BYTES {
            return Err(bad(format!("it has {} bytes", bytes.len())));
        }
        let PluginManifest {
            name,
            version,
            description,
            config_schema_json,
            effects,
            ..
        } = minicbor::decode(bytes).map_err(|e| bad(format!("not decodable: {e}")))?;
        let name_letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || name.len() > MAX_NAME_BYTES || !name.chars().all(name_letter) {
            return Err(bad(format!(
                "the name {name:?} is not made of 1 to {MAX_NAME_BYTES} of a-z, 0-9 and -"
            )));
        }
        if version.is_empty() || version.len() > MAX_NAME_BYTES || !version.chars().all(|c| c.is_ascii_graphic()) {
            return Err(bad(format!(
                "the version {version:?} is not made of 1 to {MAX_NAME_BYTES} printable letters"
            )));
        }
        if description.trim().is_empty() {
            return Err(bad("it has no description".to_owned()));
        }
        match serde_json::from_str::<serde_json::Value>(&config_schema_json) {
            Ok(serde_json::Value::Object(_)) => {}
            Ok(_) => return Err(bad("the schema of the configuration is not a JSON object".to_owned())),
            Err(e) => return Err(bad(format!("the schema of the configuration is not JSON: {e}"))),
        }
        let effects = effects
            .into_iter()
            .map(|code| {
                EffectKind::from_code(code).ok_or_else(|| bad(format!("effect {code} is not known to this host")))
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            name,
            version,
            kind,
            description,
            config_schema_json,
            effects,
        })
    }
}

fn bad(detail: String) -> LoadError {
    LoadError::BadManifest { detail }
}

#[cfg(test)]
mod tests;
