//! The outline of each shape in numbers, its symmetry, views out of it, and its import.

use super::super::*;
use super::request;

fn rounded(slots: &[OffsetFrd]) -> Vec<(f64, f64, f64)> {
    let round = |x: f64| (x * 100.0).round() / 100.0 + 0.0;
    slots
        .iter()
        .map(|s| (round(s.forward_m), round(s.right_m), round(0.0 - s.down_m)))
        .collect()
}

fn at(shape: Shape, count: usize) -> Vec<(f64, f64, f64)> {
    rounded(&slots(&request(shape, 10.0), count).unwrap())
}

fn level(places: &[(f64, f64)]) -> Vec<(f64, f64, f64)> {
    places.iter().map(|(forward, right)| (*forward, *right, 0.0)).collect()
}

#[test]
fn rows_and_arms_have_their_outline() {
    assert_eq!(
        at(Shape::Line, 4),
        level(&[(0.0, 0.0), (0.0, 10.0), (0.0, -10.0), (0.0, 20.0)])
    );
    assert_eq!(at(Shape::Column, 3), level(&[(0.0, 0.0), (-10.0, 0.0), (-20.0, 0.0)]));
    assert_eq!(at(Shape::Wedge, 3), level(&[(0.0, 0.0), (-7.07, 7.07), (-7.07, -7.07)]));
    let arm = |side: f64| level(&[(0.0, 0.0), (-7.07, side * 7.07), (-14.14, side * 14.14)]);
    assert_eq!(at(Shape::EchelonLeft, 3), arm(-1.0));
    assert_eq!(at(Shape::EchelonRight, 3), arm(1.0));
    assert_eq!(
        at(Shape::Grid, 5),
        level(&[(0.0, 0.0), (0.0, 10.0), (0.0, -10.0), (-10.0, 0.0), (-10.0, 10.0)])
    );
    for shape in Shape::ALL {
        assert_eq!(at(*shape, 1), [(0.0, 0.0, 0.0)]);
    }
}

#[test]
fn rings_have_their_outline() {
    assert_eq!(at(Shape::Circle, 2), level(&[(0.0, 0.0), (-10.0, 0.0)]));
    let corner_up = [(0.0, 0.0), (-7.07, 7.07), (-14.14, 0.0), (-7.07, -7.07)];
    assert_eq!(at(Shape::Circle, 4), level(&corner_up));
    let diamond = [(0.0, 0.0), (-7.07, 7.07), (-7.07, -7.07), (-14.14, 0.0)];
    assert_eq!(at(Shape::Diamond, 4), level(&diamond));
    // Five: the corners and the middle.
    let five = [
        (0.0, 0.0),
        (-14.14, 14.14),
        (-14.14, -14.14),
        (-28.28, 0.0),
        (-14.14, 0.0),
    ];
    assert_eq!(at(Shape::Diamond, 5), level(&five));
    // A half circle: neighbours at 90 degrees, and the ends beside the middle.
    assert_eq!(at(Shape::Arc, 3), level(&[(0.0, 0.0), (-7.07, 7.07), (-7.07, -7.07)]));
    let full = FormationRequest {
        arc_deg: Some(360.0),
        ..request(Shape::Arc, 10.0)
    };
    let alternating = [(0.0, 0.0), (-7.07, 7.07), (-7.07, -7.07), (-14.14, 0.0)];
    assert_eq!(rounded(&slots(&full, 4).unwrap()), level(&alternating));
    // Eight round a square of two spacings.
    let square = [
        (0.0, 0.0),
        (0.0, 10.0),
        (-10.0, 10.0),
        (-20.0, 10.0),
        (-20.0, 0.0),
        (-20.0, -10.0),
        (-10.0, -10.0),
        (0.0, -10.0),
    ];
    assert_eq!(at(Shape::Square, 8), level(&square));
}

#[test]
fn solid_shapes_have_their_outline() {
    let layer = |up_m: f64| {
        [
            (0.0, 0.0, up_m),
            (0.0, 10.0, up_m),
            (-10.0, 0.0, up_m),
            (-10.0, 10.0, up_m),
        ]
    };
    assert_eq!(at(Shape::Box, 8), [layer(0.0), layer(15.0)].concat());
    let three = FormationRequest {
        layers: Some(3),
        ..request(Shape::Box, 10.0)
    };
    let three = slots(&three, 7).unwrap();
    let heights: Vec<f64> = three.iter().map(|slot| (0.0 - slot.down_m).round()).collect();
    assert_eq!(heights, [0.0, 0.0, 0.0, 15.0, 15.0, 30.0, 30.0]);
    let helix = slots(&request(Shape::Helix, 10.0), 100).unwrap();
    let per_turn = helix.iter().position(|slot| 0.0 - slot.down_m >= 20.0 - 1e-6).unwrap();
    assert!(per_turn >= 6);
    // One turn above the foot, and each a little higher than the one before.
    assert!((helix[per_turn].vector() - Vector3::new(0.0, 0.0, -20.0)).norm() < 1e-6);
    assert!(helix.windows(2).all(|pair| pair[1].down_m < pair[0].down_m));
    let sphere = centred_slots(&request(Shape::Sphere, 10.0), 60).unwrap();
    let radius_m = sphere[0].norm();
    assert!(sphere.iter().all(|slot| (slot.norm() / radius_m - 1.0).abs() < 0.02));
    assert!(sphere.iter().all(|slot| slot.forward_m <= sphere[0].forward_m + 1e-9));
}

#[test]
fn both_sides_are_alike() {
    let even_sided = [
        Shape::Circle,
        Shape::Square,
        Shape::Wedge,
        Shape::Line,
        Shape::Arc,
        Shape::Diamond,
    ];
    for shape in even_sided {
        let counts: &[usize] = match shape {
            Shape::Circle | Shape::Square => &[1, 2, 3, 8, 50, 199, 200],
            Shape::Diamond => &[1, 3, 4, 5, 6, 7, 9, 16, 25, 196],
            _ => &[1, 3, 5, 51, 199],
        };
        for count in counts {
            let slots = slots(&request(shape, 5.0), *count).unwrap();
            for slot in &slots {
                let mirrored = OffsetFrd {
                    right_m: -slot.right_m,
                    ..*slot
                };
                let has = slots.iter().any(|s| (s.vector() - mirrored.vector()).norm() < 1e-6);
                assert!(has, "{shape:?} of {count}: nobody at {mirrored:?}");
            }
        }
    }
}

#[test]
fn an_anchor_that_is_no_vehicle_is_in_the_middle() {
    let mut asked = request(Shape::Column, 10.0);
    assert_eq!(anchored_slots(&asked, 3), slots(&asked, 3));
    asked.anchor = FormationAnchor::Reference { name: "truck".into() };
    let places = rounded(&anchored_slots(&asked, 3).unwrap());
    assert_eq!(places, level(&[(10.0, 0.0), (0.0, 0.0), (-10.0, 0.0)]));
    // What was drawn relative to the anchor stays there.
    let free = FormationRequest {
        anchor: asked.anchor,
        offsets: Some(vec![OffsetFrd::new(5.0, 1.0, -2.0), OffsetFrd::new(9.0, 1.0, -2.0)]),
        ..request(Shape::Free, 10.0)
    };
    assert_eq!(
        rounded(&anchored_slots(&free, 2).unwrap()),
        [(5.0, 1.0, 2.0), (9.0, 1.0, 2.0)]
    );
    assert_eq!(rounded(&slots(&free, 2).unwrap()), [(0.0, 0.0, 0.0), (4.0, 0.0, 0.0)]);
}

#[test]
fn views_are_free_ahead_outwards_or_not_at_all() {
    let of = |shape, count| views(&slots(&request(shape, 5.0), count).unwrap());
    assert!(of(Shape::Line, 7).iter().all(|view| *view == View::Ahead));
    assert_eq!(of(Shape::Column, 3), [View::Ahead, View::Blocked, View::Outward]);
    let grid = of(Shape::Grid, 9);
    assert_eq!(grid[..3], [View::Ahead; 3]);
    // The middle of the second row sees nothing; its two sides look out sidewards.
    assert_eq!(grid[3..6], [View::Blocked, View::Outward, View::Outward]);
    assert!(of(Shape::Circle, 12).iter().all(|view| *view != View::Blocked));
    assert_eq!(views(&[]), []);
    assert_eq!(views(&[OffsetFrd::default()]), [View::Ahead]);
    assert_eq!(views(&[OffsetFrd::new(f64::NAN, 0.0, 0.0); 2]).len(), 2);
}

#[test]
fn a_table_of_offsets_is_read() {
    let expected = [OffsetFrd::new(0.0, 0.0, 0.0), OffsetFrd::new(-5.0, 2.5, -3.0)];
    for text in [
        "0,0,0\n-5,2.5,-3\n",
        "forward_m,right_m,down_m\r\n0,0,0\r\n-5,2.5,-3",
        "\u{feff}# drawn by hand\n up_m , Forward_m,right_m\n\n0,0,0\n3, -5, 2.5\n",
    ] {
        assert_eq!(offsets_from_csv(text).unwrap(), expected, "{text:?}");
    }
    for text in [
        "[[0, 0, 0], [-5, 2.5, -3]]",
        r#"[{"forward_m": 0, "right_m": 0, "down_m": 0}, {"forward_m": -5, "right_m": 2.5, "up_m": 3}]"#,
    ] {
        assert_eq!(offsets_from_json(text).unwrap(), expected, "{text}");
    }
}

#[test]
fn a_table_that_is_none_is_refused_with_its_line() {
    let refused = |text: &str| offsets_from_csv(text).unwrap_err();
    assert_eq!(refused(""), OffsetsError::Empty);
    assert_eq!(refused("forward_m,right_m,down_m\n"), OffsetsError::Empty);
    assert_eq!(refused("0,0,0\n\n1,2\n"), OffsetsError::Fields { line: 3, fields: 2 });
    for (text, bad) in [
        ("0,0,0\n1,x,3\n", "x"),
        ("0,0,0\n1,NaN,3\n", "NaN"),
        ("0,0,0\n1,inf,3", "inf"),
    ] {
        assert_eq!(
            refused(text),
            OffsetsError::NotANumber {
                line: 2,
                text: bad.into()
            }
        );
    }
    assert_eq!(
        refused("1,x,3\n"),
        OffsetsError::NotANumber {
            line: 1,
            text: "x".into()
        }
    );
    assert_eq!(
        refused("forward_m,right_m,east\n1,2,3"),
        OffsetsError::UnknownColumn {
            line: 1,
            column: "east".into()
        }
    );
    assert_eq!(
        refused("forward_m,right_m,right_m\n1,2,3"),
        OffsetsError::Columns { line: 1 }
    );
    assert_eq!(refused("forward_m,right_m\n1,2"), OffsetsError::Columns { line: 1 });
    let many = "0,0,0\n".repeat(10_001);
    assert_eq!(refused(&many), OffsetsError::TooMany { most: 10_000 });
}

#[test]
fn a_list_that_is_none_is_refused_with_its_line() {
    assert_eq!(offsets_from_json("[]"), Err(OffsetsError::Empty));
    for text in [
        "{}",
        "[[0, 0, 0],\n [1, 2]\n]",
        "[[0, 0, 0],\n {\"forward_m\": 1, \"right_m\": 2, \"down_m\": 1, \"up_m\": 1}]",
        "[[0, 0, 0],\n [1, 2, 1e999]]",
        "[[0, 0, 0],\n",
    ] {
        let refused = offsets_from_json(text);
        let Err(OffsetsError::Syntax { line, .. }) = refused else {
            panic!("{text}: {refused:?}")
        };
        assert!(line >= 1 && (line >= 2) == text.contains('\n'), "{text}: line {line}");
    }
}
