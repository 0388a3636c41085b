//! `skein plugin new`: writes a crate of its own, from the templates in `plugins/template`, with the names exchanged.
//!
//! Must never do: write over anything that is there.

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where the SDK is taken from when its source tree is not on this machine.
const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");
/// The longest name a manifest may have.
const MAX_NAME: usize = 64;
/// Names that cargo or the crates of the plugin itself have taken.
const TAKEN: [&str; 12] = [
    "alloc",
    "core",
    "deps",
    "generic-uav",
    "minicbor",
    "proc-macro",
    "schemars",
    "serde",
    "skein-plugin-sdk",
    "std",
    "test",
    "examples",
];

/// `skein plugin new`
#[derive(Debug, Clone, Args)]
pub struct NewArguments {
    /// Its name, by which configurations choose it: lower-case letters, digits and hyphens.
    pub name: String,
    /// What it is.
    #[arg(long, value_enum, default_value_t = Kind::Gimbal)]
    pub kind: Kind,
    /// Directory to make [default: the name].
    #[arg(long, value_name = "DIR")]
    pub path: Option<PathBuf>,
    /// Source tree of this program, for the SDK [default: the one this program was built from, or the public repository].
    #[arg(long, value_name = "PATH")]
    pub sdk: Option<PathBuf>,
}

/// What a plugin can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// A payload that points something.
    Gimbal,
    /// A payload that takes pictures or video.
    Camera,
    /// A payload that carries data.
    Radio,
    /// A payload that finds things in frames.
    Detector,
    /// Flies a vehicle.
    UavModel,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Gimbal => "gimbal",
            Self::Camera => "camera",
            Self::Radio => "radio",
            Self::Detector => "detector",
            Self::UavModel => "UAV model",
        }
    }
}

/// The files of a template: where each goes and what is in it.
type Files = &'static [(&'static str, &'static str)];

const PAYLOAD: Files = &[
    ("src/lib.rs", include_str!("../../../../plugins/template/src/lib.rs")),
    (
        "src/device.rs",
        include_str!("../../../../plugins/template/src/device.rs"),
    ),
    (
        "src/tests.rs",
        include_str!("../../../../plugins/template/src/tests.rs"),
    ),
];

const UAV_MODEL: Files = &[
    (
        "src/lib.rs",
        include_str!("../../../../plugins/template/uav-model/src/lib.rs"),
    ),
    (
        "src/tests.rs",
        include_str!("../../../../plugins/template/uav-model/src/tests.rs"),
    ),
];

pub(super) fn new(arguments: &NewArguments) -> anyhow::Result<ExitCode> {
    let NewArguments { name, kind, .. } = arguments;
    check_name(name)?;
    let sdk = Sdk::find(arguments.sdk.as_deref())?;
    let folder = arguments.path.clone().unwrap_or_else(|| PathBuf::from(name));
    let is_empty = |folder: &Path| folder.read_dir().is_ok_and(|mut entries| entries.next().is_none());
    ensure!(
        !folder.exists() || is_empty(&folder),
        "{} is there already; choose another directory with --path",
        folder.display()
    );
    write(&folder, "Cargo.toml", &cargo_toml(name, *kind, &sdk))?;
    write(&folder, "README.md", &readme(name, *kind))?;
    write(&folder, ".gitignore", "/target\n")?;
    let files = if *kind == Kind::UavModel { UAV_MODEL } else { PAYLOAD };
    for (path, text) in files {
        write(&folder, path, &named(text, name, *kind))?;
    }
    if let Some(lock) = sdk.lock() {
        // The versions that this program was tested with.
        write(&folder, "Cargo.lock", &lock)?;
    }
    println!("{name}: a {} plugin in {}", kind.word(), folder.display());
    println!("  cd {}", folder.display());
    println!("  cargo test");
    println!("  cargo build");
    println!("  skein plugin check target/debug/{}", library(name));
    Ok(ExitCode::SUCCESS)
}

/// The file that cargo makes of it.
fn library(name: &str) -> String {
    format!("lib{}.so", name.replace('-', "_"))
}

fn check_name(name: &str) -> anyhow::Result<()> {
    let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let begins = name.starts_with(|c: char| c.is_ascii_lowercase()) && !name.ends_with('-');
    ensure!(
        begins && name.len() <= MAX_NAME && name.chars().all(letters),
        "the name {name:?} is not made of up to {MAX_NAME} lower-case letters, digits and hyphens, a letter first"
    );
    ensure!(
        !TAKEN.contains(&name),
        "the name {name:?} is taken by something a plugin needs"
    );
    Ok(())
}

/// Where the SDK comes from.
enum Sdk {
    /// A source tree on this machine.
    Tree(PathBuf),
    /// The public repository.
    Repository,
}

impl Sdk {
    fn find(given: Option<&Path>) -> anyhow::Result<Self> {
        let is_tree = |path: &Path| path.join("core/plugin-sdk/Cargo.toml").is_file();
        if let Some(path) = given {
            let path = path
                .canonicalize()
                .with_context(|| format!("{} cannot be found", path.display()))?;
            ensure!(is_tree(&path), "{} holds no core/plugin-sdk", path.display());
            return Ok(Self::Tree(path));
        }
        let built_from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        Ok(match built_from.canonicalize() {
            Ok(path) if is_tree(&path) => Self::Tree(path),
            _ => Self::Repository,
        })
    }

    /// A dependency on one of our crates.
    fn dependency(&self, name: &str, folder: &str) -> String {
        match self {
            // As TOML writes a text: a path may have anything in it.
            Self::Tree(tree) => {
                let path = toml_text(&tree.join(folder).to_string_lossy());
                format!("{name} = {{ path = {path} }}")
            }
            Self::Repository => format!("{name} = {{ git = {} }}", toml_text(REPOSITORY)),
        }
    }

    fn lock(&self) -> Option<String> {
        match self {
            Self::Tree(tree) => std::fs::read_to_string(tree.join("Cargo.lock")).ok(),
            Self::Repository => None,
        }
    }
}

/// A basic string of TOML, which JSON's is one of.
fn toml_text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn cargo_toml(name: &str, kind: Kind, sdk: &Sdk) -> String {
    let mut ours = vec![sdk.dependency("skein-plugin-sdk", "core/plugin-sdk")];
    if kind == Kind::UavModel {
        ours.push(sdk.dependency("generic-uav", "plugins/generic-uav"));
    }
    let ours = ours.join("\n");
    format!(
        r#"[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
publish = false

[lib]
# A shared library for the node, an ordinary one for the tests.
crate-type = ["cdylib", "rlib"]

[dependencies]
{ours}
minicbor = {{ version = "2.3", features = ["std", "derive"] }}
schemars = "1.2"
serde = {{ version = "1", features = ["derive"] }}

[dev-dependencies]
serde_json = "1"

[profile.release]
# A panic is caught and costs the instance; without unwinding it would cost the process, and no node takes the plugin.
panic = "unwind"

# It stands on its own, wherever it lies.
[workspace]
"#
    )
}

fn readme(name: &str, kind: Kind) -> String {
    let (library, word) = (library(name), kind.word());
    let chosen = if kind == Kind::UavModel {
        format!("model = \"{name}\"")
    } else {
        format!("payloads = [{{ name = \"{}\", plugin = \"{name}\" }}]", kind.word())
    };
    format!(
        r#"# {name}

A Skein plugin: {word}.

```sh
cargo test
cargo build --release
skein plugin check target/release/{library}
```

Copy the library into a directory of `plugins.directories` and choose it in an adoption rule: `{chosen}`. Look for `CHANGE` in `src/lib.rs`.
"#
    )
}

/// A file of the template with the names exchanged.
fn named(text: &str, name: &str, kind: Kind) -> String {
    let constant = match kind {
        Kind::Camera => "PluginKind::CAMERA",
        Kind::Radio => "PluginKind::RADIO",
        Kind::Detector => "PluginKind::DETECTOR",
        Kind::Gimbal | Kind::UavModel => "PluginKind::GIMBAL",
    };
    let own = type_name(name);
    text.replace("IndicatorLight", &own)
        .replace("LogBookUav", &own)
        .replace("PluginKind::GIMBAL", constant)
}

/// `my-light` as a type: `MyLightPlugin`. The ending keeps it apart from the other types of the template.
fn type_name(name: &str) -> String {
    let words = name.split('-').map(|word| {
        let mut letters = word.chars();
        letters.next().map_or(String::new(), |first| {
            first.to_ascii_uppercase().to_string() + letters.as_str()
        })
    });
    words.collect::<String>() + "Plugin"
}

fn write(folder: &Path, path: &str, text: &str) -> anyhow::Result<()> {
    let path = folder.join(path);
    let parent = path.parent().unwrap_or(folder);
    std::fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests;
