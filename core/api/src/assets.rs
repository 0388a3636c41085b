//! The dashboard, embedded as it was built into `web-ui/dist`. Without a built dashboard there is a page that says how to build it.
//! The build lays packed twins (`.br`, `.gz`) beside its files; who takes one gets it as it lies, everybody else the plain file.
//!
//! Must never do: read files at run time, or serve anything that was not there when the program was built.

use crate::error::ApiError;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use rust_embed::{EmbeddedFile, RustEmbed};

#[derive(RustEmbed)]
#[folder = "../../web-ui/dist"]
struct Dashboard;

/// What a page from here may load: its own files only.
pub const CONTENT_SECURITY_POLICY: &str =
    "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const NOT_BUILT: &str = "<!doctype html>
<html lang=\"en\">
<meta charset=\"utf-8\">
<title>Skein</title>
<h1>Skein is running, its dashboard is not built in</h1>
<p>This program was built without the dashboard. <code>cargo xtask demo</code> builds both.</p>
<p>The API is here all the same: <a href=\"/api/v1/openapi.json\">what it offers</a>,
<a href=\"/api/v1/fleet\">the fleet</a>, <a href=\"/metrics\">metrics</a>.</p>
</html>
";

/// Answers every path that no route takes: files of the dashboard, or an error.
///
/// # Errors
/// When there is no such file, or the method is not for reading.
pub async fn dashboard(method: Method, uri: Uri, headers: HeaderMap) -> Result<Response, ApiError> {
    let path = uri.path();
    if is_api(path) {
        return Err(ApiError::not_found(&uri));
    }
    if !matches!(method, Method::GET | Method::HEAD) {
        return Err(ApiError::MethodNotAllowed {
            path: path.to_owned(),
            method,
        });
    }
    let name = if path == "/" {
        "index.html"
    } else {
        path.trim_start_matches('/')
    };
    match file(name, &headers) {
        Some((file, encoding)) => Ok(answer(name, file, encoding, &headers)),
        None if name == "index.html" => Ok(html(NOT_BUILT.as_bytes().to_vec())),
        None => Err(ApiError::not_found(&uri)),
    }
}

/// Whether a path is the API's, where even a mistake is answered in JSON.
fn is_api(path: &str) -> bool {
    path == "/api" || path.starts_with("/api/")
}

/// How a twin is packed and how its name ends; the smaller one first.
const TWINS: [(&str, &str); 2] = [("br", ".br"), ("gzip", ".gz")];

/// A file of the dashboard, packed in a way that the asker takes where there is one.
fn file(name: &str, headers: &HeaderMap) -> Option<(EmbeddedFile, Option<&'static str>)> {
    // A twin has no name of its own, and the folder is kept in the repository by a file that is no part of the dashboard.
    if name.starts_with('.') || TWINS.iter().any(|(_, ending)| name.ends_with(ending)) {
        return None;
    }
    let packed = TWINS
        .iter()
        .filter(|(encoding, _)| takes(headers, encoding))
        .find_map(|(encoding, ending)| Some((Dashboard::get(&format!("{name}{ending}"))?, Some(*encoding))));
    packed.or_else(|| Some((Dashboard::get(name)?, None)))
}

/// Whether `Accept-Encoding` names an encoding and does not refuse it. One that is not named is not meant by `*` here: plain always serves.
fn takes(headers: &HeaderMap, encoding: &str) -> bool {
    let named = headers.get_all(header::ACCEPT_ENCODING).iter();
    named
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .any(|one| {
            let (name, weight) = one.split_once(';').unwrap_or((one, ""));
            let weight = weight.trim().strip_prefix("q=").map_or(Ok(1.0), str::parse::<f32>);
            name.trim().eq_ignore_ascii_case(encoding) && weight.is_ok_and(|weight| weight > 0.0)
        })
}

fn answer(name: &str, file: EmbeddedFile, encoding: Option<&'static str>, headers: &HeaderMap) -> Response {
    let hash: String = file
        .metadata
        .sha256_hash()
        .iter()
        .take(16)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let tag = format!("\"{hash}\"");
    let caching = if is_hashed(name) {
        "public, max-age=31536000, immutable"
    } else {
        "no-cache"
    };
    let known = headers.get(header::IF_NONE_MATCH).and_then(|value| value.to_str().ok());
    let mut response = if known.is_some_and(|known| known.split(',').any(|one| one.trim() == tag)) {
        StatusCode::NOT_MODIFIED.into_response()
    } else if name == "index.html" {
        html(file.data.into_owned())
    } else {
        ([(header::CONTENT_TYPE, content_type(name))], file.data.into_owned()).into_response()
    };
    response
        .headers_mut()
        .insert(header::CACHE_CONTROL, HeaderValue::from_static(caching));
    // Whoever keeps answers between here and the browser must not hand a packed one to somebody who cannot unpack it.
    response
        .headers_mut()
        .insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    if let Some(encoding) = encoding {
        response
            .headers_mut()
            .insert(header::CONTENT_ENCODING, HeaderValue::from_static(encoding));
    }
    // The page's own policy, of every file: a worker obeys that of its own answer, and with a 304 a browser puts the headers of this answer in
    // the place of those it has kept.
    response.headers_mut().insert(
        header::CONTENT_SECURITY_POLICY,
        HeaderValue::from_static(CONTENT_SECURITY_POLICY),
    );
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}

fn html(page: Vec<u8>) -> Response {
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (header::CACHE_CONTROL, "no-cache"),
        (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
    ];
    (headers, page).into_response()
}

/// Whether the build put a hash of the contents into the name, as Vite does for everything in `assets/`: such a file never changes.
fn is_hashed(name: &str) -> bool {
    let Some(stem) = name
        .strip_prefix("assets/")
        .and_then(|file| file.rsplit_once('.'))
        .map(|(stem, _)| stem)
    else {
        return false;
    };
    // `worker-AbC_12-3.js`: the hash is the eight characters before the first dot, after a dash.
    let stem = stem.split('.').next().unwrap_or(stem);
    stem.len() > 9 && stem.is_char_boundary(stem.len() - 9) && {
        let (_, tail) = stem.split_at(stem.len() - 9);
        tail.starts_with('-')
            && tail
                .chars()
                .skip(1)
                .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
    }
}

/// The content type by the ending of the name. Anything else is bytes, which a browser will not run.
fn content_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "webmanifest" => "application/manifest+json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "wasm" => "application/wasm",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests;
