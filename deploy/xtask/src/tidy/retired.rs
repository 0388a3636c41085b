//! Words of our own that were given up for the field's term: they do not come back.
//!
//! Must never do: forbid a word that means something else somewhere; only whole names of types are looked at.

use super::{File, Finding};

/// What was given up, and what it is called now.
const RETIRED: [(&str, &str); 22] = [
    (concat!("Bo", "ard"), "SharedState"),
    (concat!("Vehicle", "Cell"), "VehicleRecord"),
    (concat!("Payload", "Cell"), "PayloadRecord"),
    (concat!("Life", "Record"), "PluginRecord"),
    (concat!("Life", "Identity"), "PluginIdentity"),
    (concat!("Pu", "lse"), "ControlLoop"),
    (concat!("Be", "at"), "ControlTick"),
    (concat!("De", "sk"), "OperatorState"),
    (concat!("Let", "ter"), "NodeMessage"),
    (concat!("Off", "ice"), "Leadership"),
    (concat!("Alle", "giance"), "LeaderState"),
    (concat!("Be", "reaved"), "LostLeader"),
    (concat!("Lad", "der"), "FailsafePolicy"),
    (concat!("Lad", "derSettings"), "FailsafeSettings"),
    (concat!("Lad", "derEvent"), "FailsafeEvent"),
    (concat!("Lad", "derState"), "FailsafeState"),
    (concat!("In", "Other", "Hands"), "NoControlAuthority"),
    (concat!("Lane", "Shared"), "WorkerShared"),
    (concat!("Instance", "Body"), "HostedInstance"),
    (concat!("Her", "ald"), "Announcer"),
    (concat!("Eth", "er"), "RadioChannel"),
    (concat!("Se", "al"), "SecureEnvelope"),
];

/// Names that were given up, in one file of Rust.
pub fn check(file: &File) -> Vec<Finding> {
    if !file.is("rs") {
        return Vec::new();
    }
    let lines = file.text.lines().enumerate();
    let found = lines.flat_map(|(index, line)| {
        let words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        words.filter_map(move |word| {
            let (_, now) = RETIRED.iter().find(|(retired, _)| *retired == word)?;
            Some((index + 1, word, *now))
        })
    });
    let finding =
        |(line, word, now): (usize, &str, &str)| file.finding(line, "retired", format!("`{word}` is called {now}"));
    found.map(finding).collect()
}
