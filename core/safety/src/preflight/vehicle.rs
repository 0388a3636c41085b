//! The items of one vehicle.

use super::{Subject, Unit, must_be};
use crate::gnss::{disagreement_m, is_good_fix};
use skein_domain::preflight::PreflightSettings;
use skein_domain::{
    FlightMode, GnssFix, ItemStatus, LandedState, LinkHealth, NodeTime, PreflightItem, PreflightReport, Telemetry,
    VehicleId,
};

/// A named part and whether it runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedRunning {
    /// Its name.
    pub name: String,
    /// It runs.
    pub running: bool,
}

/// What is known of a vehicle before it is armed. [`VehicleChecks::observed`] fills in what its telemetry tells; what is left at
/// `None` or `false` is taken for not known, and so is not good.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VehicleChecks {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// It is heard.
    pub connected: bool,
    /// Share of frames lost.
    pub loss: Option<f64>,
    /// Its mode.
    pub mode: FlightMode,
    /// What its autopilot says of arming.
    pub ready_to_arm: Option<bool>,
    /// Why not, if it says.
    pub not_ready_because: Option<String>,
    /// Age of its newest position in seconds; absent without one.
    pub position_age_s: Option<f64>,
    /// Its estimator says that it knows where it is; absent if it says nothing of itself.
    pub estimator_good: Option<bool>,
    /// Kind of satellite fix.
    pub gnss_fix: GnssFix,
    /// Satellites used.
    pub satellites: Option<u8>,
    /// How far two sources of its position are apart, in metres; absent if there are no two.
    pub disagreement_m: Option<f64>,
    /// Remaining charge as a share of a full battery.
    pub battery: Option<f64>,
    /// Share of a full battery that the asked flight takes, with the way home and the reserve; absent if none was asked for.
    pub flight_needs: Option<f64>,
    /// The autopilot has a launch place.
    pub home_known: bool,
    /// It stands inside of all fences: `None` without a fence, or without a position.
    pub inside_fence: Option<bool>,
    /// There is a fence.
    pub has_fence: bool,
    /// What its land detector says.
    pub landed: LandedState,
    /// It is armed and not on the ground: what is asked of a vehicle that stands does not apply.
    pub airborne: bool,
    /// How fast it moves, in metres per second.
    pub speed_m_s: Option<f64>,
    /// How unsure the offset between its clock and the node's is, in seconds; absent if the offset is not known.
    pub clock_error_s: Option<f64>,
    /// The plugin that flies it.
    pub model: Option<NamedRunning>,
    /// Its payloads.
    pub payloads: Vec<NamedRunning>,
    /// Its limits (speeds, accelerations) and parameters have been read.
    pub limits_known: Option<bool>,
    /// Who else uses its system id.
    pub system_id: SystemIdUse,
    /// Alarms of its failsafe policy that stand now and would do more than warn once it is in the air, in words; `None` if nobody watches it.
    pub alarms: Option<Vec<String>>,
}

/// Who uses a vehicle's system id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SystemIdUse {
    /// The vehicle alone.
    #[default]
    Alone,
    /// Another sender at another place: what is sent goes to the vehicle alone.
    Elsewhere,
    /// Another vehicle at the same place: what is sent reaches both.
    Shared,
}

impl VehicleChecks {
    /// What telemetry and link tell. The rest is the caller's: why it is not ready, the asked flight, the fence, model, payloads,
    /// limits, duplicate ids.
    #[must_use]
    pub fn observed(vehicle: VehicleId, telemetry: &Telemetry, link: &LinkHealth, now: NodeTime) -> Self {
        let t = telemetry;
        let airborne = t.armed && t.landed != LandedState::OnGround;
        let has_position = t.local.is_some_and(|p| p.is_finite()) && t.global.is_some_and(|g| g.is_valid());
        Self {
            vehicle,
            connected: link.connected,
            loss: Some(f64::from(link.loss)),
            mode: t.mode,
            ready_to_arm: t.ready_to_arm,
            position_age_s: has_position.then(|| now.seconds_since(t.position_time).max(0.0)),
            estimator_good: t.estimator.map(|estimator| estimator.is_position_good(airborne)),
            gnss_fix: t.gnss.fix,
            satellites: (t.gnss.fix != GnssFix::Unknown).then_some(t.gnss.satellites),
            disagreement_m: disagreement_m(t, now),
            battery: t.battery.remaining.map(f64::from),
            home_known: t.home.is_some_and(|h| h.is_valid()),
            landed: t.landed,
            airborne,
            speed_m_s: t.velocity.map(|v| v.norm()),
            // Half the way there and back is what the offset can be wrong by.
            clock_error_s: link
                .clock_offset_s
                .filter(|offset_s| offset_s.is_finite())
                .and(link.round_trip_s)
                .map(|round_trip_s| 0.5 * f64::from(round_trip_s)),
            ..Self::default()
        }
    }
}

/// The report on one vehicle. Items of plugins are added to it by the caller.
#[must_use]
pub fn vehicle_report(checks: &VehicleChecks, settings: &PreflightSettings, now: NodeTime) -> PreflightReport {
    let mut items = link_items(checks, settings);
    items.extend(position_items(checks, settings));
    items.extend(energy_items(checks, settings));
    items.extend(place_items(checks, settings));
    items.extend(part_items(checks, settings));
    PreflightReport {
        vehicle: Some(checks.vehicle),
        items,
        made_at: now,
    }
}

fn link_items(c: &VehicleChecks, s: &PreflightSettings) -> Vec<PreflightItem> {
    let link = Subject::new("link", "Link").because("what is not heard cannot be commanded, nor stopped");
    let loss = Subject::new("link_loss", "Frames lost").because("commands and positions come late or not at all");
    let duplicate =
        Subject::new("duplicate_system_id", "System id of its own").because("a command would reach two vehicles");
    let ready = Subject::new("ready_to_arm", "Autopilot ready").because("the autopilot's own checks");
    // In such a mode it says that it is not ready whatever its checks find. The mode is left before it is armed, and its word is waited for.
    let of_the_mode = c.ready_to_arm == Some(false) && !c.mode.arms_by_command();
    let ready_value = match (c.ready_to_arm, &c.not_ready_because) {
        (Some(true), _) => "ready".to_owned(),
        (Some(false), _) if of_the_mode => format!("not in mode {}, which is left before arming", c.mode),
        (Some(false), Some(why)) => format!("not ready: {why}"),
        (Some(false), None) => "not ready".to_owned(),
        (None, _) => "not known".to_owned(),
    };
    let ready_status = if of_the_mode {
        ItemStatus::Amber
    } else {
        must_be(c.ready_to_arm)
    };
    vec![
        link.word(must_be(Some(c.connected)), if c.connected { "heard" } else { "lost" }),
        loss.at_most(c.loss, s.loss_amber_share, s.loss_red_share, Unit::SHARE),
        match c.system_id {
            SystemIdUse::Alone => duplicate.word(ItemStatus::Green, "unique"),
            SystemIdUse::Elsewhere => duplicate.word(
                ItemStatus::Amber,
                "used by another sender as well, to which nothing is sent",
            ),
            SystemIdUse::Shared => duplicate.word(ItemStatus::Red, "used twice"),
        },
        ready.word(ready_status, ready_value),
    ]
}

fn position_items(c: &VehicleChecks, s: &PreflightSettings) -> Vec<PreflightItem> {
    let position =
        Subject::new("position", "Position estimate").because("separation, fence and way home are reckoned from it");
    let fix = Subject::new("gnss_fix", "Satellite fix").because("the position drifts away without one");
    let satellites =
        Subject::new("gnss_satellites", "Satellites").because("with few of them the fix is lost at the first turn");
    let agreement = Subject::new("gnss_agreement", "Sources of the position agree")
        .because("one of them is wrong, and it is not known which");
    let position_item = match (c.estimator_good, c.position_age_s) {
        (Some(false), _) => position.word(ItemStatus::Red, "the estimator does not know where it is"),
        (_, age_s) => position.at_most(age_s, s.position_within_s, s.position_within_s, Unit::SECONDS),
    };
    let mut items = vec![position_item];
    if c.gnss_fix == GnssFix::Unknown && !s.require_gnss {
        items.push(fix.word(ItemStatus::Amber, "no receiver"));
    } else {
        items.push(fix.word(must_be(Some(is_good_fix(c.gnss_fix))), c.gnss_fix.word()));
        let least = f64::from(s.min_satellites);
        items.push(satellites.at_least(c.satellites.map(f64::from), least, least, Unit::COUNT));
    }
    items.push(match c.disagreement_m {
        // Nothing to compare with is no fault.
        None => agreement.word(ItemStatus::Green, "one source"),
        some => agreement.at_most(some, s.max_disagreement_m, s.max_disagreement_m, Unit::METRES),
    });
    items
}

fn energy_items(c: &VehicleChecks, s: &PreflightSettings) -> Vec<PreflightItem> {
    let level = Subject::new("battery", "Charge").because("there must be enough to come back from any flight");
    let flight = Subject::new("battery_for_flight", "Charge for the asked flight")
        .because("flight, way home and reserve must be paid for");
    let mut items = vec![level.at_least(c.battery, s.full_battery_share, s.min_battery_share, Unit::SHARE)];
    if let Some(needs) = c.flight_needs {
        items.push(flight.at_least(c.battery, needs, needs, Unit::SHARE));
    }
    items
}

fn place_items(c: &VehicleChecks, s: &PreflightSettings) -> Vec<PreflightItem> {
    let home = Subject::new("home", "Launch place").because("without one there is no way home");
    let fence =
        Subject::new("inside_fence", "Inside of the fence").because("a flight must not begin where it may not be");
    let ground = Subject::new("on_ground", "On the ground").because("only what stands is armed");
    let still = Subject::new("not_moving", "Stands still")
        .because("a vehicle that is carried, or whose estimate drifts, is not ready");
    let (fence_status, fence_value) = match (c.has_fence, c.inside_fence) {
        (false, _) => (ItemStatus::Green, "no fence"),
        (true, Some(true)) => (ItemStatus::Green, "inside"),
        (true, Some(false)) => (ItemStatus::Red, "outside"),
        (true, None) => (ItemStatus::Red, "not known"),
    };
    let in_flight = |subject: Subject| subject.word(ItemStatus::NotApplicable, "in flight");
    let on_ground = ground.word(must_be(Some(c.landed == LandedState::OnGround)), c.landed.word());
    let limit_m_s = s.max_ground_speed_m_s;
    let stands = still.at_most(c.speed_m_s, limit_m_s, limit_m_s, Unit::METRES_PER_S);
    vec![
        home.word(
            must_be(Some(c.home_known)),
            if c.home_known { "known" } else { "not known" },
        ),
        fence.word(fence_status, fence_value),
        if c.airborne { in_flight(ground) } else { on_ground },
        if c.airborne { in_flight(still) } else { stands },
    ]
}

fn part_items(c: &VehicleChecks, s: &PreflightSettings) -> Vec<PreflightItem> {
    let clock = Subject::new("clock", "Clock")
        .because("the age of positions, and so where vehicles are now, is reckoned from it");
    let model = Subject::new("model", "Model").because("the plugin that flies the vehicle");
    let payloads = Subject::new("payloads", "Payloads").because("what the vehicle carries is to work");
    let alarms = Subject::new("alarms", "No alarm that would act in flight")
        .because("it would be held or called home as soon as it is in the air");
    let alarms_item = match &c.alarms {
        Some(standing) if standing.is_empty() => alarms.word(ItemStatus::Green, "none"),
        Some(standing) => alarms.word(ItemStatus::Red, standing.join("; ")),
        None => alarms.word(ItemStatus::Red, "not known"),
    };
    let limits =
        Subject::new("limits", "Limits and parameters").because("what the vehicle can fly bounds what it is asked");
    let model_item = match &c.model {
        Some(m) if m.running => model.word(ItemStatus::Green, m.name.clone()),
        Some(m) => model.word(ItemStatus::Red, format!("{} is not running", m.name)),
        None => model.word(ItemStatus::Red, "none"),
    };
    let missing: Vec<&str> = c
        .payloads
        .iter()
        .filter(|p| !p.running)
        .map(|p| p.name.as_str())
        .collect();
    let payload_item = if missing.is_empty() {
        payloads.word(ItemStatus::Green, format!("{} running", c.payloads.len()))
    } else {
        payloads.word(ItemStatus::Red, format!("not running: {}", missing.join(", ")))
    };
    let limits_item = match c.limits_known {
        Some(true) => limits.word(ItemStatus::Green, "known"),
        Some(false) => limits.word(ItemStatus::Red, "not known"),
        // Configured ones are flown by: an operator should know.
        None => limits.word(ItemStatus::Amber, "as configured"),
    };
    vec![
        clock.at_most(c.clock_error_s, s.max_clock_error_s, s.max_clock_error_s, Unit::SECONDS),
        model_item,
        payload_item,
        limits_item,
        alarms_item,
    ]
}
