//! Counts of tests, read from what the runners print.
//!
//! Must never do: count a line that is not a runner's own summary.

#[cfg(test)]
mod tests;

use std::fmt;
use std::ops::AddAssign;

/// How many tests passed, failed and were skipped.
///
/// Shown, those that are unsteady stand among those that passed: who reads the closing line learns of them from the line above it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Passed.
    pub passed: u64,
    /// Failed.
    pub failed: u64,
    /// Ignored, skipped, not run.
    pub skipped: u64,
    /// Failed, and passed when tried again.
    pub unsteady: u64,
}

/// Whose summary lines to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Runner {
    /// `cargo test`.
    CargoTest,
    /// vitest.
    Vitest,
    /// Playwright.
    Playwright,
}

impl Tally {
    /// How many ran.
    pub fn ran(self) -> u64 {
        self.passed + self.failed + self.unsteady
    }

    /// All that failed, so many, passed when they were tried again.
    pub fn passed_again(&mut self, count: u64) {
        self.failed = self.failed.saturating_sub(count);
        self.unsteady += count;
    }

    /// Adds what one line of a runner's output says; other lines add nothing.
    pub fn read(&mut self, runner: Runner, line: &str) {
        let line = plain(line);
        let line = line.trim();
        match runner {
            Runner::CargoTest => {
                if let Some(counts) = line.strip_prefix("test result: ")
                    && let Some((_, counts)) = counts.split_once(". ")
                {
                    counts.split(';').for_each(|part| self.count(part));
                }
            }
            Runner::Vitest => {
                if let Some(counts) = line.strip_prefix("Tests ") {
                    counts.split('|').for_each(|part| self.count(part));
                }
            }
            Runner::Playwright => self.count_alone(line),
        }
    }

    /// `3 passed`, perhaps with something in brackets behind it, and nothing else on the line.
    fn count_alone(&mut self, line: &str) {
        let mut words = line.split_whitespace();
        let known = matches!(words.next().map(str::parse::<u64>), Some(Ok(_)))
            && matches!(
                words.next(),
                Some("passed" | "failed" | "skipped" | "flaky" | "interrupted" | "did")
            )
            && words.next().is_none_or(|word| word.starts_with('(') || word == "not");
        if known {
            self.count(line);
        }
    }

    fn count(&mut self, part: &str) {
        let mut words = part.split_whitespace();
        let (Some(Ok(number)), Some(word)) = (words.next().map(str::parse::<u64>), words.next()) else {
            return;
        };
        match word {
            "passed" => self.passed += number,
            "failed" | "interrupted" => self.failed += number,
            "flaky" => self.unsteady += number,
            "ignored" | "skipped" | "todo" | "did" => self.skipped += number,
            _ => {}
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
        self.unsteady += other.unsteady;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} passed, {} failed, {} skipped",
            self.passed + self.unsteady,
            self.failed,
            self.skipped
        )
    }
}

/// The line without its colour sequences (`ESC [ … letter`).
fn plain(line: &str) -> String {
    let mut text = String::with_capacity(line.len());
    let mut characters = line.chars();
    while let Some(character) = characters.next() {
        if character == '\u{1b}' {
            characters.by_ref().find(|c| c.is_ascii_alphabetic());
        } else {
            text.push(character);
        }
    }
    text
}
