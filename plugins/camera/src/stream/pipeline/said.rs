//! What `gst-launch-1.0` prints, and what it means.
//!
//! Must never do: keep more than its last few kilobytes.

use super::PipelineFault;

/// So much of it is kept, in bytes: an error stands in its last lines, with what a developer needs behind it.
const MOST_BYTES: usize = 16 << 10;
/// The exit status of a shell that does not find a program, and of `setpriv` that does not.
const NOT_FOUND: i32 = 127;

/// What was printed last.
#[derive(Debug, Default)]
pub(super) struct Said {
    text: String,
}

impl Said {
    /// More was printed.
    pub(super) fn take(&mut self, bytes: &[u8]) {
        self.text.push_str(&String::from_utf8_lossy(bytes));
        if self.text.len() > MOST_BYTES {
            let from = self.text.ceil_char_boundary(self.text.len() - MOST_BYTES);
            self.text.drain(..from);
        }
    }

    /// Why it ended, with this exit status.
    pub(super) fn fault(&self, code: Option<i32>) -> PipelineFault {
        let lines = || self.text.lines().map(str::trim);
        if code == Some(NOT_FOUND) {
            return PipelineFault::NotInstalled(lines().next_back().unwrap_or_default().to_owned());
        }
        if let Some(reason) = lines().find_map(|line| line.strip_prefix("WARNING: erroneous pipeline: ")) {
            let element = reason.strip_prefix("no element ");
            return match element {
                Some(name) => PipelineFault::NoElement(name.trim_matches('"').to_owned()),
                None => PipelineFault::Unmade(reason.to_owned()),
            };
        }
        let Some(error) = lines().find_map(|line| line.strip_prefix("ERROR: ")) else {
            return PipelineFault::Ended;
        };
        let of_element = error
            .strip_prefix("from element ")
            .and_then(|rest| rest.split_once(": "));
        match of_element {
            Some((path, reason)) => PipelineFault::Element {
                element: path.rsplit(':').next().unwrap_or(path).to_owned(),
                reason: reason.to_owned(),
            },
            None => PipelineFault::Unmade(error.to_owned()),
        }
    }
}
