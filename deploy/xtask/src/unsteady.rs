//! What was unsteady in earlier runs of this user, whatever checkout they ran in: a line for each time, in a file of the user's cache.
//!
//! Must never do: fail a run because the file cannot be read or written.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// What is older is no longer counted: the test, or the program, is another one by then.
const COUNTED_S: u64 = 30 * 24 * 3600;

/// The file. Its lines are the time in seconds since 1970, the commit, the tier and the test, with tabs between.
pub struct History {
    file: PathBuf,
}

impl History {
    /// That of this user: `unsteady.tsv` in `skein-ci` of the cache folder. None where the user has no home.
    pub fn of_this_user() -> Option<Self> {
        let cache = std::env::var_os("XDG_CACHE_HOME").map(PathBuf::from);
        let cache = cache.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache")))?;
        Some(Self::in_file(cache.join("skein-ci/unsteady.tsv")))
    }

    /// The one in this file, which need not be there.
    pub fn in_file(file: PathBuf) -> Self {
        Self { file }
    }

    /// Where it is.
    pub fn file(&self) -> &std::path::Path {
        &self.file
    }

    /// Notes tests (tier and name) that were unsteady in a run of this commit.
    pub fn add(&self, commit: &str, tests: &[(&str, &str)]) {
        let when_s = now_s();
        let mut lines = String::new();
        for (tier, test) in tests {
            // writing to a String cannot fail
            let _ = writeln!(lines, "{when_s}\t{commit}\t{tier}\t{test}");
        }
        let written = self.append(&lines);
        if let Err(error) = written {
            println!("-- unsteady tests are not noted: {}: {error}", self.file.display());
        }
    }

    fn append(&self, lines: &str) -> std::io::Result<()> {
        if let Some(folder) = self.file.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let mut file = std::fs::File::options().create(true).append(true).open(&self.file)?;
        file.write_all(lines.as_bytes())
    }

    /// Tests that were unsteady in more than one run of the last thirty days, with how often; `tier: test`.
    pub fn repeated(&self) -> Vec<(String, usize)> {
        let text = std::fs::read_to_string(&self.file).unwrap_or_default();
        let oldest_s = now_s().saturating_sub(COUNTED_S);
        let mut times: BTreeMap<String, usize> = BTreeMap::new();
        for line in text.lines() {
            let mut parts = line.split('\t');
            let when_s = parts.next().and_then(|when| when.parse::<u64>().ok());
            if let (Some(when_s), Some(_), Some(tier), Some(test)) = (when_s, parts.next(), parts.next(), parts.next())
                && when_s >= oldest_s
            {
                *times.entry(format!("{tier}: {test}")).or_default() += 1;
            }
        }
        times.into_iter().filter(|(_, times)| *times > 1).collect()
    }
}

fn now_s() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map(|since| since.as_secs()).unwrap_or_default()
}
