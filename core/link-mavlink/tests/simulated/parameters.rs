//! All parameters of a simulated autopilot, over good lines and bad ones, and what is written of them.

use crate::rig::Rig;
use skein_domain::{
    AutopilotCommand, CommandId, ParameterError, ParameterEvent, ParameterReading, ParameterValue, ReadingAction,
};

const LIST: u32 = 21;
const READ: u32 = 20;
const SET: u32 = 23;

fn begin(rig: &mut Rig) {
    let now = rig.now();
    rig.core().read_parameters(now, ReadingAction::Begin).unwrap();
    rig.flush();
}

fn sent(rig: &Rig, message: u32) -> usize {
    rig.sent.iter().filter(|(_, id, _)| *id == message).count()
}

#[track_caller]
fn write(rig: &mut Rig, name: &str, value: ParameterValue) -> ParameterEvent {
    let now = rig.now();
    rig.core().write_parameter(now, CommandId(9), name, value);
    rig.flush();
    let mut found = Vec::new();
    rig.run_until("the outcome of a write", 10.0, |rig| {
        found = rig.core().parameters().take_events();
        !found.is_empty()
    });
    assert_eq!(found.len(), 1);
    found.pop().unwrap()
}

#[test]
fn all_are_read_with_one_request_over_a_good_line() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    begin(&mut rig);
    let began_s = rig.now_s;
    rig.run_until("all parameters", 20.0, |rig| {
        rig.core().parameters().list(0).reading == ParameterReading::Complete
    });
    assert!(rig.now_s - began_s < 3.0);
    assert_eq!((sent(&rig, LIST), sent(&rig, READ)), (1, 0));
    let list = rig.core().parameters().list(0);
    assert_eq!(list.total, Some(list.parameters.len() as u32));
    let value = |name: &str| list.parameters.iter().find(|one| one.name == name).map(|one| one.value);
    assert_eq!(value("COM_OF_LOSS_T"), Some(ParameterValue::Real(1.0)));
    assert_eq!(value("MAV_SYS_ID"), Some(ParameterValue::Integer(1)));
    assert!(list.parameters.is_sorted_by(|one, next| one.name < next.name));
}

#[test]
fn what_a_bad_line_lost_is_asked_for_again() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    // A third of everything is lost, both ways, in an order that repeats after a while.
    rig.passes_down = Box::new(|number, _| number.wrapping_mul(2_654_435_761) >> 16 & 0xFF >= 85);
    rig.passes_up = Box::new(|number, _| number.wrapping_mul(2_246_822_519) >> 16 & 0xFF >= 85);
    begin(&mut rig);
    rig.run_until("all parameters", 200.0, |rig| {
        match rig.core().parameters().list(0).reading {
            ParameterReading::Complete => true,
            // One that was asked for in vain ten times: what is missing is asked for again, and nothing else.
            ParameterReading::Ended { .. } => {
                begin(rig);
                false
            }
            _ => false,
        }
    });
    let list = rig.core().parameters().list(0);
    assert_eq!(list.total, Some(list.parameters.len() as u32));
    assert!(sent(&rig, READ) > 0);
}

#[test]
fn a_write_says_what_was_before_and_is_refused_once_armed() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    let event = write(&mut rig, "MPC_XY_CRUISE", ParameterValue::Integer(7));
    assert_eq!(event.id, Some(CommandId(9)));
    assert_eq!(event.before, Some(ParameterValue::Real(5.0)));
    assert_eq!(event.outcome, Ok(ParameterValue::Real(7.0)));
    let event = write(&mut rig, "COM_RC_IN_MODE", ParameterValue::Real(0.5));
    assert!(matches!(event.outcome, Err(ParameterError::WrongType { .. })));
    let event = write(&mut rig, "NO_SUCH_THING", ParameterValue::Integer(1));
    assert!(matches!(event.outcome, Err(ParameterError::NoAnswer { .. })));

    assert_eq!(rig.ask(AutopilotCommand::Arm), Ok(()));
    let before = sent(&rig, SET);
    let event = write(&mut rig, "MPC_XY_CRUISE", ParameterValue::Integer(9));
    assert!(matches!(event.outcome, Err(ParameterError::Armed { .. })));
    assert_eq!(sent(&rig, SET), before, "nothing is sent");
    assert_eq!(
        rig.core().parameters().known("MPC_XY_CRUISE"),
        Some(ParameterValue::Real(7.0))
    );
}
