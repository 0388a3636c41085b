//! Tests of MP4 files: plain ones and ones in fragments, whose pictures are known; and damaged ones.

use super::*;
use muxide::fragmented::{FragmentConfig, FragmentedMuxer};
use openh264::OpenH264API;
use openh264::decoder::Decoder;
use openh264::encoder::{Encoder, EncoderConfig, FrameRate, IntraFramePeriod, RateControlMode};
use openh264::formats::{YUVBuffer, YUVSource};
use openh264::nal_units;
use proptest::prelude::*;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;
const PICTURES: u32 = 20;
const RATE_HZ: u32 = 10;

fn brightness_of(index: u32) -> u8 {
    40 + 8 * index as u8
}

fn part(name: &[u8; 4], contents: &[Vec<u8>]) -> Vec<u8> {
    let contents = contents.concat();
    let mut bytes = (8 + contents.len() as u32).to_be_bytes().to_vec();
    bytes.extend(name);
    bytes.extend(contents);
    bytes
}

fn numbers(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

/// Grey pictures that become brighter one by one: the two parameter sets, and each picture with the lengths of its units.
fn pictures() -> ([Vec<u8>; 2], Vec<Vec<u8>>) {
    let config = EncoderConfig::new()
        .skip_frames(false)
        .rate_control_mode(RateControlMode::Off)
        .max_frame_rate(FrameRate::from_hz(RATE_HZ as f32))
        .intra_frame_period(IntraFramePeriod::from_num_frames(8));
    let mut encoder = Encoder::with_api_config(OpenH264API::from_source(), config).unwrap();
    let (mut sets, mut samples) = ([Vec::new(), Vec::new()], Vec::new());
    for index in 0..PICTURES {
        let mut yuv = vec![brightness_of(index); WIDTH * HEIGHT];
        yuv.extend(vec![128; WIDTH * HEIGHT / 2]);
        let raw = encoder
            .encode(&YUVBuffer::from_vec(yuv, WIDTH, HEIGHT))
            .unwrap()
            .to_vec();
        let mut sample = Vec::new();
        for unit in nal_units(&raw) {
            let unit = unit
                .strip_prefix(&[0, 0, 0, 1])
                .or_else(|| unit.strip_prefix(&[0, 0, 1]))
                .unwrap_or(unit);
            match unit[0] & 0x1f {
                7 => sets[0] = unit.to_vec(),
                8 => sets[1] = unit.to_vec(),
                _ => {
                    sample.extend((unit.len() as u32).to_be_bytes());
                    sample.extend(unit);
                }
            }
        }
        assert!(!sample.is_empty());
        samples.push(sample);
    }
    (sets, samples)
}

fn mp4() -> Vec<u8> {
    let (sets, samples) = pictures();
    let head = part(b"ftyp", &[b"isom".to_vec(), numbers(&[512]), b"isomavc1".to_vec()]);
    let mdat = part(b"mdat", &samples);
    let lens: Vec<u32> = samples.iter().map(|sample| sample.len() as u32).collect();
    [head.clone(), mdat, moov(&sets, &lens, head.len() as u32 + 8)].concat()
}

/// The same pictures, a second in a fragment.
fn fragmented() -> Vec<u8> {
    let ([sps, pps], samples) = pictures();
    let config = FragmentConfig::new(WIDTH as u32, HEIGHT as u32, RATE_HZ).with_fragment_duration_ms(1000);
    let mut muxer = FragmentedMuxer::new(FragmentConfig { sps, pps, ..config }).unwrap();
    let mut bytes = muxer.init_segment();
    for (index, sample) in samples.iter().enumerate() {
        if muxer.ready_to_flush() {
            bytes.extend(muxer.flush_segment().unwrap());
        }
        let at = index as u64;
        // A unit of kind 5 is one that a decoder can begin with.
        muxer.write_video(at, at, sample, sample[4] & 0x1f == 5).unwrap();
    }
    bytes.extend(muxer.flush_segment().unwrap());
    bytes
}

fn moov([sps, pps]: &[Vec<u8>; 2], lens: &[u32], first: u32) -> Vec<u8> {
    let set = |unit: &Vec<u8>| [vec![1], (unit.len() as u16).to_be_bytes().to_vec(), unit.clone()].concat();
    let mut config = [vec![1, sps[1], sps[2], sps[3], 0xff], set(sps), set(pps)].concat();
    // The count of the first kind shares its byte with reserved bits.
    config[5] |= 0xe0;
    let mut entry = vec![0; 78];
    entry[7] = 1;
    entry[24..26].copy_from_slice(&(WIDTH as u16).to_be_bytes());
    entry[26..28].copy_from_slice(&(HEIGHT as u16).to_be_bytes());
    let avc1 = part(b"avc1", &[entry, part(b"avcC", &[config])]);
    let stbl = part(
        b"stbl",
        &[
            part(b"stsd", &[numbers(&[0, 1]), avc1]),
            part(b"stts", &[numbers(&[0, 1, PICTURES, 1])]),
            part(b"stsc", &[numbers(&[0, 1, 1, PICTURES, 1])]),
            part(b"stsz", &[numbers(&[0, 0, PICTURES]), numbers(lens)]),
            part(b"stco", &[numbers(&[0, 1, first])]),
        ],
    );
    let dinf = part(
        b"dinf",
        &[part(b"dref", &[numbers(&[0, 1]), part(b"url ", &[numbers(&[1])])])],
    );
    let minf = part(b"minf", &[part(b"vmhd", &[numbers(&[1, 0, 0])]), dinf, stbl]);
    let hdlr = part(b"hdlr", &[numbers(&[0, 0]), b"vide".to_vec(), vec![0; 13]]);
    let mdhd = part(b"mdhd", &[numbers(&[0, 0, 0, RATE_HZ, PICTURES, 0])]);
    let mdia = part(b"mdia", &[mdhd, hdlr, minf]);
    let mut tkhd = numbers(&[7, 0, 0, 1, 0, PICTURES]);
    tkhd.extend(vec![0; 52]);
    tkhd.extend(numbers(&[(WIDTH as u32) << 16, (HEIGHT as u32) << 16]));
    let mut mvhd = numbers(&[0, 0, 0, RATE_HZ, PICTURES, 0x1_0000]);
    mvhd.extend(vec![0; 76]);
    part(
        b"moov",
        &[part(b"mvhd", &[mvhd]), part(b"trak", &[part(b"tkhd", &[tkhd]), mdia])],
    )
}

fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    file
}

#[test]
fn a_plain_file_that_was_cut_off_has_no_table() {
    let bytes = mp4();
    // The table stands at its end.
    let cut = file(&bytes[..bytes.len() / 2]);
    assert!(matches!(Mp4Reader::open(cut.path()), Err(Mp4ReadError::Damaged { .. })));
    let nowhere = Mp4Reader::open(Path::new("/nowhere"));
    assert!(matches!(nowhere, Err(Mp4ReadError::Unreadable { .. })));
    let text = file(b"this is no video at all, but a sentence");
    assert!(Mp4Reader::open(text.path()).is_err());
}

#[test]
fn a_file_in_fragments_is_read_as_far_as_it_is_whole() {
    let (bytes, whole) = (fragmented(), file(&mp4()));
    let (cut, uncut) = (file(&bytes[..bytes.len() - 7]), file(&bytes));
    let (mut plain, mut fragments) = (
        Mp4Reader::open(whole.path()).unwrap(),
        Mp4Reader::open(uncut.path()).unwrap(),
    );
    assert_eq!((fragments.len(), &fragments.shown_s), (plain.len(), &plain.shown_s));
    for index in 0..plain.len() {
        // The plain file does not say which pictures a decoder can begin with: all are told the parameter sets.
        let (here, there) = (fragments.coded(index).unwrap(), plain.coded(index).unwrap());
        assert!(there.ends_with(&here), "{index}");
        assert_eq!(here.len() == there.len(), index % 8 == 0, "{index}");
        assert!((fragments.decoded_at_s(index) - plain.decoded_at_s(index)).abs() < 1e-9);
    }
    // The last fragment is not whole; those before it are shown.
    let left = Mp4Reader::open(cut.path()).unwrap().len();
    assert!(left > 0 && left < PICTURES as usize, "{left}");
    // What has no fragment yet says so.
    let head = bytes.windows(4).position(|name| name == b"moof").unwrap() - 4;
    assert!(matches!(
        Mp4Reader::open(file(&bytes[..head]).path()),
        Err(Mp4ReadError::Empty { .. })
    ));
}

#[test]
fn its_pictures_come_as_they_are_encoded_with_their_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.mp4");
    std::fs::write(&path, mp4()).unwrap();
    let mut video = Mp4Reader::open(&path).unwrap();
    assert_eq!(video.len(), PICTURES as usize);
    assert!((video.duration_s() - f64::from(PICTURES) / f64::from(RATE_HZ)).abs() < 1e-6);
    let mut decoder = Decoder::new().unwrap();
    for index in 0..video.len() {
        assert!((video.decoded_at_s(index) - index as f64 / f64::from(RATE_HZ)).abs() < 1e-6);
        let coded = video.coded(index).unwrap();
        let picture = decoder.decode(&coded).unwrap().expect("a picture");
        assert!(picture.y()[0].abs_diff(brightness_of(index as u32)) < 6);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Only the container: what a decoder makes of damaged pictures is not decided here.
    #[test]
    fn no_damage_of_the_container_makes_it_panic(
        in_fragments in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = once()[usize::from(in_fragments)].clone();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let file = file(&bytes);
        if let Ok(video) = Mp4Reader::open(file.path()) {
            prop_assert_eq!(video.shown_s.len(), video.samples.len());
            let size = bytes.len() as u64;
            prop_assert!(video.samples.iter().all(|sample| sample.start + sample.len as u64 <= size));
        }
    }

    #[test]
    fn any_configuration_of_a_decoder_is_read(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        let _ = parameter_sets(&bytes);
        let mut raw = Vec::new();
        append_units(&bytes, 4, &mut raw);
        prop_assert!(raw.len() <= bytes.len());
    }
}

fn once() -> &'static [Vec<u8>; 2] {
    static FILES: std::sync::OnceLock<[Vec<u8>; 2]> = std::sync::OnceLock::new();
    FILES.get_or_init(|| [mp4(), fragmented()])
}
