//! Tests of the folder of recordings.

use super::*;

#[test]
fn a_file_tells_by_its_name_which_camera_it_is_of() {
    assert_eq!(
        camera_of("1764230000-3-front-left.mp4"),
        Some((VehicleId(3), "front-left".into()))
    );
    for name in ["notes.txt", "video.mp4", "1-two-camera.mp4"] {
        assert_eq!(camera_of(name), None, "{name}");
    }
}

#[test]
fn the_oldest_recordings_go_when_the_folder_is_full() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["100-1-camera", "200-1-camera", "300-1-camera"] {
        std::fs::write(folder.path().join(format!("{name}.mp4")), [0; 1000]).expect("written");
        std::fs::write(folder.path().join(format!("{name}.jsonl")), "{}").expect("written");
    }
    std::fs::write(folder.path().join("flight.ulg"), [0; 1000]).expect("written");
    make_room(folder.path(), 1500);
    let left = files_of(folder.path());
    assert_eq!(left, [("300-1-camera.mp4".to_owned(), 1000)]);
    assert!(folder.path().join("flight.ulg").exists() && !folder.path().join("100-1-camera.jsonl").exists());
}
