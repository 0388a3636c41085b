//! An itinerary goes from leg to leg and ends with its last, or with any that is refused.

use super::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

const FIRST: CommandId = CommandId(2);

fn commanded() -> Commanded {
    let commanded = Commanded::default();
    commanded.begin_itinerary(Itinerary {
        id: CommandId(1),
        name: "return",
        returns: true,
        legs: VecDeque::from([VehicleCommand::Hold, VehicleCommand::Return]),
        current: Some(FIRST),
    });
    commanded
}

fn next(commanded: &Commanded, id: u64) -> Option<(CommandId, VehicleCommand)> {
    commanded.next_leg(|| CommandId(id))
}

#[test]
fn the_end_of_the_last_leg_is_the_end_of_the_whole() {
    let commanded = commanded();
    assert_eq!(next(&commanded, 3), None, "the first is still flown");
    for (leg, command) in [(3, VehicleCommand::Hold), (4, VehicleCommand::Return)] {
        let flown = CommandId(leg - 1);
        let progress = commanded.leg_progress(flown, &CommandProgress::Done);
        assert!(matches!(progress, LegProgress::GoesOn), "{progress:?}");
        assert_eq!(next(&commanded, leg), Some((CommandId(leg), command)));
    }
    let progress = commanded.leg_progress(CommandId(4), &CommandProgress::Done);
    assert!(matches!(progress, LegProgress::Over(whole) if whole.id == CommandId(1)));
    assert!(!commanded.returns());
}

#[test]
fn a_refused_leg_is_the_end_of_the_whole_and_others_are_no_leg() {
    let commanded = commanded();
    let refused = CommandProgress::Refused {
        refusal: Refusal::Superseded,
    };
    assert!(matches!(
        commanded.leg_progress(CommandId(9), &refused),
        LegProgress::NoLeg
    ));
    assert!(matches!(
        commanded.leg_progress(FIRST, &CommandProgress::Executing),
        LegProgress::GoesOn
    ));
    assert!(matches!(commanded.leg_progress(FIRST, &refused), LegProgress::Over(_)));
    assert!(commanded.abandon_itinerary().is_none());
}

#[test]
fn a_command_ends_with_its_own_number_only() {
    let commanded = Commanded::default();
    commanded.begin(CommandId(5), VehicleCommand::Land);
    commanded.progress(CommandId(4), &CommandProgress::Done);
    commanded.progress(CommandId(5), &CommandProgress::Executing);
    assert_eq!(commanded.command(), Some(VehicleCommand::Land));
    commanded.progress(CommandId(5), &CommandProgress::Done);
    assert_eq!(commanded.command(), None);
}

/// Counts the spans that have ended.
#[derive(Clone, Default)]
struct Ended(Arc<AtomicUsize>);

impl<S: tracing::Subscriber> Layer<S> for Ended {
    fn on_close(&self, _: tracing::Id, _: Context<'_, S>) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn a_span_lasts_until_its_command_has_ended_and_no_vehicle_keeps_many() {
    let ended = Ended::default();
    let _registered = tracing_subscriber::registry().with(ended.clone()).set_default();
    let count = || ended.0.load(Ordering::Relaxed);
    let commanded = Commanded::default();
    commanded.trace(CommandId(1), tracing::info_span!("command"));
    commanded.progress(CommandId(1), &CommandProgress::Executing);
    commanded.progress(CommandId(2), &CommandProgress::Done);
    assert_eq!(count(), 0);
    commanded.progress(CommandId(1), &CommandProgress::Done);
    assert_eq!(count(), 1);

    for id in 0..100 {
        commanded.trace(CommandId(id), tracing::info_span!("command"));
    }
    assert_eq!(count(), 1 + 100 - MOST_TRACED);
}
