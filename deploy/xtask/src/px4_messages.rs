//! `px4-messages`: which messages of the link over DDS a source tree of PX4 defines otherwise than `core/link-dds/messages` does for a release.
//! Those are written there.
//!
//! Must never do: take over anything but types, names and versions; change what is sent to PX4.

use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What is compared.
#[derive(clap::Args)]
pub struct MessagesArguments {
    /// PX4's source tree at that release.
    #[arg(value_name = "PX4_SOURCE")]
    dir: PathBuf,
    /// The release as its folder is called: `1.19`, or `later`.
    release: String,
}

/// Compares, and writes what is new.
pub fn run(workspace: &Workspace, arguments: &MessagesArguments) -> Result<ExitCode> {
    let root = workspace.root.join("core/link-dds/messages");
    let (incoming, release) = (root.join("incoming"), root.join(&arguments.release));
    // of each message the newest definition up to the release
    let mut known = BTreeMap::new();
    for folder in listed(&root)?
        .into_iter()
        .filter(|folder| *folder <= release || *folder == incoming)
    {
        let named = |path: PathBuf| Some((path.file_name()?.to_owned(), path));
        known.extend(listed(&folder)?.into_iter().filter_map(named));
    }
    for (name, ours) in &known {
        let places = ["msg/versioned", "msg"].map(|folder| arguments.dir.join(folder).join(name));
        let theirs = places.iter().find(|path| path.is_file());
        let theirs = theirs.with_context(|| format!("{} has no {}", arguments.dir.display(), name.display()))?;
        let text = reduced(&fs::read_to_string(theirs)?);
        if text != fs::read_to_string(ours)? {
            println!("{} differs from {}", theirs.display(), ours.display());
            ensure!(
                !ours.starts_with(&incoming),
                "PX4 reads it in another shape than the link sends:\n{text}"
            );
            fs::create_dir_all(&release)?;
            fs::write(release.join(name), text)?;
        }
    }
    println!("{} messages compared", known.len());
    Ok(ExitCode::SUCCESS)
}

/// What is in a folder, by name.
fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

/// Fields, and the version if it is not zero: without constants and comments.
fn reduced(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let version = line.starts_with("uint32 MESSAGE_VERSION") && !line.trim_end().ends_with(" 0");
        if !words.is_empty() && (version || !line.contains('=')) {
            out += &(words.join(" ") + "\n");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    //! What is left of a definition.

    #[test]
    fn fields_and_versions_are_left() {
        let text = "# About it.\nuint32 MESSAGE_VERSION = 2\n\nuint64 timestamp\t# [us]\nuint8 FIX=3 # a kind\nfloat32[4]  q\n# TOPICS a b\n";
        let left = "uint32 MESSAGE_VERSION = 2\nuint64 timestamp\nfloat32[4] q\n";
        assert_eq!(super::reduced(text), left);
        assert_eq!(
            super::reduced(&text.replace("= 2", "= 0")),
            "uint64 timestamp\nfloat32[4] q\n"
        );
    }
}
