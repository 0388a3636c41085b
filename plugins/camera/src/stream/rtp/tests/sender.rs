//! Who sends H.264 as RTP in these tests: access units of drawn sizes, packed in the ways that senders have.

/// Larger NAL units are sent in fragments.
const MOST_PAYLOAD_BYTES: usize = 1_200;
/// Pictures follow each other closely, so that the window of these tests is one of packets.
const TICKS: u32 = 90;

const DELIMITER: [u8; 2] = [9, 0x10];

/// Whether a picture is this access unit. A delimiter may be lost before parameter sets: it says nothing that these do not.
pub(super) fn is_same(picture: &[u8], unit: &[u8]) -> bool {
    let bare = unit.strip_prefix(&[0, 0, 0, 1, DELIMITER[0], DELIMITER[1]]);
    picture == unit || bare.is_some_and(|bare| picture == bare)
}

/// An access unit.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    pub(super) is_key: bool,
    pub(super) slice_lens: Vec<usize>,
}

/// How parameter sets and ends of access units are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// Parameter sets before each key picture, alone.
    SetsEachTime,
    /// The same, aggregated; no marker, only the timestamp tells of an end.
    Aggregated,
    /// Slices alone.
    SetsNever,
    /// As the first, with a delimiter before each picture.
    Delimited,
}

impl Style {
    pub(super) const ALL: [Self; 4] = [Self::SetsEachTime, Self::Aggregated, Self::SetsNever, Self::Delimited];
}

/// An SPS and a PPS.
pub(super) fn sets() -> [Vec<u8>; 2] {
    [vec![0x67, 0x42, 0xc0, 0x1e, 0xd9], vec![0x68, 0xcb, 0x8c, 0xb2]]
}

pub(super) fn append(nal: &[u8], unit: &mut Vec<u8>) {
    unit.extend([0, 0, 0, 1]);
    unit.extend(nal);
}

/// The NAL units of a picture; no two pictures have the same ones.
fn nals(index: usize, shot: &Shot, style: Style) -> Vec<Vec<u8>> {
    let mut nals = Vec::new();
    if style == Style::Delimited {
        nals.push(DELIMITER.to_vec());
    }
    if shot.is_key && style != Style::SetsNever {
        nals.extend(sets());
    }
    for (slice, len) in shot.slice_lens.iter().enumerate() {
        let header = if shot.is_key { 0x65 } else { 0x41 };
        // Only the first slice of a picture begins with its first macroblock.
        let mut nal = vec![header, if slice == 0 { 0x88 } else { 0x28 }];
        nal.extend([index as u8, (index >> 8) as u8, slice as u8]);
        nal.extend((0..*len).map(|byte| (byte * 7 + index) as u8 | 1));
        nals.push(nal);
    }
    nals
}

/// The pictures as they are to come out.
pub(super) fn units_of(shots: &[Shot], style: Style) -> Vec<Vec<u8>> {
    let unit = |(index, shot)| {
        let mut unit = Vec::new();
        nals(index, shot, style).iter().for_each(|nal| append(nal, &mut unit));
        unit
    };
    shots.iter().enumerate().map(unit).collect()
}

/// Numbers and stamps packets.
pub(super) struct Sender {
    ssrc: u32,
    sequence: u16,
    timestamp: u32,
    style: Style,
}

impl Sender {
    pub(super) fn new(ssrc: u32, sequence: u16, style: Style) -> Self {
        Self {
            ssrc,
            sequence,
            // It goes round soon.
            timestamp: u32::MAX - 2 * TICKS,
            style,
        }
    }

    fn packet(&mut self, marker: bool, payload: &[u8]) -> Vec<u8> {
        let mut packet = vec![0x80, 96 | if marker { 0x80 } else { 0 }];
        packet.extend(self.sequence.to_be_bytes());
        packet.extend(self.timestamp.to_be_bytes());
        packet.extend(self.ssrc.to_be_bytes());
        packet.extend(payload);
        self.sequence = self.sequence.wrapping_add(1);
        packet
    }

    /// The packets of each picture.
    pub(super) fn send(&mut self, shots: &[Shot]) -> Vec<Vec<Vec<u8>>> {
        let mut sent: Vec<Vec<Vec<u8>>> = Vec::new();
        for (index, shot) in shots.iter().enumerate() {
            let payloads = payloads(&nals(index, shot, self.style), self.style);
            let last = payloads.len() - 1;
            let has_marker = self.style != Style::Aggregated;
            let packets = payloads.iter().enumerate();
            let packets = packets.map(|(at, payload)| self.packet(has_marker && at == last, payload));
            sent.push(packets.collect());
            self.timestamp = self.timestamp.wrapping_add(TICKS);
        }
        if self.style == Style::Aggregated
            && let Some(last) = sent.last_mut()
        {
            // A delimiter with the next timestamp tells that the last picture has ended.
            last.push(self.packet(false, &DELIMITER));
        }
        sent
    }

    /// The parameter sets by themselves, each with a marker, as some senders have it.
    pub(super) fn send_sets(&mut self) -> Vec<Vec<u8>> {
        sets().iter().map(|set| self.packet(true, set)).collect()
    }
}

fn payloads(nals: &[Vec<u8>], style: Style) -> Vec<Vec<u8>> {
    let mut payloads = Vec::new();
    let mut rest = nals;
    if style == Style::Aggregated && nals.len() > 2 && nals[0][0] == 0x67 {
        let mut together = vec![0x78];
        for nal in &nals[..2] {
            together.extend((nal.len() as u16).to_be_bytes());
            together.extend(nal);
        }
        payloads.push(together);
        rest = &nals[2..];
    }
    for nal in rest {
        if nal.len() <= MOST_PAYLOAD_BYTES {
            payloads.push(nal.clone());
            continue;
        }
        let parts: Vec<&[u8]> = nal[1..].chunks(MOST_PAYLOAD_BYTES - 2).collect();
        for (at, part) in parts.iter().enumerate() {
            let start = if at == 0 { 0x80 } else { 0 };
            let end = if at == parts.len() - 1 { 0x40 } else { 0 };
            let mut payload = vec![nal[0] & 0xe0 | 28, start | end | nal[0] & 0x1f];
            payload.extend(*part);
            payloads.push(payload);
        }
    }
    payloads
}
