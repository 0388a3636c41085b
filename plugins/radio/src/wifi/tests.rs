//! Tests of what the kernel says, as bytes laid out by its own header (linux/nl80211.h).

use super::interface::{Interface, figures, find, noise, strongest};
use super::netlink::{WifiError, read};
use super::*;
use proptest::prelude::*;
use wl_nl80211::Nl80211Message;
use wl_nl80211::packet_generic::GenlMessage;

const FAMILY: u16 = 0x1c;
const DONE: u16 = 3;
const ERROR: u16 = 2;
const NEW_INTERFACE: u8 = 7;
const NEW_STATION: u8 = 19;
const NEW_SURVEY: u8 = 51;

fn attribute(kind: u16, value: &[u8]) -> Vec<u8> {
    let mut bytes = (4 + value.len() as u16).to_ne_bytes().to_vec();
    bytes.extend(kind.to_ne_bytes());
    bytes.extend(value);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

fn message(kind: u16, sequence: u32, contents: &[u8]) -> Vec<u8> {
    let mut bytes = (16 + contents.len() as u32).to_ne_bytes().to_vec();
    bytes.extend(kind.to_ne_bytes());
    bytes.extend(2_u16.to_ne_bytes());
    bytes.extend(sequence.to_ne_bytes());
    bytes.extend([0; 4]);
    bytes.extend(contents);
    bytes
}

fn told(command: u8, attributes: &[Vec<u8>]) -> Vec<u8> {
    let mut contents = vec![command, 1, 0, 0];
    contents.extend(attributes.concat());
    message(FAMILY, 7, &contents)
}

fn interface() -> Vec<u8> {
    told(
        NEW_INTERFACE,
        &[
            attribute(3, &5_u32.to_ne_bytes()),
            attribute(4, b"wlan0\0"),
            attribute(38, &5180_u32.to_ne_bytes()),
            attribute(98, &2000_u32.to_ne_bytes()),
        ],
    )
}

fn station(signal_dbm: i8, packets: u32, failed: u32) -> Vec<u8> {
    let info = [
        attribute(7, &signal_dbm.to_ne_bytes()),
        attribute(13, &(signal_dbm - 1).to_ne_bytes()),
        attribute(8, &attribute(5, &1300_u32.to_ne_bytes())),
        attribute(10, &packets.to_ne_bytes()),
        attribute(12, &failed.to_ne_bytes()),
    ];
    told(
        NEW_STATION,
        &[
            attribute(3, &5_u32.to_ne_bytes()),
            attribute(6, &[2, 0, 0, 0, 0, 1]),
            attribute(21, &info.concat()),
        ],
    )
}

fn survey(mhz: u32, noise_dbm: i8) -> Vec<u8> {
    let info = [attribute(1, &mhz.to_ne_bytes()), attribute(2, &noise_dbm.to_ne_bytes())];
    told(
        NEW_SURVEY,
        &[attribute(3, &5_u32.to_ne_bytes()), attribute(84, &info.concat())],
    )
}

fn answers(datagram: &[u8]) -> Result<(bool, Vec<Nl80211Message>), WifiError> {
    let mut answers: Vec<GenlMessage<Nl80211Message>> = Vec::new();
    let complete = read(datagram, 7, &mut answers)?;
    Ok((complete, answers.into_iter().map(|answer| answer.payload).collect()))
}

fn all(datagrams: &[Vec<u8>]) -> Vec<Nl80211Message> {
    let mut datagram = datagrams.concat();
    datagram.extend(message(DONE, 7, &0_i32.to_ne_bytes()));
    let (complete, answers) = answers(&datagram).unwrap();
    assert!(complete);
    answers
}

#[test]
fn an_interface_is_found_by_its_name() {
    let found = find(all(&[interface()]), "wlan0").unwrap();
    let wanted = Interface {
        index: 5,
        name: "wlan0".to_owned(),
        mhz: Some(5180),
        power_dbm: Some(20.0),
    };
    assert_eq!(found, wanted);
    assert_eq!(find(all(&[interface()]), "").unwrap(), wanted);
    assert!(matches!(
        find(all(&[interface()]), "wlan1"),
        Err(WifiError::NoInterface { .. })
    ));
    assert!(matches!(find(all(&[]), ""), Err(WifiError::NoInterface { .. })));
}

#[test]
fn figures_are_those_of_the_strongest_station() {
    let interface = find(all(&[interface()]), "").unwrap();
    let stations = all(&[station(-70, 10, 0), station(-55, 1200, 30), station(-80, 10, 0)]);
    let noise_dbm = noise(&all(&[survey(2412, -80), survey(5180, -95)]), interface.mhz);
    let figures = figures(&interface, strongest(&stations).unwrap(), noise_dbm, Some((200, 20)));
    assert_eq!((figures.rssi_dbm, figures.noise_dbm), (Some(-56.0), Some(-95.0)));
    assert!((figures.loss.unwrap() - 10.0 / 1010.0).abs() < 1e-9);
    assert_eq!((figures.channel, figures.power_dbm), (Some(36), Some(20.0)));
    assert_eq!(figures.throughput_bit_s, Some(130e6));
    assert!(strongest(&[]).is_none());
}

#[test]
fn counters_that_jumped_back_say_nothing_of_losses() {
    let interface = find(all(&[interface()]), "").unwrap();
    let stations = all(&[station(-55, 5, 1)]);
    let info = strongest(&stations).unwrap();
    assert_eq!(figures(&interface, info, None, Some((1000, 50))).loss, None);
    assert_eq!(figures(&interface, info, None, None).loss, None);
}

#[test]
fn refusals_of_the_kernel_are_typed() {
    let refused = |code: i32| answers(&message(ERROR, 7, &[&code.to_ne_bytes()[..], &[0; 16]].concat()));
    let error = refused(-1).unwrap_err();
    assert_eq!(error.refusal().code(), "not_permitted", "{error}");
    assert_eq!(refused(-95).unwrap_err().refusal().code(), "not_supported");
    assert!(refused(0).unwrap().0, "no error is an acknowledgement");
    // What answers another question is not ours.
    assert!(!answers(&message(DONE, 6, &0_i32.to_ne_bytes())).unwrap().0);
}

#[test]
fn channels_and_their_middles() {
    for (channel, mhz) in [(1, 2412), (13, 2472), (14, 2484), (36, 5180), (165, 5825)] {
        assert_eq!(Change::channel(channel), Some(Change::Frequency(mhz)));
        assert_eq!(channel_of(mhz), Some(channel));
    }
    assert_eq!(
        (Change::channel(0), Change::channel(15), Change::channel(200)),
        (None, None, None)
    );
    assert_eq!(Change::power(17.5), Change::Power(1750));
}

proptest! {
    #[test]
    fn any_bytes_can_be_read(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = answers(&bytes);
    }

    #[test]
    fn any_attributes_can_be_read(attributes in prop::collection::vec((0_u16..120, prop::collection::vec(any::<u8>(), 0..24)), 0..8)) {
        let attributes: Vec<Vec<u8>> = attributes.iter().map(|(kind, value)| attribute(*kind, value)).collect();
        let _ = answers(&told(NEW_STATION, &attributes));
    }
}
