//! What a client is told of a recorded flight that is shown: where it is, when that is not just a moment later.
//!
//! Must never do: tell what was before a jump after the jump.

use super::slow::Told;
use super::{Client, End};
use crate::protocol::ServerMessage;
use skein_replay::{Replay, ReplayState};
use tokio::sync::watch;

/// What is shown, as a client knows it.
pub(super) struct Shown {
    state: watch::Receiver<ReplayState>,
    told: Option<ReplayState>,
}

impl Shown {
    pub(super) fn of(replay: &Replay) -> Self {
        Self {
            state: replay.watch(),
            told: None,
        }
    }

    /// Where it is, if that is news: it stands in every frame how far it has gone on.
    fn news(&mut self) -> Option<ReplayState> {
        let now = self.state.borrow_and_update().clone();
        let expected = self.told.as_ref().map(|told| ReplayState {
            position_s: now.position_s,
            ..told.clone()
        });
        (expected.as_ref() != Some(&now)).then(|| self.told.insert(now).clone())
    }

    fn jumps(&self) -> Option<u64> {
        self.told.as_ref().map(|told| told.jumps)
    }
}

/// Waits for a step of it; for ever if what is shown is no recorded flight.
pub(super) async fn step(shown: Option<&mut Shown>) {
    if let Some(shown) = shown
        && shown.state.changed().await.is_ok()
    {
        return;
    }
    // A replay that has ended says nothing more: what was told stays true.
    std::future::pending().await
}

impl Client {
    pub(super) async fn send_replay(&mut self) -> Result<(), End> {
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let before = shown.jumps();
        let Some(state) = shown.news() else { return Ok(()) };
        let jumped = before.is_some_and(|before| before != state.jumps);
        self.say(&ServerMessage::Replay(Box::new(state))).await?;
        if !jumped {
            return Ok(());
        }
        // Everything is another moment's: told anew. What has happened until then is asked for by whoever wants it.
        self.told = Told::default();
        self.last_event = self.app.node.events_after(0).last().map_or(0, |event| event.seq);
        self.send_fleet().await?;
        self.send_safety().await?;
        self.send_tracks().await
    }
}
