//! The page as a browser reads it.

use super::flight::Flight;
use super::{report, written};
use crate::{Report, html};
use html5ever::parse_document;
use html5ever::tendril::TendrilSink;
use markup5ever_rcdom::{Handle, NodeData, RcDom};
use skein_recording::Recording;
use std::time::Instant;

fn parsed(page: &str) -> RcDom {
    parse_document(RcDom::default(), Default::default()).one(page)
}

/// Name, attributes, text.
type Element = (String, Vec<(String, String)>, String);

/// All elements, each with its text.
fn elements(of: &Handle, found: &mut Vec<Element>) -> String {
    let mut text = String::new();
    if let NodeData::Text { contents } = &of.data {
        text.push_str(&contents.borrow());
    }
    for child in of.children.borrow().iter() {
        text.push_str(&elements(child, found));
    }
    if let NodeData::Element { name, attrs, .. } = &of.data {
        let attributes = attrs.borrow();
        let attributes = attributes
            .iter()
            .map(|of| (of.name.local.to_string(), of.value.to_string()))
            .collect();
        found.push((name.local.to_string(), attributes, text.clone()));
    }
    text
}

#[test]
fn it_is_html_without_faults_that_names_who_drifted_and_needs_nothing_else() {
    let page = html(&report(&Flight::default()));
    let dom = parsed(&page);
    let errors = dom.errors.borrow().clone();
    assert!(errors.is_empty(), "{errors:?}");
    let mut found = Vec::new();
    elements(&dom.document, &mut found);
    for (name, attributes, _) in &found {
        assert!(
            !["script", "link", "img", "iframe", "object"].contains(&name.as_str()),
            "{name}"
        );
        for (attribute, value) in attributes {
            assert!(
                !attribute.starts_with("on") && !["src", "href"].contains(&attribute.as_str()),
                "{attribute}"
            );
            assert!(!value.contains("//"), "{value}");
        }
    }
    let rows: Vec<&String> = found
        .iter()
        .filter(|(name, ..)| name == "tr")
        .map(|(.., text)| text)
        .collect();
    assert!(
        rows.iter()
            .any(|row| row.contains("failsafe") && row.contains('4') && row.contains("hold ordered"))
    );
    assert!(
        rows.iter()
            .any(|row| row.contains("Habicht (4)") && row.contains("on the ground"))
    );
    assert_eq!(found.iter().filter(|(name, ..)| name == "svg").count(), 9);
    let numbers = |value: &str| value.contains("NaN") || value.contains("inf");
    assert!(
        !found
            .iter()
            .any(|(_, attributes, _)| attributes.iter().any(|(_, value)| numbers(value)))
    );
}

#[test]
fn whatever_a_name_is_it_stays_text() {
    let name = "<script>alert('x')</script>\"&'><b>";
    let page = html(&report(&Flight {
        name,
        ..Flight::default()
    }));
    assert!(!page.contains("<script") && !page.contains("<b>"));
    let dom = parsed(&page);
    let mut found = Vec::new();
    elements(&dom.document, &mut found);
    assert!(found.iter().any(|(tag, _, text)| tag == "th" && text.contains(name)));
    assert!(page.contains("Grace &lt;grace@example.org&gt;"));
}

/// To look at: `SKEIN_REPORT=/tmp/report cargo test -p skein-report -- --ignored pages_to_look_at`
#[test]
#[ignore = "writes pages for a person to look at"]
fn pages_to_look_at() {
    let folder = std::path::PathBuf::from(std::env::var("SKEIN_REPORT").expect("a folder"));
    let _ = std::fs::remove_file(folder.join("flight.mcap"));
    let path = written(&folder, &Flight::default());
    let page = html(&Report::of(&Recording::open(&path).expect("opens")).expect("is readable"));
    std::fs::write(folder.join("four.html"), page).expect("is written");
    let bytes = std::fs::read(&path).expect("is there");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("is cut");
    let page = html(&Report::of(&Recording::open(&path).expect("opens")).expect("is readable"));
    std::fs::write(folder.join("cut.html"), page).expect("is written");
}

/// `cargo test --release -p skein-report -- --ignored an_hour --nocapture`
#[test]
#[ignore = "takes a minute to draw the flight"]
fn an_hour_of_a_hundred_vehicles() {
    let folder = std::path::PathBuf::from(std::env::var("SKEIN_REPORT").expect("a folder"));
    let path = folder.join("large.mcap");
    if !path.exists() {
        Flight {
            vehicles: 100,
            seconds: 3600.0,
            ..Flight::default()
        }
        .write(&path)
        .finish()
        .expect("ends");
    }
    let begin = Instant::now();
    let report = Report::of(&Recording::open(&path).expect("opens")).expect("is readable");
    let read_s = begin.elapsed().as_secs_f64();
    let page = html(&report);
    std::fs::write(folder.join("large.html"), &page).expect("is written");
    let megabytes = std::fs::metadata(&path).expect("is there").len() as f64 * 1e-6;
    let status = std::fs::read_to_string("/proc/self/status").expect("is there");
    let memory = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .unwrap_or_default();
    println!(
        "{megabytes:.0} MB read in {read_s:.1} s, page of {} kB, {memory}",
        page.len() / 1000
    );
}
