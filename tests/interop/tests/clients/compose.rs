//! check-jsonschema as an independent judge of the compose files: it holds each against the schema of the Compose Specification that it carries.

use anyhow::{Context, Result, ensure};
use skein_tests_interop::{Environment, python_of};
use std::path::{Path, PathBuf};
use std::process::Command;

const JUDGE: Environment = Environment {
    name: "compose",
    requirements: &["check-jsonschema==0.39.0"],
    modules: "check_jsonschema",
};

/// Whether it finds nothing, and its words.
fn judged(python: &Path, files: &[PathBuf]) -> Result<(bool, String)> {
    let mut judge = Command::new(python.with_file_name("check-jsonschema"));
    let said = judge
        .args(["--builtin-schema", "vendor.compose-spec"])
        .args(files)
        .output()
        .context("check-jsonschema runs")?;
    Ok((
        said.status.success(),
        String::from_utf8_lossy(&said.stdout).into_owned(),
    ))
}

#[test]
fn the_compose_files_are_what_the_compose_specification_says() -> Result<()> {
    let python = python_of(&JUDGE)?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../deploy/compose");
    let entries = std::fs::read_dir(&folder).context("deploy/compose")?;
    let files: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    ensure!(files.len() >= 6, "{files:?}");
    let (right, said) = judged(&python, &files)?;
    ensure!(right, "{said}");

    // It would have noticed.
    let text = std::fs::read_to_string(folder.join("demo.yml"))?;
    let folder = tempfile::tempdir()?;
    let misspelt = folder.path().join("misspelt.yml");
    std::fs::write(&misspelt, text.replacen("command:", "comand:", 1))?;
    let (right, said) = judged(&python, &[misspelt])?;
    ensure!(!right && said.contains("comand"), "{said}");
    Ok(())
}
