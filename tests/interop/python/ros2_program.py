"""What an ordinary program of ROS 2 is made of: it listens to vehicles, waits, calls services.

It ends with a failure as soon as something does not come.
"""

import os
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, NavSatFix
from skein_msgs.msg import Formation, VehicleState

from ros2_reports import described, report

PATIENCE_S = float(os.environ.get("SKEIN_TEST_PATIENCE_S", "60"))
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Citizen:
    """Listens to some vehicles, as far as they have something to say."""

    def __init__(self, vehicles, name="citizen"):
        self.node = rclpy.create_node(name)
        self.vehicles = vehicles
        self.latest = {}
        self.count = {}
        self.clients = {}
        for vehicle in vehicles:
            base = f"/skein/{vehicle}"
            self.hear(PoseStamped, f"{base}/pose", qos_profile_sensor_data)
            self.hear(Odometry, f"{base}/odometry", qos_profile_sensor_data)
            self.hear(NavSatFix, f"{base}/nav_sat_fix", 10)
            self.hear(BatteryState, f"{base}/battery", 10)
            self.hear(VehicleState, f"{base}/state", LATCHED)
        self.hear(Formation, "/skein/formation", LATCHED)
        self.hear(DiagnosticArray, "/diagnostics", 10)

    def hear(self, kind, topic, quality):
        def keep(message):
            self.latest[topic] = message
            self.count[topic] = self.count.get(topic, 0) + 1

        self.node.create_subscription(kind, topic, keep, quality)

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.02)

    def wait(self, what, condition, limit_s=PATIENCE_S, known=lambda: ""):
        end = time.monotonic() + limit_s
        while not condition():
            if time.monotonic() > end:
                sys.exit(f"FAILED: waited {limit_s} s in vain: {what} {known()}")
            rclpy.spin_once(self.node, timeout_sec=0.05)

    def message(self, vehicle, topic):
        return self.latest.get(f"/skein/{vehicle}/{topic}")

    def state(self, vehicle):
        message = self.message(vehicle, "state")
        return message.flight_state if message else None

    def call(self, kind, name, **fields):
        if name not in self.clients:
            self.clients[name] = self.node.create_client(kind, name)
            if not self.clients[name].wait_for_service(timeout_sec=PATIENCE_S):
                sys.exit(f"FAILED: no service {name}")
        # The first answer to a program that has just started may get lost: asked again, as any program would.
        for attempt in range(3):
            future = self.clients[name].call_async(kind.Request(**fields))
            end = time.monotonic() + 20
            while not future.done() and time.monotonic() < end:
                rclpy.spin_once(self.node, timeout_sec=0.05)
            if future.done():
                print(f"{name}: {future.result()}")
                return future.result()
            print(f"{name}: no answer, attempt {attempt + 1}")
        sys.exit(f"FAILED: no answer of {name}")

    def must(self, kind, name, **fields):
        """Asks until it is taken up: shortly after the start a vehicle may not be ready yet, or another flight not be over."""
        end = time.monotonic() + PATIENCE_S
        while True:
            answer = self.call(kind, name, **fields)
            if answer.success:
                return answer
            if time.monotonic() > end:
                sys.exit(f"FAILED: {name} refused: {answer.message}")
            self.spin(1)

    def poses(self):
        topics = ("pose", "odometry", "nav_sat_fix", "battery")
        return {v: described(*(self.message(v, topic) for topic in topics)) for v in self.vehicles}

    def heard_all(self):
        topics = ("pose", "odometry", "nav_sat_fix", "battery", "state")
        return all(self.message(v, t) is not None for v in self.vehicles for t in topics)

    def graph(self):
        nodes = sorted(ns.rstrip("/") + "/" + name for name, ns in self.node.get_node_names_and_namespaces())
        topics = {name: types for name, types in self.node.get_topic_names_and_types()}
        services = {name: types for name, types in self.node.get_service_names_and_types()}
        return nodes, topics, services

    def see(self):
        wanted = ["/skein/swarm"] + [f"/skein/{v}/vehicle" for v in self.vehicles]

        def all_there():
            nodes, _, services = self.graph()
            return all(n in nodes for n in wanted) and all(f"/skein/{v}/go_to" in services for v in self.vehicles)

        self.wait("all nodes", all_there)
        self.wait("all is heard", self.heard_all)
        self.wait("diagnostics", lambda: "/diagnostics" in self.latest)
        # Endpoints are announced one by one: until nothing more comes.
        before = None
        while before != (before := self.graph()):
            self.spin(1)
        nodes, topics, services = before
        report("graph", nodes=nodes, topics=topics, services=services)


def run(play, vehicles, name="citizen"):
    """Has a citizen play its part, and ends without taking everything apart: that is not what is looked at."""
    rclpy.init()
    play(Citizen(vehicles, name))
    print("done", flush=True)
    os._exit(0)
