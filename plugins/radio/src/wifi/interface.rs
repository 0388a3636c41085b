//! One Wi-Fi interface: what it measures, and what can be set on it.

use super::netlink::{Connection, WifiError};
use super::{Change, channel_of};
use crate::link::Figures;
use wl_nl80211::packet_core::DefaultNla;
use wl_nl80211::{Nl80211Attr, Nl80211Command, Nl80211Message, Nl80211RateInfo, Nl80211StationInfo, Nl80211SurveyInfo};

/// Attributes and values of nl80211 that the library has no word for.
const TX_POWER_SETTING: u16 = 97;
const TX_POWER_FIXED: u32 = 2;

/// The interface, and what was counted before.
#[derive(Debug, Default)]
pub(super) struct Station {
    connection: Option<Connection>,
    /// Packets sent and failed, as they stood at the last measurement.
    counted: Option<(u32, u32)>,
}

/// An interface as the kernel tells of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Interface {
    pub(super) index: u32,
    pub(super) name: String,
    pub(super) mhz: Option<u32>,
    pub(super) power_dbm: Option<f64>,
}

impl Station {
    pub(super) fn measure(&mut self, name: &str) -> Result<Figures, WifiError> {
        let measured = self.connection().and_then(|connection| ask(connection, name));
        if let Err(WifiError::Kernel(_) | WifiError::Silent | WifiError::Unreadable(_)) = measured {
            // A fresh connection next time.
            self.connection = None;
        }
        let (interface, stations, survey) = measured?;
        let heard = strongest(&stations).ok_or(WifiError::NotConnected {
            name: interface.name.clone(),
        })?;
        let before = self.counted.replace(packets(heard));
        Ok(figures(&interface, heard, noise(&survey, interface.mhz), before))
    }

    pub(super) fn change(&mut self, name: &str, change: Change) -> Result<(), WifiError> {
        let connection = self.connection()?;
        let interface = find(connection.dump(question(Nl80211Command::GetInterface, vec![]))?, name)?;
        let mut attributes = vec![Nl80211Attr::IfIndex(interface.index)];
        match change {
            Change::Frequency(mhz) => attributes.push(Nl80211Attr::WiphyFreq(mhz)),
            Change::Power(hundredths_dbm) => {
                let fixed = TX_POWER_FIXED.to_ne_bytes().to_vec();
                attributes.push(Nl80211Attr::Other(DefaultNla::new(TX_POWER_SETTING, fixed)));
                attributes.push(Nl80211Attr::WiphyTxPowerLevel(hundredths_dbm));
            }
        }
        connection.set(question(Nl80211Command::SetWiphy, attributes))
    }

    fn connection(&mut self) -> Result<&mut Connection, WifiError> {
        let connection = match self.connection.take() {
            Some(connection) => connection,
            None => Connection::open()?,
        };
        Ok(self.connection.insert(connection))
    }
}

type Answers = (Interface, Vec<Nl80211Message>, Vec<Nl80211Message>);

fn ask(connection: &mut Connection, name: &str) -> Result<Answers, WifiError> {
    let interface = find(connection.dump(question(Nl80211Command::GetInterface, vec![]))?, name)?;
    let of_it = || vec![Nl80211Attr::IfIndex(interface.index)];
    let stations = connection.dump(question(Nl80211Command::GetStation, of_it()))?;
    // Not every driver surveys its channel.
    let survey = connection
        .dump(question(Nl80211Command::GetSurvey, of_it()))
        .unwrap_or_default();
    Ok((interface, stations, survey))
}

fn question(cmd: Nl80211Command, attributes: Vec<Nl80211Attr>) -> Nl80211Message {
    Nl80211Message { cmd, attributes }
}

/// The interface of this name, or the first that has one.
pub(super) fn find(answers: Vec<Nl80211Message>, name: &str) -> Result<Interface, WifiError> {
    let mut interfaces = answers.into_iter().filter_map(|answer| {
        let mut found = Interface {
            index: 0,
            name: String::new(),
            mhz: None,
            power_dbm: None,
        };
        for attribute in answer.attributes {
            match attribute {
                Nl80211Attr::IfIndex(index) => found.index = index,
                Nl80211Attr::IfName(name) => found.name = name,
                Nl80211Attr::WiphyFreq(mhz) => found.mhz = Some(mhz),
                Nl80211Attr::WiphyTxPowerLevel(hundredths) => {
                    found.power_dbm = Some(f64::from(hundredths.cast_signed()) * 0.01);
                }
                _ => {}
            }
        }
        (!found.name.is_empty()).then_some(found)
    });
    interfaces
        .find(|interface| name.is_empty() || interface.name == name)
        .ok_or(WifiError::NoInterface { name: name.to_owned() })
}

/// What is known of the station that is heard best: an access point hears several.
pub(super) fn strongest(stations: &[Nl80211Message]) -> Option<&[Nl80211StationInfo]> {
    let infos = stations
        .iter()
        .flat_map(|station| &station.attributes)
        .filter_map(|attribute| match attribute {
            Nl80211Attr::StationInfo(info) => Some(info.as_slice()),
            _ => None,
        });
    infos.max_by_key(|info| signal_dbm(info))
}

fn signal_dbm(info: &[Nl80211StationInfo]) -> Option<i8> {
    let average = info.iter().find_map(|i| match i {
        Nl80211StationInfo::SignalAvg(dbm) => Some(*dbm),
        _ => None,
    });
    average.or_else(|| {
        info.iter().find_map(|i| match i {
            Nl80211StationInfo::Signal(dbm) => Some(*dbm),
            _ => None,
        })
    })
}

fn packets(info: &[Nl80211StationInfo]) -> (u32, u32) {
    let mut counted = (0, 0);
    for i in info {
        match i {
            Nl80211StationInfo::TxPackets(sent) => counted.0 = *sent,
            Nl80211StationInfo::TxFailed(failed) => counted.1 = *failed,
            _ => {}
        }
    }
    counted
}

/// Noise on the channel in use.
pub(super) fn noise(survey: &[Nl80211Message], mhz: Option<u32>) -> Option<f64> {
    let surveys = survey
        .iter()
        .flat_map(|channel| &channel.attributes)
        .filter_map(|attribute| match attribute {
            Nl80211Attr::SurveyInfo(info) => Some(info),
            _ => None,
        });
    surveys
        .filter(|info| {
            info.iter()
                .any(|i| matches!(i, Nl80211SurveyInfo::Frequency(of) if Some(*of) == mhz))
        })
        .find_map(|info| {
            info.iter().find_map(|i| match i {
                Nl80211SurveyInfo::Noise(dbm) => Some(f64::from(*dbm)),
                _ => None,
            })
        })
}

pub(super) fn figures(
    interface: &Interface,
    info: &[Nl80211StationInfo],
    noise_dbm: Option<f64>,
    before: Option<(u32, u32)>,
) -> Figures {
    let (sent, failed) = packets(info);
    // Counters that jumped back belong to another connection.
    let since = before.and_then(|(s, f)| Some((sent.checked_sub(s)?, failed.checked_sub(f)?)));
    let loss = since
        .filter(|(sent, failed)| sent + failed > 0)
        .map(|(sent, failed)| f64::from(failed) / f64::from(sent + failed));
    let mut figures = Figures {
        rssi_dbm: signal_dbm(info).map(f64::from),
        noise_dbm,
        loss,
        channel: interface.mhz.and_then(channel_of),
        power_dbm: interface.power_dbm,
        ..Figures::default()
    };
    let mut bitrate_bit_s = None;
    for i in info {
        match i {
            Nl80211StationInfo::AckSignalAvg(dbm) => figures.remote_rssi_dbm = Some(f64::from(*dbm)),
            Nl80211StationInfo::ExpectedThroughput(kbit_s) => figures.throughput_bit_s = Some(f64::from(*kbit_s) * 1e3),
            Nl80211StationInfo::TxBitrate(rates) => bitrate_bit_s = rates.iter().find_map(bit_s),
            _ => {}
        }
    }
    figures.throughput_bit_s = figures.throughput_bit_s.or(bitrate_bit_s);
    figures
}

fn bit_s(rate: &Nl80211RateInfo) -> Option<f64> {
    match rate {
        Nl80211RateInfo::Bitrate32(hundred_kbit_s) => Some(f64::from(*hundred_kbit_s) * 1e5),
        Nl80211RateInfo::Bitrate(hundred_kbit_s) => Some(f64::from(*hundred_kbit_s) * 1e5),
        _ => None,
    }
}
