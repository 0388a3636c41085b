//! The node's end: takes archives in, unpacks them, arranges the swap, and has a version on trial confirm itself or go back.
//!
//! Must never do: swap while a vehicle is armed; answer that something is done before the disk has it.

use crate::archive;
use crate::incoming::Incoming;
use crate::rules::{self, Package, Verdict, Version, Versions};
use crate::slots::{Slots, SlotsError};
use crate::start::{Running, package_of};
use crate::trial::{self, HangGuard};
use parking_lot::Mutex;
use skein_domain::NodeTime;
use skein_domain::exchange::Severity;
use skein_state::SharedState;
use skein_state::asks::{UpgradeAnswer, UpgradeAsk};
use skein_view::{ArchiveInfo, EventKind, NodeVersions, UpgradeRefusal, VersionLabel};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Notify;

/// From the moment at which nothing is armed any more to the swap: whatever was under way to an autopilot has arrived, and its next two heartbeats
/// have told what came of it.
const SETTLE: Duration = Duration::from_secs(3);
/// The answer leaves before the node does.
const ANSWER_LEAVES: Duration = Duration::from_millis(700);
/// How often a version on trial looks at itself.
const LOOK: Duration = Duration::from_millis(200);

/// Why the program is to end, so that the service manager starts it again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Swap {
    /// Another version is tried next.
    Next,
    /// This one was tried in vain.
    GoneBack(String),
}

/// What changes while it runs.
#[derive(Debug)]
struct Now {
    versions: Versions,
    on_trial: bool,
    /// A swap to this version is being arranged.
    swapping: Option<Version>,
    broken_off: Option<UpgradeRefusal>,
}

/// The node's end.
pub struct Upgrader {
    shared: Arc<SharedState>,
    slots: Slots,
    running: Running,
    package: Option<Package>,
    now: Mutex<Now>,
    writing: Mutex<()>,
    incoming: Mutex<Option<Incoming>>,
    swap: Notify,
}

fn storage(error: &dyn std::error::Error) -> UpgradeRefusal {
    UpgradeRefusal::Storage {
        detail: error.to_string(),
    }
}

fn busy(what: &str) -> UpgradeRefusal {
    UpgradeRefusal::Busy { what: what.to_owned() }
}

impl Upgrader {
    /// For a node that runs as this. On trial, nothing is armed until it has confirmed itself.
    ///
    /// # Errors
    /// When it cannot be read which versions there are.
    pub fn new(shared: Arc<SharedState>, slots: Slots, running: Running) -> Result<Self, SlotsError> {
        let mut versions = slots.load()?.unwrap_or_default();
        let program = std::env::current_exe().and_then(|program| package_of(&program));
        let package = program.ok().filter(|_| running.version == Version::Package);
        if package.is_some() {
            versions.package.clone_from(&package);
        }
        let on_trial = running.on_trial;
        shared.hold_arming(on_trial);
        Ok(Self {
            shared,
            slots,
            running,
            package,
            now: Mutex::new(Now {
                versions,
                on_trial,
                swapping: None,
                broken_off: None,
            }),
            writing: Mutex::new(()),
            incoming: Mutex::new(None),
            swap: Notify::new(),
        })
    }

    pub(crate) fn shared(&self) -> &Arc<SharedState> {
        &self.shared
    }

    /// What this node has.
    #[must_use]
    pub fn versions(&self) -> NodeVersions {
        let now = self.now.lock();
        let label = |version: &Version| now.versions.label(version);
        let runs = label(&self.running.version);
        let trial = now.versions.trial.as_ref().filter(|trial| !trial.begun);
        let pending = now.swapping.as_ref().or(trial.map(|trial| &trial.version));
        NodeVersions {
            architecture: std::env::consts::ARCH.to_owned(),
            runs,
            on_trial: now.on_trial,
            pending: pending.map(label),
            before: now.versions.before.as_ref().map(label),
            gone_back: now.versions.gone_back.clone(),
            broken_off: now.broken_off.clone(),
            confirm_within_s: self.shared.config.upgrade.confirm_within_s,
        }
    }

    /// Does what another node, or an operator at this one, asks.
    ///
    /// # Errors
    /// Why not.
    pub async fn carry_out(self: &Arc<Self>, ask: UpgradeAsk) -> Result<UpgradeAnswer, UpgradeRefusal> {
        if let UpgradeAsk::Versions = ask {
            return Ok(UpgradeAnswer::Versions(Box::new(self.versions())));
        }
        if !self.shared.config.upgrade.accept {
            return Err(UpgradeRefusal::NotAccepted);
        }
        {
            let now = self.now.lock();
            if now.on_trial {
                return Err(busy("the version that runs there is on trial itself"));
            }
            if now.swapping.is_some() {
                return Err(busy("another version is about to be started there"));
            }
        }
        match ask {
            UpgradeAsk::Versions => Ok(UpgradeAnswer::Versions(Box::new(self.versions()))),
            UpgradeAsk::Offer(info) => self.blocking(|own| own.offer(info)).await,
            UpgradeAsk::Part { digest, at_byte, bytes } => {
                self.blocking(move |own| own.part(&digest, at_byte, &bytes)).await
            }
            UpgradeAsk::Unpack { digest } => self.blocking(move |own| own.unpack(&digest)).await,
            UpgradeAsk::Try { digest } => {
                let version = self.unpacked(&digest)?;
                self.try_version(version).await
            }
            UpgradeAsk::Back => {
                let before = self.now.lock().versions.before.clone();
                let before = before.filter(|version| self.slots.has(version));
                self.try_version(before.ok_or(UpgradeRefusal::NothingBefore)?).await
            }
        }
    }

    /// On a thread that may wait for the disk.
    async fn blocking<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Self) -> Result<T, UpgradeRefusal> + Send + 'static,
    ) -> Result<T, UpgradeRefusal> {
        let own = self.clone();
        let done = tokio::task::spawn_blocking(move || work(&own)).await;
        done.unwrap_or_else(|error| Err(storage(&error)))
    }

    /// Whether an archive would be taken. A vehicle that is armed now is named now, and not when all has been sent.
    fn offer(&self, info: ArchiveInfo) -> Result<UpgradeAnswer, UpgradeRefusal> {
        trial::may_swap(&self.shared)?;
        let node = std::env::consts::ARCH;
        if info.architecture != node {
            return Err(UpgradeRefusal::Architecture {
                archive: info.architecture,
                node: node.to_owned(),
            });
        }
        if self.slots.find(&info.digest).is_some() {
            // Unpacked when it was sent before.
            return Ok(UpgradeAnswer::Has { bytes: info.bytes });
        }
        let mut incoming = self.incoming.lock();
        if let Some(known) = incoming.as_ref().filter(|known| *known.offered() == info) {
            return Ok(UpgradeAnswer::Has {
                bytes: known.has_bytes(),
            });
        }
        let opened = Incoming::open(&self.slots.incoming(), info)?;
        let bytes = incoming.insert(opened).has_bytes();
        Ok(UpgradeAnswer::Has { bytes })
    }

    fn part(&self, digest: &str, at_byte: u64, bytes: &[u8]) -> Result<UpgradeAnswer, UpgradeRefusal> {
        let mut incoming = self.incoming.lock();
        let offered = incoming.as_mut().filter(|known| known.offered().digest == digest);
        let unknown = || UpgradeRefusal::Unknown {
            digest: digest.to_owned(),
        };
        let bytes = offered.ok_or_else(unknown)?.take(at_byte, bytes)?;
        Ok(UpgradeAnswer::Has { bytes })
    }

    fn unpack(&self, digest: &str) -> Result<UpgradeAnswer, UpgradeRefusal> {
        let mut incoming = self.incoming.lock();
        let Some(offered) = incoming.take_if(|known| known.offered().digest == digest) else {
            // Asked again, because the first answer was lost.
            return self.unpacked(digest).map(|_| UpgradeAnswer::Done);
        };
        let damaged = |detail: String| UpgradeRefusal::Damaged { detail };
        let outcome = (|| {
            let path = offered.whole()?;
            let (_, is) = archive::digest_of(path).map_err(|e| storage(&e))?;
            if is != digest {
                return Err(damaged(format!("its SHA-256 is {is}, not {digest}")));
            }
            let (manifest, _) = archive::check(path).map_err(|e| damaged(e.to_string()))?;
            if manifest.architecture != std::env::consts::ARCH {
                return Err(UpgradeRefusal::Architecture {
                    archive: manifest.architecture,
                    node: std::env::consts::ARCH.to_owned(),
                });
            }
            let keep = self.now.lock().versions.clone();
            crate::incoming::room(&self.slots.incoming(), manifest.unpacked_bytes())?;
            self.slots.unpack(path, digest, &keep).map_err(|error| match error {
                SlotsError::Archive(error) => damaged(error.to_string()),
                error => storage(&error),
            })
        })();
        // One that is of no use is not gone on with; one that was unpacked is not needed any more.
        offered.forget();
        outcome.map(|_| UpgradeAnswer::Done)
    }

    /// The version of an archive that was unpacked here.
    fn unpacked(&self, digest: &str) -> Result<Version, UpgradeRefusal> {
        let unknown = || UpgradeRefusal::Unknown {
            digest: digest.to_owned(),
        };
        self.slots.find(digest).ok_or_else(unknown)
    }

    /// Arranges that this version is started next, on trial. Nothing can be armed from now on until it has confirmed itself or it is known that
    /// there is no swap.
    async fn try_version(self: &Arc<Self>, version: Version) -> Result<UpgradeAnswer, UpgradeRefusal> {
        if self.now.lock().versions.confirmed == version {
            return Ok(UpgradeAnswer::Done);
        }
        trial::may_swap(&self.shared)?;
        {
            let mut now = self.now.lock();
            if now.swapping.is_some() {
                return Err(busy("another version is about to be started there"));
            }
            now.swapping = Some(version.clone());
            now.broken_off = None;
        }
        self.shared.hold_arming(true);
        // What is to be seen again is what is seen before anything ends.
        let expects = trial::expectations(&self.shared);
        tokio::time::sleep(SETTLE).await;
        let arranged = match trial::may_swap(&self.shared) {
            Ok(()) => {
                let change = move |versions: &mut Versions| versions.try_next(version, expects);
                self.blocking(|own| own.change(change)).await
            }
            Err(refusal) => Err(refusal),
        };
        if let Err(refusal) = arranged {
            self.resume(&refusal);
            return Err(refusal);
        }
        let own = self.clone();
        tokio::spawn(async move { own.leave().await });
        Ok(UpgradeAnswer::Done)
    }

    /// The last look, and the swap.
    async fn leave(self: Arc<Self>) {
        tokio::time::sleep(ANSWER_LEAVES).await;
        let Err(refusal) = trial::may_swap(&self.shared) else {
            self.tell(Severity::Advisory, "another version is started, on trial".into());
            self.swap.notify_one();
            return;
        };
        self.tell(Severity::Warning, format!("no other version is started: {refusal}"));
        let withdrawn = self.blocking(|own| own.change(|versions| versions.trial = None)).await;
        if let Err(error) = withdrawn {
            // It stands on the disk for the next start, whenever that is: this must not happen silently.
            self.tell(
                Severity::Critical,
                format!("the trial could not be taken back: {error}"),
            );
        }
        self.resume(&refusal);
    }

    /// There is no swap.
    fn resume(&self, because: &UpgradeRefusal) {
        let mut now = self.now.lock();
        (now.swapping, now.broken_off) = (None, Some(because.clone()));
        self.shared.hold_arming(false);
    }

    /// Changes what is kept, on the disk first.
    fn change<T>(&self, change: impl FnOnce(&mut Versions) -> T) -> Result<T, UpgradeRefusal> {
        // Who reads what there is does not wait for the disk.
        let _one_at_a_time = self.writing.lock();
        let mut versions = self.now.lock().versions.clone();
        if self.package.is_some() {
            versions.package.clone_from(&self.package);
        }
        let outcome = change(&mut versions);
        self.slots.save(&versions).map_err(|e| storage(&e))?;
        self.now.lock().versions = versions;
        Ok(outcome)
    }

    fn tell(&self, severity: Severity, text: String) {
        let (events, at) = (&self.shared.events, self.shared.now());
        events.record(at, None, severity, EventKind::Notice, text);
    }

    /// The version on trial did not come up: noted for the next start. For a node that could not be built there is no [`Upgrader`].
    ///
    /// # Errors
    /// When it cannot be noted; the next start knows that it was tried all the same.
    pub fn did_not_come_up(slots: &Slots, why: &str) -> Result<(), SlotsError> {
        slots.change(|versions| versions.give_up(why))
    }

    /// Says what happened before this start, judges the version if it is on trial, and returns when the program is to end for another one.
    pub async fn run(self: &Arc<Self>, guard: Option<HangGuard>) -> Swap {
        let label = |label: &VersionLabel| match &label.digest {
            Some(digest) => format!("{} ({})", label.version, digest.get(..12).unwrap_or(digest)),
            None => format!("{} (the package)", label.version),
        };
        let versions = self.versions();
        if let Some(back) = &versions.gone_back {
            let (from, runs) = (label(&back.from), label(&versions.runs));
            self.tell(
                Severity::Warning,
                format!("version {from} went back to {runs}: {}", back.why),
            );
        }
        if versions.on_trial {
            let runs = label(&versions.runs);
            self.tell(
                Severity::Advisory,
                format!("version {runs} is on trial: nothing is armed until it has confirmed itself"),
            );
            if let Some(swap) = self.on_trial(guard).await {
                return swap;
            }
            self.tell(Severity::Advisory, format!("version {runs} has confirmed itself"));
        }
        self.swap.notified().await;
        Swap::Next
    }

    async fn on_trial(self: &Arc<Self>, guard: Option<HangGuard>) -> Option<Swap> {
        let expects = self
            .now
            .lock()
            .versions
            .trial
            .as_ref()
            .map(|trial| trial.expects.clone());
        let expects = expects.unwrap_or_default();
        let (started, limit_s) = (self.shared.now(), self.shared.config.upgrade.confirm_within_s);
        let mut well_since: Option<NodeTime> = None;
        loop {
            tokio::time::sleep(LOOK).await;
            guard.iter().for_each(HangGuard::beat);
            let now = self.shared.now();
            let missing = expects.missing(&trial::seen(&self.shared));
            let well_for_s = match &missing {
                Some(missing) => {
                    well_since = None;
                    Err(missing.as_str())
                }
                None => Ok(now.seconds_since(*well_since.get_or_insert(now))),
            };
            let armed = trial::armed(&self.shared).is_some();
            match rules::judge(now.seconds_since(started), limit_s, well_for_s, armed) {
                Verdict::Wait => {}
                Verdict::Confirm => match self.blocking(|own| own.change(Versions::confirm)).await {
                    Ok(()) => {
                        self.now.lock().on_trial = false;
                        self.shared.hold_arming(false);
                        return None;
                    }
                    // Tried again: a version that cannot be kept is not one that stays.
                    Err(error) => tracing::error!("the version on trial is not confirmed: {error}"),
                },
                Verdict::GoBack(why) => {
                    self.tell(Severity::Warning, format!("this version goes back: {why}"));
                    let noted = why.clone();
                    let given_up = self
                        .blocking(move |own| own.change(|versions| versions.give_up(&noted)))
                        .await;
                    if let Err(error) = given_up {
                        tracing::error!("{error}");
                    }
                    return Some(Swap::GoneBack(why));
                }
            }
        }
    }
}
