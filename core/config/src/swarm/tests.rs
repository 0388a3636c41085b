//! What a member of a swarm needs, and what contradicts itself.

use crate::NodeConfig;

fn problems(swarm: &str) -> Vec<String> {
    match NodeConfig::parse(&format!("[swarm]\n{swarm}")) {
        Ok(_) => Vec::new(),
        Err(error) => error
            .to_string()
            .lines()
            .skip(1)
            .map(|line| line.trim().to_owned())
            .collect(),
    }
}

#[test]
fn a_member_of_a_swarm_needs_an_id_a_number_and_a_secret() {
    assert_eq!(problems(""), Vec::<String>::new(), "a node alone needs none of it");
    let all = problems("id = \"field 7\"");
    let keys: Vec<&str> = all.iter().filter_map(|line| line.split(':').next()).collect();
    assert_eq!(keys, ["swarm.id", "swarm.node", "swarm.secret_file"]);
    assert!(problems("id = \"field-7\"\nnode = 3\nsecret_file = \"key\"").is_empty());
}

#[test]
fn values_that_contradict_each_other_are_named() {
    let member = "id = \"f\"\nnode = 3\nsecret_file = \"key\"\n";
    for (more, key) in [
        ("observer = true\ncoordinator_priority = 3", "swarm.observer"),
        ("transports = []", "swarm.transports"),
        ("transports = [\"dds\", \"dds\"]", "swarm.transports"),
        ("lost_after_s = 0.01", "swarm.lost_after_s"),
        ("max_bytes_per_s = 1", "swarm.max_bytes_per_s"),
        ("members = 0", "swarm.members"),
    ] {
        let all = problems(&format!("{member}{more}"));
        assert!(all.iter().any(|line| line.starts_with(key)), "{more}: {all:?}");
    }
}
