//! Items, overrides and refusals cross the plugin boundary as they are.

use super::*;
use crate::{FailsafeEvent, FailsafeEventKind, Reaction, ReportOnly, Trigger};
use proptest::prelude::*;

fn crosses<T>(value: &T) -> T
where
    T: minicbor::Encode<()> + for<'b> minicbor::Decode<'b, ()>,
{
    let bytes = minicbor::to_vec(value).expect("encodes");
    minicbor::decode(&bytes).expect("decodes")
}

proptest! {
    #[test]
    fn items_cross_the_boundary(id in ".{0,20}", number in prop::option::of(-1e9..1e9), red in any::<bool>()) {
        let item = PreflightItem {
            id,
            title: "Storage".into(),
            status: if red { ItemStatus::Red } else { ItemStatus::Amber },
            value: "3 GB".into(),
            number,
            unit: "GB".into(),
            limit: number,
            why: "pictures would be lost".into(),
            may_be_overridden: red,
        };
        prop_assert_eq!(crosses(&item), item);
    }
}

#[test]
fn overrides_refusals_and_events_cross_the_boundary() {
    let given = PreflightOverride {
        operator: "ada".into(),
        reason: "seen by eye".into(),
        items: vec!["home".into()],
        vehicle: Some(VehicleId(2)),
        given_at: NodeTime(5),
        valid_s: 30.0,
    };
    assert_eq!(crosses(&given), given);
    let refusal = Refusal::Preflight {
        items: vec!["position".into(), "home".into()],
    };
    assert_eq!(crosses(&refusal), refusal);
    assert_eq!(
        (refusal.code(), refusal.to_string().as_str()),
        ("preflight", "preflight: position, home")
    );
    let event = FailsafeEvent {
        kind: FailsafeEventKind::Ordered,
        trigger: Trigger::StaleEstimate,
        value: 0.52,
        limit: 0.5,
        unit: "s".into(),
        since: NodeTime(1),
        at: NodeTime(2),
        reaction: Reaction::Hold,
        report_only: Some(ReportOnly::Overruled),
        reason: "position is old".into(),
    };
    assert_eq!(crosses(&event), event);
}

#[test]
fn the_worst_item_counts_and_red_ones_block() {
    let item = |id: &str, status| PreflightItem {
        id: id.into(),
        status,
        ..PreflightItem::default()
    };
    let report = PreflightReport {
        vehicle: None,
        items: vec![
            item("a", ItemStatus::Green),
            item("b", ItemStatus::Red),
            item("c", ItemStatus::Amber),
        ],
        made_at: NodeTime(0),
    };
    assert_eq!(report.worst(), ItemStatus::Red);
    assert_eq!(report.blocking().map(|i| i.id.as_str()).collect::<Vec<_>>(), ["b"]);
    assert_eq!(PreflightReport::default().worst(), ItemStatus::Red);
    // What does not apply is no better and no worse than what is good.
    assert!(ItemStatus::NotApplicable < ItemStatus::Green);
}

#[test]
fn what_is_red_may_be_overridden_but_for_what_never_may() {
    let item = |id: &str, status| PreflightItem {
        id: id.into(),
        status,
        // Whoever made it has no say in it.
        may_be_overridden: status != ItemStatus::Red,
        ..PreflightItem::default()
    };
    let report = PreflightReport {
        items: vec![
            item("battery", ItemStatus::Red),
            item("position", ItemStatus::Red),
            item("home", ItemStatus::Amber),
            item("not_moving", ItemStatus::NotApplicable),
        ],
        ..PreflightReport::default()
    };
    let may: Vec<bool> = report.finished().items.iter().map(|i| i.may_be_overridden).collect();
    assert_eq!(may, [true, false, false, false]);
}
