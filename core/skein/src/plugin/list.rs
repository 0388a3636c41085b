//! `skein plugin list`: what a node with these directories would find.
//!
//! Must never do: hide a library that was not taken.

use clap::Args;
use serde::Serialize;
use skein_node::plugins_beside_program;
use skein_plugin_host::{Catalog, Manifest, Plugin, PluginProblem, Trust};
use std::path::PathBuf;
use std::process::ExitCode;

/// Digits of a digest that are shown to people.
const DIGEST_SHOWN: usize = 12;

/// `skein plugin list`
#[derive(Debug, Clone, Args)]
pub struct ListArguments {
    /// Directory of plugins; may be given several times [default: `plugins` beside this program].
    #[arg(long, value_name = "DIR")]
    pub plugins: Vec<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Listed<'p> {
    path: &'p std::path::Path,
    sha256: &'p str,
    #[serde(flatten)]
    manifest: &'p Manifest,
}

#[derive(Serialize)]
struct Problem {
    path: PathBuf,
    error: String,
}

#[derive(Serialize)]
struct List<'p> {
    plugins: Vec<Listed<'p>>,
    problems: Vec<Problem>,
}

pub(super) fn list(arguments: &ListArguments) -> anyhow::Result<ExitCode> {
    let directories = if arguments.plugins.is_empty() {
        vec![plugins_beside_program()]
    } else {
        arguments.plugins.clone()
    };
    let catalog = Catalog::discover(&directories, Trust::default());
    let plugins = catalog.plugins();
    if arguments.json {
        let list = List {
            plugins: plugins.iter().map(|plugin| listed(plugin)).collect(),
            problems: catalog.problems().iter().map(|problem| told(problem)).collect(),
        };
        println!("{}", serde_json::to_string_pretty(&list)?);
        return Ok(ExitCode::SUCCESS);
    }
    for plugin in &plugins {
        let Manifest {
            name,
            version,
            kind,
            description,
            ..
        } = plugin.manifest();
        let digest = plugin.sha256().get(..DIGEST_SHOWN).unwrap_or_default();
        let kind = kind.to_string();
        println!(
            "{name:<20} {version:<10} {kind:<10} {digest}  {}",
            plugin.path().display()
        );
        println!("{:<20} {description}", "");
    }
    if plugins.is_empty() {
        let places: Vec<_> = directories.iter().map(|path| path.display().to_string()).collect();
        println!("no plugins in {}", places.join(", "));
    }
    for problem in catalog.problems() {
        println!("not taken: {problem}");
    }
    Ok(ExitCode::SUCCESS)
}

fn listed(plugin: &Plugin) -> Listed<'_> {
    Listed {
        path: plugin.path(),
        sha256: plugin.sha256(),
        manifest: plugin.manifest(),
    }
}

fn told(problem: &PluginProblem) -> Problem {
    Problem {
        path: problem.path.clone(),
        error: problem.error.to_string(),
    }
}
