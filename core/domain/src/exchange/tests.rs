//! Round trips of the plugin exchange, and its tolerance of fields it does not know.

use super::*;

#[test]
fn batches_survive_the_boundary() {
    let batch = EventBatch {
        now: NodeTime(7),
        events: vec![
            Event::Own(OwnState {
                armed: true,
                mode: FlightMode::Offboard,
                ..OwnState::default()
            }),
            Event::Command {
                id: CommandId(3),
                command: VehicleCommand::TakeOff { height_m: 5.0 },
                not_before: NodeTime(9),
            },
            Event::Refused(Refusal::TooFast {
                speed_m_s: 12.0,
                limit_m_s: 8.0,
            }),
            Event::Command {
                id: CommandId(4),
                command: VehicleCommand::Steer,
                not_before: NodeTime(9),
            },
            Event::Stick(Stick {
                forward_m_s: 1.0,
                right_m_s: -2.0,
                up_m_s: 0.5,
                yaw_rate_rad_s: 0.25,
            }),
            Event::Tick,
        ],
    };
    let bytes = minicbor::to_vec(&batch).expect("encodes");
    assert_eq!(minicbor::decode::<EventBatch>(&bytes).expect("decodes"), batch);
}

#[test]
fn a_newer_writer_is_understood() {
    // A map of field 0 (now) with an unknown trailing field, as a newer host might send it.
    let mut bytes = Vec::new();
    minicbor::Encoder::new(&mut bytes)
        .array(3)
        .and_then(|e| e.u64(5))
        .and_then(|e| e.array(0))
        .and_then(|e| e.str("new"))
        .expect("encodes");
    let batch: EventBatch = minicbor::decode(&bytes).expect("decodes");
    assert_eq!(
        batch,
        EventBatch {
            now: NodeTime(5),
            events: vec![]
        }
    );
}
