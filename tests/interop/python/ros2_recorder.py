"""What a bag does, in rclpy: takes everything that vehicles and transforms tell as it comes over the wire, for a while, and decodes it afterwards.

Writes when each message was according to its header, in nanoseconds, into a file of JSON: topic, then the stamps in the order in which they came.
"""

import json
import os
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import BatteryState, NavSatFix
from skein_msgs.msg import VehicleState
from tf2_msgs.msg import TFMessage

from ros2_reports import report, stamp_ns

PATIENCE_S = float(os.environ.get("SKEIN_TEST_PATIENCE_S", "60"))
# As a bag has it: room for what comes while something else is written.
RELIABLE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def main():
    motion, seconds, path, vehicles = sys.argv[1], float(sys.argv[2]), sys.argv[3], sys.argv[4:]
    moving = {"reliable": RELIABLE, "best-effort": BEST_EFFORT}[motion]
    rclpy.init()
    node = rclpy.create_node("recorder")
    kinds, taken = {"/tf": TFMessage}, {"/tf": []}
    node.create_subscription(TFMessage, "/tf", taken["/tf"].append, RELIABLE, raw=True)
    for vehicle in vehicles:
        for topic, kind, quality in (
            ("pose", PoseStamped, moving), ("odometry", Odometry, moving), ("nav_sat_fix", NavSatFix, RELIABLE),
            ("battery", BatteryState, RELIABLE), ("state", VehicleState, LATCHED),
        ):
            name = f"/skein/{vehicle}/{topic}"
            kinds[name], taken[name] = kind, []
            node.create_subscription(kind, name, taken[name].append, quality, raw=True)
    executor = rclpy.executors.SingleThreadedExecutor()
    executor.add_node(node)
    end = time.monotonic() + 2 * PATIENCE_S
    while not all(taken.values()):
        if time.monotonic() > end:
            sys.exit(f"FAILED: nothing of {[name for name, messages in taken.items() if not messages]}")
        executor.spin_once(timeout_sec=0.1)
    report("recording", topics=len(taken))
    begin = {name: len(messages) for name, messages in taken.items()}
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)
    stamps = {}
    for name, messages in taken.items():
        for data in messages[begin[name]:]:
            message = deserialize_message(data, kinds[name])
            if name != "/tf":
                stamps.setdefault(name, []).append(stamp_ns(message.header))
                continue
            for transform in message.transforms:
                stamps.setdefault(f"/tf {transform.child_frame_id}", []).append(stamp_ns(transform.header))
    with open(path, "w") as file:
        json.dump(stamps, file)
    octets = sum(len(data) for messages in taken.values() for data in messages)
    report("recorded", messages=sum(map(len, taken.values())), octets=octets)
    print("done", flush=True)
    os._exit(0)


main()
