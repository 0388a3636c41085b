//! Where an instance runs, and what a child process may use.

use serde::Serialize;

/// Where an instance runs. The library is the same in both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Isolation {
    /// On a watched thread of this process: fastest. What ends a process (an abort, a segmentation fault, a stack overflow) ends
    /// this one.
    InProcess,
    /// In a process of its own, within limits. Nothing it does ends this one.
    Child(ChildLimits),
}

impl Isolation {
    /// Whether it is a process of its own.
    #[must_use]
    pub const fn is_child(&self) -> bool {
        matches!(self, Self::Child(_))
    }
}

/// What a child process may use.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChildLimits {
    /// Address space beyond what the bare process has, in mebibytes; frame buffers do not count. An allocation beyond it fails, which
    /// ends most programs.
    pub memory_mib: u64,
    /// Share of one core over 10 s, 1 being a whole one. With more the process is ended.
    pub cpu_share: f64,
    /// Open files, sockets and the like.
    pub open_files: u64,
}

impl Default for ChildLimits {
    fn default() -> Self {
        Self {
            memory_mib: 256,
            cpu_share: 0.5,
            open_files: 64,
        }
    }
}
