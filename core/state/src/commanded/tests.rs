//! An itinerary goes from leg to leg and ends with its last, or with any that is refused.

use super::*;
use skein_domain::Refusal;

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
    commanded.end(CommandId(4));
    assert_eq!(commanded.command(), Some(VehicleCommand::Land));
    commanded.end(CommandId(5));
    assert_eq!(commanded.command(), None);
}
