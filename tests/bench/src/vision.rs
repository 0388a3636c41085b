//! What a detector takes for a picture, part by part, on one core: decoding beside FFmpeg's of the same clip, the model beside ONNX Runtime in Python on the
//! same file.
//!
//! The pictures are those of the first clip of each camera in a folder of labelled clips; `skein vision evaluate` shows them to the detector.

use crate::error::BenchError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The other side, for a Python that has onnxruntime.
const ONNX: &str = include_str!("vision/onnx.py");
/// So often the model is run there; the median counts.
const RUNS: u32 = 300;

/// What to run.
#[derive(Debug, Clone)]
pub struct VisionBenchArgs {
    /// The program measured.
    pub program: PathBuf,
    /// A Python with onnxruntime.
    pub python: PathBuf,
    /// FFmpeg.
    pub ffmpeg: PathBuf,
    /// A folder of labelled clips.
    pub clips: PathBuf,
    /// The folder of the detector's models: `CAMERA.onnx`.
    pub models: PathBuf,
}

/// One part of the work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VisionFigures {
    /// Which camera's clip.
    pub camera: String,
    /// Which part.
    pub part: String,
    /// What it takes for a picture, in milliseconds.
    pub took_ms: f64,
    /// What it is compared with, and what that takes, in milliseconds.
    pub beside: Option<(String, f64)>,
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VisionBenchReport {
    /// Version of onnxruntime.
    pub onnxruntime: String,
    /// Part by part.
    pub figures: Vec<VisionFigures>,
}

impl fmt::Display for VisionBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "A picture on one core, beside FFmpeg and onnxruntime {}:",
            self.onnxruntime
        )?;
        for figures in &self.figures {
            write!(
                f,
                "{:<9} {:<22} {:>7.2} ms",
                figures.camera, figures.part, figures.took_ms
            )?;
            match &figures.beside {
                Some((what, their_ms)) => {
                    writeln!(f, "  {what} {their_ms:.2} ms: {:.2}x", figures.took_ms / their_ms)?;
                }
                None => writeln!(f)?,
            }
        }
        Ok(())
    }
}

#[derive(Deserialize)]
struct OnnxAnswer {
    version: String,
    seconds: f64,
    library: String,
}

#[derive(Deserialize)]
struct Evaluated {
    cameras: BTreeMap<String, EvaluatedCamera>,
}

#[derive(Deserialize)]
struct EvaluatedCamera {
    pictures: u64,
    decoded_per_s: f64,
    stages_s: BTreeMap<String, f64>,
}

/// Measures every camera of the folder.
///
/// # Errors
/// When a program cannot be started, or says something else than it should.
pub fn run_vision_bench(args: &VisionBenchArgs) -> Result<VisionBenchReport, BenchError> {
    let (mut figures, mut onnxruntime) = (Vec::new(), String::new());
    for clip in first_clips(&args.clips)? {
        let theirs = onnx(args, &clip.camera)?;
        let built_in = evaluate(args, &clip, serde_json::json!({ "runtime": "rten" }))?;
        let installed = serde_json::json!({ "runtime": "onnxruntime", "library": theirs.library });
        let installed = evaluate(args, &clip, installed)?;
        let (beside, their_ms) = (Some(format!("onnxruntime {}", theirs.version)), theirs.seconds * 1e3);
        let mut part = |part: &str, took_ms: f64, beside: Option<(String, f64)>| {
            let (camera, part) = (clip.camera.clone(), part.to_owned());
            figures.push(VisionFigures {
                camera,
                part,
                took_ms,
                beside,
            });
        };
        let ffmpeg_ms = ffmpeg(args, &clip, built_in.pictures)?;
        part(
            "decoding",
            1e3 / built_in.decoded_per_s,
            Some(("FFmpeg".to_owned(), ffmpeg_ms)),
        );
        for (runtime, measured) in [("rten", &built_in), ("onnxruntime", &installed)] {
            for (stage, took_s) in &measured.stages_s {
                let stage = stage.trim_end_matches("_s");
                let is_model = stage == "model";
                if is_model || runtime == "rten" {
                    let name = if is_model {
                        format!("model by {runtime}")
                    } else {
                        stage.to_owned()
                    };
                    let beside = beside.clone().filter(|_| is_model).map(|beside| (beside, their_ms));
                    part(&name, took_s * 1e3, beside);
                }
            }
        }
        onnxruntime = theirs.version;
    }
    Ok(VisionBenchReport { onnxruntime, figures })
}

/// A clip of the folder.
struct Clip {
    camera: String,
    label: String,
    name: String,
}

/// The first clip of each camera.
fn first_clips(folder: &Path) -> Result<Vec<Clip>, BenchError> {
    let system = |source| BenchError::System {
        what: "reading the list of clips",
        source,
    };
    let list = std::fs::read_to_string(folder.join("index.csv")).map_err(system)?;
    let mut rows = list.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap_or_default();
    let mut first: BTreeMap<String, Clip> = BTreeMap::new();
    for row in rows {
        let of = |name: &str| {
            let column = names.iter().position(|column| *column == name);
            column
                .and_then(|column| row.get(column))
                .map(|value| (*value).to_owned())
        };
        if let (Some(camera), Some(label), Some(name)) = (of("camera"), of("label"), of("clip")) {
            first.entry(camera.clone()).or_insert(Clip { camera, label, name });
        }
    }
    Ok(first.into_values().collect())
}

/// Runs the program on one clip, which it finds in a folder that has no other.
fn evaluate(args: &VisionBenchArgs, clip: &Clip, config: serde_json::Value) -> Result<EvaluatedCamera, BenchError> {
    let system = |what| move |source| BenchError::System { what, source };
    let folder = tempfile::tempdir().map_err(system("making a folder"))?;
    let list = format!("camera,label,clip\n{},{},{}\n", clip.camera, clip.label, clip.name);
    std::fs::write(folder.path().join("index.csv"), list).map_err(system("writing a list of clips"))?;
    let clips = args.clips.canonicalize().map_err(system("finding the clips"))?;
    std::os::unix::fs::symlink(clips.join(&clip.camera), folder.path().join(&clip.camera))
        .map_err(system("linking the clips"))?;
    let mut command = Command::new(&args.program);
    command.args(["vision", "evaluate", "--json", "--jobs", "1", "--clips"]);
    command.arg(folder.path()).args(["--config", &config.to_string()]);
    let text = output(command, "program under test")?;
    let mut evaluated: Evaluated = serde_json::from_slice(&text).map_err(BenchError::Settings)?;
    evaluated.cameras.remove(&clip.camera).ok_or_else(|| BenchError::Child {
        part: "program under test",
        detail: format!("it says nothing of {}", clip.camera),
    })
}

fn onnx(args: &VisionBenchArgs, camera: &str) -> Result<OnnxAnswer, BenchError> {
    let mut command = Command::new(&args.python);
    command.args(["-c", ONNX]);
    command
        .arg(args.models.join(format!("{camera}.onnx")))
        .arg(RUNS.to_string());
    let text = output(command, "Python, which needs onnxruntime")?;
    serde_json::from_slice(&text).map_err(BenchError::Settings)
}

/// What FFmpeg takes to decode a picture of the clip and make RGB of it, in milliseconds of processor time.
fn ffmpeg(args: &VisionBenchArgs, clip: &Clip, pictures: u64) -> Result<f64, BenchError> {
    let mut command = Command::new(&args.ffmpeg);
    command.args(["-nostdin", "-hide_banner", "-benchmark", "-threads", "1", "-i"]);
    command.arg(args.clips.join(&clip.camera).join(&clip.name));
    command.args([
        "-threads",
        "1",
        "-pix_fmt",
        "rgb24",
        "-f",
        "rawvideo",
        "-y",
        "/dev/null",
    ]);
    let done = command.output().map_err(|source| BenchError::Start {
        program: args.ffmpeg.clone(),
        source,
    })?;
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    let seconds = |name: &str| -> Option<f64> {
        let after = said.rsplit_once(&format!("{name}="))?.1;
        after.split_once('s')?.0.parse().ok()
    };
    let took_s = seconds("utime")
        .zip(seconds("stime"))
        .map(|(user, system)| user + system);
    match took_s {
        Some(took_s) if done.status.success() => Ok(took_s * 1e3 / pictures.max(1) as f64),
        _ => Err(BenchError::Child {
            part: "FFmpeg",
            detail: format!("{}: {}", done.status, said.trim_end()),
        }),
    }
}

fn output(mut command: Command, part: &'static str) -> Result<Vec<u8>, BenchError> {
    let program = PathBuf::from(command.get_program());
    let done = command
        .output()
        .map_err(|source| BenchError::Start { program, source })?;
    if done.status.success() {
        return Ok(done.stdout);
    }
    let detail = format!("{}: {}", done.status, String::from_utf8_lossy(&done.stderr).trim_end());
    Err(BenchError::Child { part, detail })
}
