//! Types, echoes, silence and refusals.

use super::*;
use mavlink::dialects::common::{MavParamError, MavParamType};
use proptest::prelude::*;
use skein_domain::ParameterReading;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn value_message(name: &str, value: ParameterValue) -> PARAM_VALUE_DATA {
    let (param_value, param_type) = match value {
        ParameterValue::Integer(i) => (f32::from_bits(i.cast_unsigned()), MavParamType::MAV_PARAM_TYPE_INT32),
        ParameterValue::Real(r) => (r, MavParamType::MAV_PARAM_TYPE_REAL32),
    };
    PARAM_VALUE_DATA {
        param_value,
        param_count: 1,
        param_index: 0,
        param_id: name.into(),
        param_type,
    }
}

/// An autopilot with one integer and one real parameter, that echoes twice. Gives what it stored.
fn answer(store: &mut [(&str, ParameterValue)], parameters: &mut Parameters, now: NodeTime) -> usize {
    let mut messages = 0;
    while let Some(message) = parameters.poll(now, (1, 1)) {
        messages += 1;
        match message {
            ParameterMessage::List(_) => panic!("nobody asked for all"),
            ParameterMessage::Read(read) => {
                assert_eq!(read.param_index, -1);
                let name = read.param_id.to_str().unwrap().to_owned();
                let Some((_, value)) = store.iter().find(|(n, _)| *n == name) else {
                    return messages;
                };
                parameters.on_value(now, &value_message(&name, *value));
            }
            ParameterMessage::Set(set) => {
                let name = set.param_id.to_str().unwrap().to_owned();
                let Some((_, kept)) = store.iter_mut().find(|(n, _)| *n == name) else {
                    return messages;
                };
                *kept = match set.param_type {
                    MavParamType::MAV_PARAM_TYPE_INT32 => {
                        ParameterValue::Integer(set.param_value.to_bits().cast_signed())
                    }
                    _ => ParameterValue::Real(set.param_value),
                };
                let echo = value_message(&name, *kept);
                parameters.on_value(now, &echo);
                parameters.on_value(now, &echo);
            }
        }
    }
    messages
}

#[test]
fn read_before_written_so_that_the_type_is_right() {
    let mut store = [
        ("COM_RCL_EXCEPT", ParameterValue::Integer(0)),
        ("MPC_XY_VEL_MAX", ParameterValue::Real(12.0)),
    ];
    let mut parameters = Parameters::default();
    parameters
        .start(at(1.0), "COM_RCL_EXCEPT", Some(ParameterValue::Real(4.0)))
        .unwrap();
    parameters
        .start(at(1.0), "MPC_XY_VEL_MAX", Some(ParameterValue::Integer(8)))
        .unwrap();
    parameters.start(at(1.0), "MPC_XY_VEL_MAX", None).unwrap();
    answer(&mut store, &mut parameters, at(1.0));
    assert_eq!(store[0].1, ParameterValue::Integer(4), "not 1082130432");
    assert_eq!(store[1].1, ParameterValue::Real(8.0));
    let events = parameters.take_events();
    assert_eq!(events.len(), 3, "a second echo is nothing: {events:?}");
    assert!(events.iter().all(|event| event.outcome.is_ok()));
    assert_eq!(parameters.known("COM_RCL_EXCEPT"), Some(ParameterValue::Integer(4)));
    assert_eq!(parameters.known("NOBODY_ASKED"), None);
}

#[test]
fn a_value_that_does_not_fit_is_not_sent() {
    let mut store = [("COM_RCL_EXCEPT", ParameterValue::Integer(0))];
    let mut parameters = Parameters::default();
    for wrong in [ParameterValue::Real(4.5), ParameterValue::Real(f32::NAN)] {
        parameters.start(at(1.0), "COM_RCL_EXCEPT", Some(wrong)).unwrap();
        answer(&mut store, &mut parameters, at(1.0));
        let event = parameters.take_events().pop().unwrap();
        assert!(
            matches!(event.outcome, Err(ParameterError::WrongType { .. })),
            "{wrong:?}"
        );
    }
    assert_eq!(store[0].1, ParameterValue::Integer(0));
}

#[test]
fn silence_is_asked_into_a_few_times_and_does_not_block_the_next() {
    let mut store = [("KNOWN", ParameterValue::Integer(1))];
    let mut parameters = Parameters::default();
    parameters.start(at(1.0), "NO_SUCH", None).unwrap();
    parameters.start(at(1.0), "KNOWN", None).unwrap();
    let mut asked = 0;
    for i in 0..100 {
        asked += answer(&mut store, &mut parameters, at(1.0 + f64::from(i) * 0.1));
    }
    assert_eq!(asked, usize::from(ATTEMPTS) + 1);
    let events = parameters.take_events();
    assert!(matches!(&events[0].outcome, Err(ParameterError::NoAnswer { name, .. }) if name == "NO_SUCH"));
    assert_eq!(events[1].outcome, Ok(ParameterValue::Integer(1)));
}

#[test]
fn another_echo_or_an_error_is_a_refusal_with_what_was_kept() {
    let mut parameters = Parameters::default();
    let kept = ParameterValue::Integer(3);
    let asked = ParameterValue::Integer(7);
    parameters.start(at(1.0), "LIMITED", Some(asked)).unwrap();
    let mut t = 1.0;
    while parameters.due().is_some() {
        if parameters.poll(at(t), (1, 1)).is_some() {
            parameters.on_value(at(t), &value_message("LIMITED", kept));
        }
        t += 0.05;
    }
    let event = parameters.take_events().pop().unwrap();
    assert!(
        matches!(event.outcome, Err(ParameterError::NotTaken { kept: k, asked: a, .. }) if k == kept && a == asked)
    );

    let error = |name: &str, error| PARAM_ERROR_DATA {
        param_id: name.into(),
        error,
        ..PARAM_ERROR_DATA::default()
    };
    parameters.start(at(t), "LIMITED", Some(asked)).unwrap();
    parameters.poll(at(t), (1, 1)).unwrap();
    parameters.on_error(&error("OTHER", MavParamError::MAV_PARAM_ERROR_READ_ONLY));
    parameters.on_error(&error("LIMITED", MavParamError::MAV_PARAM_ERROR_READ_ONLY));
    let event = parameters.take_events().pop().unwrap();
    assert!(matches!(event.outcome, Err(ParameterError::NotTaken { why, .. }) if why == "read_only"));
    parameters.start(at(t), "NO_SUCH", None).unwrap();
    parameters.poll(at(t), (1, 1)).unwrap();
    parameters.on_error(&error("NO_SUCH", MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST));
    let event = parameters.take_events().pop().unwrap();
    assert!(matches!(event.outcome, Err(ParameterError::Unknown { .. })));
}

#[test]
fn names_and_numbers_of_operations_have_bounds_and_all_can_be_broken_off() {
    let mut parameters = Parameters::default();
    for name in ["", "SEVENTEEN_LETTERS", "with space", "ümlaut"] {
        assert!(
            matches!(
                parameters.start(at(1.0), name, None),
                Err(ParameterError::InvalidName { .. })
            ),
            "{name}"
        );
    }
    for _ in 0..QUEUE_MAX {
        parameters.start(at(1.0), "SIXTEEN_LETTERS_", None).unwrap();
    }
    assert_eq!(parameters.start(at(1.0), "ONE_MORE", None), Err(ParameterError::Busy));
    parameters.break_off("the link was lost", false);
    assert_eq!(parameters.take_events().len(), QUEUE_MAX);
    assert_eq!(parameters.poll(at(9.0), (1, 1)), None);
}

#[test]
fn nothing_is_written_to_an_armed_vehicle_also_if_it_is_armed_while_the_write_waits() {
    let id = CommandId(7);
    let value = ParameterValue::Integer(4);
    let mut parameters = Parameters::default();
    parameters.set_armed(true);
    parameters.write(at(1.0), id, "COM_RCL_EXCEPT", value);
    let event = parameters.take_events().pop().unwrap();
    assert_eq!(event.id, Some(id));
    assert!(matches!(event.outcome, Err(ParameterError::Armed { .. })));

    // Armed between the read, which says the type, and the write.
    parameters.set_armed(false);
    parameters.write(at(2.0), id, "COM_RCL_EXCEPT", value);
    assert!(matches!(
        parameters.poll(at(2.0), (1, 1)),
        Some(ParameterMessage::Read(_))
    ));
    parameters.set_armed(true);
    parameters.on_value(at(2.1), &value_message("COM_RCL_EXCEPT", ParameterValue::Integer(0)));
    assert_eq!(parameters.poll(at(2.1), (1, 1)), None);
    let event = parameters.take_events().pop().unwrap();
    assert!(matches!(event.outcome, Err(ParameterError::Armed { .. })));

    // Armed after it was sent: the echo still counts, but it is not sent again.
    parameters.set_armed(false);
    parameters.write(at(3.0), id, "COM_RCL_EXCEPT", value);
    assert!(matches!(
        parameters.poll(at(3.0), (1, 1)),
        Some(ParameterMessage::Set(_))
    ));
    parameters.set_armed(true);
    assert_eq!(parameters.poll(at(3.1), (1, 1)), None);
    parameters.on_value(at(3.2), &value_message("COM_RCL_EXCEPT", value));
    let event = parameters.take_events().pop().unwrap();
    assert_eq!(
        (event.before, event.outcome),
        (Some(ParameterValue::Integer(0)), Ok(value))
    );
}

#[test]
fn values_beyond_the_range_are_not_sent() {
    let mut store = [
        ("WHOLE", ParameterValue::Integer(0)),
        ("REAL", ParameterValue::Real(1.0)),
    ];
    let mut parameters = Parameters::default();
    for (name, number) in [("WHOLE", 3e9), ("WHOLE", 1e300), ("REAL", 1e39), ("REAL", 16_777_217.0)] {
        parameters.write(at(1.0), CommandId(1), name, ParameterValue::of_number(number));
        answer(&mut store, &mut parameters, at(1.0));
        let event = parameters.take_events().pop().unwrap();
        assert!(
            matches!(event.outcome, Err(ParameterError::OutOfRange { .. })),
            "{name} {number}: {event:?}"
        );
    }
    assert_eq!(store[0].1, ParameterValue::Integer(0));
    parameters.write(at(2.0), CommandId(1), "REAL", ParameterValue::Integer(5));
    parameters.poll(at(2.0), (1, 1)).unwrap();
    parameters.on_error(&PARAM_ERROR_DATA {
        param_id: "REAL".into(),
        error: MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
        ..PARAM_ERROR_DATA::default()
    });
    let event = parameters.take_events().pop().unwrap();
    assert!(matches!(event.outcome, Err(ParameterError::OutOfRange { .. })));
}

/// One of all, with its number.
fn numbered(name: &str, value: ParameterValue, index: u16, count: u16) -> PARAM_VALUE_DATA {
    PARAM_VALUE_DATA {
        param_index: index,
        param_count: count,
        ..value_message(name, value)
    }
}

#[test]
fn all_are_kept_with_their_types_and_what_has_changed_here_says_from_what() {
    let mut parameters = Parameters::default();
    assert_eq!(parameters.list(0).reading, ParameterReading::NotBegun);
    parameters.read_all(at(1.0), ReadingAction::Begin);
    assert!(matches!(
        parameters.poll(at(1.0), (1, 1)),
        Some(ParameterMessage::List(_))
    ));
    let (whole, real) = (ParameterValue::Integer(5), ParameterValue::Real(0.5));
    parameters.on_value(at(1.1), &numbered("_HASH_CHECK", whole, u16::MAX, 2));
    parameters.on_value(at(1.1), &numbered("A", whole, 0, 2));
    let half = parameters.list(0);
    assert_eq!(
        (half.reading, half.read, half.total),
        (ParameterReading::Reading, 1, Some(2))
    );
    parameters.on_value(at(1.2), &numbered("B", real, 1, 2));
    let list = parameters.list(0);
    assert_eq!(list.reading, ParameterReading::Complete);
    let names: Vec<_> = list
        .parameters
        .iter()
        .map(|one| (one.name.as_str(), one.value))
        .collect();
    assert_eq!(names, [("A", whole), ("B", real)]);
    assert_eq!(parameters.list(list.revision).parameters, []);
    assert!(!parameters.list(list.revision).whole);

    parameters.write(at(2.0), CommandId(1), "A", ParameterValue::Integer(6));
    parameters.poll(at(2.0), (1, 1)).unwrap();
    parameters.on_value(at(2.1), &numbered("A", ParameterValue::Integer(6), 0, 2));
    let news = parameters.list(list.revision);
    assert_eq!(news.parameters.len(), 1);
    assert_eq!(news.parameters[0].changed_from, Some(whole));
    // Back to what it was: nothing is changed any more, and that is news.
    parameters.write(at(3.0), CommandId(2), "A", whole);
    parameters.poll(at(3.0), (1, 1)).unwrap();
    parameters.on_value(at(3.1), &numbered("A", whole, 0, 2));
    assert_eq!(parameters.list(news.revision).parameters[0].changed_from, None);

    // After a restart everything that anybody has is out of date.
    parameters.break_off("the autopilot restarted", true);
    let after = parameters.list(news.revision);
    assert!(after.whole && after.parameters.is_empty());
    assert_eq!(after.reading, ParameterReading::NotBegun);
}

proptest! {
    /// Whatever names and numbers come while all are read, no more are kept than an autopilot has, and every one under its own name.
    #[test]
    fn what_is_kept_has_bounds(frames in prop::collection::vec((0_u32..6_000, any::<u16>(), any::<u16>()), 0..6_000)) {
        let mut parameters = Parameters::default();
        parameters.read_all(at(1.0), ReadingAction::Begin);
        for (name, index, count) in frames {
            parameters.on_value(at(1.0), &numbered(&format!("N{name}"), ParameterValue::Integer(name as i32), index, count));
        }
        let list = parameters.list(0);
        prop_assert!(list.parameters.len() <= usize::from(COUNT_MAX));
        prop_assert!(list.total.is_none_or(|total| total <= u32::from(COUNT_MAX)));
        for one in list.parameters {
            prop_assert_eq!(one.name, format!("N{}", one.value));
        }
    }

    /// Every integer and every finite real survives the field of a float, whatever the bits look like as a number.
    #[test]
    fn values_survive_the_wire(i: i32, r in prop::num::f32::NORMAL | prop::num::f32::ZERO) {
        for value in [ParameterValue::Integer(i), ParameterValue::Real(r)] {
            let (field, kind) = encode("X", value, Some(value), false).unwrap();
            prop_assert_eq!(decode(field, kind, false), Some(value));
        }
    }
}
