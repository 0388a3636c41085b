//! Fence files: what is taken, what is refused and with which words, and that nothing makes the importers panic.

use super::*;
use proptest::prelude::*;
use serde_json::{Value, json};
use skein_domain::{BreachReturn, PositionNed};

const ORIGIN: Geodetic = Geodetic {
    latitude_deg: 47.397_742,
    longitude_deg: 8.545_594,
    altitude_amsl_m: 488.0,
};

fn parse(value: &Value) -> Result<ImportedFences, FenceFileError> {
    parse_fences(&value.to_string(), Path::new("site/field.geojson"))
}

fn refused(value: &Value) -> String {
    parse(value).expect_err("refused").to_string()
}

/// A closed square ring, longitude first.
fn ring(longitude: f64, latitude: f64, half: f64) -> Value {
    let corner = |x: f64, y: f64| json!([longitude + x * half, latitude + y * half]);
    json!([
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
        corner(-1.0, -1.0)
    ])
}

fn feature(geometry: &Value, properties: &Value) -> Value {
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

fn collection(features: &[Value]) -> Value {
    json!({ "type": "FeatureCollection", "features": features })
}

fn field() -> Value {
    let polygon = json!({ "type": "Polygon", "coordinates": [ring(8.545, 47.397, 0.005), ring(8.545, 47.397, 0.001)] });
    feature(
        &polygon,
        &json!({ "name": "field", "floor_m": -5, "ceiling_m": 120.5, "action": "land", "stroke": "#f00" }),
    )
}

fn circle(properties: &Value) -> Value {
    feature(
        &json!({ "type": "Point", "coordinates": [8.55, 47.4, 12.0] }),
        properties,
    )
}

#[test]
fn polygons_with_holes_circles_and_properties_are_taken() {
    let school =
        circle(&json!({ "kind": "exclusion", "radius_m": 80, "altitude_reference": "amsl", "ceiling_m": 600 }));
    let two = json!({ "type": "MultiPolygon", "coordinates": [[ring(8.5, 47.3, 0.001)], [ring(8.6, 47.3, 0.001)]] });
    let imported = parse(&collection(&[field(), school, feature(&two, &Value::Null)])).expect("taken");
    let zones = &imported.plan.zones;
    let names: Vec<&str> = zones.iter().map(|z| z.name.as_str()).collect();
    assert_eq!(
        names,
        ["field", "field, hole 1", "field 1", "field 2 (1)", "field 2 (2)"]
    );
    let kinds: Vec<bool> = zones.iter().map(|z| z.kind == ZoneKind::Inclusion).collect();
    assert_eq!(kinds, [true, false, false, true, true]);
    assert!(
        zones
            .iter()
            .take(2)
            .all(|z| (z.floor_m, z.ceiling_m) == (Some(-5.0), Some(120.5)))
    );
    assert_eq!(
        (zones[0].action, zones[1].action),
        (BreachAction::Land, BreachAction::Land)
    );
    assert_eq!(zones[2].altitude_reference, AltitudeReference::Amsl);
    let centre = MapPoint::new(47.4, 8.55);
    assert_eq!(zones[2].outline, ZoneOutline::Circle { centre, radius_m: 80.0 });
    assert_eq!(imported.notes, ["properties without a meaning here: stroke"]);
    // A bare geometry and a bare feature are GeoJSON too.
    assert_eq!(parse(&two).expect("taken").plan.zones.len(), 2);
    assert_eq!(parse(&field()).expect("taken").plan.zones.len(), 2);
}

#[test]
fn what_is_wrong_is_said_with_file_feature_and_reason() {
    let bow_tie = json!([[8.5, 47.3], [8.6, 47.4], [8.6, 47.3], [8.5, 47.4], [8.5, 47.3]]);
    let polygon = |rings: Value| json!({ "type": "Polygon", "coordinates": rings });
    let cases = [
        (circle(&json!({})), "\"radius_m\" is missing"),
        (
            circle(&json!({ "radius_m": "wide" })),
            "\"radius_m\" is \"wide\", it must be a number",
        ),
        (circle(&json!({ "radius_m": -3 })), "the radius of -3 m"),
        (
            circle(&json!({ "radius_m": 9, "kind": "keep out" })),
            "\"kind\" is \"keep out\"",
        ),
        (
            circle(&json!({ "radius_m": 9, "action": "explode" })),
            "\"warn\", \"hold\", \"return\" or \"land\"",
        ),
        (
            circle(&json!({ "radius_m": 9, "floor_m": 50, "ceiling_m": 20 })),
            "the floor at 50 m",
        ),
        (
            feature(
                &json!({ "type": "LineString", "coordinates": [[8.5, 47.3], [8.6, 47.4]] }),
                &json!({}),
            ),
            "a LineString is no zone",
        ),
        (feature(&Value::Null, &json!({})), "no geometry"),
        (
            feature(&polygon(json!([bow_tie])), &json!({})),
            "crosses or touches itself: edges 0 and 2",
        ),
        (
            feature(&polygon(json!([ring(190.0, 47.3, 0.01)])), &json!({})),
            "point 0 is not a place",
        ),
        (feature(&polygon(json!([])), &json!({})), "no ring"),
        (
            feature(
                &polygon(json!([ring(8.5, 47.3, 0.01), ring(8.5, 47.3, 0.001)])),
                &json!({ "kind": "exclusion" }),
            ),
            "cannot have holes",
        ),
        (
            feature(&polygon(json!([[[8.5, 47.3], [8.6, 47.4]]])), &json!({})),
            "at least 3 corners",
        ),
    ];
    for (wrong, reason) in cases {
        let error = refused(&collection(&[field(), wrong]));
        assert!(error.contains("field.geojson: feature 1: "), "{error}");
        assert!(error.contains(reason), "{error} does not say {reason}");
    }
}

#[test]
fn what_is_no_geojson_is_refused() {
    for text in ["", "{", "[]", "{\"type\": \"Topology\"}", "null"] {
        let error = parse_fences(text, Path::new("x.json"))
            .expect_err("refused")
            .to_string();
        assert!(error.contains("x.json does not parse"), "{error}");
    }
}

fn plan(geo_fence: &Value) -> Value {
    json!({ "fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "geoFence": geo_fence,
        "mission": { "items": [{}, {}] }, "rallyPoints": { "points": [], "version": 2 } })
}

fn site() -> Value {
    json!({ "version": 2, "breachReturn": [47.397, 8.545, 40],
        "polygons": [{ "version": 1, "inclusion": true, "polygon": [[47.39, 8.54], [47.40, 8.54], [47.40, 8.55], [47.39, 8.55]] }],
        "circles": [{ "version": 1, "inclusion": false, "circle": { "center": [47.395, 8.545], "radius": 60.5 } }] })
}

#[test]
fn plans_of_qgroundcontrol_are_taken_with_a_note_on_the_rest() {
    let imported = parse_fences(&plan(&site()).to_string(), Path::new("site.plan")).expect("taken");
    let [polygon, circle] = &imported.plan.zones[..] else {
        panic!("{imported:?}")
    };
    assert_eq!(
        (polygon.name.as_str(), polygon.kind),
        ("site polygon 0", ZoneKind::Inclusion)
    );
    assert_eq!(circle.kind, ZoneKind::Exclusion);
    let centre = MapPoint::new(47.395, 8.545);
    assert_eq!(circle.outline, ZoneOutline::Circle { centre, radius_m: 60.5 });
    let back = imported.plan.breach_return.expect("kept");
    assert_eq!((back.place, back.height_m), (MapPoint::new(47.397, 8.545), Some(40.0)));
    assert!(
        imported.notes.iter().any(|note| note.contains("mission of 2 items")),
        "{:?}",
        imported.notes
    );
}

#[test]
fn plans_that_are_wrong_are_refused_by_part() {
    let change = |pointer: &str, to: Value| {
        let mut changed = plan(&site());
        *changed.pointer_mut(pointer).expect("there") = to;
        refused(&changed)
    };
    for (pointer, to, words) in [
        (
            "/fileType",
            json!("Mission"),
            "the file: \"fileType\" is \"Mission\", it must be \"Plan\"",
        ),
        ("/version", json!(9), "the file: \"version\" is 9, it must be 1"),
        (
            "/geoFence/version",
            json!(1),
            "geoFence: \"version\" is 1, it must be 2",
        ),
        (
            "/geoFence/polygons",
            json!({}),
            "geoFence: \"polygons\" is {}, it must be a list",
        ),
        (
            "/geoFence/polygons/0/inclusion",
            Value::Null,
            "geoFence.polygons[0]: \"inclusion\" is null",
        ),
        (
            "/geoFence/polygons/0/polygon/2",
            json!(["x"]),
            "geoFence.polygons[0]: \"polygon\" is [\"x\"]",
        ),
        (
            "/geoFence/polygons/0/polygon/0/0",
            json!(95.0),
            "geoFence.polygons[0]: zone 0 \"field polygon 0\": point 0 is not a place",
        ),
        ("/geoFence/circles/0/circle/radius", json!(0), "geoFence.circles[0]"),
        (
            "/geoFence/circles/0/version",
            json!(2),
            "geoFence.circles[0]: \"version\" is 2",
        ),
        ("/geoFence/breachReturn", json!([0]), "geoFence.breachReturn"),
    ] {
        let error = change(pointer, to);
        assert!(error.contains(words), "{error} does not say {words}");
    }
}

/// As people write them: reading many more digits may be off by the last of them.
fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

fn zones() -> impl Strategy<Value = FencePlan> {
    let place = (-80.0..80.0, -179.0..179.0);
    let outline =
        (place, 20.0..900.0, any::<bool>(), 3_u32..12).prop_map(|((latitude, longitude), radius_m, round, count)| {
            let centre = MapPoint::new(rounded(latitude), rounded(longitude));
            let radius_m = rounded(radius_m);
            if round {
                return ZoneOutline::Circle { centre, radius_m };
            }
            let frame = SwarmFrame::new(Geodetic {
                latitude_deg: latitude,
                longitude_deg: longitude,
                altitude_amsl_m: 0.0,
            });
            let corner = |k: u32| {
                let (sin, cos) = (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos();
                let place = frame.geodetic(&PositionNed::new(radius_m * cos, radius_m * sin, 0.0));
                MapPoint::new(rounded(place.latitude_deg), rounded(place.longitude_deg))
            };
            ZoneOutline::Polygon {
                corners: (0..count).map(corner).collect(),
            }
        });
    let zone = (outline, any::<(bool, bool, bool, bool)>(), 0_usize..4, "[a-z \"]{0,9}x").prop_map(
        |(outline, (inclusion, low, high, sea), action, name)| FenceZone {
            name,
            kind: if inclusion {
                ZoneKind::Inclusion
            } else {
                ZoneKind::Exclusion
            },
            outline,
            floor_m: low.then_some(-2.25),
            ceiling_m: high.then_some(118.125),
            altitude_reference: if sea {
                AltitudeReference::Amsl
            } else {
                AltitudeReference::Origin
            },
            action: [
                BreachAction::Warn,
                BreachAction::Hold,
                BreachAction::Return,
                BreachAction::Land,
            ][action],
        },
    );
    let back = prop::option::of((-80.0..80.0, prop::option::of(-9.0..99.0))).prop_map(|back| {
        back.map(|(latitude, height_m)| BreachReturn {
            place: MapPoint::new(rounded(latitude), 8.0),
            height_m: height_m.map(rounded),
        })
    });
    (prop::collection::vec(zone, 0..5), back).prop_map(|(zones, breach_return)| FencePlan { zones, breach_return })
}

/// Any JSON, with the words of the formats in it more often than chance would have.
fn some_json() -> impl Strategy<Value = Value> {
    let word = prop::sample::select(vec![
        "type",
        "Feature",
        "FeatureCollection",
        "Polygon",
        "MultiPolygon",
        "Point",
        "GeometryCollection",
        "features",
        "geometry",
        "geometries",
        "coordinates",
        "properties",
        "radius_m",
        "kind",
        "exclusion",
        "fileType",
        "Plan",
        "geoFence",
        "polygons",
        "polygon",
        "circles",
        "circle",
        "center",
        "radius",
        "inclusion",
        "version",
        "breachReturn",
    ]);
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        (0_u64..3).prop_map(Value::from),
        (-200.0..200.0).prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        word.clone().prop_map(Value::from),
    ];
    leaf.prop_recursive(6, 64, 6, move |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..6).prop_map(Value::from),
            prop::collection::vec((word.clone(), inner), 0..6)
                .prop_map(|pairs| Value::Object(pairs.into_iter().map(|(k, v)| (k.to_owned(), v)).collect())),
        ]
    })
}

proptest! {
    #[test]
    fn what_is_exported_comes_back_as_it_was(plan in zones()) {
        let text = to_geojson(&plan, None).expect("exported");
        let back = parse_fences(&text, Path::new("x.geojson")).expect("taken");
        prop_assert_eq!(back.plan, plan);
        prop_assert!(back.notes.is_empty());
    }

    #[test]
    fn no_json_makes_the_importers_panic(value in some_json()) {
        let _ = parse(&value);
        let _ = parse(&plan(&value));
        let _ = parse(&collection(&[field(), value.clone()]));
        let _ = parse(&feature(&value, &json!({})));
        let _ = parse(&feature(&json!({ "type": "Polygon", "coordinates": value }), &value));
    }

    #[test]
    fn a_damaged_file_is_taken_or_refused_but_never_panics(at in 0_usize..600, byte in any::<u8>(), which in any::<bool>()) {
        let text = if which { plan(&site()).to_string() } else { collection(&[field(), circle(&json!({ "radius_m": 5 }))]).to_string() };
        let mut bytes = text.into_bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = parse_fences(&String::from_utf8_lossy(&bytes), Path::new("x"));
    }
}

#[test]
fn zones_of_the_frame_are_put_on_the_map_and_come_back_to_the_millimetre() {
    let frame = SwarmFrame::new(ORIGIN);
    let corners_m = vec![[0.0, 0.0], [500.0, -20.0], [480.0, 700.0]];
    let zone = FenceZone {
        name: "local".to_owned(),
        kind: ZoneKind::Inclusion,
        outline: ZoneOutline::LocalPolygon {
            corners_m: corners_m.clone(),
        },
        floor_m: None,
        ceiling_m: Some(50.0),
        altitude_reference: AltitudeReference::Origin,
        action: BreachAction::Return,
    };
    let plan = FencePlan {
        zones: vec![zone],
        breach_return: None,
    };
    assert!(matches!(
        to_geojson(&plan, None),
        Err(FenceFileError::Zones(FencePlanError::NoOrigin { .. }))
    ));
    let text = to_geojson(&plan, Some(&frame)).expect("exported");
    let back = parse_fences(&text, Path::new("x.geojson")).expect("taken").plan;
    let ZoneOutline::Polygon { corners } = &back.zones[0].outline else {
        panic!("{back:?}")
    };
    for (corner, expected) in corners.iter().zip(&corners_m) {
        let [north_m, east_m] = corner.in_frame_m(&frame);
        assert!((north_m - expected[0]).hypot(east_m - expected[1]) < 1e-3);
    }
}

fn node(directory: &Path, safety: &str) -> Result<NodeConfig, crate::ConfigError> {
    let file = directory.join("skein.toml");
    let origin = "origin = { latitude_deg = 47.397742, longitude_deg = 8.545594, altitude_amsl_m = 488.0 }";
    std::fs::write(&file, format!("[swarm]\n{origin}\n[safety]\n{safety}")).expect("written");
    NodeConfig::load(&file)
}

#[test]
fn a_configuration_joins_its_fence_its_zones_and_its_files() {
    let directory = tempfile::tempdir().expect("made");
    std::fs::write(directory.path().join("field.geojson"), field().to_string()).expect("written");
    std::fs::write(directory.path().join("site.plan"), plan(&site()).to_string()).expect("written");
    let safety = "fence_files = [\"field.geojson\", \"site.plan\"]
[safety.fence]
polygon_m = [[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0]]
floor_m = -5.0
ceiling_m = 50.0
[[safety.zones]]
name = \"mast\"
kind = \"exclusion\"
outline = { shape = \"local_circle\", centre_m = [20.0, 5.0], radius_m = 4.0 }
";
    let config = node(directory.path(), safety).expect("loaded");
    let imported = config.fence_plan().expect("read");
    let names: Vec<&str> = imported.plan.zones.iter().map(|z| z.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "fence",
            "mast",
            "field",
            "field, hole 1",
            "site polygon 0",
            "site circle 0"
        ]
    );
    assert!(
        imported
            .notes
            .iter()
            .any(|note| note.contains("site.plan: its mission")),
        "{:?}",
        imported.notes
    );
    let fences = config.fences().expect("placed");
    assert_eq!(fences.zones().len(), 6);
    assert!(
        fences.contains(&PositionNed::new(20.0, 5.0, -10.0)).is_err(),
        "in the mast's circle"
    );
}

#[test]
fn a_wrong_fence_file_stops_the_configuration() {
    let directory = tempfile::tempdir().expect("made");
    let missing = node(directory.path(), "fence_files = [\"nowhere.geojson\"]")
        .expect_err("refused")
        .to_string();
    assert!(missing.contains("nowhere.geojson"), "{missing}");
    std::fs::write(
        directory.path().join("far.geojson"),
        circle(&json!({ "radius_m": 9 })).to_string().replace("47.4", "8.5"),
    )
    .expect("written");
    let far = node(directory.path(), "fence_files = [\"far.geojson\"]")
        .expect_err("refused")
        .to_string();
    assert!(far.contains("km from the swarm's origin"), "{far}");
    let without_origin = NodeConfig::parse("[safety]\nfence_files = [\"a.plan\"]")
        .expect_err("refused")
        .to_string();
    assert!(
        without_origin.contains("safety.fence_files") && without_origin.contains("swarm.origin"),
        "{without_origin}"
    );
    let local = "[[safety.zones]]\nname = \"a\"\nkind = \"inclusion\"\noutline = { shape = \"local_circle\", centre_m = [0.0, 0.0], radius_m = -1.0 }";
    let wrong = NodeConfig::parse(local).expect_err("refused").to_string();
    assert!(wrong.contains("safety.zones[0]: the radius of -1 m"), "{wrong}");
}
