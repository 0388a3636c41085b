//! Where the lines of a step go: onto the screen as they come, or together when the step has ended, for what runs in the background.
//!
//! Must never do: lose a line, or put one step's line between two of another.

use parking_lot::Mutex;
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::Arc;

/// Takes the lines of one step after the other.
#[derive(Clone, Default)]
pub enum Output {
    /// Each at once.
    #[default]
    Live,
    /// All of a step when it has ended.
    Buffered(Arc<Mutex<String>>),
}

impl Output {
    /// Nothing is kept yet.
    pub fn buffered() -> Self {
        Self::Buffered(Arc::default())
    }

    /// A line of the program's output.
    pub fn line(&self, line: &str) {
        match self {
            Self::Live => println!("{line}"),
            Self::Buffered(_) => self.keep(line),
        }
    }

    /// A line of its error output.
    pub fn complaint(&self, line: &str) {
        match self {
            Self::Live => eprintln!("{line}"),
            Self::Buffered(_) => self.keep(line),
        }
    }

    fn keep(&self, line: &str) {
        if let Self::Buffered(kept) = self {
            // writing to a String cannot fail
            let _ = writeln!(kept.lock(), "{line}");
        }
    }

    /// The step has ended: what was kept is shown.
    pub fn end(&self) {
        if let Self::Buffered(kept) = self {
            let text = std::mem::take(&mut *kept.lock());
            if cfg!(test) {
                // it would stand among the lines of the tests, and be counted with them
                return;
            }
            // who reads it is gone, and the run goes on to its verdict
            let _ = std::io::stdout().lock().write_all(text.as_bytes());
        }
    }
}
