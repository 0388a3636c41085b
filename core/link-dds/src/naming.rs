//! Names of topics: whose they are, which message, which version.
//!
//! Must never do: take a topic for a vehicle's that is not exactly of the form that PX4 and its agent give it.
//!
//! As DDS writes them: `rt/fmu/out/vehicle_status_v1`, with a namespace `rt/px4_3/fmu/out/vehicle_status_v1`.

use std::fmt;

/// What ROS 2 puts in front of the names of topics.
const ROS_TOPIC: &str = "rt/";
/// Longest namespace that is looked at.
const NAMESPACE_MAX: usize = 64;

/// Where a vehicle's topics are: what stands in front of `/fmu`, empty for the first instance of PX4.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Namespace(String);

impl Namespace {
    /// Of this name, if it can be one: letters, digits and underscores, in parts with a slash between them.
    #[must_use]
    pub fn new(name: &str) -> Option<Self> {
        let good = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        let whole = name.is_empty() || name.split('/').all(good);
        (whole && name.len() <= NAMESPACE_MAX).then(|| Self(name.to_owned()))
    }

    /// The name, without slashes around it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0
    }
}

/// As ROS 2 writes it in front of a topic.
impl fmt::Display for Namespace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            f.write_str("/fmu")
        } else {
            write!(f, "/{}/fmu", self.0)
        }
    }
}

/// Who writes a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// PX4.
    Out,
    /// We.
    In,
}

/// One topic of one vehicle.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TopicName {
    /// Whose.
    pub namespace: Namespace,
    /// Who writes it.
    pub direction: Direction,
    /// The topic without its version, for example `vehicle_status`.
    pub base: String,
    /// Version of the message: 0 without a suffix.
    pub version: u32,
}

impl TopicName {
    /// Of a name as DDS writes it; `None` if it is no topic of a PX4.
    #[must_use]
    pub fn parse(dds_name: &str) -> Option<Self> {
        let name = dds_name.strip_prefix(ROS_TOPIC)?;
        let (before, topic) = name.rsplit_once('/')?;
        let (before, direction) = match before.rsplit_once('/')? {
            (before, "out") => (before, Direction::Out),
            (before, "in") => (before, Direction::In),
            _ => return None,
        };
        let namespace = match before.strip_suffix("/fmu") {
            // With a slash but without a name it is not what ROS 2 would write.
            Some("") => return None,
            Some(namespace) => namespace,
            None if before == "fmu" => "",
            None => return None,
        };
        let namespace = Namespace::new(namespace)?;
        let (base, version) = versioned(topic);
        (!base.is_empty()).then(|| Self {
            namespace,
            direction,
            base: base.to_owned(),
            version,
        })
    }

    /// As DDS writes it.
    #[must_use]
    pub fn dds_name(&self) -> String {
        let namespace = self.namespace.name();
        let slash = if namespace.is_empty() { "" } else { "/" };
        format!("{ROS_TOPIC}{namespace}{slash}fmu/{}", self.short())
    }

    fn short(&self) -> String {
        let direction = match self.direction {
            Direction::Out => "out",
            Direction::In => "in",
        };
        let (base, version) = (&self.base, self.version);
        if version == 0 {
            format!("{direction}/{base}")
        } else {
            format!("{direction}/{base}_v{version}")
        }
    }
}

/// As ROS 2 writes it.
impl fmt::Display for TopicName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.namespace, self.short())
    }
}

/// A topic's name and the version at its end. `_v0` is none: PX4 writes version 0 without a suffix.
fn versioned(topic: &str) -> (&str, u32) {
    let Some((base, digits)) = topic.rsplit_once("_v") else {
        return (topic, 0);
    };
    let canonical = !digits.starts_with('0') && digits.bytes().all(|b| b.is_ascii_digit());
    match digits.parse() {
        Ok(version) if canonical => (base, version),
        _ => (topic, 0),
    }
}

/// What DDS calls the type of a message of `px4_msgs`.
#[must_use]
pub fn type_name(message: &str) -> String {
    format!("px4_msgs::msg::dds_::{message}_")
}

#[cfg(test)]
mod tests {
    //! What is a vehicle's topic, and what only looks like one.

    use super::*;
    use proptest::prelude::*;

    #[test]
    fn topics_of_the_first_and_of_other_instances_are_read() {
        let first = TopicName::parse("rt/fmu/out/vehicle_status").unwrap();
        assert_eq!(
            (first.namespace.name(), first.base.as_str(), first.version),
            ("", "vehicle_status", 0)
        );
        let third = TopicName::parse("rt/px4_3/fmu/in/trajectory_setpoint_v12").unwrap();
        assert_eq!(third.direction, Direction::In);
        assert_eq!(
            (third.namespace.name(), third.base.as_str(), third.version),
            ("px4_3", "trajectory_setpoint", 12)
        );
        assert_eq!(third.to_string(), "/px4_3/fmu/in/trajectory_setpoint_v12");
        let deep = TopicName::parse("rt/swarm/uav1/fmu/out/home_position").unwrap();
        assert_eq!(deep.namespace.name(), "swarm/uav1");
    }

    #[test]
    fn a_suffix_that_is_no_version_belongs_to_the_name() {
        for name in ["x_v0", "x_v01", "x_v", "x_vtol", "x_v99999999999999", "x_v+1"] {
            let topic = TopicName::parse(&format!("rt/fmu/out/{name}")).unwrap();
            assert_eq!((topic.base.as_str(), topic.version), (name, 0));
        }
    }

    #[test]
    fn other_topics_are_nobodys() {
        for name in [
            "",
            "rt/",
            "rt/fmu/out",
            "rt/fmu/out/",
            "fmu/out/x",
            "rt//fmu/out/x",
            "rt/a b/fmu/out/x",
            "rt/xfmu/out/x",
            "rt/fmu/through/x",
            "rq/fmu/out/x",
            "rt/px4_1/out/x",
            "rt/fmu/out/a/b",
        ] {
            assert_eq!(TopicName::parse(name), None, "{name}");
        }
    }

    proptest! {
        #[test]
        fn what_is_read_is_written_the_same(name in "(rt/)?([a-z0-9_]{0,6}/){0,2}fmu/(in|out)/[a-z_]{0,8}(_v[0-9]{0,3})?") {
            if let Some(topic) = TopicName::parse(&name) {
                prop_assert_eq!(topic.dds_name(), name);
            }
        }

        #[test]
        fn anything_is_survived(name in any::<String>()) {
            let _ = TopicName::parse(&name);
        }
    }
}
