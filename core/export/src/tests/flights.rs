//! Every flight that is kept in `tests/flights` comes to the same decisions with this program: real autopilots, on whose flights it is not to
//! decide otherwise unseen.

use skein_recording::Recording;
use std::path::Path;

#[test]
fn kept_flights_are_decided_as_they_were() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/flights");
    let files = std::fs::read_dir(&folder)
        .expect("the folder")
        .map(|entry| entry.expect("an entry").path());
    let files: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|is| is == "mcap"))
        .collect();
    assert!(!files.is_empty(), "no flight is kept in {}", folder.display());
    for path in files {
        let recording = Recording::open(&path).expect("opens");
        let again = crate::redecide(&recording, &mut |_| {}).expect("is of one node");
        let decided = again.decided;
        assert_eq!(again.damage, [], "{}", path.display());
        assert_eq!(
            decided.differences,
            [],
            "{}: this program decides otherwise; if that is wanted, make the file anew (tests/README.md)",
            path.display()
        );
        assert!(
            decided.setpoints + decided.failsafe + decided.formations > 0,
            "{}",
            path.display()
        );
        assert_eq!((decided.thinned, decided.without_inputs), (0, 0), "{}", path.display());
    }
}
