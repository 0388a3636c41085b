//! Who may speak to this node. A web page from elsewhere must not drive vehicles through the browser of somebody who happens to
//! have the dashboard's computer: neither by a request of its own (other origin), nor by making its own name point here.
//!
//! Must never do: authenticate people. It only keeps foreign pages out.

use crate::error::ApiError;
use crate::settings::ApiSettings;
use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, Method, header};
use axum::middleware::Next;
use axum::response::Response;
use std::net::IpAddr;
use std::sync::Arc;

/// The names and origins that are let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Guard {
    hosts: Vec<String>,
    origins: Vec<String>,
}

impl Guard {
    /// As configured.
    #[must_use]
    pub fn new(settings: &ApiSettings) -> Self {
        let plain = |name: &String| name.trim().trim_end_matches('.').to_ascii_lowercase();
        Self {
            hosts: settings.allowed_hosts.iter().map(plain).collect(),
            origins: settings
                .allowed_origins
                .iter()
                .map(|origin| origin.trim_end_matches('/').to_ascii_lowercase())
                .collect(),
        }
    }

    /// Whether a request with this method and these headers may go on. `authority` is the host in the request line, if any.
    ///
    /// # Errors
    /// When the host is not ours, or a foreign page tries to change something or to listen.
    pub fn check(&self, method: &Method, authority: Option<&Authority>, headers: &HeaderMap) -> Result<(), ApiError> {
        let host = self.own_host(authority, headers)?;
        let reads_only = matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS);
        // A page may open a WebSocket to anywhere and read what comes: browsers leave the check to the server.
        if reads_only && !headers.contains_key(header::UPGRADE) {
            return Ok(());
        }
        self.own_origin(&host, headers)
    }

    /// The host a request is for, if it is ours. An address cannot be made to point elsewhere, a name can.
    fn own_host(&self, authority: Option<&Authority>, headers: &HeaderMap) -> Result<Authority, ApiError> {
        let mut said = headers.get_all(header::HOST).iter();
        let from_header = match (said.next(), said.next()) {
            (Some(host), None) => host.to_str().ok().and_then(|host| host.parse::<Authority>().ok()),
            _ => None,
        };
        let host = authority.cloned().or(from_header).ok_or(ApiError::NoHost)?;
        let name = host
            .host()
            .trim_start_matches('[')
            .trim_end_matches(']')
            .trim_end_matches('.')
            .to_ascii_lowercase();
        if name == "localhost" || name.parse::<IpAddr>().is_ok() || self.hosts.contains(&name) {
            return Ok(host);
        }
        Err(ApiError::ForeignHost {
            host: host.host().to_owned(),
        })
    }

    /// Programs send no `Origin`. Browsers send one with everything that can change something, and with every WebSocket.
    fn own_origin(&self, host: &Authority, headers: &HeaderMap) -> Result<(), ApiError> {
        let foreign = |origin: &str| {
            Err(ApiError::ForeignOrigin {
                origin: origin.chars().take(200).collect(),
            })
        };
        let mut said = headers.get_all(header::ORIGIN).iter();
        let (first, second) = (said.next(), said.next());
        let Some(origin) = first else {
            let site = headers.get("sec-fetch-site").map(|site| site.as_bytes());
            return match site {
                None | Some(b"same-origin" | b"none") => Ok(()),
                Some(_) => foreign("another site"),
            };
        };
        let Ok(origin) = origin.to_str() else {
            return foreign("an unreadable origin");
        };
        if second.is_some() {
            return foreign("several origins");
        }
        let origin = origin.to_ascii_lowercase();
        let own = host.as_str().to_ascii_lowercase();
        let is_own = ["http://", "https://"]
            .iter()
            .any(|scheme| origin.strip_prefix(scheme).is_some_and(|rest| rest == own));
        if is_own || self.origins.contains(&origin) {
            Ok(())
        } else {
            foreign(&origin)
        }
    }
}

/// The guard as a layer around every route.
///
/// # Errors
/// As [`Guard::check`].
pub async fn keep_foreign_pages_out(
    State(guard): State<Arc<Guard>>,
    request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    guard.check(request.method(), request.uri().authority(), request.headers())?;
    Ok(next.run(request).await)
}

#[cfg(test)]
mod tests;
