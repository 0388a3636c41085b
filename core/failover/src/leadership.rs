//! Whom this node obeys, and whether it coordinates itself.
//!
//! Must never do: obey two holders of one number, or a smaller number than before; let anything out before what it rests on is kept
//! ([`Leadership::obeyed`] must be stored before a beacon or an order that follows from a change is sent).

use crate::{Beacon, Standing, Term};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};
use skein_domain::NodeId;
use thiserror::Error;

/// The leadership, as one node sees it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Leadership {
    me: NodeId,
    standing: Option<Standing>,
    obeyed: Option<Term>,
    /// It holds the obeyed term and acts. False after a restart: the swarm may have gone on meanwhile.
    acting: bool,
}

/// Why a node can't claim the leadership.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ClaimError {
    /// It is no candidate.
    #[error("this node can't coordinate")]
    NotCapable,
    /// It coordinates already.
    #[error("this node coordinates already, in term {number}")]
    HoldsAlready {
        /// In which term.
        number: u64,
    },
    /// There is no number left.
    #[error("terms have come to their end")]
    Exhausted,
}

/// Why an order is not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum OrderError {
    /// Of a coordinator that has been replaced.
    #[error("of term {ordered}, which term {obeyed} has replaced")]
    Old {
        /// The order's.
        ordered: u64,
        /// What is obeyed.
        obeyed: u64,
    },
    /// Of another holder of the same number: this node obeyed the other one first.
    #[error("of a second holder of term {number}")]
    Rival {
        /// The number.
        number: u64,
    },
}

/// A holder's offer of its leadership to another node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, Encode, Decode)]
pub struct Handover {
    /// The holder's term.
    #[n(0)]
    pub term: Term,
    /// Who is to take over.
    #[n(1)]
    pub to: NodeId,
}

impl Leadership {
    /// A node that starts; `obeyed` is the term it had stored, if it ran before. It does not act in a term of its own any more.
    #[must_use]
    pub fn new(me: NodeId, obeyed: Option<Term>) -> Self {
        Self {
            me,
            standing: None,
            obeyed,
            acting: false,
        }
    }

    /// Whose leadership this is.
    #[must_use]
    pub fn node(&self) -> NodeId {
        self.me
    }

    /// Whether and how well this node can coordinate from now on. A holder that can't any more goes on until somebody else claims
    /// the leadership: a poor coordinator is better than none.
    pub fn set_priority(&mut self, priority: Option<u8>) {
        self.standing = priority.map(|priority| Standing {
            priority,
            node: self.me,
        });
    }

    /// How suited it is; none if it can't coordinate.
    #[must_use]
    pub fn standing(&self) -> Option<Standing> {
        self.standing
    }

    /// The term this node obeys. Whenever it has changed it must be stored before anything else leaves the node.
    #[must_use]
    pub fn obeyed(&self) -> Option<Term> {
        self.obeyed
    }

    /// The term in which this node coordinates, if it does.
    #[must_use]
    pub fn acting(&self) -> Option<Term> {
        self.obeyed.filter(|_| self.acting)
    }

    /// Takes a beacon in, from whomever and however old. A holder that meets another of its own number, and is better suited, claims the
    /// next one: those who obey either then obey it.
    pub fn hear(&mut self, beacon: &Beacon) {
        let Some(term) = beacon.obeys else { return };
        self.accept(term);
        let rival = self.acting().is_some_and(|mine| {
            mine.number == term.number && mine.holder.node != term.holder.node && mine.holder > term.holder
        });
        if rival {
            // Without a number left both stay as they are: fenced apart, which is safe.
            let _renewed = self.renew();
        }
    }

    /// Judges an order of this term. A term that is newer than the obeyed one is obeyed from now on.
    ///
    /// # Errors
    ///
    /// It is of an old term, or of a second holder of the obeyed number.
    pub fn order(&mut self, term: Term) -> Result<(), OrderError> {
        self.accept(term);
        match self.obeyed {
            Some(obeyed) if obeyed.number == term.number && obeyed.holder.node == term.holder.node => Ok(()),
            Some(obeyed) if obeyed.number == term.number => Err(OrderError::Rival { number: term.number }),
            obeyed => Err(OrderError::Old {
                ordered: term.number,
                obeyed: obeyed.map_or(0, |obeyed| obeyed.number),
            }),
        }
    }

    /// Takes the leadership: because nobody holds it ([`crate::Turn::Claim`]), it was handed over, or an operator asks for it. A better
    /// priority alone is no reason: nothing here takes the leadership from a holder that is heard, unless somebody asks.
    ///
    /// # Errors
    ///
    /// This node can't coordinate, or does already.
    pub fn claim(&mut self) -> Result<Term, ClaimError> {
        if let Some(mine) = self.acting() {
            return Err(ClaimError::HoldsAlready { number: mine.number });
        }
        self.take_next()
    }

    /// Goes on coordinating under the next number, because some obey another holder of this one.
    ///
    /// # Errors
    ///
    /// This node can't coordinate any more.
    pub fn renew(&mut self) -> Result<Term, ClaimError> {
        self.take_next()
    }

    fn take_next(&mut self) -> Result<Term, ClaimError> {
        let holder = self.standing.ok_or(ClaimError::NotCapable)?;
        let last = self.obeyed.map_or(0, |term| term.number);
        let number = last.checked_add(1).ok_or(ClaimError::Exhausted)?;
        let term = Term { number, holder };
        self.obeyed = Some(term);
        self.acting = true;
        Ok(term)
    }

    /// Offers the leadership to `to`. This node goes on until it hears that the other has claimed it, so that there is no gap.
    #[must_use]
    pub fn hand_over(&self, to: NodeId) -> Option<Handover> {
        self.acting()
            .filter(|_| to != self.me)
            .map(|term| Handover { term, to })
    }

    /// Takes an offer: claims the leadership if it is meant and the offer is of the term it obeys. An old offer is ignored.
    pub fn take_over(&mut self, offer: &Handover) -> Option<Term> {
        self.accept(offer.term);
        if offer.to != self.me || self.obeyed != Some(offer.term) {
            return None;
        }
        self.claim().ok()
    }

    /// Obeys a term of a greater number; keeps to what it has otherwise.
    fn accept(&mut self, term: Term) {
        if self.obeyed.is_none_or(|obeyed| obeyed.number < term.number) {
            self.obeyed = Some(term);
            self.acting = false;
        }
    }
}

#[cfg(test)]
mod tests;
