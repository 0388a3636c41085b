//! Zones from the `.plan` files of QGroundControl: `geoFence` of version 2 with its polygons, circles and breach return point. They have
//! no heights. The mission and the rally points are other people's business.

use super::{FenceFault, ImportedFences, Refused, checked};
use serde_json::Value;
use skein_domain::{AltitudeReference, BreachAction, BreachReturn, FenceZone, MapPoint, ZoneKind, ZoneOutline};

/// The version of `geoFence` that has circles and several polygons.
const GEOFENCE_VERSION: u64 = 2;
/// The version of the file, and of each polygon and circle.
const VERSION: u64 = 1;

/// The zones of a plan.
pub(super) fn parse(plan: &Value, stem: &str) -> Result<ImportedFences, Refused> {
    let at = |part: &str| {
        let part = part.to_owned();
        move |fault: FenceFault| Refused::Part(part, fault)
    };
    if plan.get("fileType").and_then(Value::as_str) != Some("Plan") {
        return Err(at("the file")(value_fault(
            "fileType",
            plan.get("fileType"),
            "\"Plan\"",
        )));
    }
    version(plan, VERSION, "1").map_err(at("the file"))?;
    let fence = plan.get("geoFence").ok_or(FenceFault::Missing { key: "geoFence" });
    let fence = fence.map_err(at("the file"))?;
    version(fence, GEOFENCE_VERSION, "2").map_err(at("geoFence"))?;
    let mut imported = ImportedFences::default();
    for (index, entry) in list(fence, "polygons").map_err(at("geoFence"))?.iter().enumerate() {
        let name = format!("{stem} polygon {index}");
        let zone = zone(entry, name, polygon).map_err(at(&format!("geoFence.polygons[{index}]")))?;
        imported.plan.zones.push(zone);
    }
    for (index, entry) in list(fence, "circles").map_err(at("geoFence"))?.iter().enumerate() {
        let name = format!("{stem} circle {index}");
        let zone = zone(entry, name, circle).map_err(at(&format!("geoFence.circles[{index}]")))?;
        imported.plan.zones.push(zone);
    }
    if let Some(back) = fence.get("breachReturn").filter(|value| !value.is_null()) {
        imported.plan.breach_return = Some(breach_return(back).map_err(at("geoFence.breachReturn"))?);
    }
    imported.notes = notes(plan, &imported);
    Ok(imported)
}

fn notes(plan: &Value, imported: &ImportedFences) -> Vec<String> {
    let count = |of: &str, list: &str| {
        let items = plan.get(of).and_then(|part| part.get(list)).and_then(Value::as_array);
        items.map_or(0, Vec::len)
    };
    let mut notes = Vec::new();
    let (items, points) = (count("mission", "items"), count("rallyPoints", "points"));
    if items > 0 {
        notes.push(format!("its mission of {items} items is not taken"));
    }
    if points > 0 {
        notes.push(format!("its {points} rally points are not taken"));
    }
    if imported.plan.zones.is_empty() {
        notes.push("it has no fence".to_owned());
    } else {
        notes.push("its zones have no floor and no ceiling: plans know none".to_owned());
    }
    notes
}

fn zone(
    entry: &Value,
    name: String,
    outline: impl Fn(&Value) -> Result<ZoneOutline, FenceFault>,
) -> Result<FenceZone, FenceFault> {
    version(entry, VERSION, "1")?;
    let inclusion = entry.get("inclusion");
    let kind = match inclusion.and_then(Value::as_bool) {
        Some(true) => ZoneKind::Inclusion,
        Some(false) => ZoneKind::Exclusion,
        None => return Err(value_fault("inclusion", inclusion, "true or false")),
    };
    checked(FenceZone {
        name,
        kind,
        outline: outline(entry)?,
        floor_m: None,
        ceiling_m: None,
        altitude_reference: AltitudeReference::Origin,
        action: BreachAction::default(),
    })
}

fn polygon(entry: &Value) -> Result<ZoneOutline, FenceFault> {
    let corners = list(entry, "polygon")?
        .iter()
        .map(|corner| place("polygon", corner))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(ZoneOutline::Polygon { corners })
}

fn circle(entry: &Value) -> Result<ZoneOutline, FenceFault> {
    let circle = entry.get("circle").ok_or(FenceFault::Missing { key: "circle" })?;
    let centre = circle.get("center").ok_or(FenceFault::Missing { key: "center" })?;
    let radius = circle.get("radius");
    let radius_m = radius.and_then(Value::as_f64);
    Ok(ZoneOutline::Circle {
        centre: place("center", centre)?,
        radius_m: radius_m.ok_or_else(|| value_fault("radius", radius, "a number of metres"))?,
    })
}

fn breach_return(value: &Value) -> Result<BreachReturn, FenceFault> {
    let place = place("breachReturn", value)?;
    if !place.is_valid() {
        return Err(value_fault("breachReturn", Some(value), "a place on the globe"));
    }
    Ok(BreachReturn {
        place,
        height_m: value.get(2).and_then(Value::as_f64),
    })
}

/// Latitude comes first.
fn place(key: &'static str, value: &Value) -> Result<MapPoint, FenceFault> {
    let number = |index: usize| value.get(index).and_then(Value::as_f64);
    match (number(0), number(1)) {
        (Some(latitude_deg), Some(longitude_deg)) => Ok(MapPoint::new(latitude_deg, longitude_deg)),
        _ => Err(value_fault(key, Some(value), "latitude and longitude")),
    }
}

fn list<'a>(of: &'a Value, key: &'static str) -> Result<&'a Vec<Value>, FenceFault> {
    let value = of.get(key);
    value
        .and_then(Value::as_array)
        .ok_or_else(|| value_fault(key, value, "a list"))
}

fn version(of: &Value, known: u64, expected: &'static str) -> Result<(), FenceFault> {
    let found = of.get("version");
    if found.and_then(Value::as_u64) == Some(known) {
        Ok(())
    } else {
        Err(value_fault("version", found, expected))
    }
}

/// A value that is not what it must be, or is missing.
fn value_fault(key: &'static str, found: Option<&Value>, expected: &'static str) -> FenceFault {
    match found {
        None => FenceFault::Missing { key },
        Some(value) => FenceFault::Value {
            key,
            // A damaged file must not make a message of megabytes.
            found: value.to_string().chars().take(60).collect(),
            expected,
        },
    }
}
