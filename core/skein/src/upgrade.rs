//! `skein upgrade`: packs an archive, sends archives to a ground station's node, and tells how the roll-out goes and what to do next.
//!
//! Must never do: decide anything of the roll-out; it goes on at the node when this command has ended.

use crate::exit;
use anyhow::{Context, bail};
use clap::{Args, Subcommand};
use reqwest::{Client, Method, RequestBuilder, Url};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use skein_domain::NodeId;
use skein_view::{
    ArchiveInfo, NodeUpgrade, NodeUpgradeState, NodeVersions, Rollout, RolloutEnd, UpgradeReport, VersionLabel,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// An archive goes over the local network, and is checked at the node.
const SENT_WITHIN: Duration = Duration::from_secs(300);
/// How often it is looked.
const LOOK: Duration = Duration::from_secs(1);
/// The node may be away for so long while it starts its own other version.
const AWAY: Duration = Duration::from_secs(300);
/// The environment variable with an operator's secret.
const OPERATOR: &str = "SKEIN_OPERATOR";

/// `skein upgrade`
#[derive(Debug, Clone, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct UpgradeArguments {
    /// What to do besides.
    #[command(subcommand)]
    pub what: Option<UpgradeCommand>,
    /// Archives with the new version, one for each kind of processor; without any it is told how things stand.
    #[arg(value_name = "ARCHIVE")]
    pub archives: Vec<PathBuf>,
    /// The ground station's node.
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8080")]
    pub node: Url,
    /// Back to the version before.
    #[arg(long, conflicts_with = "archives")]
    pub back: bool,
    /// Only these nodes of the swarm, by number; can be given several times [default: all others].
    #[arg(long, value_name = "NODE")]
    pub only: Vec<u64>,
    /// The ground station's own node too, as the last one.
    #[arg(long)]
    pub this_node: bool,
    /// A file with the secret of an operator who may (`operators.may_upgrade`) [default: the variable SKEIN_OPERATOR].
    #[arg(long, value_name = "FILE")]
    pub operator: Option<PathBuf>,
}

/// What `skein upgrade` does besides.
#[derive(Debug, Clone, Subcommand)]
pub enum UpgradeCommand {
    /// Make an archive of a folder with `skein` and `plugins`, or of a package that was unpacked by `dpkg-deb -x`.
    Pack {
        /// The folder.
        folder: PathBuf,
        /// The archive to be made, FILE.tar.gz.
        file: PathBuf,
        /// What the version is called [default: that of this program].
        #[arg(long, default_value = env!("CARGO_PKG_VERSION"))]
        version: String,
    },
    /// Have a roll-out go no further than the node whose turn it is.
    Stop {
        /// The ground station's node.
        #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:8080")]
        node: Url,
        /// A file with the secret of an operator who may [default: the variable SKEIN_OPERATOR].
        #[arg(long, value_name = "FILE")]
        operator: Option<PathBuf>,
    },
}

/// `skein upgrade`.
///
/// # Errors
/// When an archive cannot be made, or the node does not take what it is sent.
pub async fn upgrade(arguments: UpgradeArguments) -> anyhow::Result<ExitCode> {
    match arguments.what {
        Some(UpgradeCommand::Pack { folder, file, version }) => {
            let made = tokio::task::spawn_blocking(move || {
                let info = skein_upgrade::pack(&folder, &version, &file)?;
                println!("{}: {}", file.display(), of(&info));
                anyhow::Ok(())
            });
            made.await??;
            Ok(ExitCode::SUCCESS)
        }
        Some(UpgradeCommand::Stop { node, operator }) => {
            let ground = Ground::at(&node, operator.as_deref())?;
            let report: UpgradeReport = ground.ask(Method::DELETE, "/api/v1/upgrades", None).await?;
            report.rollout.iter().for_each(tell_all);
            Ok(ExitCode::SUCCESS)
        }
        None => roll_out(&arguments).await,
    }
}

async fn roll_out(arguments: &UpgradeArguments) -> anyhow::Result<ExitCode> {
    let ground = Ground::at(&arguments.node, arguments.operator.as_deref())?;
    if arguments.archives.is_empty() && !arguments.back {
        let report: UpgradeReport = ground.ask(Method::GET, "/api/v1/upgrades", None).await?;
        println!("this node: {}", of_node(&report.this_node));
        report
            .archives
            .iter()
            .for_each(|info| println!("archive:   {}", of(info)));
        report.rollout.iter().for_each(tell_all);
        return Ok(ExitCode::SUCCESS);
    }
    for path in &arguments.archives {
        let info = ground.send(path).await?;
        println!("{}: {}", path.display(), of(&info));
    }
    let nodes = (!arguments.only.is_empty()).then_some(&arguments.only);
    let body = json!({ "nodes": nodes, "this_node": arguments.this_node });
    let path = if arguments.back {
        "/api/v1/upgrades/back"
    } else {
        "/api/v1/upgrades"
    };
    let begun: UpgradeReport = ground.ask(Method::POST, path, Some(body)).await?;
    println!("The roll-out has begun. It goes on if this command is ended; `skein upgrade stop` stops it.");
    ground.follow(begun).await
}

/// The ground station's node.
struct Ground {
    http: Client,
    url: Url,
    secret: Option<String>,
}

impl Ground {
    fn at(url: &Url, operator: Option<&Path>) -> anyhow::Result<Self> {
        let secret = match operator {
            Some(file) => {
                let text = std::fs::read_to_string(file);
                Some(text.with_context(|| format!("cannot read {}", file.display()))?)
            }
            None => std::env::var(OPERATOR).ok(),
        };
        Ok(Self {
            http: Client::builder().timeout(SENT_WITHIN).build()?,
            url: url.clone(),
            secret: secret.map(|text| text.trim().to_owned()),
        })
    }

    async fn ask<T: DeserializeOwned>(&self, method: Method, path: &str, body: Option<Value>) -> anyhow::Result<T> {
        let mut request = self.http.request(method, self.url.join(path)?);
        if let Some(body) = body {
            request = request.json(&body);
        }
        self.answer(request).await
    }

    async fn send(&self, path: &Path) -> anyhow::Result<ArchiveInfo> {
        let bytes = tokio::fs::read(path).await;
        let bytes = bytes.with_context(|| format!("cannot read {}", path.display()))?;
        let request = self.http.post(self.url.join("/api/v1/upgrades/archives")?).body(bytes);
        let answer = self.answer(request).await;
        answer.with_context(|| format!("{} is not taken", path.display()))
    }

    async fn answer<T: DeserializeOwned>(&self, request: RequestBuilder) -> anyhow::Result<T> {
        let request = match &self.secret {
            Some(secret) => request.bearer_auth(secret),
            None => request,
        };
        let answer = request.send().await?;
        let status = answer.status();
        let text = answer.text().await?;
        if status.is_success() {
            return Ok(serde_json::from_str(&text)?);
        }
        let error: Value = serde_json::from_str(&text).unwrap_or_default();
        if error.pointer("/error/code").and_then(Value::as_str) == Some("no_operator") {
            bail!(
                "the node wants an operator who may: an [[operators]] of its configuration with may_upgrade = true, and his secret in \
                 {OPERATOR} or a file named by --operator"
            );
        }
        let message = error.pointer("/error/message").and_then(Value::as_str);
        bail!("{}", message.map_or_else(|| status.to_string(), str::to_owned))
    }

    /// Tells what changes until it has ended.
    async fn follow(&self, begun: UpgradeReport) -> anyhow::Result<ExitCode> {
        let mut told = BTreeMap::new();
        let (mut report, mut answered) = (begun, Instant::now());
        loop {
            match &report.rollout {
                Some(rollout) => {
                    tell_changes(rollout, &mut told);
                    if let Some(end) = &rollout.ended {
                        return Ok(ended(rollout, end));
                    }
                }
                // It has started its own other version, which knows nothing of the roll-out.
                None if !report.this_node.on_trial => {
                    println!("this node: {}", of_node(&report.this_node));
                    let stayed = report.this_node.gone_back.is_none();
                    return Ok(if stayed {
                        ExitCode::SUCCESS
                    } else {
                        ExitCode::from(exit::FAILED)
                    });
                }
                None => {}
            }
            tokio::time::sleep(LOOK).await;
            match self.ask(Method::GET, "/api/v1/upgrades", None).await {
                Ok(next) => (report, answered) = (next, Instant::now()),
                Err(error) if answered.elapsed() > AWAY => return Err(error),
                Err(_) => {}
            }
        }
    }
}

fn of(info: &ArchiveInfo) -> String {
    let (size_mb, digest) = (info.bytes as f64 / 1e6, info.digest.get(..12).unwrap_or(&info.digest));
    format!(
        "version {} for {}, {size_mb:.1} MB, {digest}",
        info.version, info.architecture
    )
}

fn of_label(label: &VersionLabel) -> String {
    match &label.digest {
        Some(digest) => format!("{} ({})", label.version, digest.get(..12).unwrap_or(digest)),
        None => format!("{} (the package)", label.version),
    }
}

fn of_node(versions: &NodeVersions) -> String {
    let mut text = format!("runs {}", of_label(&versions.runs));
    if versions.on_trial {
        text += ", on trial";
    }
    if let Some(before) = &versions.before {
        text += &format!("; before: {}", of_label(before));
    }
    if let Some(back) = &versions.gone_back {
        text += &format!("; {} went back: {}", of_label(&back.from), back.why);
    }
    text
}

fn name(node: &NodeUpgrade) -> String {
    format!("node {} ({})", node.node, node.name)
}

fn words(progress: &NodeUpgradeState) -> String {
    match progress {
        NodeUpgradeState::Waiting => "waits".into(),
        NodeUpgradeState::Sending { sent_bytes, of_bytes } => {
            // In steps of ten: a line for each, no more.
            let tenths = sent_bytes.saturating_mul(10) / of_bytes.max(&1);
            format!("sending, {tenths}0 % of {:.1} MB", *of_bytes as f64 / 1e6)
        }
        NodeUpgradeState::Unpacking => "unpacking and checking".into(),
        NodeUpgradeState::Starting => "starting the other version".into(),
        NodeUpgradeState::OnTrial => "runs it, on trial".into(),
        NodeUpgradeState::Confirmed => "runs it, confirmed".into(),
        NodeUpgradeState::GoneBack { why } => format!("WENT BACK by itself: {why}"),
        NodeUpgradeState::Refused { refusal } => format!("refused: {refusal}"),
        NodeUpgradeState::NotReachable { why } => format!("not reached: {why}"),
        NodeUpgradeState::Lost { silent_s } => format!("NOT HEARD for {silent_s:.0} s since it was told to start"),
        NodeUpgradeState::Skipped => "left as it is".into(),
    }
}

/// A line for each node that is further than when it was last told of.
fn tell_changes(rollout: &Rollout, told: &mut BTreeMap<NodeId, String>) {
    for node in &rollout.nodes {
        let words = words(&node.progress);
        if told.get(&node.node) != Some(&words) {
            println!("{}: {words}", name(node));
            told.insert(node.node, words);
        }
    }
}

fn tell_all(rollout: &Rollout) {
    for node in &rollout.nodes {
        println!("{}: {}", name(node), words(&node.progress));
    }
    if let Some(RolloutEnd::Stopped { why }) = &rollout.ended {
        println!("stopped: {why}");
    }
}

/// How it ended, and what to do next.
fn ended(rollout: &Rollout, end: &RolloutEnd) -> ExitCode {
    let is = |wanted: fn(&NodeUpgradeState) -> bool| rollout.nodes.iter().any(|node| wanted(&node.progress));
    if let RolloutEnd::Stopped { why } = end {
        println!("Stopped: {why}");
    }
    if is(|p| matches!(p, NodeUpgradeState::GoneBack { .. })) {
        println!("The node that went back runs its old version; the others keep what they have.");
        println!(
            "Next: its log says more (journalctl -u skein). Pack a version that is mended and begin again, or `skein upgrade --back`."
        );
    }
    if is(|p| {
        matches!(
            p,
            NodeUpgradeState::Refused { .. } | NodeUpgradeState::NotReachable { .. }
        )
    }) {
        println!("Next: mend what the nodes above name, then begin again. Nodes that have the version are left alone.");
    }
    if is(|p| matches!(p, NodeUpgradeState::Lost { .. })) {
        println!(
            "Next: look at that computer. Its service manager must start the program again when it ends (Restart=always)."
        );
    }
    let all = rollout
        .nodes
        .iter()
        .all(|node| node.progress == NodeUpgradeState::Confirmed);
    if all {
        println!("All nodes of the roll-out run it. `skein upgrade --back` takes it back.");
        ExitCode::SUCCESS
    } else {
        ExitCode::from(exit::FAILED)
    }
}
