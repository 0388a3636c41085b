//! `[[operators]]`: who may do what an ordinary client of the API may not.

use serde::{Deserialize, Serialize};

/// One person, known by a secret of his own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatorSettings {
    /// The name that records show.
    pub name: String,
    /// SHA-256 of the secret in hexadecimal: the secret itself stands nowhere.
    pub token_sha256: String,
    /// May arm vehicles although items of the preflight report are red.
    #[serde(default)]
    pub may_override_preflight: bool,
    /// May give the nodes of the swarm another version of the program.
    #[serde(default)]
    pub may_upgrade: bool,
}

impl OperatorSettings {
    /// What is wrong with it, if anything.
    ///
    /// # Errors
    /// The key and what it must be.
    pub fn check(&self) -> Result<(), (&'static str, &'static str)> {
        if self.name.trim().is_empty() {
            return Err(("name", "must not be empty"));
        }
        let is_digest = self.token_sha256.len() == 64 && self.token_sha256.chars().all(|c| c.is_ascii_hexdigit());
        if !is_digest {
            return Err((
                "token_sha256",
                "must be 64 hexadecimal digits: the SHA-256 of the operator's secret",
            ));
        }
        Ok(())
    }
}
