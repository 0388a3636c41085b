//! What is encoded here is decoded there.

use super::*;

#[test]
fn errors_arrive_as_they_were() {
    let text = "why".to_owned();
    for error in [
        PluginError::Panicked { message: text.clone() },
        PluginError::Refused { detail: text.clone() },
        PluginError::NotUnderstood { detail: text.clone() },
        PluginError::Undecodable { detail: text.clone() },
        PluginError::TooLarge { len: 70, limit: 60 },
        PluginError::NotStarted { detail: text.clone() },
    ] {
        let (head, body) = encode_error(&error);
        if let PluginError::NotStarted { .. } = error {
            assert!(decode_error(head, &body).to_string().contains("why"));
        } else {
            assert_eq!(decode_error(head, &body), error);
        }
    }
    let odd = Head {
        kind: kind::FAILED,
        numbers: [99, 0, 0, 0],
    };
    assert!(matches!(decode_error(odd, b"\xff"), PluginError::Protocol { .. }));
    let (_, body) = encode_error(&PluginError::Refused {
        detail: "x".repeat(9_000),
    });
    assert_eq!(body.len(), MAX_ERROR_BYTES);
}

#[test]
fn places_and_settings_arrive_as_they_were() {
    let place = FramePlace {
        id: u64::MAX,
        offset: 1 << 40,
        len: 77,
    };
    assert_eq!(FramePlace::decode(&place.encode()), place);
    let settings = Settings {
        memory_bytes: 1,
        open_files: 2,
        max_answer_bytes: 3,
        max_snapshot_bytes: 4,
        lends_frames: true,
    };
    let bytes = minicbor::to_vec(&settings).expect("encodes");
    assert_eq!(minicbor::decode::<Settings>(&bytes).expect("decodes"), settings);
}
