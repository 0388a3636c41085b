//! This node's vehicles by id, those that are heard but not flown, and which vehicles of the swarm are taken out of the formation.
//!
//! Must never do: decide whom to adopt (that is the fleet's), or who belongs to the formation (that is the coordinator's).

use crate::vehicle::VehicleRecord;
use parking_lot::{Mutex, RwLock};
use skein_domain::{Refusal, VehicleId};
use skein_px4::PairedLink;
use skein_view::UnadoptedVehicle;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The vehicles of a node.
#[derive(Default)]
pub struct Vehicles {
    records: RwLock<BTreeMap<VehicleId, Arc<VehicleRecord>>>,
    pairs: Mutex<BTreeMap<VehicleId, Arc<PairedLink>>>,
    unadopted: Mutex<Vec<UnadoptedVehicle>>,
    withdrawn: Mutex<BTreeSet<VehicleId>>,
}

impl Vehicles {
    /// The record of a vehicle.
    pub fn record(&self, id: VehicleId) -> Option<Arc<VehicleRecord>> {
        self.records.read().get(&id).cloned()
    }

    /// All records by ascending id.
    pub fn records(&self) -> Vec<Arc<VehicleRecord>> {
        self.records.read().values().cloned().collect()
    }

    /// The record of a vehicle that somebody names.
    ///
    /// # Errors
    /// When this node does not fly it.
    pub fn known(&self, vehicle: VehicleId) -> Result<Arc<VehicleRecord>, Refusal> {
        self.record(vehicle).ok_or(Refusal::UnknownVehicle { vehicle })
    }

    /// The fleet adds a vehicle; the one with the same id, if any, is replaced.
    pub fn adopt(&self, record: Arc<VehicleRecord>) {
        self.records.write().insert(record.id, record);
    }

    /// The two links of a vehicle that is flown over two.
    pub fn pair(&self, id: VehicleId) -> Option<Arc<PairedLink>> {
        self.pairs.lock().get(&id).cloned()
    }

    /// The fleet has given a vehicle two links.
    pub fn note_pair(&self, id: VehicleId, pair: Arc<PairedLink>) {
        self.pairs.lock().insert(id, pair);
    }

    /// Vehicles heard but not flown.
    pub fn unadopted(&self) -> Vec<UnadoptedVehicle> {
        self.unadopted.lock().clone()
    }

    /// The fleet does not fly one; in place of what was said of it before.
    pub fn note_unadopted(&self, trouble: UnadoptedVehicle) {
        let mut unadopted = self.unadopted.lock();
        unadopted.retain(|u| u.system_id != trouble.system_id || u.endpoint != trouble.endpoint);
        unadopted.push(trouble);
    }

    /// The trouble with these is over.
    pub fn forget_unadopted(&self, is_over: impl Fn(&UnadoptedVehicle) -> bool) {
        self.unadopted.lock().retain(|trouble| !is_over(trouble));
    }

    /// Vehicles that are taken out of the formation: of this node's all, of others' as far as the coordinator of this node keeps count.
    pub fn withdrawn(&self) -> BTreeSet<VehicleId> {
        self.withdrawn.lock().clone()
    }

    /// Takes one of this node's vehicles out of the formation; tells whether it was in it. To be done before it is commanded, so that no
    /// regrouping can come between and call it back.
    pub fn withdraw(&self, record: &VehicleRecord) -> bool {
        record.note_withdrawal();
        self.withdrawn.lock().insert(record.id)
    }

    /// The coordinator's node takes a vehicle out, whoever flies it; tells whether it was in the formation. It is not counted as a withdrawal by
    /// the vehicle's own node: that one counts when it is told.
    pub fn leave_out(&self, id: VehicleId) -> bool {
        self.withdrawn.lock().insert(id)
    }

    /// Calls these back into the formation; tells whether one of them was taken out.
    pub fn call_back(&self, ids: &[VehicleId]) -> bool {
        let mut withdrawn = self.withdrawn.lock();
        let before = withdrawn.len();
        withdrawn.retain(|id| !ids.contains(id));
        withdrawn.len() < before
    }

    /// The coordinator has called back vehicles of this node, naming which withdrawal of each it means: a later one stands. Which of them are still out.
    pub fn obey_recalls(&self, recalled: &BTreeMap<VehicleId, u32>) -> Vec<VehicleId> {
        let (records, mut withdrawn) = (self.records(), self.withdrawn.lock());
        for record in &records {
            if recalled.get(&record.id) == Some(&record.withdrawals()) {
                withdrawn.remove(&record.id);
            }
        }
        let ids = records.iter().map(|record| record.id);
        ids.filter(|id| withdrawn.contains(id)).collect()
    }

    /// The swarm says of other nodes' vehicles whether they are out; of them only the coordinator's node keeps count.
    pub fn mirror_withdrawals(&self, told: impl IntoIterator<Item = (VehicleId, bool)>) {
        let mut withdrawn = self.withdrawn.lock();
        for (id, is_out) in told {
            if is_out {
                withdrawn.insert(id);
            } else {
                withdrawn.remove(&id);
            }
        }
    }
}
