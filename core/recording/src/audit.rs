//! The audit: what operators and programs did, each record chained to the one before by a hash, so that none can be changed or taken out
//! without that being seen. Cutting off the end is seen by the next file, whose first record names the last hash of this one.
//!
//! Must never do: hold a secret that was sent along (keys, passwords), or count a record as good whose hash it has not worked out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use skein_view::Audit;
use std::fmt::Write as _;
use thiserror::Error;

/// One link of the chain.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct AuditRecord {
    /// Counts from 0 in each file.
    pub number: u64,
    /// The action.
    #[serde(flatten)]
    pub audit: Audit,
    /// Hash of the record before; of the first one, of the last record of the file before, or zeros.
    pub before: String,
    /// SHA-256 of `number`, the action and `before`, as JSON, in hexadecimal digits.
    pub hash: String,
}

/// The end of a chain that goes on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AuditChain {
    next: u64,
    last: String,
}

/// Where a chain is broken.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Broken {
    /// A record was changed.
    #[error("audit record {number} was changed: its hash is not that of what it says")]
    Changed {
        /// Which.
        number: u64,
    },
    /// A record does not follow on the one before it.
    #[error("audit record {number} does not follow on the record before it: one was taken out, put in or changed")]
    Unlinked {
        /// Which.
        number: u64,
    },
}

/// What the first record of a node's first file names.
const BEGINNING: &str = "0000000000000000000000000000000000000000000000000000000000000000";

impl Default for AuditChain {
    fn default() -> Self {
        Self::after(BEGINNING)
    }
}

impl AuditChain {
    /// A new file's, after the last hash of the file before.
    #[must_use]
    pub fn after(last: &str) -> Self {
        Self {
            next: 0,
            last: last.to_owned(),
        }
    }

    /// The hash of the last record.
    #[must_use]
    pub fn last(&self) -> &str {
        &self.last
    }

    /// Adds an action.
    #[must_use]
    pub fn add(&mut self, audit: Audit) -> AuditRecord {
        let mut record = AuditRecord {
            number: self.next,
            audit,
            before: self.last.clone(),
            hash: String::new(),
        };
        record.hash = record.own_hash();
        self.next += 1;
        self.last.clone_from(&record.hash);
        record
    }

    /// Takes over a record that was read, if it follows. The first of a file may follow on anything.
    ///
    /// # Errors
    /// Where the chain is broken.
    pub fn follow(&mut self, record: &AuditRecord) -> Result<(), Broken> {
        let number = record.number;
        if record.hash != record.own_hash() {
            return Err(Broken::Changed { number });
        }
        let begins = self.next == 0 && number == 0;
        if !begins && (number != self.next || record.before != self.last) {
            return Err(Broken::Unlinked { number });
        }
        self.next = number + 1;
        self.last.clone_from(&record.hash);
        Ok(())
    }
}

impl AuditRecord {
    fn own_hash(&self) -> String {
        let told = (self.number, &self.audit, &self.before);
        // Numbers and text only: JSON has a place for them.
        let bytes = serde_json::to_vec(&told).unwrap_or_default();
        let mut hash = String::with_capacity(64);
        for byte in Sha256::digest(&bytes) {
            let _ = write!(hash, "{byte:02x}");
        }
        hash
    }
}
