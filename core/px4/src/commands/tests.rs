//! Retries, progress, refusals with their words, confirmation, and commands that replace each other.

use super::*;
use crate::plan::{Command, Goal, PlanStep, plan};
use mavlink::dialects::common::{MavCmd, MavSeverity, STATUSTEXT_DATA};
use skein_domain::{AutopilotCommand, FlightMode, LandedState};

const ARM_DISARM: u16 = 400;
const SET_MODE: u16 = 176;
const LAND: u16 = 21;

struct Bench {
    now: NodeTime,
    settings: LinkSettings,
    commands: Commands,
    situation: Situation,
    stream_has_run: bool,
    texts: StatusTexts,
    modes: ModeWatch,
    ended: Vec<Ended>,
    /// Commands sent: number and confirmation.
    sent: Vec<(u16, u8)>,
}

struct SentTo<'a>(&'a mut Vec<(u16, u8)>);

impl CommandOutlet for SentTo<'_> {
    fn command(&mut self, command: &Command, confirmation: u8) {
        self.0.push((command.number(), confirmation));
    }
}

impl Bench {
    fn new() -> Self {
        let situation = Situation {
            landed: LandedState::InAir,
            armed: true,
            mode: FlightMode::Hold,
            ..Situation::default()
        };
        Self {
            now: NodeTime::from_seconds(10.0),
            settings: LinkSettings::default(),
            commands: Commands::default(),
            situation,
            stream_has_run: false,
            texts: StatusTexts::default(),
            modes: ModeWatch::default(),
            ended: Vec::new(),
            sent: Vec::new(),
        }
    }

    fn act(&mut self, act: impl FnOnce(&mut Commands, &mut Around<'_>)) {
        let mut around = Around {
            now: self.now,
            settings: &self.settings,
            situation: self.situation,
            stream_has_run: self.stream_has_run,
            texts: &self.texts,
            modes: &mut self.modes,
            outlet: &mut SentTo(&mut self.sent),
            ended: &mut self.ended,
        };
        act(&mut self.commands, &mut around);
    }

    fn request(&mut self, number: u32, command: AutopilotCommand) {
        let plan = plan(command, &self.situation).unwrap();
        self.act(|commands, around| commands.start(around, Origin::Request(RequestId(number)), plan));
    }

    fn ack(&mut self, command: u16, result: u8) {
        let ack = Acknowledgement {
            command,
            result,
            ..Acknowledgement::default()
        };
        self.act(|commands, around| commands.on_ack(around, &ack));
    }

    fn text(&mut self, text: &str) {
        let severity = MavSeverity::MAV_SEVERITY_CRITICAL;
        self.texts.on_message(
            self.now,
            &STATUSTEXT_DATA {
                severity,
                text: text.into(),
                ..STATUSTEXT_DATA::default()
            },
        );
        self.act(Commands::poll);
    }

    /// Lets time pass, polling when it is due.
    fn wait(&mut self, seconds: f64) {
        let end = self.now.plus_seconds(seconds);
        while let Some(due) = self.commands.due().filter(|due| *due <= end) {
            self.now = due.max(self.now.plus_seconds(0.001));
            self.act(Commands::poll);
        }
        self.now = end;
        self.act(Commands::poll);
    }

    fn mode(&mut self, mode: FlightMode) {
        self.situation.mode = mode;
        self.act(Commands::poll);
    }

    fn outcome(&mut self, number: u32) -> Option<Result<(), Refusal>> {
        let found = self
            .ended
            .iter()
            .position(|ended| ended.origin == Origin::Request(RequestId(number)))?;
        Some(self.ended.remove(found).outcome)
    }
}

#[test]
fn accepted_only_when_acknowledged_and_seen() {
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::Land);
    bench.mode(FlightMode::Land);
    assert_eq!(bench.outcome(1), None, "seen but not acknowledged");
    bench.ack(LAND, 0);
    assert_eq!(bench.outcome(1), Some(Ok(())));
    bench.request(2, AutopilotCommand::SetMode { mode: FlightMode::Hold });
    bench.ack(SET_MODE, 0);
    bench.wait(2.0);
    assert_eq!(bench.outcome(2), None, "acknowledged but not seen");
    bench.wait(2.0);
    assert!(matches!(bench.outcome(2), Some(Err(Refusal::TimedOut { what, .. })) if what == "mode hold"));
}

#[test]
fn sent_again_with_a_counting_confirmation_and_then_given_up() {
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::Disarm);
    bench.wait(0.9);
    assert_eq!(bench.sent, [(ARM_DISARM, 0), (ARM_DISARM, 1)]);
    bench.text("Unsupported ARM_DISARM param");
    bench.wait(5.0);
    assert_eq!(
        bench
            .sent
            .iter()
            .map(|(_, confirmation)| *confirmation)
            .collect::<Vec<_>>(),
        [0, 1, 2, 3, 4]
    );
    let Some(Err(Refusal::TimedOut { what, after_s })) = bench.outcome(1) else {
        panic!()
    };
    assert!(
        what.contains("disarm") && what.contains("Unsupported ARM_DISARM param"),
        "{what}"
    );
    assert!((after_s - 2.5).abs() < 0.05);
}

#[test]
fn in_progress_extends_the_time_but_not_for_ever() {
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::Disarm);
    for _ in 0..10 {
        bench.wait(2.0);
        bench.ack(ARM_DISARM, Acknowledgement::IN_PROGRESS);
    }
    assert_eq!(bench.outcome(1), None);
    bench.situation.armed = false;
    bench.ack(ARM_DISARM, 0);
    assert_eq!(bench.outcome(1), Some(Ok(())));
    bench.request(2, AutopilotCommand::Arm);
    for _ in 0..40 {
        bench.ack(ARM_DISARM, Acknowledgement::IN_PROGRESS);
        bench.wait(2.0);
    }
    assert!(matches!(bench.outcome(2), Some(Err(Refusal::TimedOut { .. }))));
}

#[test]
fn a_refusal_carries_the_text_before_or_after_it_and_none_from_elsewhen() {
    let refused = |text: &str| {
        Some(Err(Refusal::Autopilot {
            result: "denied".into(),
            text: text.into(),
        }))
    };
    let mut bench = Bench::new();
    bench.text("an old story");
    bench.wait(1.0);
    bench.request(1, AutopilotCommand::Disarm);
    bench.wait(0.01);
    bench.text("not landed");
    bench.ack(ARM_DISARM, 2);
    bench.wait(0.1);
    assert_eq!(bench.outcome(1), refused("not landed"), "before");
    bench.wait(1.0);
    bench.request(2, AutopilotCommand::Disarm);
    bench.ack(ARM_DISARM, 2);
    bench.wait(0.1);
    bench.text("not landed");
    bench.wait(0.1);
    assert_eq!(bench.outcome(2), refused("not landed"), "after");
    bench.wait(1.0);
    bench.request(3, AutopilotCommand::Disarm);
    bench.ack(ARM_DISARM, 2);
    bench.wait(0.2);
    assert_eq!(bench.outcome(3), None);
    bench.wait(0.1);
    assert_eq!(bench.outcome(3), refused(""), "never: no long wait");
}

#[test]
fn one_of_a_number_at_a_time_and_the_newest_wins() {
    let mut bench = Bench::new();
    bench.request(
        1,
        AutopilotCommand::SetMode {
            mode: FlightMode::Mission,
        },
    );
    bench.request(2, AutopilotCommand::ReturnToLaunch);
    assert_eq!(bench.outcome(1), Some(Err(Refusal::Superseded)));
    assert_eq!(
        bench.sent,
        [(SET_MODE, 0)],
        "the second waits for the first one's answer"
    );
    bench.ack(SET_MODE, 1);
    assert_eq!(
        bench.sent,
        [(SET_MODE, 0), (SET_MODE, 0)],
        "which was not taken for its own"
    );
    bench.ack(SET_MODE, 0);
    bench.mode(FlightMode::Return);
    assert_eq!(bench.outcome(2), Some(Ok(())));
    // Another number need not wait.
    bench.request(3, AutopilotCommand::ReturnToLaunch);
    bench.request(4, AutopilotCommand::Land);
    assert_eq!(bench.sent.last(), Some(&(LAND, 0)));
    assert_eq!(bench.outcome(3), Some(Err(Refusal::Superseded)));
    bench.ack(LAND, 0);
    bench.mode(FlightMode::Land);
    assert_eq!(bench.outcome(4), Some(Ok(())));
}

#[test]
fn a_second_answer_to_a_repeated_command_is_not_the_nexts() {
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::Disarm);
    bench.wait(0.6);
    bench.ack(ARM_DISARM, 1);
    bench.wait(0.0);
    bench.request(2, AutopilotCommand::Arm);
    bench.ack(ARM_DISARM, 1);
    assert_eq!(bench.sent.len(), 2, "the number rests");
    bench.wait(0.2);
    assert_eq!(bench.sent.len(), 3);
    bench.ack(ARM_DISARM, 0);
    assert_eq!(bench.outcome(2), Some(Ok(())));
    bench.ack(ARM_DISARM, 4);
    bench.ack(9999, 4);
    assert!(bench.outcome(2).is_none(), "answers nobody waits for are nothing");
}

#[test]
fn offboard_waits_for_the_stream_within_a_bound() {
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::EnterOffboard);
    bench.wait(1.0);
    assert!(bench.sent.is_empty() && bench.commands.is_entering_offboard());
    bench.stream_has_run = true;
    bench.wait(0.0);
    assert_eq!(bench.sent, [(SET_MODE, 0)]);
    bench.ack(SET_MODE, 0);
    bench.mode(FlightMode::Offboard);
    assert_eq!(bench.outcome(1), Some(Ok(())));
    let mut bench = Bench::new();
    bench.request(1, AutopilotCommand::EnterOffboard);
    bench.wait(3.1);
    assert!(matches!(bench.outcome(1), Some(Err(Refusal::TimedOut { .. }))));
    assert!(bench.sent.is_empty(), "never without a stream");
}

#[test]
fn arming_after_a_landing_from_offboard_takes_two_steps() {
    let mut bench = Bench::new();
    let landed = LandedState::OnGround;
    bench.situation = Situation {
        armed: false,
        mode: FlightMode::Offboard,
        landed,
        ..Situation::default()
    };
    bench.request(1, AutopilotCommand::Arm);
    assert_eq!(bench.sent, [(SET_MODE, 0)]);
    bench.ack(SET_MODE, 0);
    assert_eq!(bench.sent.len(), 1, "not before HOLD is seen");
    bench.mode(FlightMode::Hold);
    assert_eq!(bench.sent, [(SET_MODE, 0), (ARM_DISARM, 0)]);
    bench.ack(ARM_DISARM, 0);
    bench.situation.armed = true;
    bench.wait(0.0);
    assert_eq!(bench.outcome(1), Some(Ok(())));
}

#[test]
fn too_many_are_refused_and_all_can_be_ended() {
    let mut bench = Bench::new();
    let step = PlanStep {
        command: Command::long(MavCmd::MAV_CMD_IMAGE_START_CAPTURE, [0.0; 7]),
        goal: Goal::Acknowledged,
    };
    for number in 0..40 {
        let plan = Plan {
            name: "x",
            class: Class::Service,
            condition: Condition::None,
            steps: vec![step],
        };
        bench.act(|commands, around| commands.start(around, Origin::Request(RequestId(number)), plan));
    }
    assert!(matches!(bench.outcome(39), Some(Err(Refusal::InvalidValue { .. }))));
    assert_eq!(bench.sent.len(), 1, "one of a number at a time");
    let refusal = Refusal::DuplicateSystemId { system_id: 1 };
    let Bench { commands, ended, .. } = &mut bench;
    commands.end_all(ended, &refusal);
    assert_eq!(bench.outcome(0), Some(Err(refusal)));
    assert_eq!(bench.commands.due(), None);
}
