//! What is known of recordings, for people.
//!
//! Must never do: print a text of a file so that it moves the terminal's cursor.

use skein_export::{Overview, time_of_day};
use std::path::Path;

fn size(bytes: u64) -> String {
    let mut size = bytes as f64;
    for unit in ["B", "kB", "MB", "GB"] {
        if size < 1000.0 {
            return if unit == "B" {
                format!("{size} {unit}")
            } else {
                format!("{size:.1} {unit}")
            };
        }
        size /= 1000.0;
    }
    format!("{size:.1} TB")
}

fn length(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    format!("{hours}:{minutes:02}:{seconds:02}")
}

/// Texts of files may hold anything.
fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

fn node(of: &Overview) -> String {
    match of.node {
        Some(node) => format!("{} ({node})", plain(&of.name)),
        None => plain(&of.name),
    }
}

/// The recordings of a folder, a line for each.
pub fn list(found: &[Overview], folder: &Path) {
    let nodes: Vec<String> = found.iter().map(node).collect();
    let width = nodes
        .iter()
        .map(|node| node.chars().count())
        .max()
        .unwrap_or_default()
        .max(4);
    println!(
        "{:<24} {:>8} {:>9} {:>8}  {:<width$} {:<9} file",
        "begin", "length", "size", "vehicles", "node", "ended"
    );
    for (of, node) in found.iter().zip(&nodes) {
        let file = of.file.strip_prefix(folder).unwrap_or(&of.file);
        println!(
            "{:<24} {:>8} {:>9} {:>8}  {node:<width$} {:<9} {}",
            time_of_day(of.begin_unix_ns),
            length(of.length_s),
            size(of.size_bytes),
            of.vehicles.len(),
            if of.finished { "whole" } else { "cut off" },
            file.display()
        );
    }
}

/// Everything about one.
pub fn info(of: &Overview) {
    println!("File:      {} ({})", of.file.display(), size(of.size_bytes));
    let swarm = if of.swarm.is_empty() {
        String::new()
    } else {
        format!(", swarm {}", plain(&of.swarm))
    };
    println!("Node:      {}{swarm}", node(of));
    println!("Written:   by Skein {}, format {}", plain(&of.version), of.format);
    println!("Begin:     {}", time_of_day(of.begin_unix_ns));
    println!("Length:    {} ({:.1} s)", length(of.length_s), of.length_s);
    let vehicles: Vec<String> = of.vehicles.iter().map(ToString::to_string).collect();
    println!(
        "Vehicles:  {}",
        if vehicles.is_empty() {
            "none".to_owned()
        } else {
            vehicles.join(", ")
        }
    );
    let order = ["critical", "warning", "advisory", "info", "unreadable"];
    let events: Vec<String> = order
        .iter()
        .filter_map(|word| Some(format!("{} {word}", of.events.get(*word)?)))
        .collect();
    println!("Events:    {}", events.join(", "));
    println!(
        "Whole:     {}",
        if of.damage.is_empty() {
            "yes, as far as was read here"
        } else {
            "no"
        }
    );
    for damage in &of.damage {
        println!("           {damage}");
    }
    println!("Topics:");
    let width = of
        .topics
        .iter()
        .map(|topic| topic.topic.chars().count())
        .max()
        .unwrap_or_default();
    for topic in &of.topics {
        println!(
            "  {:<width$} {:>9} {:>8.1} Hz  {} ({})",
            plain(&topic.topic),
            topic.messages,
            topic.rate_hz(of.length_s),
            plain(&topic.schema),
            plain(&topic.encoding)
        );
    }
}
