//! Tests of who may ask from which page.

use super::*;
use axum::http::{HeaderName, HeaderValue};

fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
    let mut headers = HeaderMap::new();
    for (name, value) in pairs {
        headers.append(HeaderName::from_static(name), HeaderValue::from_str(value).unwrap());
    }
    headers
}

fn guard() -> Guard {
    Guard::new(&ApiSettings {
        allowed_hosts: vec!["Ground.example".into()],
        allowed_origins: vec!["http://localhost:5173/".into()],
    })
}

fn outcome(method: Method, pairs: &[(&'static str, &str)]) -> Result<(), &'static str> {
    guard()
        .check(&method, None, &headers(pairs))
        .map_err(|error| error.code())
}

#[test]
fn addresses_localhost_and_configured_names_are_own_hosts() {
    let own = [
        "127.0.0.1:8080",
        "[::1]:8080",
        "10.1.2.3",
        "localhost",
        "LOCALHOST:1",
        "ground.example:8080",
        "ground.example.",
    ];
    for host in own {
        assert_eq!(outcome(Method::GET, &[("host", host)]), Ok(()), "{host}");
    }
}

#[test]
fn a_name_that_was_made_to_point_here_is_refused_even_for_reading() {
    for host in [
        "evil.example",
        "127.0.0.1.evil.example",
        "localhost.evil.example:8080",
        "ground.example.evil.example",
        "xn--1",
    ] {
        assert_eq!(outcome(Method::GET, &[("host", host)]), Err("foreign_host"), "{host}");
    }
}

#[test]
fn a_request_without_one_usable_host_is_refused() {
    assert_eq!(outcome(Method::GET, &[]), Err("no_host"));
    assert_eq!(outcome(Method::GET, &[("host", "a b")]), Err("no_host"));
    assert_eq!(
        outcome(Method::GET, &[("host", "localhost"), ("host", "evil.example")]),
        Err("no_host")
    );
}

#[test]
fn a_foreign_page_can_change_nothing() {
    for method in [Method::POST, Method::PUT, Method::DELETE, Method::PATCH] {
        for origin in [
            "http://evil.example",
            "null",
            "http://127.0.0.1:9999",
            "http://127.0.0.1",
            "https://127.0.0.1:8080.evil.example",
            "",
        ] {
            let said = [("host", "127.0.0.1:8080"), ("origin", origin)];
            assert_eq!(
                outcome(method.clone(), &said),
                Err("foreign_origin"),
                "{method} {origin}"
            );
        }
    }
    let several = [
        ("host", "127.0.0.1:8080"),
        ("origin", "http://127.0.0.1:8080"),
        ("origin", "http://evil.example"),
    ];
    assert_eq!(outcome(Method::POST, &several), Err("foreign_origin"));
    let no_origin = [("host", "127.0.0.1:8080"), ("sec-fetch-site", "cross-site")];
    assert_eq!(outcome(Method::POST, &no_origin), Err("foreign_origin"));
}

#[test]
fn a_foreign_page_can_open_no_stream() {
    let said = [
        ("host", "127.0.0.1:8080"),
        ("upgrade", "websocket"),
        ("origin", "http://evil.example"),
    ];
    assert_eq!(outcome(Method::GET, &said), Err("foreign_origin"));
    let own = [
        ("host", "127.0.0.1:8080"),
        ("upgrade", "websocket"),
        ("origin", "http://127.0.0.1:8080"),
    ];
    assert_eq!(outcome(Method::GET, &own), Ok(()));
}

#[test]
fn own_pages_the_development_server_and_programs_are_let_in() {
    let host = ("host", "localhost:8080");
    assert_eq!(outcome(Method::POST, &[host]), Ok(()));
    assert_eq!(
        outcome(
            Method::POST,
            &[
                host,
                ("origin", "http://localhost:8080"),
                ("sec-fetch-site", "same-origin")
            ]
        ),
        Ok(())
    );
    assert_eq!(
        outcome(Method::POST, &[host, ("origin", "https://LOCALHOST:8080")]),
        Ok(())
    );
    assert_eq!(
        outcome(Method::PUT, &[host, ("origin", "http://localhost:5173")]),
        Ok(())
    );
    assert_eq!(
        outcome(Method::GET, &[host, ("origin", "http://evil.example")]),
        Ok(()),
        "it cannot read the answer"
    );
}
