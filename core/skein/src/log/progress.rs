//! How far long work is, in one line of a terminal.
//!
//! Must never do: write where nobody looks: into a file or another program.

use std::io::{IsTerminal, Write};

pub struct Bar {
    what: &'static str,
    /// The last percentage told; none where nobody looks.
    told: Option<u8>,
}

impl Bar {
    pub fn new(what: &'static str) -> Self {
        let looks = std::io::stderr().is_terminal();
        Self {
            what,
            told: looks.then_some(0),
        }
    }

    pub fn at(&mut self, share: f64) {
        let percent = (share.clamp(0.0, 1.0) * 100.0) as u8;
        if self.told.is_some_and(|told| told < percent) {
            self.told = Some(percent);
            let mut terminal = std::io::stderr();
            let _ = write!(terminal, "\r{} {percent} %", self.what).and_then(|()| terminal.flush());
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if self.told.is_some_and(|told| told > 0) {
            eprint!("\r\x1b[K");
        }
    }
}
