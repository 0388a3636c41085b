"""Reads a recording and everything that was exported of it with the programs that others use, and reports the figures of each.

Arguments: the recording, a merged one, and a folder with csv/, parquet/, tracks.kml, tracks.gpx, bag/ and tlog/.
"""

import json
import sys
from pathlib import Path

import fastkml
import gpxpy
import mcap.reader
import pandas
from mcap_ros2.reader import read_ros2_messages
from pymavlink import mavutil
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore


def report(**figures):
    # Numbers of numpy have a method that makes ordinary ones of them.
    print("REPORT " + json.dumps(figures, default=lambda number: number.item()), flush=True)


def recording(path):
    """With the official reader, its own checksums on."""
    counts, schemas = {}, {}
    with open(path, "rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True)
        last = 0
        for schema, channel, message in reader.iter_messages():
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
            schemas[channel.topic] = schema.name
            assert message.log_time >= last
            last = message.log_time
            if channel.message_encoding == "json":
                json.loads(message.data)
        summary = reader.get_summary()
        told = {summary.channels[id].topic: n for id, n in summary.statistics.channel_message_counts.items()}
        assert told == counts, (told, counts)
        names = [metadata.name for metadata in reader.iter_metadata()]
    return {"counts": counts, "schemas": schemas, "metadata": names}


def table(frame):
    second = frame[frame["vehicle"] == 2]
    at = second.iloc[min(10, len(second) - 1)]
    return {
        "rows": len(frame),
        "columns": list(frame.columns),
        "rows_of_2": len(second),
        "first": pandas.to_datetime(frame["time_utc"].iloc[0], utc=True).isoformat(),
        "time_s": at["time_s"],
        "at": [at["north_m"], at["east_m"], at["down_m"]] if "north_m" in frame else None,
        "armed": str(frame["armed"].dtype) if "armed" in frame else None,
    }


def kml(path):
    document = fastkml.KML.parse(path, strict=True)
    tracks = {}
    for placemark in document.features[0].features:
        multi = placemark.kml_geometry
        points = [item for track in multi.tracks for item in track.track_items]
        tracks[placemark.name] = {"points": len(points), "height_m": points[0].coord.z, "first": str(points[0].when.dt)}
    return tracks


def gpx(path):
    with open(path) as file:
        read = gpxpy.parse(file)
    tracks = {}
    for track in read.tracks:
        points = track.segments[0].points
        tracks[track.name] = {
            "points": len(points),
            "height_m": points[0].elevation,
            "length_m": track.length_2d(),
            "seconds": (points[-1].time - points[0].time).total_seconds(),
        }
    return tracks


def bag(folder):
    """Decoded by the definitions in the bag, and by those of Jazzy that rosbags has."""
    store = get_typestore(Stores.ROS2_JAZZY)
    counts, last = {}, {}
    with Reader(folder) as reader:
        told = reader.message_count
        for connection, at, raw in reader.messages():
            message = store.deserialize_cdr(raw, connection.msgtype)
            # Written again, it is the same, octet for octet.
            again = bytes(store.serialize_cdr(message, connection.msgtype))
            assert again == bytes(raw), (connection.topic, len(raw), len(again))
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
            last[connection.topic] = message
    with AnyReader([Path(folder)], default_typestore=store) as reader:
        types = {connection.topic: connection.msgtype for connection in reader.connections}
    by_own = 0
    for message in read_ros2_messages(str(next(Path(folder).glob("*.mcap")))):
        by_own += 1
        if message.channel.topic == "/skein/uav_2/pose":
            own = message.ros_msg
    assert by_own == told == sum(counts.values()), (by_own, told)
    pose = last["/skein/uav_2/pose"]
    assert abs(own.pose.position.x - pose.pose.position.x) == 0
    orientation = pose.pose.orientation
    transforms = last["/tf"].transforms
    return {
        "counts": counts,
        "types": types,
        "pose": [pose.pose.position.x, pose.pose.position.y, pose.pose.position.z],
        "orientation": [orientation.x, orientation.y, orientation.z, orientation.w],
        "frame": pose.header.frame_id,
        "stamp": [pose.header.stamp.sec, pose.header.stamp.nanosec],
        "transforms": [[t.header.frame_id, t.child_frame_id] for t in transforms],
        "fix": [last["/skein/uav_2/nav_sat_fix"].latitude, last["/skein/uav_2/nav_sat_fix"].altitude],
        "voltage_v": last["/skein/uav_2/battery"].voltage,
        "log": [last["/rosout"].level, last["/rosout"].name, last["/rosout"].msg],
    }


def tlog(path):
    connection = mavutil.mavlink_connection(str(path), dialect="common")
    counts, texts, first = {}, [], None
    while (message := connection.recv_match()) is not None:
        kind = message.get_type()
        assert kind != "BAD_DATA", message
        counts[kind] = counts.get(kind, 0) + 1
        first = first or message._timestamp
        if kind == "STATUSTEXT":
            texts.append(message.text)
        if kind in ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "SYS_STATUS"):
            last = {**locals().get("last", {}), kind: message}
    place = last["GLOBAL_POSITION_INT"]
    return {
        "counts": counts,
        "first": first,
        "mode": connection.flightmode,
        "armed": connection.motors_armed() != 0,
        "text": "".join(texts[:2]),
        "alt_m": place.alt / 1000,
        "x_m": last["LOCAL_POSITION_NED"].x,
        "voltage_v": last["SYS_STATUS"].voltage_battery / 1000,
    }


def main():
    original, merged, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    report(what="recording", **recording(original))
    report(what="merged", **recording(merged))
    for name, read in (("csv", pandas.read_csv), ("parquet", pandas.read_parquet)):
        files = {path.stem: table(read(path)) for path in sorted((folder / name).iterdir())}
        report(what=name, **files)
    report(what="kml", **kml(folder / "tracks.kml"))
    report(what="gpx", **gpx(folder / "tracks.gpx"))
    report(what="rosbag", **bag(folder / "bag"))
    report(what="tlog", **{path.stem: tlog(path) for path in sorted((folder / "tlog").iterdir())})


main()
