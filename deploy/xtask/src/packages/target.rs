//! The computers that packages are built for, and what cross-compiling for them needs.
//!
//! Must never do: fall back to the compiler of this computer for another.

use crate::debian;
use anyhow::{Context, Result, bail, ensure};
use std::fmt;
use std::process::{Command, Stdio};

/// As Debian calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Architecture {
    /// Ground stations.
    Amd64,
    /// Jetson and Raspberry Pi.
    Arm64,
}

impl fmt::Display for Architecture {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Amd64 => "amd64",
            Self::Arm64 => "arm64",
        })
    }
}

impl Architecture {
    /// That of the computer this runs on.
    pub fn of_this_computer() -> Result<Self> {
        match std::env::consts::ARCH {
            "x86_64" => Ok(Self::Amd64),
            "aarch64" => Ok(Self::Arm64),
            other => bail!("there are no packages for {other}"),
        }
    }

    /// As the machine calls itself.
    pub fn machine(self) -> &'static str {
        match self {
            Self::Amd64 => "x86_64",
            Self::Arm64 => "aarch64",
        }
    }

    /// As rustc calls it.
    pub fn triple(self) -> &'static str {
        match self {
            Self::Amd64 => "x86_64-unknown-linux-gnu",
            Self::Arm64 => "aarch64-unknown-linux-gnu",
        }
    }

    /// As the compilers of Debian call it.
    fn prefix(self) -> &'static str {
        match self {
            Self::Amd64 => "x86_64-linux-gnu",
            Self::Arm64 => "aarch64-linux-gnu",
        }
    }

    /// The program that reads its programs.
    pub fn objdump(self) -> String {
        format!("{}-objdump", self.prefix())
    }

    /// What cargo, the build scripts of C libraries and cargo-deb look for.
    pub fn environment(self) -> Vec<(String, String)> {
        let (prefix, triple) = (self.prefix(), self.triple());
        let (lower, upper) = (triple.replace('-', "_"), triple.replace('-', "_").to_uppercase());
        vec![
            (format!("CARGO_TARGET_{upper}_LINKER"), format!("{prefix}-gcc")),
            (format!("CC_{lower}"), format!("{prefix}-gcc")),
            (format!("CXX_{lower}"), format!("{prefix}-g++")),
            (format!("AR_{lower}"), format!("{prefix}-ar")),
        ]
    }

    /// Rust's library and the compilers, installed if they are not there and that is possible.
    pub fn prepare(self) -> Result<()> {
        let there = |program: String| {
            let mut command = Command::new(program);
            let status = command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
            status.status().is_ok_and(|status| status.success())
        };
        if !there(format!("{}-g++", self.prefix())) {
            let package = format!("g++-{}", self.prefix().replace('_', "-"));
            println!("no {}-g++ found: installing {package} through apt-get", self.prefix());
            debian::install(&package).with_context(|| format!("install {package}"))?;
        }
        let added = Command::new("rustup").args(["target", "add", self.triple()]).status();
        ensure!(
            added.is_ok_and(|status| status.success()),
            "rustup target add {} failed",
            self.triple()
        );
        Ok(())
    }
}
