//! A camera whose H.264 is damaged, half told or missing: what is wrong is said in words, and with the next good pictures all is well again.

use super::{Viewer, rule, stream_of};
use serde_json::{Value, json};
use skein_config::AdoptionRule;
use skein_testkit::{LONGEST_GAP_S, Swarm, eventually, example_library, patience};
use skein_video::H264Decoder;

/// A vehicle with a camera that gives what it is told to.
async fn with_odd_camera(plugins: &std::path::Path) -> Swarm {
    let library = example_library("fixture-odd-camera", "odd_camera");
    std::fs::copy(library, plugins.join("libodd_camera.so")).unwrap();
    let directory = plugins.to_owned();
    let payload = skein_config::PayloadRule {
        name: "camera".into(),
        ..rule("odd-camera", json!({}))
    };
    Swarm::start_with(1, move |config, _| {
        config.plugins.directories.push(directory);
        config.adopt = vec![AdoptionRule {
            payloads: vec![payload],
            ..AdoptionRule::default()
        }];
    })
    .await
}

async fn gives(swarm: &Swarm, what: &str) {
    let url = format!(
        "http://{}/api/v1/vehicles/1/payloads/camera/command",
        swarm.web_address()
    );
    let request = reqwest::Client::new().post(url).json(&json!({ "gives": what }));
    let answer = request.send().await.unwrap();
    assert_eq!(answer.status(), 200, "{}", answer.text().await.unwrap());
}

/// Waits until its stream is in this state; gives the reason.
async fn comes_to(swarm: &Swarm, state: &str, what: &str) -> String {
    eventually(patience(), what, async || {
        let stream = stream_of(swarm).await;
        (stream["state"] == state).then(|| stream["reason"].as_str().unwrap_or_default().to_owned())
    })
    .await
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_a_camera_gives_is_said_in_words_and_the_next_good_pictures_are_shown() {
    let plugins = tempfile::tempdir().unwrap();
    let swarm = with_odd_camera(plugins.path()).await;
    comes_to(&swarm, "no_pictures", "a camera that gives nothing").await;
    // Nobody who looks is refused before there is a picture.
    let mut viewer = Viewer::open(&swarm, "way=h264").await;
    let mut decoder = H264Decoder::new().unwrap();
    for (what, state, words) in [
        ("no_key_pictures", "no_key_picture", ""),
        ("pictures", "live", ""),
        ("noise", "failed", "picture"),
        ("larger_pictures", "live", ""),
        ("no_slice", "failed", "no slice"),
        ("pictures", "live", ""),
        ("bad_parameter_sets", "failed", "parameter set"),
        ("larger_pictures", "live", ""),
        ("huge", "failed", "5242880 bytes"),
        ("pictures", "live", ""),
        ("nothing", "stalled", ""),
        ("pictures", "live", ""),
    ] {
        gives(&swarm, what).await;
        let reason = comes_to(&swarm, state, what).await;
        assert!(reason.contains(words), "{what}: {reason}");
        if state == "live" {
            let size_px = if what == "pictures" { (320, 240) } else { (480, 360) };
            shows(&mut viewer, &mut decoder, size_px).await;
        }
    }
    // Halves of pictures pass: what is in a slice only a decoder knows. A decoder gets over it with the next key picture.
    gives(&swarm, "halves").await;
    for _ in 0..20 {
        let _ = decoder.decode(&viewer.picture().await.bytes);
    }
    gives(&swarm, "pictures").await;
    shows(&mut viewer, &mut decoder, (320, 240)).await;

    let health: Value = stream_of(&swarm).await;
    assert_eq!((&health["width_px"], &health["height_px"]), (&json!(320), &json!(240)));
    for vehicle in &swarm.truth_now().await.vehicles {
        let gap_s = vehicle.offboard_gap_sender_max_s;
        assert!(gap_s < LONGEST_GAP_S, "{gap_s:.3} s without a setpoint");
    }
    swarm.stop().await;
}

/// Waits until the viewer has decoded a picture of this size.
async fn shows(viewer: &mut Viewer, decoder: &mut H264Decoder, size_px: (u16, u16)) {
    let shown = async {
        loop {
            let picture = viewer.picture().await;
            let decoded = decoder.decode(&picture.bytes);
            if picture.size_px == size_px && matches!(decoded, Ok(Some(_))) {
                return;
            }
        }
    };
    let shown = tokio::time::timeout(patience(), shown).await;
    shown.unwrap_or_else(|_| panic!("no picture of {size_px:?} is shown"));
}
