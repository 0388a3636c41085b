//! Clips with what is to be seen in them.
//!
//! Must never do: guess at a damaged file. It is said which line of which file is wrong.

use anyhow::{Context, bail, ensure};
use serde::Deserialize;
use skein_vision::Bounds;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A clip of the list.
#[derive(Debug, Clone)]
pub(super) struct Clip {
    /// The camera that took it, for example `infrared`.
    pub(super) camera: String,
    /// What is to be seen.
    pub(super) label: String,
    /// Its name.
    pub(super) name: String,
    /// The video.
    pub(super) path: PathBuf,
    /// Number of a picture, from 0, to the object in it.
    pub(super) truth: BTreeMap<usize, Bounds>,
}

#[derive(Deserialize)]
struct Listed {
    camera: String,
    label: String,
    clip: String,
}

#[derive(Deserialize)]
struct Labelled {
    frame: usize,
    x: f64,
    y: f64,
    width: f64,
    height: f64,
}

/// All clips of a folder.
///
/// # Errors
///
/// A list or a label cannot be read.
pub(super) fn list(folder: &Path) -> anyhow::Result<Vec<Clip>> {
    let index = folder.join("index.csv");
    let mut reader = csv::Reader::from_path(&index).with_context(|| format!("cannot read {}", index.display()))?;
    let mut clips = Vec::new();
    for listed in reader.deserialize() {
        let Listed { camera, label, clip } = listed.with_context(|| index.display().to_string())?;
        let inside = |name: &str| !name.is_empty() && Path::new(name).file_name().is_some_and(|file| file == name);
        ensure!(
            inside(&camera) && inside(&clip),
            "{}: {camera}/{clip} is no place in the folder",
            index.display()
        );
        let path = folder.join(&camera).join(&clip);
        let truth = labels(&path.with_extension("csv"))?;
        clips.push(Clip {
            camera,
            label,
            name: clip,
            path,
            truth,
        });
    }
    Ok(clips)
}

fn labels(path: &Path) -> anyhow::Result<BTreeMap<usize, Bounds>> {
    let mut reader = csv::Reader::from_path(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut truth = BTreeMap::new();
    for row in reader.deserialize() {
        let row: Labelled = row.with_context(|| path.display().to_string())?;
        let bounds = Bounds {
            center_x_px: row.x + row.width / 2.0,
            center_y_px: row.y + row.height / 2.0,
            width_px: row.width,
            height_px: row.height,
        };
        if !bounds.is_sound() {
            bail!("{}: the box of picture {} cannot be", path.display(), row.frame);
        }
        if truth.insert(row.frame, bounds).is_some() {
            bail!("{}: picture {} has two rows", path.display(), row.frame);
        }
    }
    Ok(truth)
}

impl Clip {
    /// Numbers labels from 0 that are numbered from 1: such a list has a row for a picture after the last, and none for the first.
    pub(super) fn number_from_zero(&mut self, pictures: usize) -> bool {
        let from_one = self.truth.contains_key(&pictures) && !self.truth.contains_key(&0);
        if from_one {
            let truth = std::mem::take(&mut self.truth);
            self.truth = truth.into_iter().map(|(frame, bounds)| (frame - 1, bounds)).collect();
        }
        from_one
    }
}
