//! KML 2.2 with Google's `gx:Track`: points with their times.
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

/// A `gx:Track` has all its times first: points of one part wait in memory.
pub(super) const SHAPE: Shape = Shape {
    span: 2_000,
    joined: true,
    part,
};
/// Colours of tracks, as KML has them: opacity, blue, green, red.
const COLOURS: [&str; 6] = ["ff3c14dc", "ffff9632", "ff32c832", "ff00b4ff", "ffc832c8", "ffc8c800"];

fn part(into: &mut BufWriter<File>, points: &[Point]) -> io::Result<()> {
    into.write_all(b"<gx:Track><altitudeMode>absolute</altitudeMode>\n")?;
    for point in points {
        writeln!(into, "<when>{}</when>", utc::precise(point.at_ns))?;
    }
    for Point { place, .. } in points {
        let (longitude_deg, latitude_deg) = (place.longitude_deg, place.latitude_deg);
        writeln!(
            into,
            "<gx:coord>{longitude_deg} {latitude_deg} {}</gx:coord>",
            place.altitude_amsl_m
        )?;
    }
    into.write_all(b"</gx:Track>\n")
}

pub(super) fn whole(file: BufWriter<File>, tracks: Tracks, recording: &Recording) -> io::Result<BufWriter<File>> {
    let mut xml = Writer::new(file);
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let mut root = BytesStart::new("kml");
    root.push_attribute(("xmlns", "http://www.opengis.net/kml/2.2"));
    root.push_attribute(("xmlns:gx", "http://www.google.com/kml/ext/2.2"));
    xml.write_event(Event::Start(root))?;
    xml.write_event(Event::Start(BytesStart::new("Document")))?;
    text(&mut xml, "name", &format!("Skein: {}", recording.header().name))?;
    for (index, colour) in COLOURS.iter().enumerate() {
        let mut style = BytesStart::new("Style");
        style.push_attribute(("id", format!("track{index}").as_str()));
        xml.write_event(Event::Start(style))?;
        xml.write_event(Event::Start(BytesStart::new("LineStyle")))?;
        text(&mut xml, "color", colour)?;
        text(&mut xml, "width", "3")?;
        xml.write_event(Event::End(BytesEnd::new("LineStyle")))?;
        xml.write_event(Event::End(BytesEnd::new("Style")))?;
    }
    for (index, track) in tracks.into_values().enumerate() {
        xml.write_event(Event::Start(BytesStart::new("Placemark")))?;
        text(&mut xml, "name", &track.name)?;
        text(&mut xml, "styleUrl", &format!("#track{}", index % COLOURS.len()))?;
        xml.write_event(Event::Start(BytesStart::new("gx:MultiTrack")))?;
        text(&mut xml, "gx:interpolate", "1")?;
        track.spool.pour(xml.get_mut())?;
        xml.write_event(Event::End(BytesEnd::new("gx:MultiTrack")))?;
        xml.write_event(Event::End(BytesEnd::new("Placemark")))?;
    }
    xml.write_event(Event::End(BytesEnd::new("Document")))?;
    xml.write_event(Event::End(BytesEnd::new("kml")))?;
    Ok(xml.into_inner())
}

fn text(xml: &mut Writer<BufWriter<File>>, element: &str, text: &str) -> io::Result<()> {
    xml.create_element(element).write_text_content(BytesText::new(text))?;
    Ok(())
}
