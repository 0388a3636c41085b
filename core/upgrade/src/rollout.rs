//! A roll-out: one node after the other gets the archive for its processor, starts it on trial, and is waited for.
//!
//! Must never do: begin with a node before the one before it has confirmed itself, refused or not answered; go on after a version that did not stay.

use crate::ground::{Ground, RolloutRequest};
use crate::rules;
use skein_domain::NodeId;
use skein_domain::exchange::Severity;
use skein_state::asks::{Answer, Ask, UpgradeAnswer, UpgradeAsk};
use skein_view::{
    ArchiveInfo, EventKind, NodeUpgradeState, NodeVersions, RolloutEnd, RolloutKind, UpgradeRefusal, UpgradeReport,
    VersionLabel,
};
use std::io::SeekFrom;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::fs::File;
use tokio::io::{AsyncReadExt, AsyncSeekExt};

/// Sent at once, in bytes: a second on a good network, and less than a minute where little may be sent.
const PART_BYTES: usize = 256 << 10;
/// Longest wait for an answer that takes no work.
const SOON: Duration = Duration::from_secs(5);
/// Longest wait for a part to arrive.
const PART_WITHIN: Duration = Duration::from_secs(60);
/// Longest wait for the disk of a small computer to write a version.
const UNPACKED_WITHIN: Duration = Duration::from_secs(300);
/// Longest wait for a swap to be arranged.
const ARRANGED_WITHIN: Duration = Duration::from_secs(20);
/// So often a node that does not answer is asked, with a pause between.
const TRIES: usize = 5;
const PAUSE: Duration = Duration::from_secs(1);
/// A node that has not been heard for longer than its trial may take and this is lost: it may have hung, and been started again by its watchdog.
const LOST_AFTER: Duration = Duration::from_secs(150);

/// Why nothing came of a question.
enum Failed {
    Refused(UpgradeRefusal),
    NotReached(String),
}

impl From<Failed> for NodeUpgradeState {
    fn from(failed: Failed) -> Self {
        match failed {
            Failed::Refused(refusal) => Self::Refused { refusal },
            Failed::NotReached(why) => Self::NotReachable { why },
        }
    }
}

/// Begins a roll-out; it goes on by itself.
///
/// # Errors
/// When one goes on already, a node is not known, or there is no archive.
pub fn begin(ground: &Arc<Ground>, request: RolloutRequest) -> Result<UpgradeReport, UpgradeRefusal> {
    let kind = request.kind;
    ground.prepare(request)?;
    tokio::spawn(run(ground.clone(), kind));
    Ok(ground.report())
}

/// Goes from node to node.
async fn run(ground: Arc<Ground>, kind: RolloutKind) {
    tell(&ground, Severity::Advisory, "a roll-out begins".into());
    let end = loop {
        let shared = ground.upgrader().shared();
        let coordinator = shared.swarm.as_ref().and_then(|swarm| swarm.role().coordinator());
        let Some(node) = rules::next_node(&ground.waiting(), coordinator, ground.me()) else {
            break RolloutEnd::Done;
        };
        if ground.is_stopped() {
            let why = "an operator stopped it".into();
            break RolloutEnd::Stopped { why };
        }
        let outcome = one(&ground, node, kind).await.unwrap_or_else(NodeUpgradeState::from);
        ground.note(node, |known| known.progress = outcome.clone());
        let (severity, words) = said(&outcome);
        tell(&ground, severity, format!("node {node}: {words}"));
        if !rules::goes_on(&outcome) {
            let why = format!("node {node}: {words}");
            break RolloutEnd::Stopped { why };
        }
    };
    let text = match &end {
        RolloutEnd::Done => "the roll-out has ended: each node had its turn".to_owned(),
        RolloutEnd::Stopped { why } => format!("the roll-out has stopped: {why}"),
    };
    tell(&ground, Severity::Advisory, text);
    ground.end(end);
}

fn said(outcome: &NodeUpgradeState) -> (Severity, String) {
    match outcome {
        NodeUpgradeState::Confirmed => (Severity::Info, "its version is confirmed".into()),
        NodeUpgradeState::GoneBack { why } => (Severity::Warning, format!("its new version went back: {why}")),
        NodeUpgradeState::Refused { refusal } => (Severity::Warning, format!("refused: {refusal}")),
        NodeUpgradeState::NotReachable { why } => (Severity::Warning, format!("not reached: {why}")),
        NodeUpgradeState::Lost { silent_s } => {
            let text = format!("not heard for {silent_s:.0} s since it was told to start another version");
            (Severity::Warning, text)
        }
        _ => (Severity::Info, "under way".into()),
    }
}

fn tell(ground: &Ground, severity: Severity, text: String) {
    let shared = ground.upgrader().shared();
    shared
        .events
        .record(shared.now(), None, severity, EventKind::Notice, text);
}

/// Everything with one node, to its end.
async fn one(ground: &Arc<Ground>, node: NodeId, kind: RolloutKind) -> Result<NodeUpgradeState, Failed> {
    let told = versions(ground, node, TRIES).await?;
    ground.note(node, |known| known.versions = Some(told.clone()));
    let (wanted, ask) = match kind {
        RolloutKind::Back => {
            let before = told
                .before
                .clone()
                .ok_or(Failed::Refused(UpgradeRefusal::NothingBefore))?;
            (before, UpgradeAsk::Back)
        }
        RolloutKind::Upgrade => {
            let node_is = told.architecture.clone();
            let archive = ground.archive_for(&node_is);
            let archive = archive.ok_or(Failed::Refused(UpgradeRefusal::NoArchive { node: node_is }))?;
            let wanted = VersionLabel {
                version: archive.version.clone(),
                digest: Some(archive.digest.clone()),
            };
            if told.runs.digest == wanted.digest && !told.on_trial {
                return Ok(NodeUpgradeState::Confirmed);
            }
            send(ground, node, &archive).await?;
            ground.note(node, |known| known.progress = NodeUpgradeState::Unpacking);
            let digest = archive.digest.clone();
            ask_again(ground, node, UpgradeAsk::Unpack { digest }, UNPACKED_WITHIN).await?;
            let digest = archive.digest;
            (wanted, UpgradeAsk::Try { digest })
        }
    };
    ground.note(node, |known| known.progress = NodeUpgradeState::Starting);
    // Once: where the answer is lost, what the node tells next says whether it was arranged.
    match ask_once(ground, node, ask, ARRANGED_WITHIN).await {
        Err(Failed::Refused(refusal)) => return Err(Failed::Refused(refusal)),
        Err(Failed::NotReached(why)) => {
            let told = versions(ground, node, TRIES).await;
            if told.is_ok_and(|told| rules::knows_nothing_of(&wanted, &told)) {
                return Err(Failed::NotReached(why));
            }
        }
        Ok(_) => {}
    }
    Ok(until_known(ground, node, &wanted, told.confirm_within_s).await)
}

/// Sends what a node lacks of an archive.
async fn send(ground: &Arc<Ground>, node: NodeId, archive: &ArchiveInfo) -> Result<(), Failed> {
    let unreadable = |error: std::io::Error| {
        Failed::Refused(UpgradeRefusal::Storage {
            detail: format!("the archive at this node: {error}"),
        })
    };
    let mut file = File::open(ground.path_of(archive)).await.map_err(unreadable)?;
    let mut has = has(ask_again(ground, node, UpgradeAsk::Offer(archive.clone()), SOON).await?);
    while has < archive.bytes {
        ground.note(node, |known| {
            known.progress = NodeUpgradeState::Sending {
                sent_bytes: has,
                of_bytes: archive.bytes,
            };
        });
        file.seek(SeekFrom::Start(has)).await.map_err(unreadable)?;
        let mut bytes = Vec::with_capacity(PART_BYTES);
        let mut part = (&mut file).take(PART_BYTES as u64);
        if part.read_to_end(&mut bytes).await.map_err(unreadable)? == 0 {
            return Err(unreadable(std::io::ErrorKind::UnexpectedEof.into()));
        }
        let part = UpgradeAsk::Part {
            digest: archive.digest.clone(),
            at_byte: has,
            bytes,
        };
        has = self::has(ask_again(ground, node, part, PART_WITHIN).await?);
    }
    Ok(())
}

fn has(answer: UpgradeAnswer) -> u64 {
    match answer {
        UpgradeAnswer::Has { bytes } => bytes,
        UpgradeAnswer::Versions(_) | UpgradeAnswer::Done => 0,
    }
}

/// Waits until a node has confirmed what it was told to start, or has not. It does not answer while it starts.
async fn until_known(
    ground: &Arc<Ground>,
    node: NodeId,
    wanted: &VersionLabel,
    confirm_within_s: f64,
) -> NodeUpgradeState {
    let longest = Duration::from_secs_f64(confirm_within_s.clamp(1.0, 3600.0)) + LOST_AFTER;
    let mut heard = Instant::now();
    loop {
        tokio::time::sleep(PAUSE).await;
        match versions(ground, node, 1).await {
            Ok(told) => {
                heard = Instant::now();
                let progress = rules::progress(wanted, &told);
                ground.note(node, |known| {
                    known.progress = progress.clone();
                    known.versions = Some(told);
                });
                if !matches!(progress, NodeUpgradeState::OnTrial | NodeUpgradeState::Starting) {
                    return progress;
                }
            }
            Err(_) if heard.elapsed() > longest => {
                let silent_s = heard.elapsed().as_secs_f64();
                return NodeUpgradeState::Lost { silent_s };
            }
            Err(_) => {}
        }
    }
}

async fn versions(ground: &Arc<Ground>, node: NodeId, tries: usize) -> Result<NodeVersions, Failed> {
    let mut outcome = ask_once(ground, node, UpgradeAsk::Versions, SOON).await;
    for _ in 1..tries {
        if !matches!(outcome, Err(Failed::NotReached(_))) {
            break;
        }
        tokio::time::sleep(PAUSE).await;
        outcome = ask_once(ground, node, UpgradeAsk::Versions, SOON).await;
    }
    match outcome? {
        UpgradeAnswer::Versions(told) => Ok(*told),
        _ => Err(Failed::NotReached("it answers something else".into())),
    }
}

/// Asks what may be asked again.
async fn ask_again(
    ground: &Arc<Ground>,
    node: NodeId,
    ask: UpgradeAsk,
    within: Duration,
) -> Result<UpgradeAnswer, Failed> {
    let mut outcome = ask_once(ground, node, ask.clone(), within).await;
    for _ in 1..TRIES {
        if !matches!(outcome, Err(Failed::NotReached(_))) {
            break;
        }
        tokio::time::sleep(PAUSE).await;
        outcome = ask_once(ground, node, ask.clone(), within).await;
    }
    outcome
}

async fn ask_once(
    ground: &Arc<Ground>,
    node: NodeId,
    ask: UpgradeAsk,
    within: Duration,
) -> Result<UpgradeAnswer, Failed> {
    if node == ground.me() {
        return ground.upgrader().carry_out(ask).await.map_err(Failed::Refused);
    }
    let answer = ground.upgrader().shared().ask(node, Ask::Upgrade(ask), within).await;
    match answer {
        Ok(Answer::Upgrade(outcome)) => outcome.map_err(Failed::Refused),
        Ok(_) => Err(Failed::NotReached("it answers something else".into())),
        Err(refusal) => Err(Failed::NotReached(refusal.to_string())),
    }
}
