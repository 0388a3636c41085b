//! Models that are not what they should be.

use super::*;
use crate::picture::Picture;
use crate::settings::Runtime;

#[test]
fn a_wrong_model_is_refused_with_what_is_wrong() {
    let why = |name: &str| model(name).err().map(|fault| fault.to_string()).unwrap_or_default();
    assert!(
        why("four-channels").contains("not [1, 3, height, width]"),
        "{}",
        why("four-channels")
    );
    assert!(
        why("five-rows").contains("[1, 5, 2], not [1, 4 + 4 classes, boxes]"),
        "{}",
        why("five-rows")
    );
    assert!(why("nowhere").contains("nowhere.onnx"), "{}", why("nowhere"));
    let text = OnnxModel::new(b"no model".to_vec(), &Settings::default());
    assert!(matches!(text.err(), Some(ModelFault::Unreadable(_))));
}

#[test]
fn boxes_come_back_to_the_pictures_own_pixels() {
    let mut model = model("constant").expect("is a model");
    // Twice as large as the model's input, and with room above and below: 128 by 80 lies at 64 by 40, four pixels down.
    let picture = Picture {
        width: 128,
        height: 80,
        rgb: vec![90; 3 * 128 * 80],
    };
    let found = model.find(&picture, 0.5).expect("finds");
    let [one] = found.as_slice() else { panic!("{found:?}") };
    let bounds = one.bounds;
    assert_eq!((bounds.center_x_px, bounds.center_y_px), (32.0, 16.0));
    assert_eq!((bounds.width_px, bounds.height_px), (16.0, 12.0));
}

#[test]
fn our_own_models_see_nothing_in_an_empty_picture_and_take_any_size() {
    for own in [crate::settings::Model::Visible, crate::settings::Model::Infrared] {
        let settings = Settings {
            model: own,
            ..Settings::default()
        };
        let mut model = OnnxModel::of(&settings).expect("comes with the plugin");
        for (width, height) in [(320, 256), (640, 512), (1280, 720), (33, 200)] {
            let picture = Picture {
                width,
                height,
                rgb: vec![128; 3 * width * height],
            };
            let found = model.find(&picture, settings.certain_score).expect("can be looked at");
            assert_eq!(found, Vec::new(), "{own:?} {width} {height}");
        }
    }
}

#[test]
fn a_runtime_that_is_not_there_is_named_and_automatically_the_other_one_runs() {
    let elsewhere = |runtime: Runtime| {
        let settings = Settings {
            runtime,
            library: "/nowhere/libonnxruntime.so".into(),
            ..settings("constant")
        };
        OnnxModel::of(&settings)
    };
    let fault = elsewhere(Runtime::Onnx).err();
    let named = |why: &String| why.contains("/nowhere/libonnxruntime.so");
    assert!(
        matches!(&fault, Some(ModelFault::Runtime(why)) if named(why)),
        "{fault:?}"
    );
    assert_eq!(elsewhere(Runtime::Auto).expect("is run").runtime(), "rten");
}
