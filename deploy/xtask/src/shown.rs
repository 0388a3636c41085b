//! Where the lines of a step go: onto the screen as they come, or together when the step has ended, for what runs beside another.
//!
//! Must never do: lose a line, or put one step's line between two of another.

use parking_lot::Mutex;
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::Arc;

/// Takes the lines of one step after the other.
#[derive(Clone, Default)]
pub enum Shown {
    /// Each at once.
    #[default]
    AsTheyCome,
    /// All of a step when it has ended.
    Together(Arc<Mutex<String>>),
}

impl Shown {
    /// Nothing is kept yet.
    pub fn together() -> Self {
        Self::Together(Arc::default())
    }

    /// A line of the program's output.
    pub fn line(&self, line: &str) {
        match self {
            Self::AsTheyCome => println!("{line}"),
            Self::Together(_) => self.keep(line),
        }
    }

    /// A line of its error output.
    pub fn complaint(&self, line: &str) {
        match self {
            Self::AsTheyCome => eprintln!("{line}"),
            Self::Together(_) => self.keep(line),
        }
    }

    fn keep(&self, line: &str) {
        if let Self::Together(kept) = self {
            // writing to a String cannot fail
            let _ = writeln!(kept.lock(), "{line}");
        }
    }

    /// The step has ended: what was kept is shown.
    pub fn end(&self) {
        if let Self::Together(kept) = self {
            let text = std::mem::take(&mut *kept.lock());
            // who reads it is gone, and the run goes on to its verdict
            let _ = std::io::stdout().lock().write_all(text.as_bytes());
        }
    }
}
