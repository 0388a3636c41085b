//! A ground station finds where video is sent to; cameras that speak for themselves are not doubled, and nobody can make it flood the line.
#![expect(deprecated, reason = "ground stations still use the older commands")]

use super::*;
use crate::frame::each_in_datagram;
use crate::metrics::EndpointCounters;
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage, MavResult, VideoStreamStatusFlags};
use mavlink::{MavlinkVersion, Message, MessageData};

const STATION: (u8, u8) = (255, 190);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(100.0 + seconds)
}

fn camera(name: &str, ports: &[u16]) -> ToldCamera {
    let stream = |port: &u16| ToldStream {
        name: name.into(),
        port: *port,
        running: true,
        rate_hz: 30.0,
        size_px: (1280, 720),
        bits_per_s: 4e6,
    };
    ToldCamera {
        name: name.into(),
        streams: ports.iter().map(stream).collect(),
    }
}

/// Calls `take` with a message as it comes from the line.
fn from_line<D: MessageData>(sender: (u8, u8), message: &D, mut take: impl FnMut(&Frame<'_>)) {
    let mut outbox = Outbox::new(sender.0, sender.1);
    outbox.push(message);
    outbox.drain(|bytes| each_in_datagram(bytes, &mut EndpointCounters::default(), |_, frame| take(frame)));
}

fn command(command: MavCmd, parameters: [f32; 2], component: u8) -> COMMAND_LONG_DATA {
    COMMAND_LONG_DATA {
        command,
        param1: parameters[0],
        param2: parameters[1],
        target_system: 1,
        target_component: component,
        ..COMMAND_LONG_DATA::default()
    }
}

/// What was said at which second: the component, its count, the message.
type Said = Vec<(f64, u8, u8, MavMessage)>;

struct Line {
    cameras: Cameras,
    now_s: f64,
}

impl Line {
    fn with(cameras: Vec<ToldCamera>) -> Self {
        let mut told = Cameras::new(1, 245);
        told.tell(at(0.0), cameras);
        Self {
            cameras: told,
            now_s: 0.0,
        }
    }

    fn run(&mut self, seconds: f64) -> Said {
        let (mut said, end_s) = (Vec::new(), self.now_s + seconds);
        while self.now_s < end_s {
            self.now_s += 0.01;
            let mut outbox = Outbox::new(245, 190);
            self.cameras.poll(at(self.now_s), &mut outbox);
            outbox.drain(|bytes| {
                each_in_datagram(bytes, &mut EndpointCounters::default(), |_, frame| {
                    let header = frame.header;
                    assert_eq!(header.system_id, 1, "as a part of the vehicle");
                    let message = MavMessage::parse(MavlinkVersion::V2, header.message_id, frame.payload).unwrap();
                    said.push((self.now_s, header.component_id, header.sequence, message));
                });
            });
        }
        said
    }

    fn ask(&mut self, asked: &COMMAND_LONG_DATA) -> bool {
        let (mut ours, now) = (false, at(self.now_s));
        from_line(STATION, asked, |frame| {
            assert_eq!(asked_system(frame), Some(1));
            ours = self.cameras.ask(now, frame);
        });
        ours
    }

    fn hear(&mut self, component: u8, custom_mode: u32) {
        let (message, now) = (
            HEARTBEAT_DATA {
                custom_mode,
                ..heartbeat(0)
            },
            at(self.now_s),
        );
        from_line((1, component), &message, |frame| self.cameras.hear(now, frame));
    }

    /// The answers to a command, without heartbeats.
    fn answers(&mut self, asked: &COMMAND_LONG_DATA) -> Vec<MavMessage> {
        self.ask(asked);
        let said = self.run(0.5).into_iter().map(|(.., message)| message);
        said.filter(|message| !matches!(message, MavMessage::HEARTBEAT(_)))
            .collect()
    }
}

fn speakers(said: &Said) -> Vec<u8> {
    let mut all: Vec<u8> = said.iter().map(|(_, component, ..)| *component).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn result(message: &MavMessage) -> MavResult {
    let MavMessage::COMMAND_ACK(ack) = message else {
        panic!("{message:?}")
    };
    assert_eq!((ack.target_system, ack.target_component), STATION);
    ack.result
}

#[test]
fn a_ground_station_finds_the_camera_and_the_port_of_its_stream() {
    let mut line = Line::with(vec![camera("zoom", &[5600, 5601])]);
    let said = line.run(10.0);
    assert!(said[0].0 > LISTEN_S - 0.005, "it listens first");
    assert!((7..=8).contains(&said.len()) && speakers(&said) == [105], "{said:?}");
    let sequences: Vec<u8> = said.iter().map(|(.., sequence, _)| *sequence).collect();
    assert!(sequences.windows(2).all(|pair| pair[1] == pair[0] + 1), "{sequences:?}");
    assert!(matches!(&said[0].3, MavMessage::HEARTBEAT(m) if m.mavtype == MavType::MAV_TYPE_CAMERA));

    let request = MavCmd::MAV_CMD_REQUEST_MESSAGE;
    let answers = line.answers(&command(request, [259.0, 0.0], 105));
    let [ack, MavMessage::CAMERA_INFORMATION(information)] = answers.as_slice() else {
        panic!("{answers:?}")
    };
    assert_eq!(result(ack), MavResult::MAV_RESULT_ACCEPTED);
    assert!(information.model_name.starts_with(b"zoom\0") && information.flags.bits() == 256);
    let answers = line.answers(&command(request, [269.0, 0.0], 105));
    let streams: Vec<_> = answers[1..]
        .iter()
        .map(|answer| match answer {
            MavMessage::VIDEO_STREAM_INFORMATION(m) => (m.stream_id, m.count, m.mavtype as u8, m.uri.to_str().unwrap()),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(streams, [(1, 2, 1, "5600"), (2, 2, 1, "5601")]);
    let answers = line.answers(&command(MavCmd::MAV_CMD_REQUEST_VIDEO_STREAM_STATUS, [2.0, 0.0], 105));
    let [_, MavMessage::VIDEO_STREAM_STATUS(status)] = answers.as_slice() else {
        panic!("{answers:?}")
    };
    let running = VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING;
    assert_eq!(
        (status.stream_id, status.flags, status.resolution_h),
        (2, running, 1280)
    );
    // and as one that asks all components of a vehicle for cameras
    let answers = line.answers(&command(MavCmd::MAV_CMD_REQUEST_CAMERA_INFORMATION, [1.0, 0.0], 0));
    assert!(
        matches!(answers.as_slice(), [_, MavMessage::CAMERA_INFORMATION(_)]),
        "{answers:?}"
    );
}

#[test]
fn what_it_does_not_do_it_does_not_say_it_does() {
    let mut line = Line::with(vec![camera("zoom", &[5600])]);
    line.run(5.0);
    for (number, parameters, expected) in [
        (
            MavCmd::MAV_CMD_IMAGE_START_CAPTURE,
            [0.0, 0.0],
            MavResult::MAV_RESULT_UNSUPPORTED,
        ),
        (
            MavCmd::MAV_CMD_VIDEO_STOP_STREAMING,
            [0.0, 0.0],
            MavResult::MAV_RESULT_UNSUPPORTED,
        ),
        (
            MavCmd::MAV_CMD_REQUEST_MESSAGE,
            [260.0, 0.0],
            MavResult::MAV_RESULT_UNSUPPORTED,
        ),
        (
            MavCmd::MAV_CMD_REQUEST_MESSAGE,
            [269.0, 7.0],
            MavResult::MAV_RESULT_DENIED,
        ),
        (
            MavCmd::MAV_CMD_VIDEO_START_STREAMING,
            [0.0, 0.0],
            MavResult::MAV_RESULT_ACCEPTED,
        ),
    ] {
        let answers = line.answers(&command(number, parameters, 105));
        assert_eq!((answers.len(), result(&answers[0])), (1, expected), "{number:?}");
    }
    // what is another's is left to it
    assert!(!line.ask(&command(MavCmd::MAV_CMD_REQUEST_MESSAGE, [259.0, 0.0], 100)));
    assert!(!line.ask(&command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0], 0)));
    let said = line.run(0.5);
    assert!(
        said.iter()
            .all(|(.., message)| matches!(message, MavMessage::HEARTBEAT(_))),
        "{said:?}"
    );
}

#[test]
fn a_camera_that_speaks_for_itself_keeps_its_id() {
    let mut line = Line::with(vec![camera("zoom", &[5600]), camera("wide", &[5601])]);
    line.hear(105, 0);
    assert_eq!(speakers(&line.run(5.0)), [103, 104]);
    // another one comes later
    line.hear(104, 0);
    assert_eq!(speakers(&line.run(2.0)), [102, 103]);
    // our own words that come back over a second link are nobody's
    line.hear(103, OUR_SIGN | 245);
    assert_eq!(speakers(&line.run(2.0)), [102, 103]);
    // all are taken: silence, until one is free again
    (100..=105).for_each(|component| line.hear(component, 0));
    assert!(line.run(20.0).is_empty());
    assert_eq!(speakers(&line.run(15.0)), [104, 105]);
    // and one that is not told of any more says nothing
    line.cameras.tell(at(line.now_s), vec![camera("wide", &[5601])]);
    assert_eq!(speakers(&line.run(2.0)).len(), 1);
    line.cameras.tell(at(line.now_s), Vec::new());
    assert!(line.run(2.0).is_empty() && line.cameras.due().is_none());
}

#[test]
fn many_questions_get_few_answers() {
    let mut line = Line::with(vec![camera("zoom", &[5600, 5601, 5602])]);
    line.run(5.0);
    for _ in 0..1000 {
        line.ask(&command(MavCmd::MAV_CMD_REQUEST_MESSAGE, [269.0, 0.0], 105));
    }
    let said = line.run(10.0);
    let answers = said
        .iter()
        .filter(|(.., message)| !matches!(message, MavMessage::HEARTBEAT(_)));
    assert_eq!(answers.count(), MOST_WAITING);
    let closest_s = said
        .windows(2)
        .map(|pair| pair[1].0 - pair[0].0)
        .fold(f64::MAX, f64::min);
    assert!(closest_s > APART_S - 0.011, "{closest_s} s");
}
