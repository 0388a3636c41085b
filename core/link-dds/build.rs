//! Makes Rust of the definitions in `messages/`. A folder is a release of PX4 and has the messages that changed with it, in fields or version;
//! `incoming` has what PX4 reads. A definition has a field in each line, as PX4 writes it, after its version if that is not zero.
//!
//! Must never do: guess. A line that is none of these ends the build, with its file and number.

#[path = "src/messages/kind.rs"]
mod kind;

use kind::Kind;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// The one folder that is no release.
const INCOMING: &str = "incoming";

fn main() {
    println!("cargo::rerun-if-changed=messages");
    if let Err(error) = generate() {
        println!("cargo::error={error}");
    }
}

/// Writes the structs, and the table of what PX4 sends.
fn generate() -> Result<(), Box<dyn Error>> {
    let (mut modules, mut releases) = (String::new(), Vec::new());
    // of each message: which releases brought a new shape, by their place in the list, and its version
    let mut shapes: BTreeMap<String, Vec<(usize, u32)>> = BTreeMap::new();
    for (folder, path) in entries(Path::new("messages"))? {
        let numbered = folder.starts_with(|c: char| c.is_ascii_digit());
        let module = if numbered { "v" } else { "" }.to_owned() + &folder.replace('.', "_");
        let mut structs = String::new();
        for (file, path) in entries(&path)? {
            let message = file
                .strip_suffix(".msg")
                .ok_or(format!("{} is no .msg", path.display()))?;
            let text = fs::read_to_string(&path)?;
            let shape = parse(&path, &text)?;
            structs += &declaration(message, &shape);
            if folder != INCOMING {
                let known = shapes.entry(message.to_owned()).or_default();
                known.push((releases.len(), shape.version));
            }
        }
        modules += &format!(
            "/// From `messages/{folder}`.\npub mod {module} {{ use super::{{Field, Kind, Message}}; {structs} }}\n"
        );
        if folder != INCOMING {
            releases.push(module);
        }
    }
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(out.join("messages.rs"), modules)?;
    fs::write(out.join("definitions.rs"), table(&releases, &shapes))?;
    Ok(())
}

/// What is in a folder, by name.
fn entries(folder: &Path) -> io::Result<BTreeMap<String, PathBuf>> {
    let named = |entry: fs::DirEntry| (entry.file_name().to_string_lossy().into_owned(), entry.path());
    fs::read_dir(folder)?.map(|entry| entry.map(named)).collect()
}

/// What a file defines.
#[derive(Default)]
pub struct Shape<'t> {
    version: u32,
    /// Names, types, and the elements of arrays.
    pub fields: Vec<(&'t str, Kind, Option<usize>)>,
}

/// Reads what a file defines; the path is for what is said of a bad line.
pub fn parse<'t>(path: &Path, text: &'t str) -> Result<Shape<'t>, String> {
    let mut shape = Shape::default();
    for (number, line) in (1..).zip(text.lines()) {
        let taken = take(line, &mut shape);
        taken.ok_or_else(|| format!("{}:{number}: `{line}` is no field of a known type", path.display()))?;
    }
    Ok(shape)
}

fn take<'t>(line: &'t str, shape: &mut Shape<'t>) -> Option<()> {
    if let Some(version) = line.strip_prefix("uint32 MESSAGE_VERSION = ") {
        shape.version = version.parse().ok()?;
        return Some(());
    }
    let (word, name) = line.split_once(' ')?;
    let (word, elements) = match word.strip_suffix(']') {
        Some(array) => array.split_once('[').map(|(word, elements)| (word, Some(elements)))?,
        None => (word, None),
    };
    let elements = elements.map(str::parse).transpose().ok()?;
    let kind = Kind::ALL.into_iter().find(|kind| kind.word() == word)?;
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if name.is_empty() || !name.chars().all(fits) {
        return None;
    }
    shape.fields.push((name, kind, elements));
    Some(())
}

/// The struct of a message, with the table of its fields.
fn declaration(message: &str, Shape { version, fields }: &Shape<'_>) -> String {
    let (mut members, mut table) = (String::new(), String::new());
    for (name, kind, elements) in fields {
        let one = format!("{kind:?}").to_lowercase();
        let rust = elements.map_or(one.clone(), |elements| format!("[{one}; {elements}]"));
        members += &format!("pub {name}: {rust}, ");
        table += &format!("Field {{ name: \"{name}\", kind: Kind::{kind:?}, elements: {elements:?} }}, ");
    }
    format!(
        "/// Version {version}.
        #[allow(missing_docs, reason = \"what the fields mean stands in PX4's documentation under these names\")]
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct {message} {{ {members} }}
        impl Message for {message} {{
            const NAME: &'static str = \"{message}\";
            const FIELDS: &'static [Field] = &[{table}];
        }}\n"
    )
}

/// A shape fits the releases from the one that brought it up to the one before the next.
fn table(releases: &[String], shapes: &BTreeMap<String, Vec<(usize, u32)>>) -> String {
    let mut rows = String::new();
    for (message, shapes) in shapes {
        let ends = shapes.iter().skip(1).map(|(next, _)| *next).chain([releases.len()]);
        for ((from, version), end) in shapes.iter().zip(ends) {
            let module = &releases[*from];
            let fits: Vec<String> = releases[*from..end].iter().map(|module| release(module)).collect();
            let fits = fits.join(", ");
            rows += &format!(
                "Definition::new::<crate::messages::{module}::{message}>(topic_of::{message}, {version}, &[{fits}]),\n"
            );
        }
    }
    format!("&[{rows}]")
}

/// The release of a module.
fn release(module: &str) -> String {
    let (first, rest) = module.split_at(1);
    format!("Release::{}{rest}", first.to_uppercase())
}
