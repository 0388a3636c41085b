//! `skein replay`: shows a recorded flight again, in a browser, until Ctrl-C or SIGTERM.
//!
//! Must never do: open a link to a vehicle or to another node.

use anyhow::Context;
use clap::Args;
use skein_api::ApiSettings;
use skein_node::{stop_asked, tell};
use skein_replay::{RATES, Replay, ReplayChange};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::net::TcpListener;

/// `skein replay`
#[derive(Debug, Clone, Args)]
pub struct ReplayArguments {
    /// The recording: a file that ends in `.mcap`.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Where dashboard and API are served.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:8090")]
    pub listen: SocketAddr,
    /// Recorded seconds that are shown in a second, 0.25 to 20.
    #[arg(long, default_value = "1")]
    pub rate: f64,
    /// Begin so many seconds after the recording begins.
    #[arg(long, value_name = "SECONDS", default_value = "0")]
    pub from_s: f64,
}

/// Shows it.
///
/// # Errors
/// When the file is no recording, or the address is in use.
pub async fn replay(arguments: &ReplayArguments) -> anyhow::Result<()> {
    let (rate, from_s) = (arguments.rate, arguments.from_s);
    anyhow::ensure!(RATES.contains(&rate), "--rate {rate}: it is 0.25 to 20");
    anyhow::ensure!(from_s >= 0.0, "--from-s {from_s}: it is 0 or more");
    let path = arguments.file.clone();
    let opened = tokio::task::spawn_blocking(move || Replay::open(&path)).await?;
    let replay = Arc::new(opened?);
    let listener = TcpListener::bind(arguments.listen)
        .await
        .with_context(|| format!("cannot listen on {}", arguments.listen))?;
    let address = listener.local_addr()?;
    let begun = ReplayChange {
        position_s: (from_s > 0.0).then_some(from_s),
        rate: Some(rate),
        playing: Some(true),
    };
    let state = replay.change(begun).await?;
    tell(format_args!(
        "{} of {}, {:.0} s",
        state.file, state.node, state.duration_s
    ));
    tell(format_args!(
        "Dashboard: http://{address}/   (a recorded flight: no command leaves; Ctrl-C ends it)"
    ));
    let router = skein_api::replay_router(replay, &ApiSettings::default());
    let stop = async {
        // Without signals it goes on until it is killed.
        if stop_asked().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    skein_api::serve(listener, router, stop).await?;
    Ok(())
}
