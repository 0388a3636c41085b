//! `skein vision …`: how well a detector sees, on clips whose truth is known.
//!
//! Must never do: look at pictures by itself. What sees is a detector plugin, loaded and called as a node does it.

mod clips;
mod eye;
mod report;

use anyhow::{Context, ensure};
use clap::{Args, Subcommand};
use clips::Clip;
use eye::Eye;
use futures_util::{StreamExt, stream};
use report::{Report, Watched};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// `skein vision`
#[derive(Debug, Clone, Args)]
pub struct VisionArguments {
    /// What to do.
    #[command(subcommand)]
    pub what: VisionCommand,
}

/// What can be done.
#[derive(Debug, Clone, Subcommand)]
pub enum VisionCommand {
    /// Show a detector clips whose objects are known, and say how many it found.
    Evaluate(EvaluateArguments),
}

/// `skein vision evaluate`
#[derive(Debug, Clone, Args)]
pub struct EvaluateArguments {
    /// The folder: `index.csv` with `camera,label,clip`, and for each clip `CAMERA/CLIP` (H.264 in MP4) and a CSV file of the same name with
    /// `frame,x,y,width,height`: the object in each picture, in pixels; a picture without a row has none.
    #[arg(long, value_name = "DIR")]
    pub clips: PathBuf,
    /// The detector [default: `plugins/libdetector_plugin.so` beside this program].
    #[arg(long, value_name = "FILE")]
    pub plugin: Option<PathBuf>,
    /// Its configuration, as JSON. For Skein's own detector `model` is the clip's camera, unless it is given.
    #[arg(long, default_value = "{}", value_name = "JSON")]
    pub config: String,
    /// Look at this camera's clips alone.
    #[arg(long)]
    pub camera: Option<String>,
    /// Clips that are looked at at a time [default: one for each core].
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..))]
    pub jobs: Option<u8>,
    /// Print the report as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Runs one of them.
pub async fn vision(arguments: VisionArguments) -> anyhow::Result<ExitCode> {
    match arguments.what {
        VisionCommand::Evaluate(arguments) => evaluate(arguments).await,
    }
}

async fn evaluate(arguments: EvaluateArguments) -> anyhow::Result<ExitCode> {
    let mut clips = clips::list(&arguments.clips)?;
    clips.retain(|clip| arguments.camera.as_ref().is_none_or(|camera| *camera == clip.camera));
    ensure!(
        !clips.is_empty(),
        "{} lists no clip of that camera",
        arguments.clips.display()
    );
    let plugin = match arguments.plugin {
        Some(plugin) => plugin,
        None => {
            let program = std::env::current_exe()?;
            let beside = program.parent().context("this program is in no folder")?;
            beside.join("plugins/libdetector_plugin.so")
        }
    };
    let eye = Arc::new(Eye::load(&plugin, &arguments.config)?);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores, usize::from);
    let (mut report, all) = (Report::default(), clips.len());
    let mut watched = stream::iter(clips)
        .map(|clip| tokio::spawn(watch(eye.clone(), clip)))
        .buffer_unordered(jobs);
    while let Some(one) = watched.next().await {
        let one = one??;
        let summary = one.summary();
        report.take(one);
        eprintln!("{:>4} of {all}  {summary}", report.clips());
    }
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report.figures())?);
    } else {
        println!("{}", report.figures());
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows a whole clip to a new instance.
async fn watch(eye: Arc<Eye>, clip: Clip) -> anyhow::Result<Watched> {
    let name = clip.name.clone();
    eye.watch(clip).await.with_context(|| format!("clip {name}"))
}
