//! The ground station's end: the archives that it keeps, and the roll-out that was begun at it.
//!
//! Must never do: run two roll-outs at a time; say that a node has a version which that node has not told of.

use crate::archive;
use crate::incoming::{MOST_ARCHIVE_BYTES, room};
use crate::upgrader::Upgrader;
use parking_lot::Mutex;
use skein_domain::NodeId;
use skein_view::{
    ArchiveInfo, NodeUpgrade, NodeUpgradeState, Rollout, RolloutEnd, RolloutKind, UpgradeRefusal, UpgradeReport,
};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The folder of archives under the node's state folder.
const FOLDER: &str = "archives";

/// What an operator asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RolloutRequest {
    /// To another version, or back.
    pub kind: RolloutKind,
    /// Who asks.
    pub operator: String,
    /// These nodes; all others of the swarm if none are named.
    pub nodes: Option<Vec<NodeId>>,
    /// This node too, as the last one.
    pub this_node: bool,
}

/// The ground station's end.
pub struct Ground {
    upgrader: Arc<Upgrader>,
    folder: PathBuf,
    archives: Mutex<BTreeMap<String, ArchiveInfo>>,
    rollout: Mutex<Option<Rollout>>,
    stop: AtomicBool,
}

fn storage(error: &io::Error) -> UpgradeRefusal {
    UpgradeRefusal::Storage {
        detail: error.to_string(),
    }
}

impl Ground {
    /// Of this node. Archives of an earlier run are not taken up: whoever begins a roll-out says what of.
    #[must_use]
    pub fn new(upgrader: Arc<Upgrader>, state: &Path) -> Self {
        Self {
            upgrader,
            folder: state.join(FOLDER),
            archives: Mutex::default(),
            rollout: Mutex::default(),
            stop: AtomicBool::new(false),
        }
    }

    /// This node's own end.
    #[must_use]
    pub fn upgrader(&self) -> &Arc<Upgrader> {
        &self.upgrader
    }

    /// Everything about upgrades here.
    #[must_use]
    pub fn report(&self) -> UpgradeReport {
        UpgradeReport {
            this_node: self.upgrader.versions(),
            archives: self.archives.lock().values().cloned().collect(),
            rollout: self.rollout.lock().clone(),
        }
    }

    /// A file for an archive that comes in, of so many bytes. To be given to [`Self::keep`].
    ///
    /// # Errors
    /// When a roll-out goes on, it is too large, or the disk too full.
    pub fn incoming(&self, bytes: u64) -> Result<PathBuf, UpgradeRefusal> {
        self.is_free()?;
        if bytes > MOST_ARCHIVE_BYTES {
            let detail = format!("{bytes} bytes are more than {MOST_ARCHIVE_BYTES}");
            return Err(UpgradeRefusal::Damaged { detail });
        }
        std::fs::create_dir_all(&self.folder).map_err(|e| storage(&e))?;
        if self.archives.lock().is_empty() {
            // What an earlier run left.
            for old in std::fs::read_dir(&self.folder).map_err(|e| storage(&e))?.flatten() {
                let _ = std::fs::remove_file(old.path());
            }
        }
        room(&self.folder, bytes)?;
        Ok(self.folder.join("incoming"))
    }

    /// Checks an archive that has come in, and keeps it in place of the one for the same processor. Waits for the disk.
    ///
    /// # Errors
    /// When it is damaged; it is removed then.
    pub fn keep(&self, incoming: &Path) -> Result<ArchiveInfo, UpgradeRefusal> {
        let checked = archive::check(incoming).map_err(|error| UpgradeRefusal::Damaged {
            detail: error.to_string(),
        });
        let (_, info) = checked.inspect_err(|_| drop(std::fs::remove_file(incoming)))?;
        self.is_free()?;
        std::fs::rename(incoming, self.path_of(&info)).map_err(|e| storage(&e))?;
        let before = self.archives.lock().insert(info.architecture.clone(), info.clone());
        if let Some(before) = before.filter(|before| before.digest != info.digest) {
            let _ = std::fs::remove_file(self.path_of(&before));
        }
        Ok(info)
    }

    pub(crate) fn path_of(&self, archive: &ArchiveInfo) -> PathBuf {
        self.folder.join(format!("{}.tar.gz", archive.digest))
    }

    /// The archive for this kind of processor.
    pub(crate) fn archive_for(&self, architecture: &str) -> Option<ArchiveInfo> {
        self.archives.lock().get(architecture).cloned()
    }

    fn is_free(&self) -> Result<(), UpgradeRefusal> {
        let busy = self
            .rollout
            .lock()
            .as_ref()
            .is_some_and(|rollout| rollout.ended.is_none());
        if busy {
            let what = "a roll-out goes on already".into();
            return Err(UpgradeRefusal::Busy { what });
        }
        Ok(())
    }

    /// A roll-out is about to begin: nobody has had a turn yet.
    ///
    /// # Errors
    /// When one goes on already, a node is not known, or there is no archive.
    pub(crate) fn prepare(&self, request: RolloutRequest) -> Result<(), UpgradeRefusal> {
        if request.kind == RolloutKind::Upgrade && self.archives.lock().is_empty() {
            let node = "any node: send one first".into();
            return Err(UpgradeRefusal::NoArchive { node });
        }
        let nodes = self.chosen(&request)?;
        if nodes.is_empty() {
            return Err(UpgradeRefusal::NoNodes);
        }
        {
            let mut rollout = self.rollout.lock();
            if rollout.as_ref().is_some_and(|known| known.ended.is_none()) {
                let what = "a roll-out goes on already".into();
                return Err(UpgradeRefusal::Busy { what });
            }
            self.stop.store(false, Ordering::Release);
            *rollout = Some(Rollout {
                kind: request.kind,
                operator: request.operator,
                nodes,
                ended: None,
            });
        }
        Ok(())
    }

    /// Has a roll-out go no further than the node whose turn it is.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Release);
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// This node's number; 0 if it is in no swarm.
    pub(crate) fn me(&self) -> NodeId {
        let swarm = self.upgrader.shared().swarm.as_ref();
        swarm.map_or(NodeId(0), |swarm| swarm.role().node)
    }

    fn chosen(&self, request: &RolloutRequest) -> Result<Vec<NodeUpgrade>, UpgradeRefusal> {
        let shared = self.upgrader.shared();
        let me = self.me();
        let mut known: BTreeMap<NodeId, String> = BTreeMap::from([(me, shared.config.node.name.clone())]);
        if let Some(swarm) = &shared.swarm {
            let nodes = &swarm.picture().nodes;
            known.extend(nodes.iter().map(|node| (node.node, node.name.clone())));
        }
        let wanted: Vec<NodeId> = match &request.nodes {
            Some(nodes) => nodes.clone(),
            None => known.keys().copied().filter(|node| *node != me).collect(),
        };
        let mut chosen = BTreeMap::new();
        for node in wanted.into_iter().chain(request.this_node.then_some(me)) {
            let name = known.get(&node).cloned().ok_or(UpgradeRefusal::UnknownNode { node })?;
            let waiting = NodeUpgrade {
                node,
                name,
                progress: NodeUpgradeState::Waiting,
                versions: None,
            };
            chosen.insert(node, waiting);
        }
        Ok(chosen.into_values().collect())
    }

    /// Those whose turn has not been yet.
    pub(crate) fn waiting(&self) -> Vec<NodeId> {
        let rollout = self.rollout.lock();
        let nodes = rollout.iter().flat_map(|rollout| &rollout.nodes);
        let waiting = nodes.filter(|node| node.progress == NodeUpgradeState::Waiting);
        waiting.map(|node| node.node).collect()
    }

    /// How far a node is now.
    pub(crate) fn note(&self, node: NodeId, change: impl FnOnce(&mut NodeUpgrade)) {
        let mut rollout = self.rollout.lock();
        let mut nodes = rollout.iter_mut().flat_map(|rollout| &mut rollout.nodes);
        if let Some(known) = nodes.find(|known| known.node == node) {
            change(known);
        }
    }

    /// It has ended; those whose turn has not been are left as they are.
    pub(crate) fn end(&self, end: RolloutEnd) {
        if let Some(rollout) = self.rollout.lock().as_mut() {
            for node in &mut rollout.nodes {
                if node.progress == NodeUpgradeState::Waiting {
                    node.progress = NodeUpgradeState::Skipped;
                }
            }
            rollout.ended = Some(end);
        }
    }
}
