//! Live video in an air that loses 2 % of all datagrams and delays the rest by 50 ms: the picture does not freeze, neither at the ground station,
//! which has it over the swarm's bus, nor in a browser beside it that speaks WebRTC with the vehicle's node over the air itself.

use skein_sim::stalls::StallProbe;
use skein_testkit::{Peer, patience};
use skein_tests_multihost::field::{Field, GROUND, usual};
use skein_tests_multihost::mission::Mission;
use skein_tests_multihost::relay::Quality;
use std::fmt;
use std::net::{IpAddr, Ipv4Addr};
use std::time::{Duration, Instant};

const TOGETHER_S: f64 = 30.0;
const ALL: [u8; 6] = [1, 2, 3, 4, 5, 6];
const COORDINATOR: u8 = 2;
/// The vehicle that carries a camera.
const OBSERVER: u8 = 4;
const LOSSY_AIR: Quality = Quality {
    loss: 0.02,
    delay_s: 0.05,
    // Zenoh leaves out what was overtaken.
    jitter_s: 0.0,
    doubled: 0.0,
    overtaken: 0.0,
};
/// A way that has become longer is taken for a full one at first, and less is sent; until then, in seconds.
const LONGER_WAY_KNOWN_S: f64 = 20.0;
const WATCHED: Duration = Duration::from_secs(60);
/// A picture that stands still for longer is frozen, in seconds.
const FREEZE_S: f64 = 0.5;
const RATE_HZ: f64 = 30.0;
/// So many of the pictures come. Each freeze costs some, and so does a link that carries only every other one.
const SHARE: f64 = 0.9;

#[tokio::test(flavor = "multi_thread")]
async fn video_goes_on_where_datagrams_are_lost_and_late() {
    let mut plans = usual();
    plans[usize::from(OBSERVER) - 1].camera = true;
    let mut field = Field::start(31, plans);
    field.led_by(COORDINATOR, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    field.air().everywhere(LOSSY_AIR);
    field.pass(LONGER_WAY_KNOWN_S).await;

    let (ground, observer) = (
        field.host(GROUND).namespace().clone(),
        field.host(OBSERVER).namespace().clone(),
    );
    let straight = tokio::task::spawn_blocking(move || {
        ground.within(|| {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let runtime = runtime.expect("a runtime in the ground station's network");
            runtime.block_on(watch(ground.air, observer.air))
        })
    });
    let manage = field.host(GROUND).namespace().manage;
    let [a, b, c, _] = manage.octets();
    let over_the_bus = watch(Ipv4Addr::new(a, b, c, 1), manage).await;
    let straight = straight.await.expect("it is watched to the end");
    println!("over the swarm's bus: {over_the_bus}");
    println!("WebRTC over the air:  {straight}");

    Mission::new(&mut field, GROUND).in_bad_air().land().await;
    field.end("video in a lossy air", &[]).await;
    for seen in [over_the_bus, straight] {
        assert!(seen.longest_s <= FREEZE_S, "frozen: {seen}");
        let least = SHARE * RATE_HZ * WATCHED.as_secs_f64();
        assert!(f64::from(seen.pictures) >= least, "too few: {seen}");
    }
}

/// What somebody saw.
struct Seen {
    pictures: u32,
    /// The longest time without a picture, less that in which this machine stood still.
    longest_s: f64,
    /// How often the picture was frozen.
    freezes: u32,
}

impl fmt::Display for Seen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate_hz = f64::from(self.pictures) / WATCHED.as_secs_f64();
        let (longest_s, freezes) = (self.longest_s, self.freezes);
        write!(
            f,
            "{rate_hz:.1} pictures a second, longest time without one {longest_s:.2} s, frozen {freezes} times"
        )
    }
}

/// Looks at the camera by way of a node, as a browser with this address does.
async fn watch(own: Ipv4Addr, node: Ipv4Addr) -> Seen {
    let probe = StallProbe::start().expect("a thread");
    let mut peer = Peer::at(IpAddr::V4(own)).await;
    let url = format!("http://{node}:8080/api/v1/vehicles/{OBSERVER}/payloads/camera/video/whep");
    let request = reqwest::Client::new().post(url).timeout(patience());
    let request = request.header("content-type", "application/sdp").body(peer.offer());
    let answer = request.send().await.expect("the node answers");
    assert_eq!(answer.status(), 201);
    peer.accept(&answer.text().await.expect("an answer"));
    peer.picture().await;
    let begun = Instant::now();
    let (mut last, mut pictures, mut longest, mut freezes) = (begun, 0, Duration::ZERO, 0);
    while begun.elapsed() < WATCHED {
        peer.picture().await;
        let now = Instant::now();
        let stood_still = probe.until(now).saturating_sub(probe.until(last));
        let without = (now - last).saturating_sub(stood_still);
        longest = longest.max(without);
        freezes += u32::from(without.as_secs_f64() > FREEZE_S);
        (last, pictures) = (now, pictures + 1);
    }
    Seen {
        pictures,
        longest_s: longest.as_secs_f64(),
        freezes,
    }
}
