//! What the plugin needs of a gimbal, whatever it is spoken to in.

use crate::manager::Manager;
use crate::orders::{Control, ControlOutcome, Moment, Status, Turn};
use crate::settings::{Backend, Settings};
use crate::siyi::Siyi;
use minicbor::{Decode, Encode};
use skein_domain::SystemId;
use skein_domain::exchange::Event;
use skein_plugin_sdk::Effects;

/// A gimbal.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) enum Device {
    #[n(0)]
    Mavlink(#[n(0)] Manager),
    #[n(1)]
    Siyi(#[n(0)] Siyi),
}

impl Device {
    /// One of which nothing is known yet.
    pub(crate) fn new(settings: &Settings, system_id: Option<SystemId>) -> Self {
        match settings.backend {
            Backend::Mavlink => Self::Mavlink(Manager::new(system_id, settings)),
            Backend::Siyi => Self::Siyi(Siyi::default()),
        }
    }

    /// Whether it is what this configuration asks for: a snapshot may come from another.
    pub(crate) fn fits(&self, settings: &Settings) -> bool {
        matches!(
            (self, settings.backend),
            (Self::Mavlink(_), Backend::Mavlink) | (Self::Siyi(_), Backend::Siyi)
        )
    }

    /// Takes what arrived.
    pub(crate) fn hear(&mut self, at: &Moment, event: &Event) -> Option<ControlOutcome> {
        match (self, event) {
            (Self::Mavlink(manager), Event::Mavlink(message)) => manager.hear(at, message),
            (Self::Siyi(siyi), Event::Received { bytes }) => {
                siyi.hear(at, bytes);
                None
            }
            _ => None,
        }
    }

    /// Once per tick: asks for what is not known, and keeps in touch.
    pub(crate) fn work(&mut self, at: &Moment, effects: &mut Effects) -> Option<ControlOutcome> {
        match self {
            Self::Mavlink(manager) => manager.work(at, effects),
            Self::Siyi(siyi) => {
                siyi.work(at, effects);
                None
            }
        }
    }

    /// Asks for control, or to give it up. An outcome follows, here or from [`Self::hear`] or [`Self::work`].
    pub(crate) fn ask(&mut self, at: &Moment, control: Control, effects: &mut Effects) -> Option<ControlOutcome> {
        match self {
            Self::Mavlink(manager) => manager.ask(at, control, effects),
            // It knows no owners: whoever speaks last is obeyed.
            Self::Siyi(_) => Some((control, Ok(()))),
        }
    }

    /// Turns it.
    pub(crate) fn turn(&mut self, at: &Moment, turn: Turn, effects: &mut Effects) {
        match self {
            Self::Mavlink(manager) => manager.turn(at, turn, effects),
            Self::Siyi(siyi) => siyi.turn(at, turn, effects),
        }
    }

    /// Whether it keeps to north by itself when the vehicle turns.
    pub(crate) fn holds_north(&self) -> bool {
        match self {
            Self::Mavlink(manager) => manager.holds_north(),
            Self::Siyi(_) => false,
        }
    }

    /// Whether it turns at rates as told; if not, it is told angles that move.
    pub(crate) fn turns_at_rates(&self) -> bool {
        match self {
            Self::Mavlink(manager) => manager.turns_at_rates(),
            Self::Siyi(_) => true,
        }
    }

    /// Whether it obeys without further asking.
    pub(crate) fn obeys(&self) -> bool {
        match self {
            Self::Mavlink(manager) => manager.is_ours(),
            Self::Siyi(_) => true,
        }
    }

    /// Whether control of it may be taken without being told to.
    pub(crate) fn is_free(&self, at: &Moment) -> bool {
        match self {
            Self::Mavlink(manager) => manager.is_free(at),
            Self::Siyi(_) => true,
        }
    }

    pub(crate) fn status(&self, at: &Moment) -> Status {
        match self {
            Self::Mavlink(manager) => manager.status(at),
            Self::Siyi(siyi) => siyi.status(at),
        }
    }
}
