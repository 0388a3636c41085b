//! Who leads next, and how a formation goes on under another leader without anybody moving.
//!
//! Must never do: plan. Succession must be done within a control period; a new shape is planned afterwards.

use crate::formation::{self, Formation};
use skein_domain::{GnssFix, NodeTime, OffsetFrd, SlotMove, VehicleId};
use skein_flight::transition;
use skein_view::{PeerEntry, PeerSnapshot};
use std::cmp::Ordering;

/// The given vehicles, fittest to lead first: by the configured order, then by health, then by id.
#[must_use]
pub fn by_fitness(ids: &[VehicleId], configured: &[VehicleId], peers: &PeerSnapshot) -> Vec<VehicleId> {
    let rank = |id: &VehicleId| configured.iter().position(|c| c == id).unwrap_or(usize::MAX);
    let mut ordered = ids.to_vec();
    ordered.sort_by(|a, b| {
        let (of_a, of_b) = (health(peers.entry(*a)), health(peers.entry(*b)));
        rank(a)
            .cmp(&rank(b))
            .then(of_b.partial_cmp(&of_a).unwrap_or(Ordering::Equal))
            .then(a.cmp(b))
    });
    ordered
}

/// How fit a vehicle is to lead, larger is fitter: satellite fix, then link and charge in steps of ten percent, so that small
/// differences do not outweigh the order of ids.
fn health(entry: Option<&PeerEntry>) -> (u8, i32) {
    let Some(entry) = entry else { return (0, 0) };
    let fix = match entry.telemetry.gnss.fix {
        GnssFix::Unknown => 1,
        GnssFix::None | GnssFix::TwoD => 0,
        GnssFix::ThreeD | GnssFix::Dgps | GnssFix::RtkFloat | GnssFix::RtkFixed => 2,
    };
    let tenths = |share: f32| (share.clamp(0.0, 1.0) * 10.0).round() as i32;
    let charge = entry.telemetry.battery.remaining.map_or(5, tenths);
    (fix, charge - tenths(entry.link.loss))
}

/// The same formation without `lost`, led by the fittest of the rest: everyone stays where it is relative to the others. `None` if
/// nobody is left, or nobody led.
#[must_use]
pub fn succeed(
    formation: &Formation,
    lost: VehicleId,
    start: NodeTime,
    configured: &[VehicleId],
    peers: &PeerSnapshot,
) -> Option<Formation> {
    if formation.leader != Some(lost) {
        return None;
    }
    let available = formation::available(peers);
    let heirs: Vec<VehicleId> = formation
        .members
        .iter()
        .copied()
        .filter(|id| *id != lost && available.contains(id) && formation.slots.contains_key(id))
        .collect();
    let leader = *by_fitness(&heirs, configured, peers).first()?;
    let base = transition::sample(formation.slots.get(&leader)?, start).offset;
    let staying = |slot: &SlotMove| {
        let offset = OffsetFrd::from(transition::sample(slot, start).offset.vector() - base.vector());
        SlotMove {
            from: offset,
            to: offset,
            detour_up_m: 0.0,
            start,
            duration_s: 0.0,
        }
    };
    let slots = formation
        .slots
        .iter()
        .filter(|(id, _)| heirs.contains(id) && **id != leader)
        .map(|(id, slot)| (*id, staying(slot)))
        .collect();
    let mut members = heirs;
    members.retain(|id| *id != leader);
    members.insert(0, leader);
    let mut request = formation.request.clone();
    request.leader = Some(leader);
    if let Some(named) = &mut request.members {
        named.retain(|id| *id != lost);
    }
    Some(Formation {
        request,
        leader: Some(leader),
        members,
        slots,
        keeping: formation
            .keeping
            .iter()
            .filter(|(id, _)| **id != leader && **id != lost)
            .map(|(id, keeping)| (*id, keeping.clone()))
            .collect(),
        decided: start,
        settled_at: start,
        ..formation.clone()
    })
}
