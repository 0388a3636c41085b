//! How simulated vehicles are on DDS: in which domain, of which release, under which names.
//!
//! Must never do: name two vehicles of one simulation the same while their system ids differ.

use skein_link_dds::definitions::Release;
use skein_link_dds::naming::Namespace;
use std::collections::BTreeMap;

/// How vehicles are on DDS.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DdsSettings {
    /// The DDS domain, 101 at most: only participants of one domain hear each other.
    pub domain_id: u16,
    /// The release of PX4 whose messages are spoken.
    pub release: Release,
    /// Vehicles of another release, by system id.
    pub others: BTreeMap<u8, Release>,
    /// Where each vehicle's topics are.
    pub namespaces: Namespaces,
}

impl Default for DdsSettings {
    /// The newest release that is known, named as PX4's own simulation names its instances, in domain 0.
    fn default() -> Self {
        let [.., newest] = Release::ALL;
        Self {
            domain_id: 0,
            release: newest,
            others: BTreeMap::new(),
            namespaces: Namespaces::default(),
        }
    }
}

impl DdsSettings {
    /// The release of a vehicle.
    #[must_use]
    pub fn release_of(&self, system_id: u8) -> Release {
        self.others.get(&system_id).copied().unwrap_or(self.release)
    }
}

/// Where vehicles' topics are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Namespaces {
    /// As PX4's own simulation has it: system id 1 is instance 0 and has `/fmu`; system id N + 1 has `/px4_N/fmu`.
    #[default]
    Instances,
    /// System id N has `/px4_N/fmu`.
    SystemIds,
}

impl Namespaces {
    /// Of a vehicle.
    #[must_use]
    pub fn of(self, system_id: u8) -> Namespace {
        let number = match self {
            Self::Instances => system_id.saturating_sub(1),
            Self::SystemIds => system_id,
        };
        let named = (number > 0).then(|| Namespace::new(&format!("px4_{number}")));
        named.flatten().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    //! Names and releases.

    use super::*;

    #[test]
    fn instances_are_named_as_px4_names_them() {
        let name = |namespaces: Namespaces, id| namespaces.of(id).to_string();
        assert_eq!(name(Namespaces::Instances, 1), "/fmu");
        assert_eq!(name(Namespaces::Instances, 4), "/px4_3/fmu");
        assert_eq!(name(Namespaces::SystemIds, 1), "/px4_1/fmu");
    }

    #[test]
    fn the_newest_release_is_spoken_unless_another_is_asked_for() {
        let mut settings = DdsSettings::default();
        assert_eq!(Some(&settings.release), Release::ALL.iter().max());
        settings.others.insert(2, Release::V1_15);
        assert_eq!(settings.release_of(2), Release::V1_15);
        assert_eq!(settings.release_of(3), Release::Later);
    }
}
