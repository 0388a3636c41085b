//! Steps that do not rise, and triggers that must not be off, are refused by name.

use crate::NodeConfig;

fn refusal(text: &str) -> String {
    NodeConfig::parse(text).expect_err("refused").to_string()
}

#[test]
fn link_loss_and_stale_estimates_cannot_be_off() {
    for trigger in ["link_loss", "stale_estimate"] {
        let error = refusal(&format!("[safety.failsafe.{trigger}]\nmode = \"off\"\n"));
        assert!(error.contains(&format!("safety.failsafe.{trigger}.mode")), "{error}");
        let warn_only = format!("[safety.failsafe.{trigger}]\nmode = \"warn_only\"\n");
        assert!(NodeConfig::parse(&warn_only).is_ok(), "{trigger}");
        let error = refusal(&format!("[safety.failsafe.{trigger}]\nsteps = []\n"));
        assert!(error.contains(&format!("safety.failsafe.{trigger}.steps")), "{error}");
    }
    assert!(NodeConfig::parse("[safety.failsafe.tracking_error]\nmode = \"off\"\n").is_ok());
}

#[test]
fn steps_rise_in_time_and_strength() {
    let rule = |steps: &str| format!("[safety.failsafe.gnss_loss]\nsteps = [{steps}]\n");
    let step = |after_s: &str, reaction: &str| format!("{{ after_s = {after_s}, reaction = \"{reaction}\" }}");
    let both = |a: String, b: String| rule(&format!("{a}, {b}"));
    assert!(NodeConfig::parse(&both(step("1", "warn"), step("2", "land"))).is_ok());
    for wrong in [
        both(step("2", "warn"), step("1", "land")),
        both(step("1", "land"), step("2", "hold")),
        both(step("1", "warn"), step("nan", "hold")),
        rule(&step("1e9", "hold")),
        rule(&step("-1", "hold")),
    ] {
        let error = refusal(&wrong);
        assert!(error.contains("safety.failsafe.gnss_loss.steps"), "{error}");
    }
    let unknown = refusal(&rule(&step("1", "explode")));
    assert!(unknown.contains("explode"), "{unknown}");
}

#[test]
fn a_limit_that_clears_above_itself_is_refused() {
    let error = refusal("[safety.failsafe.tracking_error]\nlimit_m = 2.0\nclear_m = 3.0\n");
    assert!(error.contains("safety.failsafe.tracking_error.clear_m"), "{error}");
    let error = refusal("[safety.failsafe]\nreaction_within_s = inf\n");
    assert!(error.contains("safety.failsafe.reaction_within_s"), "{error}");
}

#[test]
fn words_are_written_as_they_are_shown() {
    for trigger in skein_domain::Trigger::ALL {
        assert_eq!(serde_json::json!(trigger), trigger.word());
    }
    for reaction in skein_domain::Reaction::ALL {
        assert_eq!(serde_json::json!(reaction), reaction.word());
    }
}
