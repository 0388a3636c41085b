//! A camera that does what the tests of its host tell it to: right, wrong and fatal. Not for flying.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_plugin_sdk::domain::exchange::{Create, Effect, Event, Severity};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::payload::{FrameHeader, PixelFormat};
use skein_plugin_sdk::domain::{CommandId, NodeTime};
use skein_plugin_sdk::frames::{self, FrameMut};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, log};

/// Size of its pictures.
const SIDE_PX: u32 = 64;

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Config {
    /// Fail already when it is created.
    refuse: bool,
    /// Take no end when it is destroyed.
    hang_at_end: bool,
}

/// What it can be told.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Order {
    /// Add to what it remembers.
    Remember { text: String },
    /// Report this state, whatever the schema says.
    Report { json: String },
    /// Tell this event, whatever the schema says.
    Tell { json: String },
    /// Give a picture of this brightness.
    Picture { brightness: u8 },
    /// Borrow a buffer and keep it.
    Keep,
    /// Give back all that were kept.
    GiveBack,
    /// Give a frame under a number it was not lent.
    FalseFrame { id: u64 },
    /// Give a frame whose header does not fit.
    WrongHeader,
    /// An effect that is not in the manifest.
    Forbidden,
    /// Write lines to the log.
    Log { lines: u32 },
    /// Write to standard error.
    Stderr { text: String, times: u32 },
    /// Say what it can see of its surroundings.
    LookAround,
    /// Open files until it gets no more; say how many it got.
    OpenFiles,
    /// Take memory until it gets no more.
    TakeMemory,
    /// Turn forever on a thread of its own.
    Spin,
    /// End in this way.
    Die { how: Death },
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Death {
    Panic,
    Abort,
    Exit,
    SegmentationFault,
    StackOverflow,
    Hang,
}

/// What it reports.
#[derive(Debug, Serialize, JsonSchema)]
struct State {
    /// How often.
    #[allow(dead_code, reason = "the reports are written by hand, also wrong ones")]
    count: u32,
}

struct TestCamera {
    config: Config,
    remembered: Vec<u8>,
    kept: Vec<FrameMut>,
}

impl Payload for TestCamera {
    type Config = Config;
    type Command = Order;
    type State = State;
    type Occurrence = State;

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::CAMERA,
        name: "test-camera",
        version: "1.0.0",
        description: "Does what the tests tell it to.",
        effects: &[
            EffectKind::Transmit,
            EffectKind::Report,
            EffectKind::Occurrence,
            EffectKind::Frame,
            EffectKind::CommandProgress,
        ],
        mavlink_messages: &[0],
        tick_rate_hz: 10,
    };

    fn create(create: Create, config: Config) -> Result<Self, CreateError> {
        if config.refuse {
            return Err(CreateError::new("refused on purpose"));
        }
        Ok(Self {
            config,
            remembered: create.snapshot.unwrap_or_default(),
            kept: Vec::new(),
        })
    }

    fn command(&mut self, _: NodeTime, id: CommandId, order: Order, effects: &mut Effects) {
        match order {
            Order::Remember { text } => self.remembered.extend(text.into_bytes()),
            Order::Report { json } => effects.push(Effect::Report { state_json: json }),
            Order::Tell { json } => effects.push(Effect::Occurrence { event_json: json }),
            Order::Picture { brightness } => picture(brightness, effects),
            Order::Keep => match frames::acquire(16) {
                Some(frame) => self.kept.push(frame),
                None => effects.transmit(b"none".to_vec()),
            },
            Order::GiveBack => self.kept.clear(),
            Order::FalseFrame { id } => effects.push(Effect::Frame(FrameHeader { id, ..header() })),
            Order::WrongHeader => {
                if let Some(frame) = frames::acquire(100) {
                    effects.frame(frame, header());
                }
            }
            Order::Forbidden => effects.notice(Severity::Info, "not in the manifest"),
            Order::Log { lines } => (0..lines).for_each(|line| log::info!("line {line}")),
            Order::Stderr { text, times } => (0..times).for_each(|_| eprintln!("{text}")),
            Order::LookAround => effects.transmit(surroundings().into_bytes()),
            Order::OpenFiles => {
                let files: Vec<_> = (0..10_000)
                    .map_while(|_| std::fs::File::open("/dev/null").ok())
                    .collect();
                effects.transmit(files.len().to_string().into_bytes());
            }
            Order::TakeMemory => take_memory(),
            Order::Spin => drop(std::thread::spawn(|| {
                loop {
                    std::hint::spin_loop();
                }
            })),
            Order::Die { how } => die(&how),
        }
        effects.done(id);
    }

    fn handle(&mut self, _: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            match event {
                Event::Received { bytes } => effects.transmit(bytes.clone()),
                Event::Frame(header) => {
                    let sum = frames::read(header, |bytes| bytes.iter().map(|b| u64::from(*b)).sum::<u64>());
                    effects.transmit(format!("{sum:?}").into_bytes());
                }
                _ => {}
            }
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        self.remembered.clone()
    }
}

impl Drop for TestCamera {
    fn drop(&mut self) {
        if self.config.hang_at_end {
            die(&Death::Hang);
        }
    }
}

fn header() -> FrameHeader {
    FrameHeader {
        sequence: 1,
        width_px: SIDE_PX,
        height_px: SIDE_PX,
        format: PixelFormat::Gray8,
        len: u64::from(SIDE_PX * SIDE_PX),
        ..FrameHeader::default()
    }
}

fn picture(brightness: u8, effects: &mut Effects) {
    match frames::acquire((SIDE_PX * SIDE_PX) as usize) {
        Some(mut frame) => {
            frame.fill(brightness);
            effects.frame(frame, header());
        }
        None => effects.transmit(b"none".to_vec()),
    }
}

/// What a plugin can see of the process it runs in.
fn surroundings() -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let variables = std::env::vars().count();
    let entries = std::fs::read_dir("/proc/self/fd").into_iter().flatten().flatten();
    let files: Vec<_> = entries
        .map(|entry| std::fs::read_link(entry.path()).unwrap_or_default())
        .collect();
    format!("{} {variables} {files:?}", folder.display())
}

fn take_memory() {
    let mut taken = Vec::new();
    for _ in 0..64 << 10 {
        taken.push(vec![1_u8; 1 << 20]);
    }
    drop(std::hint::black_box(taken));
}

fn die(how: &Death) {
    match how {
        Death::Panic => panic!("on purpose"),
        Death::Abort => std::process::abort(),
        #[expect(clippy::disallowed_methods, reason = "that is what is tested")]
        Death::Exit => std::process::exit(3),
        // SAFETY: none. That is what is tested.
        Death::SegmentationFault => unsafe { std::ptr::null_mut::<u8>().write_volatile(1) },
        Death::StackOverflow => drop(std::hint::black_box(deeper(1))),
        Death::Hang => loop {
            std::thread::park();
        },
    }
}

#[expect(unconditional_recursion, reason = "that is what is tested")]
fn deeper(depth: u64) -> [u64; 512] {
    let mut room = [depth; 512];
    room[0] += deeper(std::hint::black_box(depth + 1))[511];
    std::hint::black_box(room)
}

skein_plugin_sdk::export_payload!(TestCamera);
