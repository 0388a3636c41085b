//! Addresses as text: every form there and back, and what is refused.

use super::*;

#[test]
fn every_form_survives_being_written_and_read() {
    for text in [
        "udp-listen://127.0.0.1:14540",
        "udp-listen://[::1]:0",
        "udp-connect://192.168.4.1:14550",
        "tcp://sitl.local:5760",
        "tcp://[::1]:5760",
        "serial:///dev/ttyACM0?baud=921600",
    ] {
        let address: EndpointAddress = text.parse().unwrap();
        assert_eq!(address.to_string(), text);
    }
    let address: EndpointAddress = "serial:///dev/ttyUSB0".parse().unwrap();
    assert_eq!(
        address,
        EndpointAddress::Serial {
            path: "/dev/ttyUSB0".into(),
            baud: DEFAULT_BAUD
        }
    );
}

#[test]
fn what_cannot_be_meant_is_refused_with_the_text_in_the_message() {
    for text in [
        "",
        "127.0.0.1:14540",
        "udp://127.0.0.1:14540",
        "udp-listen://localhost:14540",
        "udp-connect://127.0.0.1:0",
        "tcp://:5760",
        "tcp://host",
        "tcp://host:0",
        "tcp://host:99999",
        "serial://",
        "serial:///dev/ttyACM0?baud=fast",
        "serial:///dev/ttyACM0?baud=0",
        "serial:///dev/ttyACM0?parity=even",
    ] {
        let error = text.parse::<EndpointAddress>().unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
}
