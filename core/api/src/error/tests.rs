//! Tests of how errors become HTTP.

use super::*;
use skein_domain::{FlightState, Incarnation, VehicleId};

/// One of each. A new reason does not compile in `refusal_status` until it has a status; here it is checked by eye.
#[allow(clippy::too_many_lines, reason = "one entry for each reason")]
fn every_refusal() -> Vec<(Refusal, u16)> {
    let vehicle = VehicleId(3);
    vec![
        (Refusal::UnknownVehicle { vehicle }, 404),
        (Refusal::LinkLost { vehicle }, 409),
        (
            Refusal::WrongState {
                state: FlightState::Idle,
                command: "land".into(),
            },
            409,
        ),
        (Refusal::PilotInControl, 409),
        (
            Refusal::NotReadyToArm {
                detail: "no fix".into(),
            },
            409,
        ),
        (
            Refusal::Autopilot {
                result: "denied".into(),
                text: String::new(),
            },
            409,
        ),
        (
            Refusal::TimedOut {
                what: "arming".into(),
                after_s: 2.0,
            },
            409,
        ),
        (Refusal::Superseded, 409),
        (
            Refusal::OutsideFence {
                detail: "height".into(),
            },
            409,
        ),
        (
            Refusal::TooFast {
                speed_m_s: 20.0,
                limit_m_s: 12.0,
            },
            409,
        ),
        (
            Refusal::TooClose {
                other: vehicle,
                distance_m: 1.0,
                limit_m: 2.0,
            },
            409,
        ),
        (
            Refusal::InvalidValue {
                detail: "spacing".into(),
            },
            409,
        ),
        (Refusal::NoSwarmFrame, 409),
        (Refusal::NoPosition, 409),
        (Refusal::NotEnoughVehicles { have: 1, need: 2 }, 409),
        (
            Refusal::StaleIncarnation {
                got: Incarnation(1),
                current: Incarnation(2),
            },
            409,
        ),
        (Refusal::DuplicateSystemId { system_id: 4 }, 409),
        (
            Refusal::NotRunning {
                what: "the coordinator".into(),
            },
            409,
        ),
        (
            Refusal::NotPermitted {
                detail: "faults".into(),
            },
            403,
        ),
        (
            Refusal::Clock {
                detail: "the start has passed".into(),
            },
            409,
        ),
    ]
}

#[test]
fn each_refusal_has_its_status_and_keeps_its_reason_and_facts() {
    for (refusal, status) in every_refusal() {
        let sentence = refusal.to_string();
        let code = refusal.code();
        let error = ApiError::from(refusal);
        assert_eq!(error.status().as_u16(), status, "{code}");
        let detail = error.detail();
        assert_eq!(detail.code, code);
        assert_eq!(detail.message, sentence);
        assert_eq!(
            detail.detail["reason"], code,
            "the code is the reason as it stands in JSON"
        );
    }
}

#[test]
fn an_error_is_one_json_object_of_known_shape() {
    let body = ErrorBody {
        error: ApiError::UnknownField {
            field: "command.bogus".into(),
        }
        .detail(),
    };
    assert_eq!(
        serde_json::to_value(body).unwrap(),
        json!({ "error": {
            "code": "unknown_field",
            "message": "unknown field `command.bogus`",
            "detail": { "field": "command.bogus" },
        } })
    );
}
