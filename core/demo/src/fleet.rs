//! What flies in the demonstration: a mixed swarm, or one model that somebody wants to see fly. Every third vehicle could host the coordinator, every third observes with a gimbal and
//! a camera, and each has a radio.

use crate::args::{DemoArguments, DemoLink, FaultPlan};
use skein_config::{AdoptionRule, Isolation, LinkKind, PayloadRule, SystemIdSet};
use skein_domain::SystemId;
use skein_sim::vehicle::ParameterValue;

/// How fast the quadrotors climb and descend at most in a formation, in metres per second.
const VERTICAL_M_S: f64 = 2.5;
/// Pictures of one camera, and of all together, per second at most: to draw them is most of what a large swarm would take of the computer.
const PICTURES_HZ: f64 = 5.0;
const ALL_PICTURES_HZ: f64 = 20.0;

/// Parameters of the simulated vehicles that differ from the autopilot's defaults.
pub fn parameters() -> Vec<(String, ParameterValue)> {
    vec![("MPC_Z_VEL_MAX_DN".into(), ParameterValue::Real(3.0))]
}

/// The adoption rules, one per vehicle.
pub fn rules(arguments: &DemoArguments) -> Vec<AdoptionRule> {
    if !arguments.listen.is_empty() {
        // Nothing is known of them beforehand: neither what they carry nor that they climb quicker than others.
        let any = AdoptionRule::default();
        return vec![AdoptionRule {
            model: arguments.model.clone().unwrap_or(any.model.clone()),
            ..any
        }];
    }
    (1..=arguments.count())
        .map(|system_id| rule(system_id, arguments))
        .collect()
}

fn rule(system_id: u8, arguments: &DemoArguments) -> AdoptionRule {
    let mixed_isolation = arguments.faults == Some(FaultPlan::Plugins);
    let (model, carries): (_, &[&str]) = match (arguments.model.as_deref(), system_id % 3) {
        (Some(model), _) => (model, &["radio"]),
        (None, 1) => ("coordinator-uav", &["radio"]),
        (None, 2) => ("observation-uav", &["gimbal", "camera", "radio"]),
        (None, _) => ("generic-uav", &["radio"]),
    };
    let (links, carries) = match arguments.link {
        DemoLink::Mavlink => (vec![LinkKind::Mavlink], carries),
        DemoLink::Both => (vec![LinkKind::Dds, LinkKind::Mavlink], carries),
        // The simulated payloads speak MAVLink.
        DemoLink::Dds => (vec![LinkKind::Dds], [].as_slice()),
    };
    // Half of the models and of the payloads each way, so that no kind of plugin runs in one way only.
    let isolation = |number: usize| match (mixed_isolation, (usize::from(system_id) / 3 + number) % 2) {
        (true, 1) => Isolation::Child,
        _ => Isolation::InProcess,
    };
    AdoptionRule {
        system_ids: SystemIdSet::one(SystemId(system_id)),
        links,
        model: model.into(),
        // Numbers in a table of tables: nothing in it that the other form could not hold.
        model_config: serde_json::from_value(quick(model)).unwrap_or_default(),
        model_isolation: isolation(usize::from(system_id)),
        payloads: carries
            .iter()
            .enumerate()
            .map(|(i, name)| PayloadRule {
                isolation: isolation(i),
                ..payload(name, arguments.count())
            })
            .collect(),
        ..AdoptionRule::default()
    }
}

/// The demonstration's quadrotors climb and descend quicker than a model assumes of a vehicle it knows nothing of: a detour over another
/// vehicle takes as long as the slower of both. The simulated ones are built for it.
pub fn quick(model: &str) -> serde_json::Value {
    let flight =
        serde_json::json!({ "climb_m_s": VERTICAL_M_S, "descent_m_s": VERTICAL_M_S, "acceleration_m_s2": 3.0 });
    match model {
        "generic-uav" => flight,
        "coordinator-uav" | "observation-uav" => serde_json::json!({ "flight": flight }),
        // Somebody's own model has settings of its own.
        _ => serde_json::json!({}),
    }
}

fn payload(name: &str, vehicles: u8) -> PayloadRule {
    let cameras = f64::from(vehicles / 3).max(1.0);
    let config = match name {
        "camera" => {
            // The page tells how old the pictures are that it shows.
            serde_json::json!({ "source": "synthetic", "rate_hz": PICTURES_HZ.min(ALL_PICTURES_HZ / cameras), "clock": true })
        }
        _ => serde_json::json!({}),
    };
    PayloadRule {
        name: name.into(),
        plugin: name.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: skein_config::Escalation::Degrade,
        config,
    }
}
