//! The plugin: commands in, the device turned, the state told.

mod judging;
mod report;

use crate::aim::{Aim, Pending, PendingOf, Rates, Sweep};
use crate::attitude::{Direction, Limits, Yaw};
use crate::device::Device;
use crate::following::Following;
use crate::manager;
use crate::orders::{Control, ControlOutcome, Moment, Turn};
use crate::settings::Settings;
use minicbor::{Decode, Encode};
use report::Reporter;
use skein_domain::exchange::{Create, Event, OwnState, Severity};
use skein_domain::manifest::EffectKind;
use skein_domain::payload::{GimbalCommand, GimbalOwner, GimbalState};
use skein_domain::{CommandId, Geodetic, NodeTime, Refusal, SwarmFrame};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, saved};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;
/// What is wanted is sent again after this time, in seconds, for messages of this kind are not acknowledged.
const REPEAT_S: f64 = 0.5;
/// Pause after control was refused before it is asked for again, in seconds.
const CONTROL_PAUSE_S: f64 = 2.0;

/// A gimbal of one vehicle.
#[derive(Debug)]
pub struct Gimbal {
    settings: Settings,
    core: Core,
    /// The vehicle as it was last told; every batch tells it anew.
    own: OwnState,
    reporter: Reporter,
}

/// What outlives a restart.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
struct Core {
    #[n(0)]
    device: Device,
    #[n(1)]
    aim: Aim,
    #[n(2)]
    pending: Option<Pending>,
    /// When what is wanted was last sent.
    #[n(3)]
    sent: Option<NodeTime>,
    /// When control was last asked for without a command for it.
    #[n(4)]
    control_asked: Option<NodeTime>,
    /// Angles were reached: they need not be sent again.
    #[n(5)]
    reached: bool,
    /// Where rates have brought it, if it is told angles for them.
    #[n(6)]
    sweep: Option<Sweep>,
    #[n(7)]
    #[cbor(default)]
    following: Following,
}

impl Payload for Gimbal {
    type Config = Settings;
    type Command = GimbalCommand;
    type State = GimbalState;
    type Occurrence = ();

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::GIMBAL,
        name: "gimbal",
        version: env!("CARGO_PKG_VERSION"),
        description: "A gimbal over MAVLink's gimbal protocol v2 or SIYI's own: angles, rates, places to point at, and who steers it.",
        effects: &[
            EffectKind::CommandProgress,
            EffectKind::Notice,
            EffectKind::Mavlink,
            EffectKind::Transmit,
            EffectKind::Report,
        ],
        mavlink_messages: manager::MESSAGES,
        tick_rate_hz: 20,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let restored = saved::restored(SNAPSHOT_VERSION, create.snapshot.as_deref());
        let fits = |core: &Core| core.device.fits(&settings);
        let core = restored.filter(fits).unwrap_or_else(|| Core {
            device: Device::new(&settings, create.system_id),
            aim: Aim::Idle,
            pending: None,
            sent: None,
            control_asked: None,
            reached: false,
            sweep: None,
            following: Following::default(),
        });
        Ok(Self {
            settings,
            core,
            own: OwnState::default(),
            reporter: Reporter::default(),
        })
    }

    fn command(&mut self, now: NodeTime, id: CommandId, command: GimbalCommand, effects: &mut Effects) {
        if let Err(refusal) = self.begin(now, id, command, effects) {
            effects.refused(id, refusal);
        }
        self.report(now, effects);
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            match event {
                Event::Own(own) => self.own = *own,
                Event::Mavlink(_) | Event::Received { .. } => self.hear(now, event, effects),
                Event::Tick => self.tick(now, effects),
                _ => {}
            }
        }
        self.report(now, effects);
    }

    fn snapshot(&self) -> Vec<u8> {
        saved::encode(SNAPSHOT_VERSION, &self.core)
    }
}

/// The parts that a step works on, borrowed apart so that the device can look at the moment while it changes.
fn moment<'a>(now: NodeTime, settings: &'a Settings, own: &OwnState) -> Moment<'a> {
    Moment {
        now,
        settings,
        vehicle_yaw_rad: own.kinematics.map(|kinematics| kinematics.yaw_rad),
        vehicle_roll_pitch_rad: own.roll_rad.zip(own.pitch_rad),
    }
}

impl Gimbal {
    /// Begins a command, or says why not. A command that was not done yet ends by it.
    fn begin(
        &mut self,
        now: NodeTime,
        id: CommandId,
        command: GimbalCommand,
        effects: &mut Effects,
    ) -> Result<(), Refusal> {
        let aim = Aim::of(&command, self.settings.rate_max_rad_s)?;
        let status = self.core.device.status(&moment(now, &self.settings, &self.own));
        if !status.connected {
            return Err(Refusal::not_running("the gimbal"));
        }
        if let (
            Some(_),
            GimbalOwner::Other {
                system_id,
                component_id,
            },
        ) = (aim, status.owner)
        {
            return Err(foreign(system_id, component_id));
        }
        if matches!(aim, Some(Aim::Place(_))) && self.place().is_none() {
            return Err(Refusal::NoPosition);
        }
        self.end(Err(Refusal::Superseded), effects);
        effects.executing(id);
        let of = match (aim, command) {
            (Some(aim), _) => {
                self.core.aim = aim;
                self.core.sent = None;
                self.core.control_asked = None;
                self.core.reached = false;
                self.core.sweep = None;
                self.core.following.restart();
                PendingOf::Aim
            }
            (None, GimbalCommand::ReleaseControl) => {
                self.core.aim = Aim::Idle;
                PendingOf::Release
            }
            (None, _) => PendingOf::Take,
        };
        self.core.pending = Some(Pending { id, begun: now, of });
        match of {
            PendingOf::Aim => self.drive(now, effects),
            PendingOf::Take => self.ask(now, Control::Take, effects),
            PendingOf::Release => self.ask(now, Control::Release, effects),
        }
        Ok(())
    }

    /// Ends the command that is under way, if there is one.
    fn end(&mut self, outcome: Result<(), Refusal>, effects: &mut Effects) {
        if let Some(pending) = self.core.pending.take() {
            effects.ended(pending.id, outcome);
        }
    }

    fn hear(&mut self, now: NodeTime, event: &Event, effects: &mut Effects) {
        let at = moment(now, &self.settings, &self.own);
        let outcome = self.core.device.hear(&at, event);
        self.control_ended(now, outcome, effects);
    }

    fn ask(&mut self, now: NodeTime, control: Control, effects: &mut Effects) {
        let at = moment(now, &self.settings, &self.own);
        let outcome = self.core.device.ask(&at, control, effects);
        self.control_ended(now, outcome, effects);
    }

    fn control_ended(&mut self, now: NodeTime, outcome: Option<ControlOutcome>, effects: &mut Effects) {
        let Some((control, outcome)) = outcome else {
            return;
        };
        let waits_for = self.core.pending.map(|pending| pending.of);
        match (control, waits_for, outcome) {
            (Control::Take, Some(PendingOf::Take), outcome) | (Control::Release, Some(PendingOf::Release), outcome) => {
                self.end(outcome, effects);
            }
            (Control::Take, Some(PendingOf::Aim), Err(refusal)) => {
                self.core.aim = Aim::Idle;
                self.end(Err(refusal), effects);
            }
            (Control::Take, Some(PendingOf::Aim), Ok(())) => self.drive(now, effects),
            _ => {}
        }
    }

    fn tick(&mut self, now: NodeTime, effects: &mut Effects) {
        let at = moment(now, &self.settings, &self.own);
        let outcome = self.core.device.work(&at, effects);
        self.control_ended(now, outcome, effects);
        self.yield_to_others(now, effects);
        self.drive(now, effects);
        self.judge(now, effects);
        self.look_after(now, effects);
    }

    /// Whoever else steers the gimbal has it: what was asked here before ends.
    fn yield_to_others(&mut self, now: NodeTime, effects: &mut Effects) {
        let status = self.core.device.status(&moment(now, &self.settings, &self.own));
        let GimbalOwner::Other {
            system_id,
            component_id,
        } = status.owner
        else {
            return;
        };
        if self.core.aim == Aim::Idle {
            return;
        }
        self.core.aim = Aim::Idle;
        if self.core.pending.is_some_and(|pending| pending.of == PendingOf::Aim) {
            self.end(Err(foreign(system_id, component_id)), effects);
        }
        effects.notice(
            Severity::Advisory,
            format!("The gimbal is now steered by system {system_id}, component {component_id}."),
        );
    }

    /// Sends what is wanted where that is due, and gets control for it first.
    fn drive(&mut self, now: NodeTime, effects: &mut Effects) {
        let at = moment(now, &self.settings, &self.own);
        let status = self.core.device.status(&at);
        if self.core.aim == Aim::Idle || !status.connected {
            return;
        }
        if !self.core.device.obeys() {
            if self.core.device.is_free(&at) && !at.within(self.core.control_asked, CONTROL_PAUSE_S) {
                self.core.control_asked = Some(now);
                self.ask(now, Control::Take, effects);
            }
            return;
        }
        let follows = self.is_to_follow();
        let rests = self.core.reached && !follows;
        if rests || !follows && at.within(self.core.sent, REPEAT_S) {
            return;
        }
        let direction = match self.core.aim {
            Aim::Rates(rates) if !self.core.device.turns_at_rates() => self.swept(now, rates),
            _ => self.wanted(now),
        };
        let turn = match (self.core.aim, direction) {
            (Aim::Rates(rates), None) if self.core.device.turns_at_rates() => Turn::At(rates),
            // One move, and the first time that it is asked for.
            (Aim::Angles(_), Some(direction)) if !follows && self.core.sent.is_none() => Turn::Once(direction),
            (_, Some(direction)) => Turn::To(direction),
            (_, None) => return,
        };
        self.core.sent = Some(now);
        let at = moment(now, &self.settings, &self.own);
        self.core.device.turn(&at, turn, effects);
    }

    /// Whether it has to be told anew in every tick where to look.
    fn is_to_follow(&self) -> bool {
        match self.core.aim {
            Aim::Idle => false,
            Aim::Place(_) => true,
            Aim::Rates(rates) => !self.core.device.turns_at_rates() && rates != Rates::NONE,
            Aim::Angles(direction) => matches!(direction.yaw, Yaw::North(_)) && !self.core.device.holds_north(),
        }
    }

    /// Where rates have brought it, from where it looked when they began. `None` until that is known.
    fn swept(&mut self, now: NodeTime, rates: Rates) -> Option<Direction> {
        let at = moment(now, &self.settings, &self.own);
        let direction = match self.core.sweep {
            Some(sweep) => sweep.at(now, rates),
            None => {
                let looks = self.core.device.status(&at).attitude?;
                Direction {
                    pitch_rad: looks.pitch_rad,
                    yaw: Yaw::Vehicle(looks.yaw.off_nose(at.vehicle_yaw_rad)?),
                }
            }
        };
        let direction = self.limits(now).nearest(direction, at.vehicle_yaw_rad);
        self.core.sweep = Some(Sweep { when: now, direction });
        Some(direction)
    }

    /// Where the gimbal is to look, within what it can reach.
    fn wanted(&self, now: NodeTime) -> Option<Direction> {
        let at = moment(now, &self.settings, &self.own);
        let direction = match self.core.aim {
            Aim::Idle => return None,
            Aim::Rates(_) => self.core.sweep?.direction,
            Aim::Angles(direction) => direction,
            Aim::Place(place) => {
                let attitude = self.core.device.status(&at).attitude;
                let present = attitude.and_then(|attitude| attitude.yaw.off_north(at.vehicle_yaw_rad));
                Direction::towards(&self.place()?, &place, present.unwrap_or_default())
            }
        };
        Some(self.limits(now).nearest(direction, at.vehicle_yaw_rad))
    }

    fn limits(&self, now: NodeTime) -> Limits {
        let at = moment(now, &self.settings, &self.own);
        let (low, high) = (self.settings.pitch_min_rad, self.settings.pitch_max_rad);
        let own = Limits {
            pitch_min_rad: low,
            pitch_max_rad: high,
            yaw_min_rad: None,
            yaw_max_rad: None,
        };
        self.core.device.status(&at).limits.unwrap_or(own).within(low, high)
    }

    /// Where the vehicle is on Earth.
    fn place(&self) -> Option<Geodetic> {
        let from_frame = || {
            let (origin, kinematics) = (self.own.frame_origin?, self.own.kinematics?);
            Some(SwarmFrame::new(origin).geodetic(&kinematics.position))
        };
        self.own.global.or_else(from_frame).filter(Geodetic::is_valid)
    }
}

fn foreign(system_id: u8, component_id: u8) -> Refusal {
    Refusal::not_permitted(format!(
        "the gimbal is steered by system {system_id}, component {component_id}; take control of it first"
    ))
}
