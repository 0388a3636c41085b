//! `skein plugin …` against a running node: the life of its plugins, over its API.
//!
//! Must never do: reach around the API. What a person can do here, a program can do there.

use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use reqwest::{Method, Url};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// A node is asked for no longer than this: an exchange of versions takes its time per instance.
const ANSWER_WITHIN: Duration = Duration::from_secs(60);

/// Which node.
#[derive(Debug, Clone, Args)]
pub struct NodeArguments {
    /// The node's dashboard address.
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8080")]
    pub node: Url,
    /// What to do there.
    #[command(subcommand)]
    pub what: NodeCommand,
}

/// What can be done with the plugins of a running node.
#[derive(Debug, Clone, Subcommand)]
pub enum NodeCommand {
    /// Its plugins, with versions and instances.
    List,
    /// Look for new and changed libraries in its directories.
    Rescan,
    /// Go over to the newest version of a plugin, in flight; back if it does not come up.
    Upgrade {
        /// The plugin.
        plugin: String,
    },
    /// Go back to the version before.
    Rollback {
        /// The plugin.
        plugin: String,
    },
    /// Forget a plugin that nothing uses.
    Remove {
        /// The plugin.
        plugin: String,
    },
    /// Start a plugin instance anew and forget its failures.
    Restart {
        /// The vehicle.
        vehicle: u16,
        /// The payload; the vehicle's UAV model if left out.
        payload: Option<String>,
    },
    /// Put a payload on a vehicle.
    Attach {
        /// The vehicle.
        vehicle: u16,
        /// The payload's name on it.
        payload: String,
        /// The plugin [default: as the payload is called].
        #[arg(long)]
        plugin: Option<String>,
        /// In a process of its own.
        #[arg(long)]
        child: bool,
        /// How its device is reached, for example udp://192.168.144.25:37260.
        #[arg(long, value_name = "ADDRESS")]
        transport: Option<String>,
        /// Its configuration as JSON.
        #[arg(long, default_value = "{}", value_name = "JSON")]
        config: String,
    },
    /// Take a payload off a vehicle.
    Detach {
        /// The vehicle.
        vehicle: u16,
        /// The payload.
        payload: String,
    },
    /// Give a payload a command.
    Command {
        /// The vehicle.
        vehicle: u16,
        /// The payload.
        payload: String,
        /// The command as JSON, for example '{"command":"neutral"}'.
        command: String,
    },
    /// Hand a library over; it stays off until it is enabled.
    Upload {
        /// The library.
        file: PathBuf,
    },
    /// Enable an uploaded library.
    Enable {
        /// Its file name.
        file: String,
    },
}

pub(super) async fn node(arguments: &NodeArguments) -> anyhow::Result<ExitCode> {
    let client = Client::new(arguments.node.clone())?;
    let answer = client.carry_out(&arguments.what).await?;
    match &arguments.what {
        NodeCommand::List | NodeCommand::Rescan | NodeCommand::Enable { .. } => list(&answer),
        NodeCommand::Upgrade { .. } | NodeCommand::Rollback { .. } => return Ok(exchanged(&answer)),
        _ => println!("done"),
    }
    Ok(ExitCode::SUCCESS)
}

struct Client {
    http: reqwest::Client,
    node: Url,
}

impl Client {
    fn new(node: Url) -> anyhow::Result<Self> {
        let http = reqwest::Client::builder().timeout(ANSWER_WITHIN).build()?;
        Ok(Self { http, node })
    }

    async fn carry_out(&self, what: &NodeCommand) -> anyhow::Result<Value> {
        let of = |vehicle: &u16, payload: &str| format!("vehicles/{vehicle}/payloads/{payload}");
        match what {
            NodeCommand::List => self.ask(Method::GET, "plugins", None).await,
            NodeCommand::Rescan => self.ask(Method::POST, "plugins/rescan", None).await,
            NodeCommand::Upgrade { plugin } => self.ask(Method::POST, &format!("plugins/{plugin}/upgrade"), None).await,
            NodeCommand::Rollback { plugin } => {
                self.ask(Method::POST, &format!("plugins/{plugin}/rollback"), None)
                    .await
            }
            NodeCommand::Remove { plugin } => self.ask(Method::DELETE, &format!("plugins/{plugin}"), None).await,
            NodeCommand::Restart { vehicle, payload } => {
                let path = match payload {
                    Some(payload) => format!("{}/restart", of(vehicle, payload)),
                    None => format!("vehicles/{vehicle}/model/restart"),
                };
                self.ask(Method::POST, &path, None).await
            }
            NodeCommand::Attach {
                vehicle,
                payload,
                plugin,
                child,
                transport,
                config,
            } => {
                let config: Value = serde_json::from_str(config).context("--config is not JSON")?;
                let rule = json!({
                    "name": payload,
                    "plugin": plugin.as_ref().unwrap_or(payload),
                    "isolation": if *child { "child" } else { "in_process" },
                    "transport": transport,
                    "config": config,
                });
                self.ask(Method::POST, &format!("vehicles/{vehicle}/payloads"), Some(rule))
                    .await
            }
            NodeCommand::Detach { vehicle, payload } => self.ask(Method::DELETE, &of(vehicle, payload), None).await,
            NodeCommand::Command {
                vehicle,
                payload,
                command,
            } => {
                let command: Value = serde_json::from_str(command).context("the command is not JSON")?;
                self.ask(
                    Method::POST,
                    &format!("{}/command", of(vehicle, payload)),
                    Some(command),
                )
                .await
            }
            NodeCommand::Upload { file } => self.upload(file).await,
            NodeCommand::Enable { file } => {
                self.ask(Method::POST, &format!("plugins/uploads/enable?file={file}"), None)
                    .await
            }
        }
    }

    async fn ask(&self, method: Method, path: &str, body: Option<Value>) -> anyhow::Result<Value> {
        let request = self.http.request(method, self.node.join(&format!("api/v1/{path}"))?);
        let request = match body {
            Some(body) => request.json(&body),
            None => request,
        };
        self.answer(request).await
    }

    async fn upload(&self, file: &PathBuf) -> anyhow::Result<Value> {
        let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let url = self.node.join(&format!("api/v1/plugins/uploads?file={name}"))?;
        self.answer(self.http.post(url).body(bytes)).await
    }

    async fn answer(&self, request: reqwest::RequestBuilder) -> anyhow::Result<Value> {
        let answer = request
            .send()
            .await
            .with_context(|| format!("no node answers at {}", self.node))?;
        let status = answer.status();
        let text = answer.text().await?;
        let body: Value = serde_json::from_str(&text).unwrap_or(Value::Null);
        if status.is_success() {
            return Ok(body);
        }
        match body.pointer("/error/message").and_then(Value::as_str) {
            Some(message) => bail!("{message}"),
            None => bail!("the node answered {status}"),
        }
    }
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value.get(key).and_then(Value::as_str).unwrap_or("-")
}

fn items<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn list(answer: &Value) {
    for plugin in items(answer, "plugins") {
        let instances = items(plugin, "instances").iter().filter_map(Value::as_str);
        let instances = instances.collect::<Vec<_>>().join(", ");
        println!(
            "{:<18} {:<10} {:<10} {}",
            text(plugin, "name"),
            text(plugin, "version"),
            text(plugin, "kind"),
            if instances.is_empty() { "unused" } else { &instances }
        );
        if let Some(candidate) = plugin.get("candidate").and_then(Value::as_str) {
            println!(
                "{:<18} {candidate} is there: skein plugin node upgrade {}",
                "",
                text(plugin, "name")
            );
        }
    }
    for problem in items(answer, "problems") {
        println!("not taken: {}", problem.as_str().unwrap_or_default());
    }
}

fn exchanged(answer: &Value) -> ExitCode {
    let (name, from, to) = (text(answer, "name"), text(answer, "from"), text(answer, "to"));
    for instance in items(answer, "instances") {
        match instance.get("error").and_then(Value::as_str) {
            Some(error) => println!("{:<20} did not come up: {error}", text(instance, "name")),
            None => println!("{:<20} state {}", text(instance, "name"), text(instance, "restored")),
        }
    }
    if answer.get("rolled_back") == Some(&Value::Bool(true)) {
        println!("{name}: {to} did not come up; {from} goes on");
        return ExitCode::from(crate::exit::FAILED);
    }
    println!("{name}: {to} instead of {from}");
    ExitCode::SUCCESS
}
