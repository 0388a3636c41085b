//! Whose topic a topic of a merged recording is: those of nodes other than the first stand below `/nodes/<node>`.
//!
//! Must never do: take a topic of one node for that of another.

use skein_recording::{Recording, Topic};

/// What topics of other nodes begin with.
const NODES: &str = "/nodes/";

/// The name of a topic as another node's.
pub(crate) fn of_node(node: &str, topic: &Topic) -> String {
    format!("{NODES}{node}{topic}")
}

/// The node that a topic is of, `None` for the node of the file, and which topic it is; `None` for one of another program.
pub(crate) fn parse(name: &str) -> Option<(Option<&str>, Topic)> {
    match name.strip_prefix(NODES) {
        Some(rest) => {
            let (node, _) = rest.split_once('/')?;
            let topic = Topic::parse(rest.strip_prefix(node)?)?;
            Some((Some(node), topic))
        }
        None => Topic::parse(name).map(|topic| (None, topic)),
    }
}

/// Whether several nodes are in it.
pub(crate) fn is_merged(recording: &Recording) -> bool {
    recording.topics().any(|(info, _)| info.name.starts_with(NODES))
}
