//! Values in parts come out whole or not at all.

use super::*;
use proptest::prelude::*;

proptest! {
    /// Whatever is lost, doubled or turned around: what comes out is a value that was told, and never an older one after a newer one.
    #[test]
    fn only_whole_values_come_out_and_none_turns_back(
        sizes in prop::collection::vec(0_usize..400, 1..6),
        order in prop::collection::vec(any::<prop::sample::Index>(), 1..200),
    ) {
        let values: Vec<Vec<u8>> = sizes.iter().enumerate().map(|(i, n)| vec![i as u8; *n]).collect();
        let parts: Vec<Part> = values
            .iter()
            .enumerate()
            .flat_map(|(i, value)| split(value, i as u64, 37).expect("fits"))
            .collect();
        let mut assembly = Assembly::default();
        let mut newest = None;
        for at in order {
            let part = at.get(&parts).clone();
            let revision = part.revision;
            if let Some(whole) = assembly.take(part) {
                prop_assert_eq!(&whole, &values[revision as usize]);
                prop_assert!(newest.is_none_or(|newest| newest < revision));
                newest = Some(revision);
            }
        }
    }

    #[test]
    fn strange_bytes_are_an_error(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = unpack::<Vec<(u64, String)>>(&bytes);
    }
}

#[test]
fn what_is_packed_comes_out_again_also_without_bounds() {
    let value = (vec![f64::INFINITY, -0.0, 1.5], "goose".to_owned(), Some(7_u64));
    let read: (Vec<f64>, String, Option<u64>) = unpack(&pack(&value).expect("packs")).expect("unpacks");
    assert_eq!(read, value);
}

#[test]
fn a_value_that_blows_up_when_unpacked_is_refused() {
    let value = vec![0_u64; 16 << 20];
    assert!(matches!(pack(&value), Err(PartsError::Refused { .. })));
    let mut plain = Vec::new();
    ciborium::into_writer(&value, &mut plain).expect("written");
    let packed = deflated(&plain).expect("packs");
    assert!(packed.len() < 200_000);
    assert!(unpack::<Vec<u64>>(&packed).is_err());
}

#[test]
fn too_many_parts_are_refused() {
    assert!(matches!(
        split(&[0; 1000], 1, 10),
        Err(PartsError::TooLarge { bytes: 1000 })
    ));
}
