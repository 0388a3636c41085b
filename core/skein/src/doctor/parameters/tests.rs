//! Files of parameters: those that are shipped, those that are none; and what a difference is.

use super::{Wanted, compare, of_line, read};
use crate::doctor::Findings;
use serde_json::json;
use std::path::Path;

#[test]
fn every_shipped_file_is_read_and_names_each_parameter_once() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/vehicles");
    let mut files = 0;
    for entry in std::fs::read_dir(folder).expect("deploy/vehicles").flatten() {
        if entry.path().extension().is_some_and(|end| end == "params") {
            let wanted = read(&entry.path()).expect("is right");
            let mut names: Vec<_> = wanted.iter().map(|wanted| &wanted.name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), wanted.len(), "{:?}", entry.path());
            assert!(
                wanted.iter().all(|wanted| wanted.name.len() <= 16),
                "{:?}",
                entry.path()
            );
            files += 1;
        }
    }
    assert!(files >= 2);
}

#[test]
fn a_line_that_is_none_is_refused() {
    assert_eq!(
        of_line("1\t1\tCOM_OF_LOSS_T\t1.0\t9").expect("is right"),
        Wanted {
            name: "COM_OF_LOSS_T".to_owned(),
            value: 1.0
        }
    );
    for line in [
        "COM_OF_LOSS_T 1.0",
        "1\t1\tCOM_OF_LOSS_T\tone\t9",
        "1\t1\tCOM_OBL_RC_ACT\t5.5\t6",
        "1\t1\tCOM_OBL_RC_ACT\t5\t2",
        "1\t1\tCOM_OF_LOSS_T\tNaN\t9",
    ] {
        assert!(of_line(line).is_err(), "{line}");
    }
}

#[test]
fn a_difference_is_told_with_both_values() {
    let wanted = |name: &str, value| Wanted {
        name: name.to_owned(),
        value,
    };
    let known = [
        json!({ "name": "COM_OBL_RC_ACT", "value": { "type": "integer", "value": 0 } }),
        json!({ "name": "COM_OF_LOSS_T", "value": { "type": "real", "value": 1.000_000_1 } }),
    ];
    let all = [
        wanted("COM_OBL_RC_ACT", 5.0),
        wanted("COM_OF_LOSS_T", 1.0),
        wanted("OF_ANOTHER_RELEASE", 3.0),
    ];
    let mut findings = Findings::default();
    compare(7, &all, &known, &mut findings);
    let told = findings.lines.join("\n");
    assert!(told.contains("COM_OBL_RC_ACT = 0, not 5"), "{told}");
    assert!(told.contains("1 of vehicle 7"), "{told}");
    assert!(!told.contains("OF_ANOTHER"), "{told}");
}
