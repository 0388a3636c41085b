//! What is sent where is read, and what cannot be is refused by its key.

use crate::{NodeConfig, RtpQuality};

fn refused(text: &str) -> String {
    NodeConfig::parse(text).expect_err("refused").to_string()
}

#[test]
fn a_camera_that_is_sent_is_read() {
    let text = "[[video.rtp]]\nvehicle = 3\ncamera = \"zoom\"\nto = \"[fe80::1]:5600\"\nquality = \"sub\"\n";
    let rtp = NodeConfig::parse(text).expect("parses").video.rtp;
    assert_eq!((rtp[0].vehicle, rtp[0].camera.as_str()), (3, "zoom"));
    assert_eq!(
        (rtp[0].to.to_string().as_str(), rtp[0].quality),
        ("[fe80::1]:5600", RtpQuality::Sub)
    );
}

#[test]
fn an_address_that_is_none_is_named_with_one_that_is() {
    let error = refused("[[video.rtp]]\nvehicle = 1\ncamera = \"camera\"\nto = \"192.168.1.5\"\n");
    assert!(
        error.contains("line 4") && error.contains("\"192.168.1.5\" is no address with a port"),
        "{error}"
    );
    let without = refused("[[video.rtp]]\nvehicle = 1\ncamera = \"camera\"\n");
    assert!(without.contains("missing field `to`"), "{without}");
}

#[test]
fn nobody_and_two_at_one_port_are_refused() {
    let entry = |camera: &str, to: &str| format!("[[video.rtp]]\nvehicle = 1\ncamera = \"{camera}\"\nto = \"{to}\"\n");
    let error = refused(
        &[
            entry("", "0.0.0.0:0"),
            entry("camera", "10.0.0.5:5600"),
            entry("other", "10.0.0.5:5600"),
        ]
        .concat(),
    );
    for part in [
        "video.rtp[0].camera: name the payload",
        "video.rtp[0].to: has port 0",
        "video.rtp[0].to: name one host",
        "video.rtp[2].to: is there twice",
    ] {
        assert!(error.contains(part), "{part} missing in {error}");
    }
    assert!(!error.contains("rtp[1]"), "{error}");
}
