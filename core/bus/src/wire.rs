//! What is inside of a sealed datagram: one frame of one of the classes, as CBOR.
//!
//! Must never do: change the meaning of a number; a new kind of frame gets a new one, and what is not known is not understood.

use crate::bulk::{Chunk, Have};
use crate::courier::{Parcel, Receipt};
use crate::latest::{Entry, Key, News};
use crate::links::Report;
use crate::query::{QueryAnswer, Question};
use crate::video::{VideoLost, VideoPart};
use minicbor::{Decode, Encode};

/// One frame.
#[derive(Debug, Clone, PartialEq, Eq, Encode, Decode)]
pub enum Frame {
    /// The newest values of some keys.
    #[n(0)]
    State(#[n(0)] Vec<Entry>),
    /// A command.
    #[n(1)]
    Parcel(#[n(0)] Parcel),
    /// What has been received of commands.
    #[n(2)]
    Receipt(#[n(0)] Receipt),
    /// A question.
    #[n(3)]
    Question(#[n(0)] Question),
    /// Its answer.
    #[n(4)]
    QueryAnswer(#[n(0)] QueryAnswer),
    /// A part of something large.
    #[n(5)]
    Chunk(#[n(0)] Chunk),
    /// What has been received of something large.
    #[n(6)]
    Have(#[n(0)] Have),
    /// How its sender hears the others.
    #[n(7)]
    Report(#[n(0)] Report),
    /// The newest values of some keys, of which some are told as differences.
    #[n(8)]
    News(#[n(0)] News),
    /// Keys of the receiver whose bases its sender lacks.
    #[n(9)]
    Lacks(#[n(0)] Vec<Key>),
    /// A part of a picture of a video.
    #[n(10)]
    VideoPart(#[n(0)] VideoPart),
    /// What its receiver misses.
    #[n(11)]
    VideoLost(#[n(0)] VideoLost),
}

/// What a frame costs beside the body of a command, question, answer or chunk, at most.
pub const FRAME_BYTES: usize = 64;

impl Frame {
    /// As bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        // Writing into memory does not fail.
        minicbor::to_vec(self).unwrap_or_default()
    }

    /// From bytes; none if they are no frame that is known.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        minicbor::decode(bytes).ok()
    }
}
