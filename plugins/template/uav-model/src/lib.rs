//! A UAV model to copy: it flies as `generic-uav` does, of which it holds one, and keeps a log book beside it.
//!
//! All commands, tasks and the whole flight state machine are `generic-uav`'s. Look for `CHANGE` to see where your own behaviour comes in.
//!
//! Must never do: I/O, read a clock, wait. Time comes in with the events, so that the same events give the same effects.

use generic_uav::GenericUav;
use minicbor::bytes::ByteVec;
use minicbor::{Decode, Encode};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_plugin_sdk::domain::exchange::{Create, Event, OwnState, Severity};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::{LandedState, NodeTime};
use skein_plugin_sdk::{CreateError, Effects, UavManifest, UavModel, log};

/// What stands in the node's configuration. CHANGE: your settings; a node checks them against the schema that these comments become.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How it flies: the settings of `generic-uav`.
    pub flight: generic_uav::Settings,
    /// An operator is told once when the vehicle has been in the air for so long, in seconds.
    #[schemars(range(min = 1.0))]
    pub tell_after_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            flight: generic_uav::Settings::default(),
            tell_after_s: 900.0,
        }
    }
}

/// What it reports of itself. CHANGE: your state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct State {
    /// Whole seconds in the air.
    pub airborne_s: u64,
    /// Farthest from home so far, in whole metres.
    pub farthest_m: u64,
}

/// The model: one instance per vehicle.
pub struct LogBookUav {
    uav: GenericUav,
    settings: Settings,
    book: Book,
    ticked: Option<NodeTime>,
    reported: Option<State>,
}

/// What must survive a restart beside the flight. Number the fields and never reuse a number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
struct Book {
    #[n(0)]
    airborne_s: f64,
    #[n(1)]
    farthest_m: f64,
    #[n(2)]
    told: bool,
}

/// The flight's snapshot, and the book.
#[derive(Encode, Decode)]
struct Snapshot {
    #[n(0)]
    flight: ByteVec,
    #[n(1)]
    book: Book,
}

/// What `generic-uav` does, and what this model adds.
const EFFECTS: &[EffectKind] = &[
    EffectKind::Setpoint,
    EffectKind::StopStream,
    EffectKind::Autopilot,
    EffectKind::CommandProgress,
    EffectKind::State,
    EffectKind::Anchor,
    EffectKind::Notice,
    EffectKind::TrackingError,
    EffectKind::Limits,
    EffectKind::RouteFinished,
    // Added here. The host refuses any effect that is not named.
    EffectKind::Report,
];

impl UavModel for LogBookUav {
    type Config = Settings;

    const MANIFEST: UavManifest = UavManifest {
        name: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        description: "Flies as generic-uav does and keeps a log book.",
        effects: EFFECTS,
    };

    fn create(mut create: Create, settings: Settings) -> Result<Self, CreateError> {
        let mut book = Book::default();
        if let Some(bytes) = create.snapshot.take() {
            match minicbor::decode::<Snapshot>(&bytes) {
                Ok(snapshot) => {
                    book = snapshot.book;
                    create.snapshot = Some(snapshot.flight.into());
                }
                Err(error) => log::warn!("the snapshot is of no use ({error}): starting anew"),
            }
        }
        let uav = GenericUav::create(create, settings.flight)?;
        Ok(Self {
            uav,
            settings,
            book,
            ticked: None,
            reported: None,
        })
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        // CHANGE: to keep an event from the flight, or to give it another, hand them through one by one.
        self.uav.handle(now, events, effects);
        if events.contains(&Event::Tick) {
            self.keep_book(now, effects);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        let flight = self.uav.snapshot().into();
        minicbor::to_vec(Snapshot {
            flight,
            book: self.book,
        })
        .unwrap_or_default()
    }

    fn state_schema() -> Option<schemars::Schema> {
        Some(schemars::schema_for!(State))
    }
}

impl LogBookUav {
    fn keep_book(&mut self, now: NodeTime, effects: &mut Effects) {
        let period_s = self
            .ticked
            .map_or(0.0, |ticked| now.seconds_since(ticked))
            .clamp(0.0, 1.0);
        self.ticked = Some(now);
        let Some(own) = self.uav.own_state() else { return };
        if is_airborne(own) {
            self.book.airborne_s += period_s;
        }
        if let Some((home, here)) = own.home.zip(self.uav.position()) {
            self.book.farthest_m = self.book.farthest_m.max(home.horizontal_distance_m(&here));
        }
        if self.book.airborne_s >= self.settings.tell_after_s && !self.book.told {
            self.book.told = true;
            let text = format!("in the air for {:.0} s", self.book.airborne_s);
            effects.notice(Severity::Advisory, text);
        }
        let state = State {
            airborne_s: self.book.airborne_s as u64,
            farthest_m: self.book.farthest_m as u64,
        };
        if self.reported != Some(state) {
            effects.report(&state);
            self.reported = Some(state);
        }
    }
}

fn is_airborne(own: &OwnState) -> bool {
    own.armed && own.landed != LandedState::OnGround
}

// What the node looks for in the library.
skein_plugin_sdk::export_uav_model!(LogBookUav);

#[cfg(test)]
mod tests;
