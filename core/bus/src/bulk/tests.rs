//! Something large over a network that loses, doubles and turns around.

use super::*;
use crate::envelope::Boot;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const ME: NodeId = NodeId(1);
const OTHER: NodeId = NodeId(2);
const BOOT: Boot = Boot(9);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn chunk(id: u64, index: u32, of: u32) -> Chunk {
    Chunk {
        id,
        index,
        of,
        part: vec![index as u8; 10],
    }
}

proptest! {
    #[test]
    fn it_comes_whole_once_and_unchanged(length in 0_usize..9000, seed in any::<u64>(), loss in 0.0_f64..0.5) {
        let mut chance = ChaCha8Rng::seed_from_u64(seed);
        let settings = BulkSettings::default();
        let thing: Vec<u8> = (0..length).map(|index| ((index * 7) >> 2) as u8).collect();
        let (mut sending, mut receiving) = (Sending::new(settings), Receiving::new(settings));
        let id = sending.send(at(0.0), OTHER, thing.clone(), 50).unwrap();
        let (mut there, mut back) = (Vec::new(), Vec::new());
        let (mut got, mut ended) = (Vec::new(), Vec::new());
        let mut now_s = 0.0;
        while ended.is_empty() && now_s < 200.0 {
            now_s += 0.1;
            there.extend(std::iter::from_fn(|| sending.next(at(now_s))).map(|(_, chunk)| chunk));
            prop_assert!(there.len() <= 400);
            while !there.is_empty() {
                let place = chance.random_range(0..there.len());
                let chunk: Chunk = there.swap_remove(place);
                if chance.random::<f64>() < loss { continue; }
                for _ in 0..1 + usize::from(chance.random::<f64>() < 0.2) {
                    let (have, whole) = receiving.take(at(now_s), ME, BOOT, chunk.clone());
                    got.extend(whole);
                    back.push(have);
                }
            }
            while !back.is_empty() {
                let place = chance.random_range(0..back.len());
                let have: Have = back.swap_remove(place);
                if chance.random::<f64>() >= loss { ended.extend(sending.have(at(now_s), OTHER, &have)); }
            }
        }
        prop_assert_eq!(ended, vec![(id, true)]);
        prop_assert_eq!(got, vec![thing]);
    }
}

#[test]
fn without_progress_it_is_given_up_at_both_ends() {
    let settings = BulkSettings::default();
    let (mut sending, mut receiving) = (Sending::new(settings), Receiving::new(settings));
    let id = sending.send(at(0.0), OTHER, vec![0; 1000], 100).unwrap();
    assert!(sending.expire(at(14.0)).is_empty());
    assert_eq!(sending.expire(at(15.0)), [(id, OTHER)]);
    receiving.take(at(0.0), ME, BOOT, chunk(1, 0, 2));
    receiving.expire(at(15.0));
    let (have, whole) = receiving.take(at(15.0), ME, BOOT, chunk(1, 1, 2));
    assert_eq!((have.missing, whole), (0, None), "begins anew");
}

#[test]
fn a_receiver_refuses_what_is_too_large_too_many_or_nonsense() {
    let settings = BulkSettings {
        most_bytes: 25,
        most_at_once: 2,
        ..BulkSettings::default()
    };
    let mut receiving = Receiving::new(settings);
    let mut refused = |chunk| receiving.take(at(0.0), ME, BOOT, chunk).0.refused;
    assert!(!refused(chunk(1, 0, 3)) && !refused(chunk(1, 1, 3)) && refused(chunk(1, 2, 3)));
    assert!(refused(chunk(1, 0, 3)), "and stays refused");
    assert!(!refused(chunk(2, 0, 9)) && !refused(chunk(3, 0, 9)) && refused(chunk(4, 0, 9)));
    assert!(refused(chunk(5, 0, 0)));
    assert!(
        !refused(chunk(2, u32::MAX, u32::MAX)),
        "passed over: not of the thing that began"
    );
}

#[test]
fn a_sender_refuses_what_is_too_large_or_too_many() {
    let settings = BulkSettings::default();
    let mut sending = Sending::new(settings);
    let bytes = settings.most_bytes + 1;
    let too_large = sending.send(at(0.0), OTHER, vec![0; bytes], 1000);
    assert!(matches!(too_large, Err(BulkError::TooLarge { .. })));
    for _ in 0..settings.most_at_once {
        sending.send(at(0.0), OTHER, Vec::new(), 100).unwrap();
    }
    assert!(matches!(
        sending.send(at(0.0), OTHER, Vec::new(), 100),
        Err(BulkError::TooMany { .. })
    ));
    assert!(sending.send(at(0.0), ME, Vec::new(), 100).is_ok());
}

#[test]
fn a_receiver_that_starts_again_ends_what_its_earlier_run_had_a_part_of() {
    let mut sending = Sending::new(BulkSettings::default());
    let begun = sending.send(at(0.0), OTHER, vec![0; 1000], 100).unwrap();
    sending.send(at(0.0), OTHER, vec![0; 1000], 100).unwrap();
    let have = Have {
        id: begun,
        missing: 3,
        after: 0,
        refused: false,
    };
    assert_eq!(sending.have(at(0.1), OTHER, &have), None);
    assert_eq!(sending.restarted(OTHER), [(begun, OTHER)]);
}
