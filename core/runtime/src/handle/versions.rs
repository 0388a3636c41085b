//! Other versions of the program: what exchanges them belongs to the process, which hands it in when the node runs.
//!
//! Must never do: exchange anything itself.

use super::NodeHandle;
use skein_state::asks::{UpgradeAnswer, UpgradeAsk};
use skein_upgrade::{Ground, Running, Slots, SlotsError, Upgrader};
use skein_view::UpgradeRefusal;
use std::path::Path;
use std::sync::Arc;

impl NodeHandle {
    /// Lets the versions of this node be exchanged, which are kept under this state folder. It runs as `running`. Set once.
    ///
    /// # Errors
    /// When it cannot be read which versions there are.
    pub fn keep_versions(&self, state: &Path, running: Running) -> Result<Arc<Upgrader>, SlotsError> {
        let upgrader = Upgrader::new(self.shared.clone(), Slots::under(state), running)?;
        let upgrader = Arc::new(upgrader);
        let ground = Ground::new(upgrader.clone(), state);
        // The first one stays: a process keeps its versions in one place.
        let _ = self.parts.versions.set(Arc::new(ground));
        Ok(upgrader)
    }

    /// What exchanges the program.
    ///
    /// # Errors
    /// When this node has no place to keep versions in.
    pub fn versions(&self) -> Result<&Arc<Ground>, UpgradeRefusal> {
        self.parts.versions.get().ok_or(UpgradeRefusal::NoStateFolder)
    }

    pub(crate) async fn exchange_version(&self, ask: UpgradeAsk) -> Result<UpgradeAnswer, UpgradeRefusal> {
        let upgrader = self.versions()?.upgrader().clone();
        upgrader.carry_out(ask).await
    }
}
