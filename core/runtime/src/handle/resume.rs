//! The operator's answer after a restart of the node in flight.
//!
//! Must never do: answer by itself.

use super::NodeHandle;
use super::flying_on;
use skein_domain::Refusal;

impl NodeHandle {
    /// Vehicles that were taken back after a restart fly on, or what was flown is forgotten: they hold then, as after any hold.
    ///
    /// # Errors
    /// When nothing is asked.
    pub async fn resume(&self, fly_on: bool) -> Result<(), Refusal> {
        let nothing = || Refusal::not_permitted("nothing waits to be flown on");
        self.shared.resume.question().ok_or_else(nothing)?;
        if !fly_on {
            self.shared.resume.end();
            return Ok(());
        }
        flying_on::fly_on(self).await.then_some(()).ok_or_else(nothing)
    }
}
