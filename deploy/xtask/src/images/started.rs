//! An image that is started: as its own user, who may write to no more than a read-only root leaves; how long it takes and how much memory.
//!
//! Must never do: take more for right than the compose files give.

use super::Builder;
use super::limits::{Limits, MEMORY_BYTES};
use anyhow::{Context, Result, ensure};
use std::process::Stdio;

/// Programs that have no business in an image.
const COMPILERS: [&str; 6] = ["cc", "gcc", "c++", "cargo", "rustc", "make"];

/// Looks at the image and starts its program.
pub(super) fn check(builder: &Builder<'_>, image: &str, target: &str) -> Result<()> {
    let working = builder.said(builder.buildah().args(["from", "--pull-never", image]))?;
    let checked = within(builder, &working, target);
    builder.said(builder.buildah().args(["rm", &working]))?;
    checked.with_context(|| image.to_owned())
}

/// The image's GStreamer gives H.264 as the camera plugin asks for it: from a test picture, for want of the board's camera.
pub(super) fn gives_pictures(builder: &Builder<'_>, image: &str) -> Result<()> {
    let working = builder.said(builder.buildah().args(["from", "--pull-never", image]))?;
    let line = "gst-launch-1.0 -q videotestsrc num-buffers=10 ! openh264enc ! h264parse ! rtph264pay ! rtpstreampay ! fdsink | wc -c";
    let given = builder.said(builder.buildah().args(["run", &working, "--", "/bin/sh", "-ec", line]));
    builder.said(builder.buildah().args(["rm", &working]))?;
    let bytes: u64 = given?.parse().with_context(|| format!("{image}: {line}"))?;
    ensure!(bytes > 1_000, "{image}: GStreamer gave {bytes} bytes of H.264");
    println!("  GStreamer gives {bytes} bytes of H.264");
    Ok(())
}

fn within(builder: &Builder<'_>, working: &str, target: &str) -> Result<()> {
    let run = |line: &str| builder.said(builder.buildah().args(["run", working, "--", "/bin/sh", "-ec", line]));
    let id = run("id -u")?;
    ensure!(id == "10001", "it runs as user {id}");
    for compiler in COMPILERS {
        let found = run(&format!("command -v {compiler} || true"))?;
        ensure!(found.is_empty(), "it has a compiler: {found}");
    }
    let writable = run("find / -xdev -type d -writable -not -path '/proc/*' -not -path '/dev/*' 2>/dev/null || true")?;
    let expected = |folder: &&str| {
        ["/tmp", "/var/tmp", "/var/lib/skein", "/run"]
            .iter()
            .any(|top| folder.starts_with(top))
    };
    let others: Vec<_> = writable.lines().filter(|folder| !expected(folder)).collect();
    ensure!(others.is_empty(), "its user may write to {others:?}");
    let version = run("skein --version")?;
    let plugins = run("skein plugin list")?;
    ensure!(plugins.contains("generic-uav"), "{plugins}");
    let inspected = builder.said(builder.buildah().args(["inspect", "--type", "container", working]))?;
    for wanted in ["org.opencontainers.image.title", "\"10001:10001\""] {
        ensure!(inspected.contains(wanted), "{wanted} is missing");
    }
    ensure!(
        target == "sim" || inspected.contains("Healthcheck"),
        "it has no health check"
    );
    let (ready_s, memory_kib) = started(builder, working, target)?;
    println!(
        "  {version} is up after {ready_s} s with {:.0} of {} MB and half a core, as user 10001",
        memory_kib as f64 / 1024.0,
        MEMORY_BYTES >> 20,
    );
    Ok(())
}

/// Starts the node or the simulation with what the compose files give it, waits until it is up, and gives how long that took and the most memory
/// it had, in kibibytes.
fn started(builder: &Builder<'_>, working: &str, target: &str) -> Result<(f64, u64)> {
    let program = if target == "sim" {
        "skein sim --vehicles 1 --send-to 127.0.0.1:14540"
    } else {
        "skein run --config node.toml"
    };
    let script = format!(
        r#"cd /tmp
printf '[web]\nlisten = "127.0.0.1:0"\n[[endpoints]]\naddress = "udp-listen://127.0.0.1:0"\n[plugins]\ndirectories = ["/usr/lib/skein/plugins"]\n' > node.toml
begun=$(date +%s%N)
{program} > said 2>&1 &
node=$!
while ! grep -q 'Stop with Ctrl-C' said; do kill -0 $node; sleep 0.05; done
echo $(( ($(date +%s%N) - begun) / 1000000 )) $(grep VmHWM /proc/$node/status | tr -dc 0-9)
kill -INT $node; wait $node || true"#
    );
    let mut command = builder.buildah();
    command.args(["run", working, "--", "/bin/sh", "-ec", &script]);
    let limits = Limits::new()?;
    let said = builder.said(limits.within(&command).stdin(Stdio::null()))?;
    let last = said.lines().last().unwrap_or_default();
    let (took_ms, memory) = last.split_once(' ').with_context(|| said.clone())?;
    Ok((took_ms.parse::<f64>()? / 1000.0, memory.parse()?))
}
