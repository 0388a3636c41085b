//! The plugin: figures in, the state and warnings out.

mod report;

use crate::link::{Figures, Heard};
use crate::occurrence::RadioEvent;
use crate::range::{Away, FallOff, Thresholds};
use crate::settings::{Settings, Source};
use crate::wifi::{Change, Wifi, WifiReport};
use mavlink::MessageData;
use mavlink::dialects::common::RADIO_STATUS_DATA;
use minicbor::{Decode, Encode};
use payload_mavlink::decode as decode_message;
use report::Reporter;
use skein_domain::exchange::{Create, Event, OwnState, Severity};
use skein_domain::manifest::EffectKind;
use skein_domain::payload::{RadioCommand, RadioState};
use skein_domain::{CommandId, NodeTime, Refusal};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, saved};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;
/// Transmission power of a Wi-Fi interface that makes sense, in decibels over a milliwatt.
const POWER_DBM: std::ops::RangeInclusive<f64> = 0.0..=40.0;
/// Only this much of distances counts as flying, in metres: on the ground beside the station everything is well.
const BESIDE_M: f64 = 5.0;

/// A radio of one vehicle.
#[derive(Debug)]
pub struct Radio {
    settings: Settings,
    core: Core,
    wifi: Option<Wifi>,
    /// What is wrong with the source.
    fault: String,
    /// The vehicle as it was last told; every batch tells it anew.
    own: OwnState,
    reporter: Reporter,
}

/// What outlives a restart.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
struct Core {
    #[n(0)]
    heard: Option<Heard>,
    #[n(1)]
    fall_off: FallOff,
    #[n(2)]
    warned: bool,
    /// Commands that the source works on. One that was asked before a restart ends with it.
    #[n(3)]
    pending: Vec<CommandId>,
    /// The instance that wrote this; another one has to end what was pending.
    #[n(4)]
    incarnation: u32,
}

impl Payload for Radio {
    type Config = Settings;
    type Command = RadioCommand;
    type State = RadioState;
    type Occurrence = RadioEvent;

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::RADIO,
        name: "radio",
        version: env!("CARGO_PKG_VERSION"),
        description: "Quality of a radio link from RADIO_STATUS or Linux Wi-Fi, its range, and a warning before the vehicle leaves it.",
        effects: &[
            EffectKind::CommandProgress,
            EffectKind::Notice,
            EffectKind::Report,
            EffectKind::Occurrence,
        ],
        mavlink_messages: &[RADIO_STATUS_DATA::ID],
        tick_rate_hz: 5,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let mut fault = String::new();
        let wifi = match settings.source {
            Source::RadioStatus => None,
            Source::Nl80211 => Wifi::start(&settings.interface, settings.poll_hz)
                .map_err(|error| fault = format!("no thread to ask the kernel on: {error}"))
                .ok(),
        };
        Ok(Self {
            settings,
            core: saved::restored(SNAPSHOT_VERSION, create.snapshot.as_deref()).unwrap_or_default(),
            wifi,
            fault,
            own: OwnState::default(),
            reporter: Reporter::new(create.incarnation.0),
        })
    }

    fn command(&mut self, now: NodeTime, id: CommandId, command: RadioCommand, effects: &mut Effects) {
        self.end_what_was_pending(effects);
        match self.begin(id, command) {
            Ok(()) => effects.executing(id),
            Err(refusal) => effects.refused(id, refusal),
        }
        self.report(now, effects);
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        self.end_what_was_pending(effects);
        for event in events {
            match event {
                Event::Own(own) => self.own = *own,
                Event::Mavlink(message) if self.settings.source == Source::RadioStatus => {
                    if let Some(said) = decode_message(message) {
                        self.hear(now, Figures::from_radio_status(&said, self.settings.rssi_scale));
                    }
                }
                Event::Tick => self.tick(now, effects),
                _ => {}
            }
        }
        self.report(now, effects);
    }

    fn snapshot(&self) -> Vec<u8> {
        saved::encode(SNAPSHOT_VERSION, &self.core)
    }
}

impl Radio {
    /// What an earlier instance had begun is not heard of any more: its thread is gone.
    fn end_what_was_pending(&mut self, effects: &mut Effects) {
        if self.core.incarnation == self.reporter.incarnation {
            return;
        }
        self.core.incarnation = self.reporter.incarnation;
        for id in std::mem::take(&mut self.core.pending) {
            effects.refused(id, Refusal::not_running("the instance that had begun it"));
        }
    }

    fn begin(&mut self, id: CommandId, command: RadioCommand) -> Result<(), Refusal> {
        let Some(wifi) = &self.wifi else {
            let detail = match self.settings.source {
                Source::RadioStatus => {
                    "settings of a telemetry radio: it takes them only over its own serial line".to_owned()
                }
                Source::Nl80211 => self.fault.clone(),
            };
            return Err(Refusal::NotSupported { detail });
        };
        let change = match command {
            RadioCommand::SetChannel { channel } => Change::channel(channel)
                .ok_or_else(|| Refusal::invalid(format!("there is no Wi-Fi channel {channel}")))?,
            RadioCommand::SetPower { power_dbm } if POWER_DBM.contains(&power_dbm) => Change::power(power_dbm),
            RadioCommand::SetPower { .. } => {
                return Err(Refusal::invalid(format!(
                    "power_dbm must be within {} and {}",
                    POWER_DBM.start(),
                    POWER_DBM.end()
                )));
            }
        };
        if !wifi.tell(id, change) {
            return Err(Refusal::not_permitted("too many commands wait for the kernel's answer"));
        }
        self.core.pending.push(id);
        Ok(())
    }

    fn hear(&mut self, now: NodeTime, figures: Figures) {
        let step_s = self.core.heard.map_or(0.0, |before| now.seconds_since(before.when));
        self.core.heard = Some(Heard { when: now, figures });
        if let (Some(away), Some(snr_db)) = (self.away(), figures.snr_db(&self.settings))
            && away.distance_m > BESIDE_M
        {
            self.core
                .fall_off
                .learn(away.distance_m, snr_db, step_s, self.settings.memory_s);
        }
    }

    fn tick(&mut self, now: NodeTime, effects: &mut Effects) {
        while let Some(told) = self.wifi.as_ref().and_then(Wifi::take) {
            match told {
                WifiReport::Figures(figures) => {
                    self.fault.clear();
                    self.hear(now, *figures);
                }
                WifiReport::Fault(fault) => self.fault = fault,
                WifiReport::Changed(id, outcome) => {
                    self.core.pending.retain(|pending| *pending != id);
                    effects.ended(id, outcome);
                }
            }
        }
        self.warn(effects);
    }

    fn warn(&mut self, effects: &mut Effects) {
        let Some((away, range_m)) = self.away().zip(self.core.fall_off.range_m(self.settings.snr_margin_db)) else {
            return;
        };
        let thresholds = Thresholds {
            before_s: self.settings.warn_before_s,
            share: self.settings.warn_share,
        };
        let Away { distance_m, .. } = away;
        let warns = distance_m > BESIDE_M && away.warns(range_m, thresholds, self.core.warned);
        match (self.core.warned, warns) {
            (false, true) => {
                effects.notice(
                    Severity::Warning,
                    format!("{distance_m:.0} m from the ground station: its radio reaches about {range_m:.0} m."),
                );
                effects.occurrence(&RadioEvent::RangeWarning {
                    distance_m,
                    range_m,
                    out_of_range_in_s: away.out_of_range_in_s(range_m),
                });
            }
            (true, false) => effects.occurrence(&RadioEvent::RangeRecovered { distance_m, range_m }),
            _ => {}
        }
        self.core.warned = warns;
    }

    /// Where the vehicle is as seen from the ground station, which stands where the vehicle was launched.
    fn away(&self) -> Option<Away> {
        let (home, vehicle) = (self.own.home?, self.own.kinematics?);
        let way = vehicle.position.vector() - home.vector();
        let distance_m = way.norm();
        let radial_m_s = if distance_m > 0.0 {
            way.dot(&vehicle.velocity.vector()) / distance_m
        } else {
            0.0
        };
        (distance_m.is_finite() && radial_m_s.is_finite()).then_some(Away { distance_m, radial_m_s })
    }
}
