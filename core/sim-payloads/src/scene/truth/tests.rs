//! The truth against what is drawn.

use super::super::{Look, ObjectPath, Scene, SceneObject, focal_length_px};
use super::*;
use proptest::prelude::*;

const SIZE_PX: (u32, u32) = (200, 150);
const EVERY_KIND: [TargetKind; 7] = [
    TargetKind::Multirotor,
    TargetKind::Marker,
    TargetKind::Quadrotor,
    TargetKind::FixedWing,
    TargetKind::Bird,
    TargetKind::Aeroplane,
    TargetKind::Helicopter,
];

fn camera(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> CameraPose {
    CameraPose {
        position: PositionNed::new(10.0, -20.0, -100.0),
        roll_rad,
        pitch_rad,
        yaw_rad,
        field_of_view_rad: 0.8,
    }
}

/// A thing that looks so large and stands at a place of the picture, as shares of its size from its middle.
fn target_at(pose: &CameraPose, kind: TargetKind, size_px: f64, (across, along): (f64, f64)) -> SceneTarget {
    let object = SceneObject {
        kind,
        size_m: None,
        path: ObjectPath::Hover(PositionNed::default()),
        speed_m_s: None,
        phase: 0.0,
    };
    let lens = Lens::new(pose, SIZE_PX);
    let (width_px, height_px) = (f64::from(SIZE_PX.0), f64::from(SIZE_PX.1));
    let ray = lens.ray(width_px * (0.5 + across), height_px * (0.5 + along));
    let depth_m = object.size_m() * focal_length_px(pose.field_of_view_rad, SIZE_PX.0) / size_px;
    SceneTarget {
        position: pose.position.moved(ray * depth_m),
        ..object.at(0.0)
    }
}

fn drawn(scene: &Scene, pose: &CameraPose, targets: &[SceneTarget]) -> Vec<u8> {
    let mut rgb = vec![0; 3 * (SIZE_PX.0 * SIZE_PX.1) as usize];
    scene.render(pose, targets, SIZE_PX.0, SIZE_PX.1, &mut rgb);
    rgb
}

/// Left, right, top and bottom of the pixels that differ.
fn difference(with: &[u8], without: &[u8]) -> Option<[f64; 4]> {
    let width = SIZE_PX.0 as usize;
    let pairs = with.chunks(3).zip(without.chunks(3)).enumerate();
    let places = pairs.filter(|(_, (with, without))| with != without);
    let places = places.map(|(pixel, _)| ((pixel % width) as f64, (pixel / width) as f64));
    places.fold(None, |around: Option<[f64; 4]>, (column, row)| {
        let [left, right, top, bottom] = around.unwrap_or([f64::INFINITY, 0.0, f64::INFINITY, 0.0]);
        Some([
            left.min(column),
            right.max(column + 1.0),
            top.min(row),
            bottom.max(row + 1.0),
        ])
    })
}

fn sides(seen: &Seen) -> [f64; 4] {
    let (half_width_px, half_height_px) = (seen.width_px / 2.0, seen.height_px / 2.0);
    [
        seen.center_x_px - half_width_px,
        seen.center_x_px + half_width_px,
        seen.center_y_px - half_height_px,
        seen.center_y_px + half_height_px,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn what_is_drawn_is_where_the_truth_says(
        kind in prop::sample::select(EVERY_KIND.to_vec()), infrared in any::<bool>(),
        (roll, pitch, yaw) in (-0.4..0.4_f64, -0.5..1.0_f64, -3.0..3.0_f64),
        (bank, climb, heading, beat) in (-0.6..0.6_f64, -0.3..0.3_f64, -3.0..3.0_f64, 0.0..6.0_f64),
        size_px in 12.0..90.0_f64, place in (-0.6..0.6_f64, -0.6..0.6_f64),
    ) {
        let pose = camera(roll, pitch, yaw);
        let target = SceneTarget {
            roll_rad: bank, pitch_rad: climb, yaw_rad: heading, beat_rad: beat,
            ..target_at(&pose, kind, size_px, place)
        };
        let scene = Scene::new(3).with_look(if infrared { Look::Infrared } else { Look::Visible });
        let changed = difference(&drawn(&scene, &pose, &[target]), &drawn(&scene, &pose, &[]));
        match (truth(&pose, &[target], SIZE_PX).as_slice(), changed) {
            ([seen], Some(changed)) => {
                let [left, right, top, bottom] = sides(seen);
                let [drawn_left, drawn_right, drawn_top, drawn_bottom] = changed;
                let around = [left - drawn_left, drawn_right - right, top - drawn_top, drawn_bottom - bottom];
                // No pixel lies outside. Of what is wholly in the picture each side of the box is reached, but for the tips of rotors seen
                // from their edge.
                let thin = [TargetKind::Helicopter, TargetKind::Multirotor];
                let thin_px = if thin.contains(&kind) { 1.5 } else { 1.0 };
                prop_assert!(around.iter().all(|over_px| *over_px < 1.0), "{:?} but {changed:?}", sides(seen));
                let is_whole = seen.inside > 0.999_999;
                prop_assert!(!is_whole || around.iter().all(|over_px| *over_px > -thin_px), "{:?} but {changed:?}", sides(seen));
                prop_assert!(seen.inside > 0.0 && seen.inside <= 1.0 + 1e-12);
            }
            // A part that only just reaches into the picture may miss every sample, or its corner be empty.
            ([seen], None) => prop_assert!(seen.inside < 0.25, "{seen:?}"),
            ([], changed) => prop_assert_eq!(changed, None),
            (more, _) => prop_assert!(false, "{more:?}"),
        }
    }

    #[test]
    fn nothing_is_seen_that_is_not_ahead_and_no_number_does_harm(
        values in prop::array::uniform9(prop_oneof![any::<f64>(), -10.0..10.0_f64]),
        kind in prop::sample::select(EVERY_KIND.to_vec()),
    ) {
        let pose = CameraPose { position: PositionNed::new(values[0], values[1], values[2]), ..camera(values[3], values[4], 0.0) };
        let target = SceneTarget {
            position: PositionNed::new(values[4], values[5], values[6]),
            size_m: values[7], roll_rad: values[8], beat_rad: values[1], kind, ..SceneTarget::default()
        };
        let mut small = vec![0; 3 * 16 * 12];
        Scene::new(1).with_clouds(values[0]).render(&pose, &[target], 16, 12, &mut small);
        for seen in truth(&pose, &[target], SIZE_PX) {
            prop_assert!(Lens::new(&pose, SIZE_PX).depth_m(&target.position) > 0.0);
            prop_assert!(seen.width_px > 0.0 && seen.width_px <= f64::from(SIZE_PX.0), "{seen:?}");
        }
    }
}

#[test]
fn a_ball_is_as_large_as_it_is_and_half_of_it_is_half_inside() {
    let pose = camera(0.0, 0.0, 0.0);
    let whole = target_at(&pose, TargetKind::Marker, 40.0, (0.0, 0.0));
    let edge = target_at(&pose, TargetKind::Marker, 40.0, (0.5, 0.0));
    let outside = target_at(&pose, TargetKind::Marker, 40.0, (0.7, 0.0));
    let behind = SceneTarget {
        position: pose.position.moved(pose.position.vector() - whole.position.vector()),
        ..whole
    };
    let seen = truth(&pose, &[outside, whole, behind, edge], SIZE_PX);
    assert_eq!(seen.iter().map(|seen| seen.target).collect::<Vec<_>>(), [1, 3]);
    let ([middle, half], lens) = (<[Seen; 2]>::try_from(seen).unwrap(), Lens::new(&pose, SIZE_PX));
    // A ball of radius r at a distance d is seen under asin(r / d).
    let distance_m = lens.depth_m(&whole.position);
    let across_px = 2.0 * lens.focal_px * (0.5 / distance_m).asin().tan();
    assert!((middle.width_px - across_px).abs() < 1e-9 && (middle.height_px - across_px).abs() < 1e-9);
    assert!((middle.center_x_px - 100.0).abs() < 1e-9 && (middle.center_y_px - 75.0).abs() < 1e-9);
    assert!((middle.inside - 1.0).abs() < 1e-12 && middle.position == whole.position);
    assert!(
        (half.inside - 0.5).abs() < 0.03 && (half.center_x_px + half.width_px / 2.0 - 200.0).abs() < 1e-9,
        "{half:?}"
    );
}

#[test]
fn a_bird_that_beats_its_wings_changes_its_shape() {
    let pose = camera(0.0, 0.0, 0.0);
    let bird = target_at(&pose, TargetKind::Bird, 60.0, (0.0, 0.0));
    let shape = |beat_rad: f64| {
        let seen = truth(
            &pose,
            &[SceneTarget {
                yaw_rad: 3.0,
                beat_rad,
                ..bird
            }],
            SIZE_PX,
        );
        (seen[0].width_px, seen[0].height_px)
    };
    let (level, raised) = (shape(0.2), shape(1.9));
    assert!(raised.1 > 1.5 * level.1 && raised.0 < level.0, "{level:?} {raised:?}");
}

#[test]
fn a_warm_body_is_bright_against_a_cool_sky_and_the_ground_in_between() {
    let scene = Scene::new(3).with_look(Look::Infrared);
    let pose = camera(0.0, 0.0, 1.0);
    let bird = target_at(&pose, TargetKind::Bird, 60.0, (0.0, -0.25));
    let rgb = drawn(&scene, &pose, &[bird]);
    assert!(
        rgb.as_chunks::<3>()
            .0
            .iter()
            .all(|[red, green, blue]| red == green && green == blue)
    );
    let row = |row: usize| &rgb[3 * row * SIZE_PX.0 as usize..3 * (row + 1) * SIZE_PX.0 as usize];
    let (sky, ground) = (row(0)[0], row(149)[0]);
    let body = row(37).iter().max().copied().unwrap();
    assert!(
        sky < 70 && ground > sky + 20 && body > ground + 60,
        "{sky} {ground} {body}"
    );
}

#[test]
fn clouds_stand_in_the_sky_and_nowhere_else() {
    let pose = camera(0.0, 0.3, 1.0);
    let (clear, clouded) = (Scene::new(3), Scene::new(3).with_clouds(0.5));
    let differing = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 8).count();
    let (without, with) = (drawn(&clear, &pose, &[]), drawn(&clouded, &pose, &[]));
    assert!(differing(&without, &with) > without.len() / 10);
    assert_eq!(with, drawn(&clouded, &pose, &[]));
    assert!(differing(&with, &drawn(&Scene::new(4).with_clouds(0.5), &pose, &[])) > 0);
    // Half a metre on the way they are where they were: nothing in them is finer than a pixel.
    let on = CameraPose {
        position: pose.position.moved(nalgebra::Vector3::new(0.3, 0.4, 0.0)),
        ..pose
    };
    assert_eq!(differing(&with, &drawn(&clouded, &on, &[])), 0);
    let down = CameraPose {
        pitch_rad: -0.8,
        ..pose
    };
    assert_eq!(drawn(&clear, &down, &[]), drawn(&clouded, &down, &[]));
}
