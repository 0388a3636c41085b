//! Which routes are a vehicle's own.

use super::*;

#[test]
fn only_routes_below_a_vehicle_are_its_own() {
    assert_eq!(vehicle_of("/api/v1/vehicles/12/payloads"), Some(VehicleId(12)));
    assert_eq!(
        vehicle_of("/api/v1/vehicles/12/payloads/camera/frame"),
        Some(VehicleId(12))
    );
    for other in [
        "/api/v1/vehicles/12",
        "/api/v1/vehicles/12/",
        "/api/v1/vehicles",
        "/api/v1/vehicles/x/y",
        "/",
    ] {
        assert_eq!(vehicle_of(other), None, "{other}");
    }
}
