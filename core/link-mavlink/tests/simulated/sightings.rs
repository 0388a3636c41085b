//! Movers of the simulation, heard through real sockets beside its vehicles.

use crate::net::Net;
use skein_domain::PositionNed;
use skein_link_mavlink::Sightings;
use skein_sim::{Mover, PortPlan, Report, SimSettings, Simulation};
use std::sync::Arc;

#[tokio::test]
async fn movers_are_sighted_and_vehicles_are_not() {
    let mut net = Net::new();
    let sightings = Arc::new(Sightings::new());
    net.references = Some(sightings.clone());
    let (_endpoint, address) = net.listen("px4").await;
    let east = |speed_m_s: f64, report: Report| Mover {
        report,
        path: vec![
            PositionNed::new(100.0, -50.0, -3.0),
            PositionNed::new(100.0, 5_000.0, -3.0),
        ],
        speed_m_s,
        rate_hz: 20.0,
        ..Mover::default()
    };
    let aircraft = Report::Adsb {
        address: 0x004C_A123,
        receiver_system_id: 250,
    };
    let simulation = Simulation::start(SimSettings {
        vehicles: 1,
        ports: PortPlan::SendTo(address),
        movers: vec![
            east(3.0, Report::FollowTarget { system_id: 42 }),
            east(40.0, aircraft),
            east(8.0, Report::Position { system_id: 77 }),
        ],
        ..SimSettings::default()
    })
    .unwrap();
    net.discovered(1).await;
    for (source, speed_m_s) in [("mavlink:42", 3.0), ("adsb:4CA123", 40.0), ("mavlink:77", 8.0)] {
        net.until(source, |_| sightings.of(source).is_some()).await;
        let seen = sightings.of(source).unwrap();
        let velocity = seen.velocity.unwrap();
        assert!(
            (velocity.east_m_s - speed_m_s).abs() < 0.02 && velocity.north_m_s.abs() < 0.02,
            "{seen:?}"
        );
        assert!((seen.heading_rad.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
        let truth = simulation.truth();
        let real = truth.movers.iter().find(|mover| mover.source == source).unwrap();
        let frame = skein_domain::SwarmFrame::new(SimSettings::default().origin);
        let place = frame.position(&seen.place);
        // Heard a little earlier or later than the truth was published.
        let apart_m = place.distance_m(&real.position);
        assert!(apart_m < 1.0 + speed_m_s, "{apart_m} m, {seen:?}");
        assert!((place.north_m - 100.0).abs() < 0.5 && (place.down_m + 3.0).abs() < 0.1);
    }
    assert_eq!(sightings.of("mavlink:1"), None, "the vehicle is one of ours");
}
