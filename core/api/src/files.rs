//! Files of this node's disk, sent a piece at a time.
//!
//! Must never do: choose which file; who calls has checked its name.

use axum::body::{Body, Bytes};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use std::io;
use std::path::Path;
use tokio::fs::File;
use tokio::io::AsyncReadExt;

/// A file is sent in pieces of this size.
const PIECE_BYTES: usize = 64 << 10;

/// A file to be saved under this name.
///
/// # Errors
/// When it cannot be opened.
pub(crate) async fn send(path: &Path, name: &str, kind: &'static str) -> io::Result<Response> {
    let file = File::open(path).await?;
    let pieces = futures_util::stream::try_unfold(file, |mut file| async move {
        let mut piece = vec![0; PIECE_BYTES];
        let len = file.read(&mut piece).await?;
        piece.truncate(len);
        Ok::<_, io::Error>((len > 0).then_some((Bytes::from(piece), file)))
    });
    let disposition = format!("attachment; filename=\"{}\"", name.replace('"', ""));
    let headers = [
        (header::CONTENT_TYPE, kind.to_owned()),
        (header::CONTENT_DISPOSITION, disposition),
    ];
    Ok((headers, Body::from_stream(pieces)).into_response())
}
