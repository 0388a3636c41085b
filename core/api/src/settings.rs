//! What the web side may be told. Bounds that nobody has reason to change stand beside the code that keeps them.

use skein_config::WebSettings;

/// Settings of the web side.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ApiSettings {
    /// Host names under which browsers may reach it, beside `localhost` and plain addresses. Without ports.
    pub allowed_hosts: Vec<String>,
    /// Origins, beside its own, whose pages may give commands, for example `http://localhost:5173` while the dashboard is
    /// served by a development server. Empty in operation.
    pub allowed_origins: Vec<String>,
}

impl From<&WebSettings> for ApiSettings {
    fn from(web: &WebSettings) -> Self {
        Self {
            allowed_hosts: web.allowed_hosts.clone(),
            allowed_origins: Vec::new(),
        }
    }
}
