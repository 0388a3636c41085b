//! The keeper: an actor that writes what is flown into the file, and after a restart goes on with what the file said once it is decided of every
//! vehicle whether it was taken back.
//!
//! Bound: one look at a time, one write at a time. Must never do: let anything that flies wait for the disk.

use super::flown::flown_now;
use crate::handle::NodeHandle;
use crate::handle::flying_on;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_config::ResumeThen;
use skein_coordination::ActiveRoute;
use skein_domain::exchange::Severity;
use skein_domain::{FormationAnchor, NodeTime};
use skein_state::SharedState;
use skein_state::resume::{Flown, Kept, file, node_name, unix_us};
use skein_state::whole_file;
use skein_view::EventKind;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// How often it is looked whether something has changed.
const LOOK: Duration = Duration::from_millis(200);
/// In flight it is written at least so often, in seconds: its age is what it is judged by.
const WRITTEN_EVERY_S: f64 = 2.0;
/// Whoever was taken back is under the swarm's control by then, in seconds.
const AVAILABLE_WITHIN_S: f64 = 1.0;
/// A node of a swarm waits so long for a coordinator, in seconds.
const LED_WITHIN_S: f64 = 10.0;

/// The actor.
pub struct Keeper;

/// One look.
pub struct Look;

/// What it is started with.
pub struct KeeperArguments {
    /// The node.
    pub handle: NodeHandle,
}

/// State. What was flown before is in the shared state.
pub struct KeeperState {
    handle: NodeHandle,
    shared: Arc<SharedState>,
    written: Option<(Flown, NodeTime)>,
    /// The path of a virtual leader, and how far it has come.
    path: Option<ActiveRoute>,
    /// Since when it is decided of every vehicle.
    decided: Option<NodeTime>,
    /// It was told that the file cannot be written.
    told_unwritable: bool,
}

impl Actor for Keeper {
    type Msg = Look;
    type State = KeeperState;
    type Arguments = KeeperArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<Look>,
        arguments: KeeperArguments,
    ) -> Result<KeeperState, ActorProcessingErr> {
        let shared = arguments.handle.shared().clone();
        // The next is asked for when the last is done: a slow disk piles up nothing.
        myself.cast(Look)?;
        Ok(KeeperState {
            handle: arguments.handle,
            shared,
            written: None,
            path: None,
            decided: None,
            told_unwritable: false,
        })
    }

    async fn handle(&self, myself: ActorRef<Look>, _: Look, state: &mut KeeperState) -> Result<(), ActorProcessingErr> {
        state.go_on().await;
        state.keep().await;
        myself.send_after(LOOK, || Look);
        Ok(())
    }
}

impl KeeperState {
    /// Goes on with what was flown before, when it is time.
    async fn go_on(&mut self) {
        let (shared, now) = (self.shared.clone(), self.shared.now());
        let Some(before) = shared.resume.before() else { return };
        if shared.resume.is_asking() {
            if shared.coordination.read().formation.is_some() {
                shared.resume.end();
            }
            return;
        }
        if !shared.resume.is_decided(now) {
            return;
        }
        let since_s = now.seconds_since(*self.decided.get_or_insert(now));
        let taken = shared.resume.taken();
        let under_control = flying_on::under_control(&shared);
        if since_s < AVAILABLE_WITHIN_S && !taken.iter().all(|id| under_control.contains(id)) {
            return;
        }
        if !shared.coordinates() {
            let led = shared
                .swarm
                .as_ref()
                .is_some_and(|swarm| swarm.role().coordinator().is_some());
            if !led && since_s < LED_WITHIN_S {
                return;
            }
            shared.resume.end();
            flying_on::tell(&shared, &taken, "they do what the swarm's coordinator says");
            return;
        }
        if taken.is_empty() {
            shared.resume.end();
            flying_on::tell(&shared, &taken, "nothing is gone on with");
        } else if shared.resume.then() == ResumeThen::FlyOn {
            flying_on::tell(&shared, &taken, "they fly on");
            flying_on::fly_on(&self.handle).await;
        } else {
            let fly = if before.formation.is_some() {
                "the formation"
            } else {
                "what each did"
            };
            flying_on::tell(
                &shared,
                &taken,
                &format!("they hold; {fly} is flown on when an operator says so"),
            );
            shared.resume.ask(now);
        }
    }

    /// Writes what is flown, if that has changed or was written some time ago.
    async fn keep(&mut self) {
        let Some(path) = self.shared.resume.path().map(Path::to_owned) else {
            return;
        };
        let now = self.shared.now();
        self.follow_path();
        let flown = flown_now(&self.shared, self.shared.resume.before(), self.path.as_ref());
        let due = match &self.written {
            None => true,
            Some((before, _)) if *before != flown => true,
            Some((_, at)) => !flown.vehicles.is_empty() && now.seconds_since(*at) >= WRITTEN_EVERY_S,
        };
        if !due {
            return;
        }
        let kept = Kept {
            node: node_name(&self.shared.config),
            written_us: unix_us(),
            time: now,
            flown: flown.clone(),
        };
        let shared = self.shared.clone();
        let written = tokio::task::spawn_blocking(move || write(&shared, &path, &kept)).await;
        let fault = written
            .unwrap_or_else(|_| Err("the writing was broken off".into()))
            .err();
        if let Some(fault) = &fault
            && !self.told_unwritable
        {
            let text = format!("what is flown cannot be kept for a restart (resume.file): {fault}");
            let events = &self.shared.events;
            events.record(now, None, Severity::Warning, EventKind::Notice, text);
        }
        self.told_unwritable = fault.is_some();
        self.written = Some((flown, now));
    }

    /// Notes how far the anchor of a formation on a path has come.
    fn follow_path(&mut self) {
        let coordination = self.shared.coordination.read();
        let request = coordination.formation.as_ref().map(|formation| &formation.request);
        let route = match request.map(|request| &request.anchor) {
            Some(FormationAnchor::Path { route }) => route.clone(),
            _ => {
                self.path = None;
                return;
            }
        };
        drop(coordination);
        if self.path.as_ref().is_none_or(|path| path.route != route) {
            self.path = Some(ActiveRoute {
                route,
                next: 0,
                finished: false,
            });
        }
        if let (Some(path), Some(anchor)) = (&mut self.path, self.shared.peers().anchor) {
            path.advance(&anchor.position);
        }
    }
}

/// Writes the file, unless the node is stopping on purpose.
fn write(shared: &SharedState, path: &Path, kept: &Kept) -> Result<(), String> {
    let bytes = file::encode(kept).map_err(|fault| fault.to_string())?;
    let _writing = shared.resume.writing();
    if shared.is_stopping() {
        return Ok(());
    }
    whole_file::replace(path, &bytes).map_err(|error| format!("{}: {error}", path.display()))
}
