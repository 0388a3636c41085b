//! The model: hands every event through to the flight and watches the conditions for hosting the coordinator.

use crate::settings::Settings;
use generic_uav::GenericUav;
use minicbor::bytes::ByteVec;
use minicbor::{Decode, Encode};
use skein_plugin_sdk::domain::exchange::{Create, Event};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::payload::CoordinatorCapability;
use skein_plugin_sdk::domain::{FlightState, NodeTime};
use skein_plugin_sdk::{CreateError, Effects, UavManifest, UavModel, log};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;

/// Flies one vehicle that can host the coordinator.
pub struct CoordinatorUav {
    uav: GenericUav,
    settings: Settings,
    watch: Watch,
    /// What was last said; a new instance says it again.
    told: Option<CoordinatorCapability>,
}

/// What is not the flight's.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
struct Watch {
    /// The charge is enough, with a margin on the way back.
    #[n(0)]
    charged: bool,
    /// Since when all conditions hold.
    #[n(1)]
    since: Option<NodeTime>,
}

#[derive(Encode, Decode)]
struct Snapshot {
    #[n(0)]
    version: u32,
    #[n(1)]
    flight: ByteVec,
    #[n(2)]
    watch: Watch,
}

impl UavModel for CoordinatorUav {
    type Config = Settings;

    const MANIFEST: UavManifest = UavManifest {
        name: "coordinator-uav",
        version: env!("CARGO_PKG_VERSION"),
        description: "Flies as generic-uav does, and says whether its vehicle can host the coordinator of the swarm.",
        // Those of `GenericUav` first: one constant list cannot take in another.
        effects: &[
            EffectKind::Setpoint,
            EffectKind::StopStream,
            EffectKind::Autopilot,
            EffectKind::CommandProgress,
            EffectKind::State,
            EffectKind::Anchor,
            EffectKind::Notice,
            EffectKind::TrackingError,
            EffectKind::RouteFinished,
            EffectKind::Limits,
            EffectKind::Capability,
        ],
    };

    fn create(mut create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let mut watch = Watch::default();
        if let Some(bytes) = create.snapshot.take() {
            match minicbor::decode::<Snapshot>(&bytes) {
                Ok(snapshot) if snapshot.version == SNAPSHOT_VERSION => {
                    watch = snapshot.watch;
                    create.snapshot = Some(snapshot.flight.into());
                }
                Ok(other) => log::warn!("the snapshot is of version {}: starting anew", other.version),
                Err(error) => log::warn!("the snapshot is of no use ({error}): starting anew"),
            }
        }
        Ok(Self {
            uav: GenericUav::create(create, settings.flight)?,
            settings,
            watch,
            told: None,
        })
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        self.uav.handle(now, events, effects);
        let heard = events.iter().any(|event| matches!(event, Event::Own(_) | Event::Tick));
        if heard {
            self.judge(now, effects);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        let snapshot = Snapshot {
            version: SNAPSHOT_VERSION,
            flight: self.uav.snapshot().into(),
            watch: self.watch,
        };
        // Writing into a vector does not fail; if it did, no snapshot would be better than half of one.
        minicbor::to_vec(snapshot).unwrap_or_default()
    }
}

impl CoordinatorUav {
    /// Says whether it is capable, when that changes.
    fn judge(&mut self, now: NodeTime, out: &mut Effects) {
        self.watch.charged = self.is_charged();
        if self.holds() {
            self.watch.since.get_or_insert(now);
        } else {
            self.watch.since = None;
        }
        let settled = |since: NodeTime| now.seconds_since(since) >= self.settings.settle_s;
        let capability = CoordinatorCapability {
            capable: self.watch.since.is_some_and(settled),
            priority: self.settings.priority,
        };
        if self.told != Some(capability) {
            out.capability(capability);
            self.told = Some(capability);
        }
    }

    fn is_charged(&self) -> bool {
        let charge = self.uav.own_state().and_then(|own| own.battery.remaining);
        let margin = if self.watch.charged {
            0.0
        } else {
            self.settings.battery_margin
        };
        match charge.filter(|charge| charge.is_finite()) {
            // No more than full is asked for.
            Some(charge) => f64::from(charge) >= (self.settings.min_battery + margin).min(1.0),
            None => self.settings.without_battery,
        }
    }

    fn holds(&self) -> bool {
        let Some(own) = self.uav.own_state() else {
            return false;
        };
        let state = self.uav.state();
        let lost = !own.link_connected || matches!(state, FlightState::Faulted);
        let placed = !self.settings.needs_position || own.kinematics.is_some();
        let flies = !self.settings.needs_flight || state.is_available_in_air();
        !lost && placed && flies && self.watch.charged
    }
}
