//! The receiver of bulk.
//!
//! Must never do: keep room for something because a chunk says that it is large; hand out one thing twice.

use super::{BulkSettings, Chunk, Have, WINDOW};
use crate::envelope::Boot;
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;

/// Things of one sender that are remembered as ended, so that a chunk sent again begins nothing.
const ENDED: usize = 64;

#[derive(Debug)]
struct Coming {
    of: u32,
    parts: BTreeMap<u32, Vec<u8>>,
    missing: u32,
    bytes: usize,
    progress: NodeTime,
}

#[derive(Debug)]
struct FromOne {
    boot: Boot,
    coming: BTreeMap<u64, Coming>,
    /// How many parts it had, if it came whole.
    ended: BTreeMap<u64, Option<u32>>,
}

/// What one node is receiving.
#[derive(Debug)]
pub struct Receiving {
    settings: BulkSettings,
    from: BTreeMap<NodeId, FromOne>,
}

impl Receiving {
    /// Nothing yet.
    #[must_use]
    pub fn new(settings: BulkSettings) -> Self {
        Self {
            settings,
            from: BTreeMap::new(),
        }
    }

    /// Takes a chunk in. Gives what to tell the sender, and the whole thing with its last chunk.
    pub fn take(&mut self, now: NodeTime, from: NodeId, boot: Boot, chunk: Chunk) -> (Have, Option<Vec<u8>>) {
        let one = self.from.entry(from).or_insert_with(|| FromOne::new(boot));
        if one.boot != boot {
            *one = FromOne::new(boot);
        }
        let id = chunk.id;
        let refused = Have {
            id,
            missing: 0,
            after: 0,
            refused: true,
        };
        if let Some(ended) = one.ended.get(&id) {
            let whole = |of: u32| Have {
                missing: of,
                refused: false,
                ..refused
            };
            return (ended.map_or(refused, whole), None);
        }
        let crowded = one.coming.len() >= self.settings.most_at_once && !one.coming.contains_key(&id);
        if chunk.of == 0 || crowded {
            return (refused, None);
        }
        let coming = one.coming.entry(id).or_insert_with(|| Coming::new(now, chunk.of));
        coming.put(now, chunk);
        if coming.bytes > self.settings.most_bytes {
            one.end(id, None);
            return (refused, None);
        }
        let have = coming.have(id);
        if have.missing < coming.of {
            return (have, None);
        }
        let whole: Vec<u8> = std::mem::take(&mut coming.parts).into_values().flatten().collect();
        one.end(id, Some(have.missing));
        (have, Some(whole))
    }

    /// Forgets what makes no progress.
    pub fn expire(&mut self, now: NodeTime) {
        let limit_s = self.settings.give_up_after_s;
        for one in self.from.values_mut() {
            one.coming
                .retain(|_, coming| now.seconds_since(coming.progress) < limit_s);
        }
    }
}

impl FromOne {
    fn new(boot: Boot) -> Self {
        Self {
            boot,
            coming: BTreeMap::new(),
            ended: BTreeMap::new(),
        }
    }

    fn end(&mut self, id: u64, parts: Option<u32>) {
        self.coming.remove(&id);
        self.ended.insert(id, parts);
        if self.ended.len() > ENDED {
            self.ended.pop_first();
        }
    }
}

impl Coming {
    fn new(now: NodeTime, of: u32) -> Self {
        Self {
            of,
            parts: BTreeMap::new(),
            missing: 0,
            bytes: 0,
            progress: now,
        }
    }

    fn put(&mut self, now: NodeTime, chunk: Chunk) {
        let near = chunk.index >= self.missing && chunk.index - self.missing <= WINDOW;
        if chunk.of != self.of || chunk.index >= self.of || !near || self.parts.contains_key(&chunk.index) {
            return;
        }
        self.progress = now;
        self.bytes += chunk.part.len();
        self.parts.insert(chunk.index, chunk.part);
        while self.parts.contains_key(&self.missing) {
            self.missing += 1;
        }
    }

    fn have(&self, id: u64) -> Have {
        let behind = self.parts.range(self.missing..).map(|(index, _)| index - self.missing);
        let after = behind
            .filter(|by| (1..=WINDOW).contains(by))
            .fold(0, |bits, by| bits | 1 << (by - 1));
        Have {
            id,
            missing: self.missing,
            after,
            refused: false,
        }
    }
}
