//! GPX 1.1: points with their times, longitude and latitude as attributes.
//!
//! Must never do: write a text without escaping it.

use super::spool::Shape;
use super::{Point, Tracks};
use crate::utc;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use skein_recording::Recording;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};

/// A point needs no other.
pub(super) const SHAPE: Shape = Shape {
    span: 64,
    joined: false,
    part,
};

fn part(into: &mut BufWriter<File>, points: &[Point]) -> io::Result<()> {
    for Point { at_ns, place } in points {
        let (latitude_deg, longitude_deg) = (place.latitude_deg, place.longitude_deg);
        let (altitude_m, at) = (place.altitude_amsl_m, utc::precise(*at_ns));
        writeln!(
            into,
            r#"<trkpt lat="{latitude_deg}" lon="{longitude_deg}"><ele>{altitude_m}</ele><time>{at}</time></trkpt>"#
        )?;
    }
    Ok(())
}

pub(super) fn whole(file: BufWriter<File>, tracks: Tracks, recording: &Recording) -> io::Result<BufWriter<File>> {
    let mut xml = Writer::new(file);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let mut root = BytesStart::new("gpx");
    root.push_attribute(("version", "1.1"));
    root.push_attribute(("creator", "Skein"));
    root.push_attribute(("xmlns", "http://www.topografix.com/GPX/1/1"));
    xml.write_event(Event::Start(root))?;
    xml.write_event(Event::Start(BytesStart::new("metadata")))?;
    text(&mut xml, "name", &format!("Skein: {}", recording.header().name))?;
    let begin = recording.header().base.unix_ns(recording.span().0);
    text(&mut xml, "time", &utc::precise(begin))?;
    xml.write_event(Event::End(BytesEnd::new("metadata")))?;
    for track in tracks.into_values() {
        xml.write_event(Event::Start(BytesStart::new("trk")))?;
        text(&mut xml, "name", &track.name)?;
        xml.write_event(Event::Start(BytesStart::new("trkseg")))?;
        track.spool.pour(xml.get_mut())?;
        xml.write_event(Event::End(BytesEnd::new("trkseg")))?;
        xml.write_event(Event::End(BytesEnd::new("trk")))?;
    }
    xml.write_event(Event::End(BytesEnd::new("gpx")))?;
    Ok(xml.into_inner())
}

fn text(xml: &mut Writer<BufWriter<File>>, element: &str, text: &str) -> io::Result<()> {
    xml.create_element(element).write_text_content(BytesText::new(text))?;
    Ok(())
}
