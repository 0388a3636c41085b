//! Tests of reading: stills in order, damaged ones passed over.

use super::*;
use image::{Rgb, RgbImage};
use std::path::Path;
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(20);

/// The next picture or error, however long it takes.
fn next(reader: &mut Reader) -> Result<Picture, DecodeError> {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        match reader.take() {
            Ok(Some(picture)) => return Ok(picture),
            Ok(None) => std::thread::yield_now(),
            Err(error) => return Err(error),
        }
    }
    panic!("no picture came");
}

fn save(folder: &Path, name: &str, brightness: u8) {
    RgbImage::from_pixel(16, 8, Rgb([brightness; 3]))
        .save(folder.join(name))
        .unwrap();
}

fn brightness(picture: &Picture) -> u8 {
    assert_eq!(picture.rgb.len(), (picture.width_px * picture.height_px * 3) as usize);
    picture.rgb[0]
}

#[test]
fn stills_come_in_the_order_of_their_names_again_and_again() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "b.png", 20);
    save(folder.path(), "a.png", 10);
    save(folder.path(), "c.jpg", 30);
    std::fs::write(folder.path().join("notes.txt"), "no picture").unwrap();
    let mut reader = start(Files::Stills(folder.path().to_owned()), 0).unwrap();
    let seen: Vec<u8> = (0..7).map(|_| brightness(&next(&mut reader).unwrap())).collect();
    let near = |a: u8, b: u8| a.abs_diff(b) <= 2;
    assert!(
        seen.iter().zip([10, 20, 30, 10, 20, 30, 10]).all(|(a, b)| near(*a, b)),
        "{seen:?}"
    );
    // Another instance goes on behind what was taken.
    let mut reader = start(Files::Stills(folder.path().to_owned()), 7).unwrap();
    assert!(near(brightness(&next(&mut reader).unwrap()), 20));
}

#[test]
fn a_damaged_still_is_told_and_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "a.png", 10);
    std::fs::write(folder.path().join("b.png"), b"\x89PNG\r\n\x1a\nand no more").unwrap();
    let mut reader = start(Files::Stills(folder.path().to_owned()), 0).unwrap();
    assert_eq!(brightness(&next(&mut reader).unwrap()), 10);
    assert!(matches!(next(&mut reader), Err(DecodeError::Damaged { .. })));
    assert_eq!(brightness(&next(&mut reader).unwrap()), 10);
}

#[test]
fn a_folder_without_a_picture_is_no_source() {
    let folder = tempfile::tempdir().unwrap();
    let mut reader = start(Files::Stills(folder.path().to_owned()), 0).unwrap();
    assert!(matches!(next(&mut reader), Err(DecodeError::Empty { .. })));
    assert_eq!(next(&mut reader), Err(Ended.into()));
    std::fs::write(folder.path().join("a.jpg"), b"no picture").unwrap();
    let mut reader = start(Files::Stills(folder.path().to_owned()), 0).unwrap();
    assert!(matches!(next(&mut reader), Err(DecodeError::Damaged { .. })));
    assert_eq!(next(&mut reader), Err(Ended.into()));
}
