//! Who is taken back, and that nobody is against anybody's will.

use super::*;
use proptest::prelude::*;

fn seen(mode: FlightMode, failsafe: bool) -> SeenVehicle {
    SeenVehicle {
        is_heard: true,
        is_placed: true,
        airborne: true,
        mode,
        failsafe,
    }
}

/// What becomes of a vehicle that shows these modes from these times on, looked at 50 times a second for ten seconds.
fn flown(shown: &[(f64, SeenVehicle)]) -> (Taking, f64) {
    let mut taking = Taking::Awaited;
    for period in 0..500_u32 {
        let now_s = f64::from(period) / 50.0;
        let at = shown
            .iter()
            .rev()
            .find(|(from_s, _)| *from_s <= now_s)
            .expect("begins at zero")
            .1;
        taking = step(taking, &at, NodeTime::from_seconds(now_s));
        if matches!(taking, Taking::Taken | Taking::Left(_)) {
            return (taking, now_s);
        }
    }
    (taking, 10.0)
}

#[test]
fn who_has_stayed_in_offboard_is_taken_when_no_failsafe_can_show_any_more() {
    let (taking, after_s) = flown(&[(0.0, seen(FlightMode::Offboard, false))]);
    assert_eq!(taking, Taking::Taken);
    assert!((STAYED_S..STAYED_S + 0.05).contains(&after_s), "{after_s}");
}

#[test]
fn who_comes_back_out_of_the_failsafe_is_taken_at_once() {
    for mode in [FlightMode::Return, FlightMode::Hold, FlightMode::Land] {
        let back = [(0.0, seen(mode, true)), (1.4, seen(FlightMode::Offboard, false))];
        assert_eq!(flown(&back), (Taking::Taken, 1.4));
    }
    // The failsafe shows only with the next heartbeat.
    let late = [
        (0.0, seen(FlightMode::Offboard, false)),
        (0.8, seen(FlightMode::Return, true)),
        (1.8, seen(FlightMode::Offboard, false)),
    ];
    assert_eq!(flown(&late), (Taking::Taken, 1.8));
}

#[test]
fn another_failsafe_that_setpoints_do_not_end_is_left_to_itself() {
    let stays = [(0.0, seen(FlightMode::Return, true))];
    let (taking, after_s) = flown(&stays);
    assert_eq!(taking, Taking::Left(Why::Stays(FlightMode::Return)));
    assert!(after_s < COMES_BACK_S + 0.05, "{after_s}");
}

#[test]
fn who_was_chosen_a_mode_for_is_left_before_and_while_it_is_held() {
    for mode in FlightMode::ALL
        .iter()
        .filter(|mode| !matches!(mode, FlightMode::Unknown | FlightMode::Offboard))
    {
        let left = Taking::Left(Why::Chosen(*mode));
        assert_eq!(flown(&[(0.0, seen(*mode, false))]), (left, 0.0));
        let during = [(0.0, seen(FlightMode::Return, true)), (0.5, seen(*mode, false))];
        assert_eq!(flown(&during), (left, 0.5));
    }
}

#[test]
fn who_stands_is_left_and_of_whom_nothing_is_known_nothing_follows() {
    let landed = SeenVehicle {
        airborne: false,
        ..seen(FlightMode::Offboard, false)
    };
    assert_eq!(flown(&[(0.0, landed)]).0, Taking::Left(Why::OnGround));
    let lost = SeenVehicle {
        is_heard: false,
        ..seen(FlightMode::Position, false)
    };
    assert_eq!(flown(&[(0.0, lost)]).0, Taking::Awaited);
    assert_eq!(flown(&[(0.0, seen(FlightMode::Unknown, false))]).0, Taking::Awaited);
    let nowhere = SeenVehicle {
        is_placed: false,
        ..seen(FlightMode::Offboard, false)
    };
    let later = [(0.0, nowhere), (5.0, seen(FlightMode::Offboard, false))];
    // Held, and taken when it is known where it is among the others.
    assert_eq!(flown(&later), (Taking::Taken, 5.0));
}

fn any_seen() -> impl Strategy<Value = SeenVehicle> {
    let mode = proptest::sample::select(FlightMode::ALL);
    let often = prop_oneof![Just(FlightMode::Offboard), Just(FlightMode::Return), mode];
    let likely = || prop::bool::weighted(0.9);
    (likely(), likely(), likely(), often, any::<bool>()).prop_map(|(is_heard, is_placed, airborne, mode, failsafe)| {
        SeenVehicle {
            is_heard,
            is_placed,
            airborne,
            mode,
            failsafe,
        }
    })
}

proptest! {
    #[test]
    fn nobody_gets_a_setpoint_in_a_mode_that_somebody_chose_and_who_is_left_stays_left(
        all in prop::collection::vec((any_seen(), 0.02..1.5_f64), 1..40)
    ) {
        let (mut taking, mut now_s, mut left, mut first) = (Taking::Awaited, 0.0, false, None);
        for (seen, after_s) in all {
            now_s += after_s;
            taking = step(taking, &seen, NodeTime::from_seconds(now_s));
            let known = seen.is_heard && seen.mode != FlightMode::Unknown;
            let ours = seen.mode == FlightMode::Offboard
                || (seen.failsafe && matches!(seen.mode, FlightMode::Return | FlightMode::Hold | FlightMode::Land));
            match taking {
                Taking::Holding { since, .. } => {
                    prop_assert!(!left);
                    prop_assert!(!known || (ours && seen.airborne), "{seen:?}");
                    // Out of OFFBOARD nobody is held for longer than it takes to come back.
                    let for_s = now_s - since.as_seconds();
                    prop_assert!(!known || seen.mode == FlightMode::Offboard || for_s < COMES_BACK_S + 1e-3);
                    prop_assert_eq!(*first.get_or_insert(since), since);
                }
                Taking::Taken if !left => {
                    prop_assert!(seen.mode == FlightMode::Offboard && seen.airborne && seen.is_placed);
                    return Ok(());
                }
                Taking::Taken => prop_assert!(false, "taken after it was left"),
                Taking::Left(_) => left = true,
                Taking::Awaited => prop_assert!(!left && first.is_none()),
            }
        }
    }
}
