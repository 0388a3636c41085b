//! Which tests failed, as `cargo test` and Playwright list them, and whether the list is whole; which never ended; which failed and then
//! passed, as Playwright lists them; whether the machine stood still meanwhile.
//!
//! Must never do: give the names of some when others ended without a word.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

/// So many lines of a panic are kept as the reason: where, and the values of an assertion.
const MOST_LINES: usize = 4;

/// The lists at the end of each test program's output.
#[derive(Debug, Default)]
pub struct Failures {
    names: Vec<String>,
    unsteady: Vec<String>,
    /// Those that the runner has told to be running, and that have not ended since.
    unended: Vec<String>,
    begun: u64,
    ended: u64,
    listing: Listing,
    stood_still: bool,
    reasons: BTreeMap<String, Vec<String>>,
    /// The test whose captured output is being read.
    reading: Option<String>,
}

/// Which list a line may belong to: the one whose heading stands right above it.
#[derive(Debug, Default)]
enum Listing {
    #[default]
    Nothing,
    Failed,
    FailedInBrowser,
    Unsteady,
}

impl Failures {
    /// Takes one line of the output.
    pub fn read(&mut self, line: &str) {
        // The list follows its heading at once. Before it stands a heading alike, with what each test wrote.
        let entry = line.strip_prefix("    ");
        match (&self.listing, entry) {
            (Listing::Failed, Some(name)) if !name.contains(' ') => self.names.push(name.to_owned()),
            // filled up with a rule to the width of the screen
            (Listing::FailedInBrowser, Some(name)) => self.names.push(name.trim_end_matches(['─', ' ']).to_owned()),
            (Listing::Unsteady, Some(name)) => self.unsteady.push(name.trim_end_matches(['─', ' ']).to_owned()),
            _ => self.listing = Listing::under(line),
        }
        self.read_slow(line);
        self.read_reason(line);
        if line.starts_with("running ") && (line.ends_with(" tests") || line.ends_with(" test")) {
            self.begun += 1;
        } else if line.starts_with("test result: ") {
            self.ended += 1;
        }
    }

    /// `cargo test` names who has been running for a minute, and later how it ended. Where one runs at a time it names each as it begins, in
    /// a line that is ended with how it ended.
    fn read_slow(&mut self, line: &str) {
        let Some(test) = line.strip_prefix("test ") else {
            return;
        };
        if let Some((name, _)) = test.split_once(" has been running for over ") {
            self.unended.push(name.to_owned());
        } else if let Some(name) = test.strip_suffix(" ... ") {
            self.unended.push(name.to_owned());
        } else if let Some((name, _)) = test.split_once(" ... ") {
            self.unended.retain(|slow| slow != name);
        }
    }

    /// What a test that failed wrote stands under its name; of that the panic is kept.
    fn read_reason(&mut self, line: &str) {
        let heading = line
            .strip_prefix("---- ")
            .and_then(|rest| rest.strip_suffix(" stdout ----"));
        if let Some(test) = heading {
            self.reading = Some(test.to_owned());
        } else if line == "failures:" || line == "stack backtrace:" || line.starts_with("note: ") {
            self.reading = None;
        } else if let Some(test) = &self.reading {
            let kept = self.reasons.entry(test.clone()).or_default();
            let begins = kept.is_empty() && line.contains(" panicked at ");
            if begins || (!kept.is_empty() && kept.len() < MOST_LINES && !line.trim().is_empty()) {
                kept.push(line.trim().to_owned());
            }
        }
    }

    /// Each test that failed, with the panic that ended it where one is known.
    pub fn told(&self) -> Vec<String> {
        let reason = |name: &String| match self.reasons.get(name) {
            Some(lines) if !lines.is_empty() => format!("{name}: {}", lines.join(" | ")),
            _ => name.clone(),
        };
        self.names.iter().map(reason).collect()
    }

    /// Takes in what another program told.
    pub fn add(&mut self, other: Self) {
        self.names.extend(other.names);
        self.reasons.extend(other.reasons);
        self.unsteady.extend(other.unsteady);
        self.unended.extend(other.unended);
        self.begun += other.begun;
        self.ended += other.ended;
        self.stood_still |= other.stood_still;
    }

    /// The tests that had not ended when the output did; where several run at a time, those that had run for more than a minute.
    pub fn unended(&self) -> Vec<String> {
        self.unended.clone()
    }

    /// The tests that failed; none if a program ended before it could say.
    pub fn names(&self) -> &[String] {
        if self.begun == self.ended { &self.names } else { &[] }
    }

    /// The machine, or just this run, was stopped for a while.
    pub fn note_standstill(&mut self) {
        self.stood_still = true;
    }

    /// Whether it was: then a test in real time that failed says nothing.
    pub fn stood_still(&self) -> bool {
        self.stood_still
    }

    /// The tests that failed and passed when the runner itself tried them again.
    pub fn unsteady(&self) -> &[String] {
        &self.unsteady
    }
}

impl Listing {
    fn under(line: &str) -> Self {
        let counted = |word: &str| line.strip_suffix(word)?.trim().parse::<u64>().ok();
        if line == "failures:" {
            Self::Failed
        } else if counted(" failed").is_some() {
            Self::FailedInBrowser
        } else if counted(" flaky").is_some() {
            Self::Unsteady
        } else {
            Self::Nothing
        }
    }
}
