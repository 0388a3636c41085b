//! Who asks: an operator is known by a secret shown as a bearer token, of which the configuration holds the SHA-256.
//!
//! Must never do: let an ordinary request pass for a person's. Without configured operators nobody is one.

use crate::app::App;
use crate::error::ApiError;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use sha2::{Digest, Sha256};
use skein_config::OperatorSettings;
use skein_runtime::NodeHandle;

/// Somebody the configuration knows.
pub(crate) struct Operator(pub(crate) OperatorSettings);

impl FromRequestParts<App> for Operator {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        named(&app.node, &parts.headers).map(Self).ok_or(ApiError::NoOperator)
    }
}

/// The operator that a request's secret names, if it shows one.
pub(crate) fn named(node: &NodeHandle, headers: &HeaderMap) -> Option<OperatorSettings> {
    let shown = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    known(&node.config().operators, shown.strip_prefix("Bearer ")?)
}

/// The operator with this secret. Digests are compared: how long that takes tells nothing of the secret.
fn known(operators: &[OperatorSettings], secret: &str) -> Option<OperatorSettings> {
    let digest = Sha256::digest(secret.as_bytes());
    let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    operators
        .iter()
        .rfind(|operator| operator.token_sha256.eq_ignore_ascii_case(&hex))
        .cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anna() -> OperatorSettings {
        OperatorSettings {
            name: "anna".into(),
            // Of "password".
            token_sha256: "5E884898DA28047151D0E56F8DC6292773603D0D6AABBDD62A11EF721D1542D8".into(),
            may_override_preflight: true,
            may_upgrade: false,
        }
    }

    #[test]
    fn only_the_whole_secret_makes_an_operator() {
        assert_eq!(known(&[anna()], "password").map(|o| o.name), Some("anna".to_owned()));
        for wrong in ["", "passwor", "password ", "Password", &anna().token_sha256] {
            assert_eq!(known(&[anna()], wrong), None, "{wrong}");
        }
        assert_eq!(known(&[], "password"), None);
    }
}
