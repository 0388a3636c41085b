//! The life of one plugin instance, whatever its kind: created, called, snapshotted with every call, started again from its snapshot
//! after a failure, exchanged for another version, given up. Its actor owns it; what must outlive the actor is in [`skein_state::PluginRecord`].
//!
//! Must never do: carry out an effect of a batch that failed, or lose an event of one silently: they are handed to the next
//! incarnation, once.

use skein_config::Isolation;
use skein_domain::exchange::{Create, Effect, Event, EventBatch, FaultDrill, Severity};
use skein_domain::{CommandId, Incarnation, NodeTime};
use skein_plugin_host::{ChildLimits, Frame, Instance, Plugin, PluginError};
use skein_state::PluginRecord;
use skein_state::SharedState;
use skein_state::restart::{Decision, RestartLimits, fraction};
use skein_view::{ActorStatus, EventKind, RestartRecord, Restored};
use std::sync::Arc;
use std::time::Instant;

/// What a call came to.
#[derive(Debug)]
pub enum Called {
    /// What the plugin wants done, and the frames it gave.
    Answered(Vec<Effect>, Vec<Arc<Frame>>),
    /// It failed and starts again, or is waiting for that.
    Failed,
    /// It failed too often: this is the moment to escalate.
    GivenUp(String),
}

/// The running instance and what is needed to start it again.
pub struct PluginLife {
    shared: Arc<SharedState>,
    record: Arc<PluginRecord>,
    limits: &'static RestartLimits,
    instance: Option<Instance>,
    incarnation: Incarnation,
    /// Not started again before; `None` when given up.
    start_at: Option<NodeTime>,
    /// When the failure was noticed, and the back-off that was decided on.
    failed: Option<(Instant, f64)>,
    /// Events of a batch that failed, for the next incarnation.
    left_over: Vec<Event>,
    /// When the call times are written next.
    statistics_at: NodeTime,
    /// Commands that no incarnation will carry out any more, until their owner says so.
    lost: Vec<CommandId>,
}

impl PluginLife {
    /// For a new incarnation of the actor: goes on where the record says.
    pub fn new(shared: Arc<SharedState>, record: Arc<PluginRecord>, limits: &'static RestartLimits) -> Self {
        let (incarnation, given_up) = {
            let health = record.health();
            (health.incarnation.next(), health.status == ActorStatus::GivenUp)
        };
        Self {
            shared,
            record,
            limits,
            instance: None,
            incarnation,
            start_at: (!given_up).then_some(NodeTime(0)),
            failed: None,
            left_over: Vec::new(),
            statistics_at: NodeTime(0),
            lost: Vec::new(),
        }
    }

    /// Whether an instance is there to be called.
    pub fn is_running(&self) -> bool {
        self.instance.is_some()
    }

    /// The incarnation that runs or comes next.
    pub fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    /// Starts the instance if it is not running and its back-off is over; tells whether it runs. The second value is why it was
    /// given up, if that happened now.
    pub async fn ensure(&mut self) -> (bool, Option<String>) {
        if self.is_running() {
            return (true, None);
        }
        let now = self.shared.now();
        if self.start_at.is_none_or(|at| at > now) {
            return (false, None);
        }
        let plugin = self.record.plugin();
        let snapshot = self.record.snapshot();
        let asked = Instant::now();
        match self.create(plugin, snapshot, self.incarnation).await {
            Ok((instance, restored)) => {
                self.instance = Some(instance);
                self.started(restored, asked);
                (true, None)
            }
            Err(error) => (false, self.fail(&error.to_string())),
        }
    }

    /// Makes an instance and looks whether it has the state it was given.
    async fn create(
        &self,
        plugin: Arc<Plugin>,
        snapshot: Option<Vec<u8>>,
        incarnation: Incarnation,
    ) -> Result<(Instance, Restored), PluginError> {
        let record = &self.record;
        let settings = &self.shared.config.plugins;
        let isolation = match record.isolation {
            Isolation::InProcess => skein_plugin_host::Isolation::InProcess,
            Isolation::Child => skein_plugin_host::Isolation::Child(ChildLimits {
                memory_mib: settings.child_memory_mib,
                cpu_share: settings.child_cpu_share,
                open_files: settings.child_open_files,
            }),
        };
        let create = Create {
            vehicle: record.vehicle,
            incarnation,
            config_json: record.config_json.clone(),
            snapshot: snapshot.clone(),
            now: self.shared.now(),
            payload: record.payload.clone(),
            system_id: Some(record.system_id),
        };
        let runners = self.shared.plugins.runners_of(record);
        let instance = runners.create(plugin, isolation, create).await?;
        let restored = match snapshot {
            None => Restored::Fresh,
            Some(before) if instance.snapshot().await? == before => Restored::Exactly,
            Some(_) => Restored::Differently,
        };
        Ok((instance, restored))
    }

    fn started(&mut self, restored: Restored, asked: Instant) {
        let now = self.shared.now();
        let restart = self.failed.take();
        self.statistics_at = NodeTime(0);
        {
            let plugin = self.record.plugin();
            let mut health = self.record.change_health();
            health.status = ActorStatus::Running;
            health.incarnation = self.incarnation;
            health.since = now;
            health.version.clone_from(&plugin.manifest().version);
            if restart.is_some() {
                health.restarts += 1;
            }
        }
        if let Some((noticed, backoff_s)) = restart {
            // The deliberate wait is told beside it, not in it.
            let took_s = if backoff_s > 0.0 { asked } else { noticed }.elapsed().as_secs_f64();
            self.keep_restart(now, took_s, backoff_s, restored);
        }
        if self.incarnation > Incarnation(1) {
            let text = match restored {
                Restored::Fresh => "runs again, without a former state",
                Restored::Exactly => "runs again with its state",
                Restored::Differently => "runs again, but with another state than it had",
            };
            let severity = if restored == Restored::Differently {
                Severity::Warning
            } else {
                Severity::Advisory
            };
            self.tell(severity, ActorStatus::Running, text);
        }
    }

    fn keep_restart(&self, time: NodeTime, took_s: f64, backoff_s: f64, restored: Restored) {
        let name = self.record.health().name.clone();
        self.shared.plugins.note_restart(RestartRecord {
            time,
            name,
            isolation: self.record.isolation,
            took_s,
            backoff_s,
            restored,
        });
    }

    /// Hands a batch to the instance. What is left over from one that failed comes first.
    pub async fn call(&mut self, mut events: Vec<Event>, frames: &[Arc<Frame>]) -> Called {
        let Some(instance) = &self.instance else {
            return Called::Failed;
        };
        let kept: Vec<Event> = events.iter().filter(|e| is_worth_a_second_try(e)).cloned().collect();
        let before = std::mem::take(&mut self.left_over);
        // What a second incarnation fails with as well is not tried on a third.
        let beyond_hope: Vec<CommandId> = before.iter().filter_map(command_of).collect();
        events.splice(0..0, before);
        let now = self.shared.now();
        match instance.call(EventBatch { now, events }, frames).await {
            Ok(answer) => {
                self.record.keep_snapshot(Some(answer.snapshot));
                Called::Answered(answer.effects, answer.frames)
            }
            Err(error) => {
                self.left_over = kept;
                self.lost.extend(beyond_hope);
                match self.fail(&error.to_string()) {
                    Some(why) => Called::GivenUp(why),
                    // At once if the policy says so: every period without a setpoint counts.
                    None => match self.ensure().await {
                        (_, Some(why)) => Called::GivenUp(why),
                        _ => Called::Failed,
                    },
                }
            }
        }
    }

    /// Ends the failed instance and decides when the next starts; gives the reason if there is none.
    fn fail(&mut self, error: &str) -> Option<String> {
        let now = self.shared.now();
        self.instance = None;
        self.incarnation = self.incarnation.next();
        let decision = self.record.note_failure(self.limits, now, fraction(now));
        let (status, backoff_s) = match decision {
            Decision::RestartAfter(delay_s) => (ActorStatus::Restarting, Some(delay_s)),
            Decision::GiveUp => (ActorStatus::GivenUp, None),
        };
        {
            let mut health = self.record.change_health();
            health.status = status;
            health.last_error = error.to_owned();
            health.since = now;
            health.process_id = None;
        }
        self.start_at = backoff_s.map(|delay_s| now.plus_seconds(delay_s));
        if backoff_s.is_none() {
            self.forget_left_over();
        }
        if let Some(backoff_s) = backoff_s {
            self.failed = Some((Instant::now(), backoff_s));
            self.tell(Severity::Warning, status, &format!("failed: {error}; restarting"));
            return None;
        }
        self.failed = None;
        self.tell(Severity::Critical, status, &format!("failed too often: {error}"));
        Some(error.to_owned())
    }

    /// Exchanges the running instance for one of another version, with its state. If that one does not come up, nothing has
    /// changed: the old one was not touched.
    ///
    /// # Errors
    /// Why the new version did not come up.
    pub async fn exchange(&mut self, plugin: Arc<Plugin>) -> Result<Restored, PluginError> {
        let snapshot = match &self.instance {
            Some(instance) => Some(instance.snapshot().await?),
            None => self.record.snapshot(),
        };
        let incarnation = self.incarnation.next();
        let (instance, restored) = self.create(plugin.clone(), snapshot, incarnation).await?;
        // Its first call decides: an empty batch does nothing, but has to come back.
        let now = self.shared.now();
        let answer = instance
            .call(
                EventBatch {
                    now,
                    events: Vec::new(),
                },
                &[],
            )
            .await?;
        self.record.keep_snapshot(Some(answer.snapshot));
        self.instance = Some(instance);
        self.incarnation = incarnation;
        self.statistics_at = NodeTime(0);
        let before = self.record.exchange(plugin.clone());
        {
            let mut health = self.record.change_health();
            health.status = ActorStatus::Running;
            health.incarnation = incarnation;
            health.since = now;
            health.version.clone_from(&plugin.manifest().version);
        }
        self.start_at = Some(now);
        let (old, new) = (&before.manifest().version, &plugin.manifest().version);
        self.tell(
            Severity::Advisory,
            ActorStatus::Running,
            &format!("version {old} exchanged for {new}"),
        );
        Ok(restored)
    }

    /// An operator's reset: the failures are forgotten and the instance starts anew, without its state if `fresh`.
    pub fn reset(&mut self, fresh: bool) {
        self.record.forget_failures();
        if fresh {
            self.record.keep_snapshot(None);
        }
        self.forget_left_over();
        if self.instance.take().is_some() {
            self.incarnation = self.incarnation.next();
        }
        self.failed = None;
        self.start_at = Some(self.shared.now());
        self.record.change_health().status = ActorStatus::Restarting;
        self.tell(
            Severity::Advisory,
            ActorStatus::Restarting,
            "is started anew by the operator",
        );
    }

    /// Nobody will be handed what is left over: its commands are lost.
    fn forget_left_over(&mut self) {
        self.lost
            .extend(self.left_over.drain(..).filter_map(|event| command_of(&event)));
    }

    /// Commands that no incarnation will carry out any more; their askers have to be told.
    pub fn take_lost(&mut self) -> Vec<CommandId> {
        std::mem::take(&mut self.lost)
    }

    /// Ends the child process, if the instance has one of its own; tells whether.
    pub fn kill(&self) -> bool {
        self.instance.as_ref().is_some_and(Instance::kill)
    }

    /// Writes the instance's call times into its health, twice a second: their quantiles cost more than a call.
    pub fn publish_statistics(&mut self) {
        let now = self.shared.now();
        let Some(instance) = &self.instance else { return };
        if now < self.statistics_at {
            return;
        }
        self.statistics_at = now.plus_seconds(0.5);
        let statistics = instance.statistics();
        let mut health = self.record.change_health();
        health.calls = statistics.calls;
        health.call_p50_us = statistics.p50_us;
        health.call_p99_us = statistics.p99_us;
        health.process_id = instance.pid();
    }

    fn tell(&self, severity: Severity, status: ActorStatus, what: &str) {
        let record = &self.record;
        let kind = EventKind::Supervision {
            actor: record.health().name.clone(),
            status,
        };
        let text = format!("{} {what}", record.label);
        self.shared
            .events
            .record(self.shared.now(), Some(record.vehicle), severity, kind, text);
    }
}

fn command_of(event: &Event) -> Option<CommandId> {
    match event {
        Event::Command { id, .. } | Event::PayloadCommand { id, .. } => Some(*id),
        _ => None,
    }
}

/// What is told again by itself in every period, and what was to bring the failure about, is not.
fn is_worth_a_second_try(event: &Event) -> bool {
    !matches!(
        event,
        Event::Tick
            | Event::Own(_)
            | Event::Anchor(_)
            | Event::Peers(_)
            | Event::Stick(_)
            | Event::Frame(_)
            | Event::FaultDrill(FaultDrill::Panic | FaultDrill::Hang | FaultDrill::Abort)
    )
}
