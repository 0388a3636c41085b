//! Pictures against the ground truth of where things are in them.

use super::*;
use proptest::prelude::*;

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn looking(position: PositionNed, roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> CameraPose {
    CameraPose {
        position,
        roll_rad: roll_deg.to_radians(),
        pitch_rad: pitch_deg.to_radians(),
        yaw_rad: yaw_deg.to_radians(),
        field_of_view_rad: 1.2,
    }
}

fn picture(pose: &CameraPose, targets: &[SceneTarget]) -> Vec<u8> {
    brightness(&Scene::new(3), pose, targets)
}

fn brightness(scene: &Scene, pose: &CameraPose, targets: &[SceneTarget]) -> Vec<u8> {
    let mut rgb = vec![0; 3 * (WIDTH * HEIGHT) as usize];
    scene.render(pose, targets, WIDTH, HEIGHT, &mut rgb);
    let bright = |pixel: &[u8; 3]| {
        let [red, green, blue] = pixel.map(f32::from);
        (0.299 * red + 0.587 * green + 0.114 * blue) as u8
    };
    rgb.as_chunks::<3>().0.iter().map(bright).collect()
}

/// Middle of the pixels in which two pictures differ by more than a little, and how many there are.
fn blob(with: &[u8], without: &[u8], least: u8) -> Option<(f64, f64, usize)> {
    let changed: Vec<usize> = (0..with.len())
        .filter(|i| with[*i].abs_diff(without[*i]) >= least)
        .collect();
    let count = changed.len();
    let sum = changed.iter().fold((0.0, 0.0), |(u, v), i| {
        let (row, column) = (i / WIDTH as usize, i % WIDTH as usize);
        (u + column as f64 + 0.5, v + row as f64 + 0.5)
    });
    (count > 0).then(|| (sum.0 / count as f64, sum.1 / count as f64, count))
}

#[test]
fn a_place_ahead_is_in_the_middle_and_others_where_they_belong() {
    let pose = looking(PositionNed::new(5.0, 5.0, -10.0), 0.0, 0.0, 90.0);
    let at = |north, east, down| project(&pose, &PositionNed::new(north, east, down), WIDTH, HEIGHT);
    let middle = at(5.0, 50.0, -10.0).unwrap();
    assert!((middle.0 - 80.0).abs() < 1e-9 && (middle.1 - 60.0).abs() < 1e-9);
    // Looking east, north is to the left and down is below.
    assert!(at(8.0, 50.0, -10.0).unwrap().0 < 80.0);
    assert!(at(5.0, 50.0, -7.0).unwrap().1 > 60.0);
    assert_eq!(at(5.0, 4.0, -10.0), None, "behind");
    // The edge of the field of view is the edge of the picture.
    let edge = at(5.0 - 45.0 * 0.6_f64.tan(), 50.0, -10.0).unwrap();
    assert!((edge.0 - 160.0).abs() < 1e-9, "{edge:?}");
}

#[test]
fn the_horizon_leans_with_the_camera_and_sinks_when_it_looks_up() {
    let above_below = |roll_deg: f64, pitch_deg: f64, column: usize| {
        let out = picture(
            &looking(PositionNed::new(0.0, 0.0, -30.0), roll_deg, pitch_deg, 20.0),
            &[],
        );
        // The haze at the horizon is the brightest there is.
        let column: Vec<u8> = out.iter().copied().skip(column).step_by(WIDTH as usize).collect();
        (0..column.len()).max_by_key(|row| column[*row]).unwrap() as f64
    };
    assert!((above_below(0.0, 0.0, 80) - 60.0).abs() < 3.0);
    // The right side of the camera is down: the horizon stands higher there.
    assert!(above_below(20.0, 0.0, 150) < above_below(20.0, 0.0, 10) - 30.0);
    assert!(above_below(0.0, 15.0, 80) > 80.0);
}

#[test]
fn the_ground_stays_where_it_is_and_depends_on_the_seed() {
    let here = looking(PositionNed::new(0.0, 0.0, -20.0), 0.0, -90.0, 0.0);
    let pose = looking(PositionNed::new(3.0, 0.0, -20.0), 0.0, -90.0, 0.0);
    let (before, after) = (picture(&here, &[]), picture(&pose, &[]));
    // Looking straight down with north up: three metres north move everything down by three metres' worth of pixels.
    let shift = (3.0 / 20.0 * focal_length_px(1.2, WIDTH)).round() as usize;
    let same = (0..(HEIGHT as usize - shift) * WIDTH as usize)
        .filter(|i| before[*i].abs_diff(after[i + shift * WIDTH as usize]) < 12)
        .count();
    assert!(same > 9 * (HEIGHT as usize - shift) * WIDTH as usize / 10, "{same}");
    let other = brightness(&Scene::new(4), &here, &[]);
    assert_ne!(before, other);
    assert_eq!(before, picture(&here, &[]), "the same every time");
}

#[test]
fn a_short_buffer_gets_the_rows_that_fit() {
    let pose = looking(PositionNed::new(0.0, 0.0, -20.0), 5.0, -10.0, 0.0);
    let half = 3 * (WIDTH * HEIGHT) as usize / 2;
    let mut short = vec![7; half + 10];
    Scene::new(3).render(&pose, &[], WIDTH, HEIGHT, &mut short);
    assert_eq!(&short[half..], &[7; 10]);
}

/// FNV-1a of a picture's bytes.
fn hash(picture: &[u8]) -> u64 {
    let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    picture.iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

#[test]
fn a_scene_with_nothing_switched_on_is_drawn_as_it_always_was() {
    let eye = PositionNed::new(3.0, -4.0, -20.0);
    let target = |north_m, east_m, down_m, size_m, kind| SceneTarget {
        position: PositionNed::new(north_m, east_m, down_m),
        size_m,
        kind,
        ..SceneTarget::default()
    };
    let targets = [
        target(9.0, 0.0, -19.0, 0.7, TargetKind::Multirotor),
        target(20.0, 2.0, -21.0, 1.5, TargetKind::Marker),
        target(60.0, 30.0, -25.0, 0.6, TargetKind::Multirotor),
    ];
    let hashes = [
        (0.0, 0.0, 10.0),
        (12.0, -20.0, 25.0),
        (-7.0, 20.0, 5.0),
        (0.0, -90.0, 0.0),
    ]
    .map(|(roll_deg, pitch_deg, yaw_deg)| {
        let mut rgb = vec![0; 3 * (WIDTH * HEIGHT) as usize];
        let pose = looking(eye, roll_deg, pitch_deg, yaw_deg);
        Scene::with_ground(7, 1.5).render(&pose, &targets, WIDTH, HEIGHT, &mut rgb);
        hash(&rgb)
    });
    let before = [
        0x29ff_973c_634a_a904,
        0x185f_b53b_a542_75a0,
        0xf5f5_783c_ed31_caec,
        0x2682_7737_576c_5d23,
    ];
    assert_eq!(hashes, before, "{hashes:#018x?}");
}

fn direction() -> impl Strategy<Value = (f64, f64, f64)> {
    (-30.0..30.0, -60.0..40.0, -180.0..180.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_target_is_drawn_where_it_is_and_as_large_as_it_is(
        (roll_deg, pitch_deg, yaw_deg) in direction(), across in -0.42..0.42_f64, along in -0.3..0.3_f64,
        depth_m in 6.0..60.0_f64, size_px in 8.0..30.0_f64, marker in any::<bool>(),
    ) {
        let pose = looking(PositionNed::new(12.0, -7.0, -80.0), roll_deg, pitch_deg, yaw_deg);
        let lens = Lens::new(&pose, (WIDTH, HEIGHT));
        let ray = lens.ray(f64::from(WIDTH) * (0.5 + across), f64::from(HEIGHT) * (0.5 + along));
        let position = pose.position.moved(ray * depth_m);
        let size_m = size_px * depth_m / lens.focal_px;
        let kind = if marker { TargetKind::Marker } else { TargetKind::Multirotor };
        let (u, v) = project(&pose, &position, WIDTH, HEIGHT).unwrap();
        let without = picture(&pose, &[]);
        let with = picture(&pose, &[SceneTarget { position, size_m, kind, ..SceneTarget::default() }]);
        let (seen_u, seen_v, count) = blob(&with, &without, 12).expect("it is seen");
        let off = (seen_u - u).hypot(seen_v - v);
        prop_assert!(off < 1.5 + 0.12 * size_px, "{off} px off, at {u},{v}, {count} pixels");
        // No larger than its outline; a ball fills it.
        let full = 0.25 * std::f64::consts::PI * size_px * size_px;
        prop_assert!((count as f64) < 1.8 * full + 12.0, "{count} of {full}");
        if marker {
            prop_assert!(count as f64 > 0.6 * full, "{count} of {full}");
        } else {
            prop_assert!(count as f64 > 0.04 * full, "{count} of {full}");
            let (row, column) = (v as usize, u as usize);
            prop_assert!(with[row * WIDTH as usize + column] < 80, "its body is dark");
        }
    }

    #[test]
    fn the_nearer_of_two_is_in_front(order in any::<bool>(), yaw_deg in -180.0..180.0_f64) {
        let pose = looking(PositionNed::new(0.0, 0.0, -50.0), 0.0, 0.0, yaw_deg);
        let lens = Lens::new(&pose, (WIDTH, HEIGHT));
        let at = |depth_m: f64, kind| SceneTarget { position: pose.position.moved(lens.forward * depth_m), size_m: 2.0, kind, ..SceneTarget::default() };
        let mut targets = [at(10.0, TargetKind::Marker), at(20.0, TargetKind::Multirotor)];
        if order {
            targets.reverse();
        }
        let mut out = vec![0; (3 * WIDTH * HEIGHT) as usize];
        Scene::new(3).render(&pose, &targets, WIDTH, HEIGHT, &mut out);
        let middle = 3 * (60 * WIDTH + 80) as usize;
        prop_assert!(out[middle] > 100 && out[middle + 1] < 40, "red: {:?}", &out[middle..middle + 3]);
    }

    #[test]
    fn no_pose_and_no_target_does_harm(
        values in prop::array::uniform5(prop_oneof![any::<f64>(), -10.0..10.0_f64]), size_m in any::<f64>(),
        place in prop::array::uniform3(prop_oneof![any::<f64>(), -10.0..10.0_f64]),
    ) {
        let pose = CameraPose {
            position: PositionNed::new(values[0], values[1], values[0]),
            roll_rad: values[2], pitch_rad: values[3], yaw_rad: values[4], field_of_view_rad: values[1],
        };
        let position = PositionNed::new(place[0], place[1], place[2]);
        let target = SceneTarget { position, size_m, kind: TargetKind::Multirotor, ..SceneTarget::default() };
        let mut out = vec![0; 3 * 16 * 12];
        Scene::new(1).render(&pose, &[target], 16, 12, &mut out);
    }
}
