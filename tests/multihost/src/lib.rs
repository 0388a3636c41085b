//! The real program on several hosts: each in a network namespace of this machine, with an address of its own, joined by an air that
//! this crate makes worse on purpose; judged by what the simulators know. What each part is for:
//!
//! | part | what |
//! |---|---|
//! | [`net`] | the hosts' namespaces, the devices in them, and how nothing of them is left behind |
//! | [`relay`] | what is between the hosts: loss, delay, jitter, doubles, overtaking, one-way links, partitions |
//! | [`host`] | one host: its node, its simulated vehicle, their ends and new starts |
//! | [`compose`] | the commands of a compose file |
//! | [`field`] | all hosts of a flight together |
//! | [`operator`] | what a person does over HTTP |
//! | [`mission`] | the parts of a flight, each given by the operator and waited for in the truth |
//! | [`judge`] | whether it went well |
//!
//! Must never do: reach into a node. It gets a configuration file, datagrams, HTTP requests and signals, as in the field.
#![forbid(unsafe_code)]

pub mod compose;
pub mod field;
pub mod host;
pub mod judge;
pub mod mission;
pub mod net;
pub mod operator;
pub mod relay;
