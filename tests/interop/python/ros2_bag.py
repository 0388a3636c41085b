"""A bag in the hands of rclpy: every message is deserialised into the type that ROS 2 itself has of it, then played as `ros2 bag play` does, topic by
topic to a subscriber, and counted there.

Argument: the bag's folder.
"""

import importlib
import os
import sys
import time
from pathlib import Path

import rclpy
import yaml
from mcap.reader import make_reader
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

from ros2_reports import report

PATIENCE_S = float(os.environ.get("SKEIN_TEST_PATIENCE_S", "60"))
WHOLE = QoSProfile(history=HistoryPolicy.KEEP_ALL, reliability=ReliabilityPolicy.RELIABLE)
# So many are under way at once.
WINDOW = 50


def type_of(name):
    """The class of `package/msg/Name`."""
    package, part, kind = name.split("/")
    return getattr(importlib.import_module(f"{package}.{part}"), kind)


def read(folder):
    """By topic: the type, and the messages as they are in the file."""
    described = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    topics = {}
    for name in described["relative_file_paths"]:
        with open(folder / name, "rb") as file:
            for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
                assert channel.message_encoding == "cdr" and schema.encoding == "ros2msg", channel
                topics.setdefault(channel.topic, (schema.name, []))[1].append(message.data)
    told = {entry["topic_metadata"]["name"]: (entry["topic_metadata"]["type"], entry["message_count"])
            for entry in described["topics_with_message_count"]}
    held = {topic: (kind, len(messages)) for topic, (kind, messages) in topics.items()}
    assert told == held, (told, held)
    assert described["message_count"] == sum(count for _, count in held.values()), described["message_count"]
    return topics


def deserialised(topics):
    for topic, (name, messages) in topics.items():
        kind = type_of(name)
        for data in messages:
            message = deserialize_message(data, kind)
            again = deserialize_message(serialize_message(message), kind)
            # As text, for what is not a number is not equal to itself.
            assert repr(again) == repr(message), (topic, message)


def played(node, topic, name, messages):
    """How many of them came, each octet for octet the next one."""
    kind, came = type_of(name), []
    # Beside the log, which the node itself writes to.
    topic = "/played" + topic
    subscription = node.create_subscription(kind, topic, came.append, WHOLE, raw=True)
    publisher = node.create_publisher(kind, topic, WHOLE)
    end = time.monotonic() + PATIENCE_S
    while publisher.get_subscription_count() == 0 and time.monotonic() < end:
        time.sleep(0.01)
    for number, data in enumerate(messages, 1):
        publisher.publish(data)
        while len(came) < number - WINDOW or (number == len(messages) and len(came) < number):
            if time.monotonic() > end:
                return len(came)
            rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_publisher(publisher)
    node.destroy_subscription(subscription)
    assert came == messages, topic
    return len(came)


def main():
    topics = read(Path(sys.argv[1]))
    deserialised(topics)
    report("deserialised", counts={topic: len(messages) for topic, (_, messages) in topics.items()})
    rclpy.init()
    node = rclpy.create_node("player")
    report("played", counts={topic: played(node, topic, *rest) for topic, rest in topics.items()})
    print("done", flush=True)
    os._exit(0)


main()
