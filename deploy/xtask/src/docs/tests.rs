//! What is read out of documents, help texts and sources, and what pages are made of it.

use super::links::{Link, anchors, include, of, resolved};
use super::reference::{api, commands, metrics, own_options};
use serde_json::json;

#[test]
fn links_and_headings_are_found_outside_of_code() {
    let text = "# What it is\n[a](b.md#c) ![d](e.png) [f](https://g)\n```\n# not\n[h](i.md)\n```\n## `x` and [y](z.md): 2\n## What it is\n[j](#k)";
    let link = |line, path, anchor| Link { line, path, anchor };
    assert_eq!(
        of(text),
        [
            link(2, "b.md", Some("c")),
            link(2, "e.png", None),
            link(7, "z.md", None),
            link(9, "", Some("k")),
        ]
    );
    assert_eq!(anchors(text), ["what-it-is", "x-and-y-2", "what-it-is-1"]);
    assert_eq!(include("{{#include ../a.md}}"), Some("../a.md"));
    assert_eq!(include("`{{#include a.md}}`"), None);
    assert_eq!(resolved("deploy/docs/src", "../../../core/a.md"), "core/a.md");
}

#[test]
fn a_page_keeps_its_lines_and_its_links_lead_where_the_site_is_read() {
    let folder = tempfile::tempdir().expect("can be made");
    let file = |path: &str, text: &str| super::write(&folder.path().join(path), text).expect("written");
    file("core/a.md", "# A\n\n[b](b.rs) [guide](../deploy/docs/src/guide.md#x)\n");
    file("core/b.rs", "");
    file(
        "deploy/docs/src/guide.md",
        "One.\n\n![p](../../../p.png)\n```toml\n{{#include ../../../core/b.rs}}\n```\n",
    );
    file("deploy/docs/src/in/page.md", "{{#include ../../../../core/a.md}}\n");
    let page = |name: &str| super::pages::whole(folder.path(), &format!("{}/{name}", super::PAGES)).expect("is there");
    assert_eq!(page("guide.md"), "One.\n\n![p](pictures/p.png)\n```toml\n\n```\n");
    assert_eq!(
        page("in/page.md"),
        "# A\n\n[b](https://github.com/skein-swarm/skein/blob/main/core/b.rs) [guide](../guide.md#x)\n"
    );
}

#[test]
fn a_help_text_is_cut_to_what_is_its_own() {
    let help = "Fly\n\nCommands:\n  run   Run\n  help  Help\n\nOptions:\n      --log <FILTER>\n          What\n\n      --seed <SEED>\n          Seed\n\n  -h, --help\n          Print\n\nEnd";
    assert_eq!(commands(help), ["run"]);
    let own = own_options(help);
    assert!(
        own.contains("--seed") && own.contains("Seed") && own.contains("End"),
        "{own}"
    );
    assert!(
        !own.contains("--log") && !own.contains("What") && !own.contains("-h"),
        "{own}"
    );
    assert_eq!(own_options("Fly\n\nOptions:\n  -h, --help\n          Print\n"), "Fly");
}

#[test]
fn operations_and_metrics_become_rows() {
    let page = api(&json!({"paths": {"/a": {"get": {"tags": ["fleet"], "summary": "All | of it."}}}}));
    assert!(
        page.contains("## fleet") && page.contains("| GET | `/a` | All \\| of it. |"),
        "{page}"
    );
    let page = metrics(
        "describe_gauge!(\"up\", \"1 if it runs.\"); gauge!(\"up\").set(1); counter!(\"lost\")",
        "counters!(\n    /// Bytes.\n    bytes_in,\n);\n\n/// Not one.\nfn sent() {}",
    );
    for row in [
        "| `up` | 1 if it runs. |",
        "| `lost` |  |",
        "| `skein_endpoint_bytes_in_total` | Bytes. |",
    ] {
        assert!(page.contains(row), "{row} is not in {page}");
    }
    assert!(!page.contains("Not one."), "{page}");
}
