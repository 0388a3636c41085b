//! Zones from GeoJSON (RFC 7946) and back. A polygon's outer ring is the zone, holes of an inclusion are exclusions; a point with
//! `radius_m` is a circle; a point of kind `breach_return` is where to come back to.

use super::{FenceFault, FenceFileError, ImportedFences, Refused, checked};
use geojson::{Feature, FeatureCollection, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue, Position};
use serde::de::DeserializeOwned;
use skein_domain::{
    AltitudeReference, BreachReturn, FencePlan, FenceZone, MapPoint, PositionNed, SwarmFrame, ZoneKind, ZoneOutline,
};
use skein_safety::FencePlanError;
use std::collections::BTreeSet;

/// The properties that mean something here.
const KNOWN: [&str; 8] = [
    "name",
    "kind",
    "floor_m",
    "ceiling_m",
    "altitude_reference",
    "action",
    "radius_m",
    "height_m",
];
/// The kind of a point that is no zone.
const BREACH_RETURN: &str = "breach_return";

/// The zones of a GeoJSON text.
pub(super) fn parse(value: JsonValue, stem: &str) -> Result<ImportedFences, Refused> {
    let parsed: GeoJson = serde_json::from_value(value).map_err(|e| Refused::NotThat(e.to_string()))?;
    let features = match parsed {
        GeoJson::FeatureCollection(collection) => collection.features,
        GeoJson::Feature(feature) => vec![feature],
        GeoJson::Geometry(geometry) => vec![geometry.into()],
    };
    let mut imported = ImportedFences::default();
    let mut unknown = BTreeSet::new();
    for (index, feature) in features.iter().enumerate() {
        let zones = of_feature(feature, &format!("{stem} {index}"), &mut imported.plan.breach_return)
            .map_err(|fault| Refused::Part(format!("feature {index}"), fault))?;
        imported.plan.zones.extend(zones);
        let keys = feature.properties.iter().flat_map(JsonObject::keys);
        unknown.extend(keys.filter(|key| !KNOWN.contains(&key.as_str())).cloned());
    }
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.into_iter().collect();
        imported
            .notes
            .push(format!("properties without a meaning here: {}", names.join(", ")));
    }
    Ok(imported)
}

fn of_feature(
    feature: &Feature,
    default_name: &str,
    breach_return: &mut Option<BreachReturn>,
) -> Result<Vec<FenceZone>, FenceFault> {
    let geometry = feature.geometry.as_ref().ok_or(FenceFault::NoGeometry)?;
    let empty = JsonObject::new();
    let properties = feature.properties.as_ref().unwrap_or(&empty);
    if let GeometryValue::Point { coordinates } = &geometry.value
        && properties.get("kind").and_then(JsonValue::as_str) == Some(BREACH_RETURN)
    {
        *breach_return = Some(BreachReturn {
            place: valid_point(coordinates)?,
            height_m: number(properties, "height_m")?,
        });
        return Ok(Vec::new());
    }
    let template = FenceZone {
        name: word(properties, "name", "a text")?.unwrap_or_else(|| default_name.to_owned()),
        kind: word(properties, "kind", "\"inclusion\" or \"exclusion\"")?.unwrap_or(ZoneKind::Inclusion),
        outline: ZoneOutline::Polygon { corners: Vec::new() },
        floor_m: number(properties, "floor_m")?,
        ceiling_m: number(properties, "ceiling_m")?,
        altitude_reference: word(properties, "altitude_reference", "\"origin\" or \"amsl\"")?.unwrap_or_default(),
        action: word(properties, "action", "\"warn\", \"hold\", \"return\" or \"land\"")?.unwrap_or_default(),
    };
    match &geometry.value {
        GeometryValue::Polygon { coordinates } => of_polygon(&template, coordinates),
        GeometryValue::MultiPolygon { coordinates } if coordinates.is_empty() => Err(FenceFault::NoRing),
        GeometryValue::MultiPolygon { coordinates } => {
            let mut zones = Vec::new();
            for (part, rings) in coordinates.iter().enumerate() {
                let mut template = template.clone();
                if coordinates.len() > 1 {
                    template.name = format!("{} ({})", template.name, part + 1);
                }
                zones.extend(of_polygon(&template, rings)?);
            }
            Ok(zones)
        }
        GeometryValue::Point { coordinates } => {
            let radius_m = number(properties, "radius_m")?.ok_or(FenceFault::Missing { key: "radius_m" })?;
            let outline = ZoneOutline::Circle {
                centre: point(coordinates)?,
                radius_m,
            };
            Ok(vec![checked(FenceZone { outline, ..template })?])
        }
        other => Err(FenceFault::Geometry {
            geometry: other.type_name().to_owned(),
        }),
    }
}

/// The zone of the outer ring, then exclusions of the holes.
fn of_polygon(template: &FenceZone, rings: &[Vec<Position>]) -> Result<Vec<FenceZone>, FenceFault> {
    if rings.is_empty() {
        return Err(FenceFault::NoRing);
    }
    if rings.len() > 1 && template.kind == ZoneKind::Exclusion {
        return Err(FenceFault::HoleInExclusion);
    }
    let mut zones = Vec::new();
    for (hole, ring) in rings.iter().enumerate() {
        let mut corners = ring.iter().map(point).collect::<Result<Vec<_>, _>>()?;
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        let mut zone = FenceZone {
            outline: ZoneOutline::Polygon { corners },
            ..template.clone()
        };
        if hole > 0 {
            zone.name = format!("{}, hole {hole}", zone.name);
            zone.kind = ZoneKind::Exclusion;
        }
        zones.push(checked(zone)?);
    }
    Ok(zones)
}

/// Longitude comes first.
fn point(position: &Position) -> Result<MapPoint, FenceFault> {
    match position.as_slice() {
        [longitude_deg, latitude_deg, ..] => Ok(MapPoint::new(*latitude_deg, *longitude_deg)),
        _ => Err(FenceFault::Missing { key: "coordinates" }),
    }
}

fn valid_point(position: &Position) -> Result<MapPoint, FenceFault> {
    let place = point(position)?;
    if place.is_valid() {
        return Ok(place);
    }
    Err(FenceFault::Value {
        key: "coordinates",
        found: format!("{:?}", position.as_slice()),
        expected: "a place on the globe, longitude first",
    })
}

/// A number, if the property is there and not null.
fn number(properties: &JsonObject, key: &'static str) -> Result<Option<f64>, FenceFault> {
    let given = properties.get(key).filter(|value| !value.is_null());
    given
        .map(|value| {
            value.as_f64().ok_or_else(|| FenceFault::Value {
                key,
                found: value.to_string(),
                expected: "a number",
            })
        })
        .transpose()
}

/// A word, if the property is there and not null.
fn word<T: DeserializeOwned>(
    properties: &JsonObject,
    key: &'static str,
    expected: &'static str,
) -> Result<Option<T>, FenceFault> {
    let given = properties.get(key).filter(|value| !value.is_null());
    given
        .map(|value| {
            serde_json::from_value(value.clone()).map_err(|_| FenceFault::Value {
                key,
                found: value.to_string(),
                expected,
            })
        })
        .transpose()
}

/// A plan as GeoJSON text. Zones in the swarm's frame need its origin to be put on the map.
///
/// # Errors
/// [`FenceFileError::Zones`] for a zone that needs an origin where none is given.
pub fn to_geojson(plan: &FencePlan, frame: Option<&SwarmFrame>) -> Result<String, FenceFileError> {
    let mut features = Vec::new();
    for (index, zone) in plan.zones.iter().enumerate() {
        let no_origin = || FencePlanError::NoOrigin {
            index,
            name: zone.name.clone(),
        };
        let on_map = |p: &[f64; 2]| -> Result<MapPoint, FencePlanError> {
            let place = frame
                .ok_or_else(no_origin)?
                .geodetic(&PositionNed::new(p[0], p[1], 0.0));
            Ok(MapPoint::new(place.latitude_deg, place.longitude_deg))
        };
        let (geometry, radius_m) = match &zone.outline {
            ZoneOutline::Polygon { corners } => (polygon(corners), None),
            ZoneOutline::LocalPolygon { corners_m } => {
                let corners: Vec<MapPoint> = corners_m.iter().map(on_map).collect::<Result<_, _>>()?;
                (polygon(&corners), None)
            }
            ZoneOutline::Circle { centre, radius_m } => (GeometryValue::new_point(position(centre)), Some(*radius_m)),
            ZoneOutline::LocalCircle { centre_m, radius_m } => {
                (GeometryValue::new_point(position(&on_map(centre_m)?)), Some(*radius_m))
            }
        };
        features.push(feature(geometry, properties(zone, radius_m)));
    }
    if let Some(back) = &plan.breach_return {
        let mut properties = JsonObject::new();
        properties.insert("kind".to_owned(), BREACH_RETURN.into());
        properties.insert("height_m".to_owned(), back.height_m.into());
        features.push(feature(GeometryValue::new_point(position(&back.place)), properties));
    }
    let collection = GeoJson::from(FeatureCollection::new(features));
    collection.to_string_pretty().map_err(|e| FenceFileError::Unparsable {
        file: "<export>".into(),
        message: e.to_string(),
    })
}

fn feature(geometry: GeometryValue, properties: JsonObject) -> Feature {
    Feature {
        geometry: Some(Geometry::new(geometry)),
        properties: Some(properties),
        ..Feature::default()
    }
}

fn position(place: &MapPoint) -> Position {
    Position::from([place.longitude_deg, place.latitude_deg])
}

/// The ring is closed, as the format asks for.
fn polygon(corners: &[MapPoint]) -> GeometryValue {
    let ring: Vec<Position> = corners.iter().chain(corners.first()).map(position).collect();
    GeometryValue::new_polygon([ring])
}

fn properties(zone: &FenceZone, radius_m: Option<f64>) -> JsonObject {
    let mut properties = JsonObject::new();
    let kind = match zone.kind {
        ZoneKind::Inclusion => "inclusion",
        ZoneKind::Exclusion => "exclusion",
    };
    let reference = match zone.altitude_reference {
        AltitudeReference::Origin => "origin",
        AltitudeReference::Amsl => "amsl",
    };
    let mut put = |key: &str, value: JsonValue| properties.insert(key.to_owned(), value);
    put("name", zone.name.as_str().into());
    put("kind", kind.into());
    put("altitude_reference", reference.into());
    put("action", zone.action.word().into());
    for (key, value) in [
        ("floor_m", zone.floor_m),
        ("ceiling_m", zone.ceiling_m),
        ("radius_m", radius_m),
    ] {
        if let Some(value) = value {
            put(key, value.into());
        }
    }
    properties
}
