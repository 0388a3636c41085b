//! Which tests failed, as `cargo test` lists them, and whether the list is whole.
//!
//! Must never do: give the names of some when others ended without a word.

#[cfg(test)]
mod tests;

/// The list at the end of each test program's output.
#[derive(Debug, Default)]
pub struct Failures {
    names: Vec<String>,
    begun: u64,
    ended: u64,
    listing: bool,
}

impl Failures {
    /// Takes one line of the output.
    pub fn read(&mut self, line: &str) {
        // The list follows its heading at once. Before it stands a heading alike, with what each test wrote.
        let entry = line.strip_prefix("    ").filter(|name| !name.contains(' '));
        match entry {
            Some(name) if self.listing => self.names.push(name.to_owned()),
            _ => self.listing = line == "failures:",
        }
        if line.starts_with("running ") && (line.ends_with(" tests") || line.ends_with(" test")) {
            self.begun += 1;
        } else if line.starts_with("test result: ") {
            self.ended += 1;
        }
    }

    /// The tests that failed; none if a program ended before it could say.
    pub fn names(&self) -> &[String] {
        if self.begun == self.ended { &self.names } else { &[] }
    }
}
