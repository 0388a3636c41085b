//! `skein doctor` at a node that runs, and at one that does not.

use skein_testkit::{Process, patience};
use std::path::Path;
use std::time::Duration;

/// Vehicles are found and heard within this.
const FOUND_WITHIN: Duration = Duration::from_secs(30);

async fn examine(arguments: &[&str]) -> (i32, String) {
    let mut doctor = Process::skein(&[&["doctor"], arguments].concat());
    let code = doctor.exit_code(patience()).await;
    (code, doctor.output())
}

#[tokio::test]
async fn a_node_that_runs_is_looked_at_from_outside() {
    let mut node = Process::skein(&["demo", "--manual", "--vehicles", "2"]);
    let line = node.line("Dashboard: ").await;
    let url = line.split_whitespace().nth(1).expect("an address").to_owned();
    let begun = tokio::time::Instant::now();
    let told = loop {
        let (code, told) = examine(&["--node", &url]).await;
        if code == 0 && told.contains("2 of 2 vehicles are heard") && told.contains("vehicle: uav-1 is heard") {
            break told;
        }
        assert!(begun.elapsed() < FOUND_WITHIN + patience(), "{told}");
        tokio::time::sleep(Duration::from_millis(300)).await;
    };
    assert!(
        told.contains("link: simulation") && told.contains("preflight: "),
        "{told}"
    );
    let (code, brief) = examine(&["--node", &url, "--brief"]).await;
    assert_eq!(code, 0, "{brief}");
    assert!(!brief.contains("preflight"), "{brief}");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/vehicles/pi4.params");
    let file = file.to_str().expect("is text");
    let (code, compared) = examine(&["--node", &url, "--vehicle", "1", "--parameters", file]).await;
    assert_eq!(code, 0, "a difference is no fault of the node: {compared}");
    assert!(compared.contains("COM_OBL_RC_ACT = 0, not 5"), "{compared}");
    let (code, nobody) = examine(&["--node", &url, "--vehicle", "9", "--parameters", file]).await;
    assert!(code != 0 && nobody.contains('9'), "{nobody}");
    node.signal("TERM").await;
}

#[tokio::test]
async fn a_node_that_does_not_run_is_not_well() {
    let (code, told) = examine(&["--node", "http://127.0.0.1:9", "--brief"]).await;
    assert_eq!(code, 1, "{told}");
    assert!(told.contains("does not answer") && told.contains("mend:"), "{told}");
    let (code, told) = examine(&["--node", "http://127.0.0.1:9", "--vehicle", "1"]).await;
    assert_eq!(code, 2, "a vehicle without a file: {told}");
}
