//! What a person does at a gateway, over HTTP.
//!
//! Must never do: try again what was refused, unless the flight asks for it.

use reqwest::{Client, Method};
use serde_json::{Value, json};
use std::net::Ipv4Addr;
use std::time::Duration;

/// Longest a node may take to answer. Commands for vehicles of other hosts go over the air and back.
const ANSWER_WITHIN: Duration = Duration::from_secs(10);

/// Somebody at one gateway.
#[derive(Debug, Clone)]
pub struct Operator {
    client: Client,
    base: String,
}

/// An answer.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Status of HTTP; 0 if none came.
    pub status: u16,
    /// Its body; a text if it was no JSON.
    pub body: Value,
}

impl Answer {
    /// Whether it was done.
    #[must_use]
    pub fn is_success(&self) -> bool {
        (200..300).contains(&self.status)
    }
}

impl Operator {
    pub(crate) fn new(address: Ipv4Addr) -> Self {
        let client = Client::builder().timeout(ANSWER_WITHIN).build();
        Self {
            client: client.unwrap_or_default(),
            base: format!("http://{address}:8080"),
        }
    }

    /// What stands there; null if the node does not answer.
    pub async fn get(&self, path: &str) -> Value {
        let answer = self.ask(Method::GET, path, None).await;
        if answer.is_success() { answer.body } else { Value::Null }
    }

    /// Asks for something to be done.
    pub async fn ask(&self, method: Method, path: &str, body: Option<Value>) -> Answer {
        let mut request = self.client.request(method, format!("{}{path}", self.base));
        if let Some(body) = body {
            request = request.json(&body);
        }
        let Ok(answer) = request.send().await else {
            return Answer {
                status: 0,
                body: Value::Null,
            };
        };
        let status = answer.status().as_u16();
        let text = answer.text().await.unwrap_or_default();
        let body = serde_json::from_str(&text).unwrap_or(Value::String(text));
        Answer { status, body }
    }

    /// Gives vehicles a command (all, or those named); gives each one's refusal.
    pub async fn command(&self, vehicles: Option<&[u8]>, command: Value) -> Answer {
        let targets = vehicles.map_or(json!("all"), |ids| json!({ "vehicles": ids }));
        let body = json!({ "targets": targets, "command": command });
        self.ask(Method::POST, "/api/v1/commands", Some(body)).await
    }

    /// What the node knows of its swarm.
    pub async fn swarm(&self) -> Value {
        self.get("/api/v1/swarm").await
    }

    /// Whether this node coordinates.
    pub async fn acts(&self) -> bool {
        self.swarm().await["acting"] == json!(true)
    }

    /// The fleet as this node shows it.
    pub async fn fleet(&self) -> Value {
        self.get("/api/v1/fleet").await
    }

    /// One vehicle as this node shows it.
    pub async fn vehicle(&self, id: u8) -> Value {
        self.get(&format!("/api/v1/vehicles/{id}")).await
    }
}
