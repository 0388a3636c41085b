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
    for name in Dashboard::iter().filter(|name| !name.starts_with('.')) {
        assert_ne!(content_type(&name), "application/octet-stream", "{name}");
    }
}

/// A worker that were served with the policy of data could load none of its own parts.
#[tokio::test]
async fn every_embedded_file_has_the_pages_policy() {
    for name in Dashboard::iter().filter(|name| !name.starts_with('.')) {
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
