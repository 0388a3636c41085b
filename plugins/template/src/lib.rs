//! A payload plugin to copy: an indicator light that is reached over a line of its own.
//!
//! Everything a payload plugin can have is in here once: a configuration, commands, a state, events, a device that answers late or not at
//! all, and a snapshot. Look for `CHANGE` to see where your own device comes in.
//!
//! Must never do: I/O, read a clock, wait. Time and bytes come in as events; what is to be sent goes out as effects.

mod device;

use device::{Answer, Lines};
use minicbor::{Decode, Encode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_plugin_sdk::domain::exchange::{Create, Event, Severity};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::{CommandId, NodeTime, Refusal};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, log};

/// What stands in the node's configuration. CHANGE: your settings; a node checks them against the schema that these comments become.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Brightness if a command names none, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub brightness: f64,
    /// The light is asked for its state this often, in seconds.
    #[schemars(range(min = 0.1))]
    pub poll_s: f64,
    /// It counts as gone when it has not answered for so long, in seconds.
    #[schemars(range(min = 0.1))]
    pub timeout_s: f64,
    /// Above this temperature it tells that it is too hot, in degrees Celsius.
    pub hot_c: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            brightness: 0.5,
            poll_s: 1.0,
            timeout_s: 3.0,
            hot_c: 70.0,
        }
    }
}

/// What it can be told. CHANGE: your commands, or one of the common vocabularies in `skein_plugin_sdk::domain::payload`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Shine.
    On {
        /// 0 to 1; as configured if left out.
        #[serde(default)]
        brightness: Option<f64>,
    },
    /// Be dark.
    Off,
}

/// What it reports of itself. CHANGE: your state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct State {
    /// It answers.
    pub connected: bool,
    /// Its brightness, 0 to 1; 0 is dark.
    pub brightness: f64,
    /// Its temperature in degrees Celsius.
    pub temperature_c: Option<f64>,
}

/// What it tells when something happens. CHANGE: your events, or `()` for none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Occurrence {
    /// It is too hot.
    Overheated {
        /// Its temperature in degrees Celsius.
        temperature_c: f64,
    },
}

/// The plugin: one instance per light.
pub struct IndicatorLight {
    settings: Settings,
    /// What a new instance goes on with after a restart.
    kept: Kept,
    /// What it does not need: the device is asked again.
    lines: Lines,
    state: State,
    told: Option<State>,
    asked: Option<NodeTime>,
    heard: Option<NodeTime>,
}

/// Everything that must survive a restart. Number the fields and never reuse a number: an older snapshot is then still understood.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
struct Kept {
    /// The brightness that was last asked for.
    #[n(0)]
    wanted: Option<f64>,
    /// The command that waits for the light's answer, and since when.
    #[n(1)]
    waiting: Option<(CommandId, NodeTime)>,
    /// It was told that it is too hot.
    #[n(2)]
    hot: bool,
}

impl Payload for IndicatorLight {
    type Config = Settings;
    type Command = Command;
    type State = State;
    type Occurrence = Occurrence;

    const MANIFEST: PayloadManifest = PayloadManifest {
        // CHANGE: what it is.
        kind: PluginKind::GIMBAL,
        name: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        description: "An indicator light on a line of its own.",
        // The host refuses any effect that is not named here.
        effects: &[
            EffectKind::CommandProgress,
            EffectKind::Notice,
            EffectKind::Transmit,
            EffectKind::Report,
            EffectKind::Occurrence,
        ],
        // Ids of MAVLink messages that are to arrive as `Event::Mavlink`; answer with `effects.mavlink`.
        mavlink_messages: &[],
        tick_rate_hz: 10,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        // The node has checked the schema; what no schema can say is checked here.
        if settings.timeout_s <= settings.poll_s {
            return Err(CreateError::new("timeout_s must be longer than poll_s"));
        }
        let kept = match create.snapshot.as_deref().map(minicbor::decode) {
            Some(Ok(kept)) => kept,
            Some(Err(error)) => {
                log::warn!("the snapshot is of no use ({error}): starting anew");
                Kept::default()
            }
            None => Kept::default(),
        };
        Ok(Self {
            settings,
            kept,
            lines: Lines::default(),
            state: State::default(),
            told: None,
            asked: None,
            heard: None,
        })
    }

    fn command(&mut self, now: NodeTime, id: CommandId, command: Command, effects: &mut Effects) {
        let brightness = match command {
            Command::On { brightness } => brightness.unwrap_or(self.settings.brightness),
            Command::Off => 0.0,
        };
        if !(0.0..=1.0).contains(&brightness) {
            let detail = format!("brightness {brightness} is not within 0 to 1");
            effects.refused(id, Refusal::InvalidValue { detail });
            return;
        }
        // Every command ends in exactly one `done` or `refused`; a newer one replaces the one that waits.
        if let Some((earlier, _)) = self.kept.waiting.replace((id, now)) {
            effects.refused(earlier, Refusal::Superseded);
        }
        self.kept.wanted = Some(brightness);
        effects.executing(id);
        effects.transmit(device::set(brightness));
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            match event {
                Event::Received { bytes } => {
                    for answer in self.lines.take(bytes) {
                        self.take(now, &answer, effects);
                    }
                }
                Event::Tick => self.tick(now, effects),
                // The vehicle's own state, its peers and its other payloads come too.
                _ => {}
            }
        }
        // Reported when it changes.
        if self.told != Some(self.state) {
            effects.report(&self.state);
            self.told = Some(self.state);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        minicbor::to_vec(self.kept).unwrap_or_default()
    }
}

impl IndicatorLight {
    fn take(&mut self, now: NodeTime, answer: &Answer, effects: &mut Effects) {
        self.heard = Some(now);
        self.state = State {
            connected: true,
            brightness: answer.brightness,
            temperature_c: Some(answer.temperature_c),
        };
        let reached = self
            .kept
            .wanted
            .is_some_and(|wanted| (wanted - answer.brightness).abs() < 0.01);
        if reached && let Some((id, _)) = self.kept.waiting.take() {
            effects.done(id);
        }
        let hot = answer.temperature_c > self.settings.hot_c;
        if hot && !self.kept.hot {
            let temperature_c = answer.temperature_c;
            effects.occurrence(&Occurrence::Overheated { temperature_c });
            effects.notice(Severity::Warning, format!("the light is {temperature_c} °C hot"));
        }
        self.kept.hot = hot;
    }

    fn tick(&mut self, now: NodeTime, effects: &mut Effects) {
        let over = |since: NodeTime, limit_s: f64| now.seconds_since(since) >= limit_s;
        if self.asked.is_none_or(|asked| over(asked, self.settings.poll_s)) {
            self.asked = Some(now);
            effects.transmit(device::ask());
        }
        if self.heard.is_some_and(|heard| over(heard, self.settings.timeout_s)) {
            self.heard = None;
            self.state = State::default();
        }
        if let Some((id, since)) = self.kept.waiting
            && over(since, self.settings.timeout_s)
        {
            self.kept.waiting = None;
            let (what, after_s) = ("the light".to_owned(), now.seconds_since(since));
            effects.refused(id, Refusal::TimedOut { what, after_s });
        }
    }
}

// What the node looks for in the library.
skein_plugin_sdk::export_payload!(IndicatorLight);

#[cfg(test)]
mod tests;
