//! Tests of what the dashboard is served as.

use super::*;

#[test]
fn only_names_with_a_hash_are_kept_for_good() {
    for name in [
        "assets/index-DiwrgTda.js",
        "assets/index-D1_r-Tda.css",
        "assets/maplibre-gl-worker-AbCdEf12.mjs",
        "assets/a-12345678.js.map",
    ] {
        assert!(is_hashed(name), "{name}");
    }
    for name in [
        "index.html",
        "favicon.svg",
        "assets/logo.svg",
        "assets/a.js",
        "index-DiwrgTda.js",
        "assets/üüüüüüüüü.js",
        "assets/-.js",
        "assets/x",
    ] {
        assert!(!is_hashed(name), "{name}");
    }
}

#[test]
fn scripts_and_styles_have_the_type_that_nosniff_wants() {
    assert_eq!(
        content_type("assets/index-DiwrgTda.js"),
        "text/javascript; charset=utf-8"
    );
    assert_eq!(content_type("assets/worker.mjs"), "text/javascript; charset=utf-8");
    assert_eq!(content_type("assets/index.css"), "text/css; charset=utf-8");
    assert_eq!(content_type("favicon.svg"), "image/svg+xml");
    assert_eq!(content_type("unknown"), "application/octet-stream");
    assert_eq!(content_type("x.exe"), "application/octet-stream");
}

#[test]
fn every_embedded_file_has_a_type_of_its_own() {
    for name in pages_files() {
        assert_ne!(content_type(&name), "application/octet-stream", "{name}");
    }
}

/// What of the embedded files has a name that can be asked for.
fn pages_files() -> impl Iterator<Item = String> {
    Dashboard::iter()
        .map(std::borrow::Cow::into_owned)
        .filter(|name| file(name, &HeaderMap::new()).is_some())
}

fn accepting(encodings: &'static str) -> HeaderMap {
    HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(encodings))])
}

#[test]
fn an_encoding_is_taken_by_whom_names_it_and_does_not_refuse_it() {
    for (said, br, gzip) in [
        ("gzip, deflate, br, zstd", true, true),
        ("gzip, deflate", false, true),
        ("GZIP;q=0.5,br; q=1", true, true),
        ("br;q=0, gzip;q=0.000", false, false),
        ("br;q=nonsense", false, false),
        ("brotli, x-gzip", false, false),
        ("*", false, false),
        ("", false, false),
    ] {
        assert_eq!(takes(&accepting(said), "br"), br, "{said}");
        assert_eq!(takes(&accepting(said), "gzip"), gzip, "{said}");
    }
    assert!(!takes(&HeaderMap::new(), "br"));
}

/// Each file in each of its forms: said how it is packed, with a tag of its own, and the packed ones smaller than the plain one. A program
/// without a built dashboard has no file to look at.
#[tokio::test]
async fn who_takes_a_packed_file_gets_it_and_others_get_it_plain() {
    for name in pages_files() {
        let uri: Uri = format!("/{name}").parse().expect("a path");
        let mut tags = std::collections::BTreeSet::new();
        let plain = Dashboard::get(&name).expect("it is there").data.len();
        let forms = std::iter::once((None, "identity", ""))
            .chain(TWINS.map(|(encoding, ending)| (Some(encoding), encoding, ending)))
            .filter(|(_, _, ending)| Dashboard::get(&format!("{name}{ending}")).is_some());
        for (packed, accepts, ending) in forms {
            let answer = dashboard(Method::GET, uri.clone(), accepting(accepts))
                .await
                .expect("the file");
            let said = |header| answer.headers().get(header).and_then(|value| value.to_str().ok());
            assert_eq!(said(header::CONTENT_ENCODING), packed, "{name}");
            assert_eq!(said(header::VARY), Some("accept-encoding"), "{name}");
            assert!(
                tags.insert(said(header::ETAG).expect("a tag").to_owned()),
                "{name}{ending}"
            );
            let length = axum::body::to_bytes(answer.into_body(), usize::MAX)
                .await
                .expect("a body")
                .len();
            assert!(
                if ending.is_empty() {
                    length == plain
                } else {
                    length < plain
                },
                "{name}{ending}: {length} of {plain}"
            );
        }
    }
}

#[tokio::test]
async fn a_packed_twin_has_no_name_of_its_own() {
    for name in ["/index.html.br", "/index.html.gz", "/.gitkeep"] {
        assert!(
            dashboard(Method::GET, name.parse().expect("a path"), HeaderMap::new())
                .await
                .is_err(),
            "{name}"
        );
    }
}

/// A worker that were served with the policy of data could load none of its own parts.
#[tokio::test]
async fn every_embedded_file_has_the_pages_policy() {
    for name in pages_files() {
        let uri: Uri = format!("/{name}").parse().expect("a path");
        let answer = dashboard(Method::GET, uri, HeaderMap::new()).await.expect("the file");
        assert_eq!(
            answer
                .headers()
                .get(header::CONTENT_SECURITY_POLICY)
                .map(HeaderValue::as_bytes),
            Some(CONTENT_SECURITY_POLICY.as_bytes()),
            "{name}"
        );
    }
}
