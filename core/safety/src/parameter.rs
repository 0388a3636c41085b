//! Whether a parameter of an autopilot may be written now.
//!
//! Must never do: let one through to a vehicle that is armed, or about to be: a gain that is changed in flight can bring it down.

use skein_domain::{FlightState, LandedState, ParameterError, Telemetry};

/// Whether `name` may be written to a vehicle that says this of itself, and whose model has it in this state.
///
/// # Errors
/// When it is armed, or is being armed.
pub fn may_write(name: &str, telemetry: &Telemetry, state: FlightState) -> Result<(), ParameterError> {
    // Disarmed in the air: what it says of itself cannot be right.
    let flies = matches!(
        telemetry.landed,
        LandedState::InAir | LandedState::TakingOff | LandedState::Landing
    );
    if telemetry.armed || flies || matches!(state, FlightState::Arming | FlightState::TakingOff) {
        return Err(ParameterError::Armed { name: name.to_owned() });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    //! Every state in which it may not be.

    use super::*;

    #[test]
    fn only_a_disarmed_vehicle_on_the_ground_is_written_to() {
        let standing = Telemetry {
            landed: LandedState::OnGround,
            ..Telemetry::default()
        };
        assert_eq!(may_write("A", &standing, FlightState::Idle), Ok(()));
        assert_eq!(may_write("A", &standing, FlightState::Faulted), Ok(()));
        let armed = Telemetry {
            armed: true,
            ..standing
        };
        let flying = Telemetry {
            landed: LandedState::InAir,
            ..standing
        };
        for (telemetry, state) in [
            (armed, FlightState::Idle),
            (flying, FlightState::Idle),
            (standing, FlightState::Arming),
            (standing, FlightState::TakingOff),
        ] {
            let refused = may_write("A", &telemetry, state);
            assert_eq!(
                refused,
                Err(ParameterError::Armed { name: "A".into() }),
                "{telemetry:?}"
            );
        }
    }
}
