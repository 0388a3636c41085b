//! `images`: the container images, built and started here without a container engine and without a registry: by buildah, on a Debian that
//! debootstrap makes and that is tagged with the base's name.
//!
//! Must never do: pull an image, or build from another file than the one that is shipped.

mod limits;
mod started;

use crate::debian;
use crate::packages::{self, Architecture, base};
use crate::workspace::Workspace;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// The file with all targets, from the root.
const DOCKERFILE: &str = "deploy/images/Dockerfile";
/// The base that it names.
const BASE: &str = "docker.io/library/debian:bookworm-slim";
/// What is built: a target, for a board.
const IMAGES: [(&str, &str); 5] = [
    ("vehicle", PLAIN),
    ("ground", PLAIN),
    ("sim", PLAIN),
    ("vehicle", "pi"),
    ("vehicle", "jetson"),
];
/// No board in particular.
const PLAIN: &str = "plain";
/// A vehicle's image is no larger than this, as it is sent.
const MOST_BYTES: u64 = 60_000_000;

/// What `cargo xtask images` may be told.
#[derive(clap::Args)]
pub struct ImagesArguments {
    /// For these computers [default: both].
    #[arg(long = "arch", value_name = "ARCHITECTURE")]
    architectures: Vec<Architecture>,
}

/// Builds the packages, then the images from them, starts each, says how large it is.
pub fn run(workspace: &Workspace, arguments: &ImagesArguments) -> Result<ExitCode> {
    let wanted = match arguments.architectures.as_slice() {
        [] => vec![Architecture::Amd64, Architecture::Arm64],
        named => named.to_vec(),
    };
    if Command::new("buildah").arg("--version").output().is_err() {
        println!("no buildah found: installing it through apt-get");
        debian::install("buildah").context("install buildah")?;
    }
    packages::build(workspace, &wanted)?;
    for architecture in wanted {
        let builder = Builder::new(workspace, architecture)?;
        builder.base(&base(workspace, architecture)?)?;
        for (target, board) in IMAGES {
            let image = builder.build(target, board)?;
            let bytes = builder.size(&image)?;
            println!("{image} for {architecture}: {:.1} MB compressed", bytes as f64 / 1e6);
            ensure!(
                (target, board) != ("vehicle", PLAIN) || bytes <= MOST_BYTES,
                "that is more than {MOST_BYTES} bytes"
            );
            started::check(&builder, &image, target)?;
            if board != PLAIN {
                started::gives_pictures(&builder, &image)?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// buildah with a store of its own for each architecture.
struct Builder<'w> {
    workspace: &'w Workspace,
    architecture: Architecture,
    store: PathBuf,
}

impl<'w> Builder<'w> {
    fn new(workspace: &'w Workspace, architecture: Architecture) -> Result<Self> {
        let store = workspace.target.join("images").join(architecture.to_string());
        std::fs::create_dir_all(&store)?;
        Ok(Self {
            workspace,
            architecture,
            store,
        })
    }

    /// Without a daemon, without overlays, without namespaces that only some machines have.
    fn buildah(&self) -> Command {
        let mut command = Command::new("buildah");
        command
            // With a root of its own buildah takes no driver from the environment. Overlays stay mounted when it ends.
            .args(["--storage-driver", "vfs", "--root"])
            .arg(self.store.join("root"))
            .arg("--runroot")
            .arg(self.store.join("run"))
            .env("BUILDAH_ISOLATION", "chroot")
            .stdin(Stdio::null());
        command
    }

    fn said(&self, command: &mut Command) -> Result<String> {
        let output = command
            .stderr(Stdio::inherit())
            .output()
            .context("cannot start buildah")?;
        ensure!(output.status.success(), "buildah failed: see above");
        Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Makes an image of a root and tags it with the base's name.
    fn base(&self, root: &Path) -> Result<()> {
        let known = self
            .buildah()
            .args(["images", "-q", BASE])
            .stderr(Stdio::null())
            .output()?;
        if !known.stdout.is_empty() {
            return Ok(());
        }
        println!("making {BASE} for {} of {}", self.architecture, root.display());
        let arch = self.architecture.to_string();
        let working = self.said(self.buildah().args(["from", "--arch", &arch, "scratch"]))?;
        self.said(self.buildah().args(["add", "--quiet", &working]).arg(root).arg("/"))?;
        self.said(
            self.buildah()
                .args(["config", "--arch", &arch, "--cmd", "/bin/sh", &working]),
        )?;
        self.said(self.buildah().args(["commit", "--quiet", "--rm", &working, BASE]))?;
        Ok(())
    }

    /// One target for a board; its name. What a board's base is named stands here for Debian's.
    fn build(&self, target: &str, board: &str) -> Result<String> {
        let version = self.workspace.version()?;
        let image = if board == PLAIN {
            format!("skein-{target}:{version}")
        } else {
            format!("skein-{target}-{board}:{version}")
        };
        let arch = self.architecture.to_string();
        println!("building {image} for {arch}");
        let mut build = self.buildah();
        build
            .args(["build", "--pull-never", "--format", "docker", "--arch", &arch])
            .args(["--build-arg", &format!("TARGETARCH={arch}")])
            .args(["--build-arg", &format!("BOARD={board}")])
            .args(["--build-arg", &format!("JETSON_BASE={BASE}")])
            .args(["--target", target, "--tag", &image, "--file"])
            .arg(self.workspace.root.join(DOCKERFILE))
            .arg(self.workspace.target.join("packages"));
        let ended = build.stdout(Stdio::inherit()).status()?;
        ensure!(ended.success(), "{image} was not built: see above");
        Ok(image)
    }

    /// As it would be sent: every layer compressed.
    fn size(&self, image: &str) -> Result<u64> {
        let folder = self.store.join("pushed");
        if folder.exists() {
            std::fs::remove_dir_all(&folder)?;
        }
        let to = format!("dir:{}", folder.display());
        self.said(
            self.buildah()
                .args(["push", "--quiet", "--compression-format", "gzip", image, &to]),
        )?;
        let files = std::fs::read_dir(&folder)?.flatten();
        let sizes = files.filter_map(|file| file.metadata().ok()).map(|data| data.len());
        let bytes = sizes.sum();
        std::fs::remove_dir_all(&folder)?;
        Ok(bytes)
    }
}
