//! Several zones together: what is inside, which ways are, who may come back, and which breach counts.

use super::super::clearance::Clearance;
use super::super::tests::polygon_about;
use super::*;
use proptest::prelude::*;

fn at(north_m: f64, east_m: f64, height_m: f64) -> PositionNed {
    PositionNed::new(north_m, east_m, -height_m)
}

fn zone(name: &str, kind: ZoneKind, volume: Fence) -> Zone {
    Zone {
        name: name.to_owned(),
        kind,
        action: BreachAction::Hold,
        volume,
    }
}

fn block(north: [f64; 2], east: [f64; 2], heights: [f64; 2]) -> Fence {
    let corners = vec![
        [north[0], east[0]],
        [north[1], east[0]],
        [north[1], east[1]],
        [north[0], east[1]],
    ];
    Fence::new(corners, heights[0], heights[1]).unwrap()
}

/// A field with a school in it, over which one may fly, and a tower beside the field that is higher and overlaps it.
fn site() -> Fences {
    Fences::new(vec![
        zone(
            "field",
            ZoneKind::Inclusion,
            block([0.0, 100.0], [0.0, 100.0], [0.0, 60.0]),
        ),
        zone(
            "tower",
            ZoneKind::Inclusion,
            block([90.0, 150.0], [0.0, 50.0], [20.0, 120.0]),
        ),
        zone(
            "school",
            ZoneKind::Exclusion,
            block([40.0, 60.0], [40.0, 60.0], [0.0, 30.0]),
        ),
    ])
}

fn detail(verdict: Result<(), Refusal>) -> String {
    match verdict {
        Err(Refusal::OutsideFence { detail }) => detail,
        other => panic!("{other:?}"),
    }
}

#[test]
fn inside_is_any_inclusion_and_no_exclusion() {
    let site = site();
    for place in [
        at(10.0, 10.0, 10.0),
        at(140.0, 10.0, 100.0),
        at(95.0, 10.0, 100.0),
        at(50.0, 50.0, 30.0),
        at(40.0, 50.0, 10.0),
    ] {
        assert_eq!(site.contains(&place), Ok(()), "{place:?}");
    }
    assert_eq!(
        detail(site.contains(&at(50.0, 45.0, 10.0))),
        "\"school\": 5.0 m inside, where nothing may fly"
    );
    assert_eq!(
        detail(site.contains(&at(50.0, 50.0, 28.0))),
        "\"school\": 2.0 m inside, where nothing may fly"
    );
    assert_eq!(
        detail(site.contains(&at(10.0, -3.0, 10.0))),
        "\"field\": 3.0 m beyond the boundary"
    );
    assert_eq!(
        detail(site.contains(&at(140.0, 55.0, 100.0))),
        "\"tower\": 5.0 m beyond the boundary"
    );
    assert!(matches!(
        site.contains(&at(f64::NAN, 0.0, 0.0)),
        Err(Refusal::InvalidValue { .. })
    ));
    assert_eq!(Fences::default().contains(&at(1e9, 0.0, 0.0)), Ok(()));
    let only_out = Fences::new(
        site.zones()
            .iter()
            .filter(|z| z.kind == ZoneKind::Exclusion)
            .cloned()
            .collect(),
    );
    assert_eq!(
        only_out.contains(&at(1e6, 0.0, 1e4)),
        Ok(()),
        "without an inclusion everywhere is inside"
    );
}

#[test]
fn ways_go_over_low_exclusions_and_from_inclusion_to_inclusion() {
    let site = site();
    assert_eq!(
        site.contains_way(&at(10.0, 50.0, 31.0), &at(90.0, 50.0, 31.0)),
        Ok(()),
        "over the school"
    );
    assert_eq!(
        site.contains_way(&at(10.0, 50.0, 30.0), &at(90.0, 50.0, 30.0)),
        Ok(()),
        "along its roof"
    );
    assert_eq!(
        site.contains_way(&at(10.0, 40.0, 5.0), &at(90.0, 40.0, 5.0)),
        Ok(()),
        "along its wall"
    );
    let through = site.contains_way(&at(10.0, 50.0, 29.0), &at(90.0, 50.0, 29.0));
    assert!(detail(through).ends_with("crosses \"school\""));
    assert!(
        site.contains_way(&at(10.0, 50.0, 5.0), &at(90.0, 50.0, 45.0)).is_err(),
        "climbs too late"
    );
    assert_eq!(
        site.contains_way(&at(10.0, 10.0, 40.0), &at(140.0, 10.0, 50.0)),
        Ok(()),
        "through both"
    );
    let over = site.contains_way(&at(10.0, 10.0, 40.0), &at(140.0, 10.0, 110.0));
    assert!(
        detail(over).contains("leaves all zones"),
        "over the field's ceiling before the tower"
    );
}

#[test]
fn the_strongest_action_counts_then_the_furthest() {
    let mut zones = site().zones().to_vec();
    zones[2].action = BreachAction::Land;
    zones.push(zone(
        "pond",
        ZoneKind::Exclusion,
        block([45.0, 200.0], [45.0, 200.0], [0.0, 30.0]),
    ));
    let fences = Fences::new(zones);
    let breach = fences.breach(&at(55.0, 55.0, 10.0)).unwrap();
    assert_eq!(
        (breach.zone.name.as_str(), breach.action),
        ("school", BreachAction::Land)
    );
    assert_eq!(breach.excess.outside_m, 5.0);
    let both = fences.breach(&at(80.0, 120.0, 10.0)).unwrap();
    assert_eq!(
        both.zone.name, "field",
        "equal actions, and 20 m out of the field as 20 m in the pond: the last"
    );
    assert_eq!(fences.breach(&at(10.0, 10.0, 10.0)), None);
    assert!(fences.excess(&at(10.0, 10.0, 10.0)).is_inside());
}

#[test]
fn landing_asks_for_the_ground_only() {
    let mut zones = site().zones().to_vec();
    zones.push(zone(
        "approach",
        ZoneKind::Exclusion,
        block([0.0, 30.0], [0.0, 30.0], [40.0, 300.0]),
    ));
    let fences = Fences::new(zones);
    assert_eq!(
        fences.landing(&at(10.0, 10.0, -30.0)),
        Ok(()),
        "under a high exclusion, under the floor"
    );
    assert!(detail(fences.landing(&at(50.0, 50.0, 0.0))).contains("school"));
    assert!(detail(fences.landing(&at(50.0, 140.0, 0.0))).contains("field"));
}

#[test]
fn who_is_outside_may_come_back_but_not_go_further() {
    let site = site();
    let out = at(-10.0, 50.0, 10.0);
    assert_eq!(site.may_move(&out, &at(5.0, 50.0, 10.0), true), Ok(()));
    assert_eq!(site.may_move(&out, &at(-10.0, 60.0, 10.0), true), Ok(()), "along");
    assert!(site.may_move(&out, &at(-11.0, 50.0, 10.0), true).is_err());
    assert!(
        site.may_move(&out, &at(70.0, 50.0, 10.0), true).is_err(),
        "back, but through the school"
    );
    let entered = at(50.0, 45.0, 10.0);
    assert_eq!(site.may_move(&entered, &at(50.0, 35.0, 10.0), true), Ok(()));
    assert!(site.may_move(&entered, &at(50.0, 48.0, 10.0), true).is_err());
    // On the ground under the floor, and not on the way anywhere.
    assert_eq!(
        site.may_move(&at(10.0, 10.0, -5.0), &at(10.0, 10.0, -5.0), false),
        Ok(())
    );
}

#[test]
fn walls_between_overlapping_inclusions_fall_away() {
    let site = site();
    let at_90: Vec<[f64; 2]> = site
        .walls()
        .iter()
        .filter(|wall| wall.ends_m.iter().all(|p| p[0] == 90.0))
        .map(|wall| [wall.floor_m, wall.ceiling_m])
        .collect();
    assert_eq!(
        at_90,
        [[60.0, 120.0]],
        "the tower's wall in the field is left over the field's ceiling only"
    );
}

fn some_fences() -> impl Strategy<Value = (Fences, [f64; 2])> {
    let exclusions = prop::collection::vec((polygon_about(), 0.0..60.0, 5.0..60.0), 0..4);
    (polygon_about(), polygon_about(), exclusions).prop_map(|((field, centre), (other, other_centre), exclusions)| {
        let moved = |vertices: Vec<[f64; 2]>, about: [f64; 2], by: [f64; 2], scale: f64| -> Vec<[f64; 2]> {
            let to = |v: [f64; 2], k: usize| centre[k] + by[k] + (v[k] - about[k]) * scale;
            vertices.into_iter().map(|v| [to(v, 0), to(v, 1)]).collect()
        };
        let mut zones = vec![
            zone("a", ZoneKind::Inclusion, Fence::new(field, 0.0, 80.0).unwrap()),
            zone(
                "b",
                ZoneKind::Inclusion,
                Fence::new(moved(other, other_centre, [40.0, 10.0], 1.0), 10.0, 100.0).unwrap(),
            ),
        ];
        for (((vertices, about), floor, height), by) in
            exclusions.into_iter().zip([[20.0, 0.0], [-20.0, 15.0], [0.0, -30.0]])
        {
            let volume = Fence::new(moved(vertices, about, by, 0.2), floor, floor + height).unwrap();
            zones.push(zone("x", ZoneKind::Exclusion, volume));
        }
        (Fences::new(zones), centre)
    })
}

proptest! {
    #[test]
    fn a_way_that_passes_is_inside_throughout_and_one_that_does_not_comes_to_a_boundary(
        (fences, centre) in some_fences(), a in prop::array::uniform3(-70.0..70.0), b in prop::array::uniform3(-70.0..70.0),
    ) {
        let place = |d: [f64; 3]| at(centre[0] + d[0], centre[1] + d[1], 45.0 + 0.6 * d[2]);
        let (from, to) = (place(a), place(b));
        let step_m = from.distance_m(&to) / 400.0;
        let samples: Vec<PositionNed> = (0..=400)
            .map(|k| from.vector().lerp(&to.vector(), f64::from(k) / 400.0).into())
            .collect();
        if fences.contains_way(&from, &to).is_ok() {
            let worst_m = samples.iter().map(|p| fences.excess(p).distance_m()).fold(0.0, f64::max);
            prop_assert!(worst_m < 1e-4, "{worst_m} m out");
        } else {
            let near = Clearance { horizontal_m: 2.0 * step_m, vertical_m: 2.0 * step_m };
            prop_assert!(samples.iter().any(|p| fences.keeps_clearance(p, p, &near).is_err()), "refused without a reason");
        }
    }

    #[test]
    fn one_fence_says_what_it_said_alone((vertices, centre) in polygon_about(), d in prop::array::uniform3(-120.0..120.0)) {
        let fence = Fence::new(vertices, 2.0, 60.0).unwrap();
        let fences = Fences::from(fence.clone());
        let place = at(centre[0] + d[0], centre[1] + d[1], 30.0 + 0.5 * d[2]);
        prop_assert_eq!(fences.contains(&place).is_ok(), fence.contains(&place).is_ok());
        prop_assert_eq!(fences.excess(&place), fence.excess(&place));
        let middle = at(centre[0], centre[1], 30.0);
        prop_assert_eq!(fences.contains_way(&middle, &place).is_ok(), fence.contains_way(&middle, &place).is_ok());
    }

    #[test]
    fn nothing_panics_on_numbers_that_are_none(n in prop::array::uniform6(any::<f64>())) {
        let (from, to) = (PositionNed::new(n[0], n[1], n[2]), PositionNed::new(n[3], n[4], n[5]));
        let site = site();
        let _ = (site.contains_way(&from, &to), site.may_move(&from, &to, true), site.breach(&from).is_some(), site.landing(&to));
    }
}
