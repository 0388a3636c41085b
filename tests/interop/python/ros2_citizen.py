"""An ordinary program of ROS 2 meets the swarm: looks at nodes, topics and services, listens, commands, steers by velocity.

Prints what it does; a line `REPORT {...}` holds what it sees at that moment. Ends with a failure as soon as something does not come.
"""

import json
import math
import os
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, CameraInfo, CompressedImage, NavSatFix
from skein_msgs.msg import Formation, GimbalState, VehicleState
from skein_msgs.srv import Follow, GoTo, PointGimbal, SetFormation, TakeOff
from std_srvs.srv import SetBool, Trigger

PATIENCE_S = float(os.environ.get("SKEIN_TEST_PATIENCE_S", "60"))
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def report(phase, **facts):
    print("REPORT " + json.dumps({"phase": phase, **facts}), flush=True)


class Citizen:
    def __init__(self, vehicles):
        self.node = rclpy.create_node("citizen")
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

    def wait(self, what, condition, limit_s=PATIENCE_S):
        end = time.monotonic() + limit_s
        while not condition():
            if time.monotonic() > end:
                sys.exit(f"FAILED: waited {limit_s} s in vain: {what}")
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
        found = {}
        for vehicle in self.vehicles:
            pose, odometry, fix = (self.message(vehicle, t) for t in ("pose", "odometry", "nav_sat_fix"))
            battery = self.message(vehicle, "battery")
            q = pose.pose.orientation
            found[vehicle] = {
                "stamp_age_s": time.time() - pose.header.stamp.sec - pose.header.stamp.nanosec * 1e-9,
                "frame": pose.header.frame_id,
                "position": [pose.pose.position.x, pose.pose.position.y, pose.pose.position.z],
                "yaw": math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)),
                "odometry_frames": [odometry.header.frame_id, odometry.child_frame_id],
                "speed": math.dist(
                    (0, 0, 0),
                    (odometry.twist.twist.linear.x, odometry.twist.twist.linear.y, odometry.twist.twist.linear.z),
                ),
                "forward": odometry.twist.twist.linear.x,
                "fix": [fix.latitude, fix.longitude, fix.altitude, fix.status.status],
                "battery": [battery.voltage, battery.percentage],
            }
        return found

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
        nodes, topics, services = self.graph()
        report("graph", nodes=nodes, topics=topics, services=services)


def look(citizen):
    citizen.see()
    before = dict(citizen.count)
    begin = time.monotonic()
    citizen.spin(3)
    seconds = time.monotonic() - begin
    rates = {topic: (citizen.count[topic] - before.get(topic, 0)) / seconds for topic in citizen.count}
    report("rates", rates=rates, diagnostics=len(citizen.latest["/diagnostics"].status))
    report("ground", poses=citizen.poses())


def refusals(citizen, first):
    """What cannot be meant is refused with its reason, and what is asked too often too."""
    answers = {}
    answers["nan"] = citizen.call(GoTo, f"/skein/{first}/go_to", speed_m_s=math.nan).code
    answers["huge"] = citizen.call(TakeOff, f"/skein/{first}/take_off_to", height_m=1e308).code
    answers["shape"] = citizen.call(SetFormation, "/skein/set_formation", shape="blob", spacing_m=5.0).code
    answers["nobody"] = citizen.call(Follow, "/skein/follow", leader=1, spacing_m=5.0).code
    answers["no_gimbal"] = citizen.call(PointGimbal, f"/skein/{first}/point_gimbal", gimbal="nose", frame_id="map").code
    answers["on_ground"] = citizen.call(Trigger, f"/skein/{first}/land").message.split(":")[0]
    client = citizen.clients[f"/skein/{first}/land"]
    # Not each of a flood is answered; each that is answered is a refusal, and some say why.
    codes, asked = [], 0
    while "too_many_requests" not in codes and asked < 1000:
        futures = [client.call_async(Trigger.Request()) for _ in range(100)]
        asked += len(futures)
        citizen.spin(2)
        codes += [f.result().message.split(":")[0] for f in futures if f.done()]
    answers["flood"] = sorted(set(codes))
    citizen.spin(3)
    report("refusals", answers=answers, asked=asked, answered=len(codes))


def up(citizen):
    first, second = citizen.vehicles[0], citizen.vehicles[1]
    citizen.must(SetBool, f"/skein/{first}/arm", data=True)
    citizen.wait("armed", lambda: citizen.message(first, "state").armed)
    citizen.must(SetBool, f"/skein/{first}/arm", data=False)
    citizen.wait("disarmed", lambda: not citizen.message(first, "state").armed and citizen.state(first) == "idle")
    citizen.must(Trigger, f"/skein/{first}/take_off")
    citizen.must(TakeOff, f"/skein/{second}/take_off_to", height_m=10.0)
    for vehicle in citizen.vehicles[2:]:
        citizen.must(Trigger, f"/skein/{vehicle}/take_off")
    citizen.wait("all hold", lambda: all(citizen.state(v) == "holding" for v in citizen.vehicles), 120)
    citizen.spin(2)
    report("up", poses=citizen.poses())


def go(citizen):
    first = citizen.vehicles[0]
    target = citizen.message(first, "pose").pose.position
    goal = [target.x - 10.0, target.y - 12.0, target.z + 3.0]
    request = {"set_yaw": True, "yaw_rad": 2.0, "speed_m_s": 4.0}
    message = GoTo.Request(**request)
    position = message.position
    position.x, position.y, position.z = goal
    citizen.must(GoTo, f"/skein/{first}/go_to", position=position, **request)
    citizen.wait("goes", lambda: citizen.state(first) == "going_to")
    citizen.wait("is there", lambda: citizen.state(first) == "holding")
    citizen.spin(1)
    report("there", goal=goal, yaw=2.0, poses=citizen.poses())


def steer(citizen):
    """By velocity: forward, then nothing any more; then garbage, which moves nothing."""
    first = citizen.vehicles[0]
    publisher = citizen.node.create_publisher(Twist, f"/skein/{first}/cmd_vel", 10)
    citizen.wait("cmd_vel is heard", lambda: publisher.get_subscription_count() > 0)
    report("steering", poses=citizen.poses())
    velocity = Twist()
    velocity.linear.x = 2.0
    speeds = []
    begin = time.monotonic()
    while time.monotonic() - begin < 8:
        publisher.publish(velocity)
        citizen.spin(0.1)
        if time.monotonic() - begin > 3:
            speeds.append(citizen.poses()[first]["forward"])
    report("steered", forward=sum(speeds) / len(speeds), seconds=8, poses=citizen.poses())
    begin = time.monotonic()
    citizen.wait("stands", lambda: citizen.poses()[first]["speed"] < 0.2)
    report("expired", after_s=time.monotonic() - begin, poses=citizen.poses())
    citizen.spin(1)
    for bad in (math.nan, 1e308, math.inf, 500.0):
        velocity.linear.x = bad
        for _ in range(500):
            publisher.publish(velocity)
        citizen.spin(0.5)
    citizen.spin(2)
    values = {
        pair.key: pair.value
        for status in citizen.latest["/diagnostics"].status
        if status.name == f"skein: {first}"
        for pair in status.values
    }
    report("garbage", diagnostics=values, poses=citizen.poses())


def form(citizen):
    answer = citizen.must(SetFormation, "/skein/set_formation", shape="wedge", spacing_m=5.0)
    citizen.wait("in formation", lambda: all(citizen.message(v, "state").in_formation for v in citizen.vehicles))
    citizen.wait("the formation is told", lambda: citizen.latest["/skein/formation"].active)
    told = citizen.latest["/skein/formation"]
    report(
        "formed",
        members=list(answer.members),
        leader=answer.leader,
        told=[told.shape, list(told.members)],
        distance_m=answer.planned_min_distance_m,
    )
    citizen.must(Trigger, "/skein/dissolve_formation")
    citizen.wait("dissolved", lambda: not citizen.latest["/skein/formation"].active)
    ids = [citizen.message(v, "state").id for v in citizen.vehicles]
    answer = citizen.must(Follow, "/skein/follow", leader=ids[1], followers=[ids[0]], spacing_m=6.0)
    report("following", members=list(answer.members), leader=answer.leader)


def down(citizen):
    citizen.must(Trigger, "/skein/hold")
    citizen.must(Trigger, f"/skein/{citizen.vehicles[1]}/return_home")
    citizen.must(Trigger, f"/skein/{citizen.vehicles[0]}/land")
    for vehicle in citizen.vehicles[2:]:
        citizen.must(Trigger, f"/skein/{vehicle}/land")
    citizen.wait("all are down", lambda: all(citizen.state(v) == "idle" for v in citizen.vehicles), 180)
    report("down", poses=citizen.poses())


def main():
    mode, vehicles = sys.argv[1], sys.argv[2:]
    rclpy.init()
    citizen = Citizen(vehicles)
    if mode == "look":
        look(citizen)
    else:
        look(citizen)
        refusals(citizen, vehicles[0])
        up(citizen)
        go(citizen)
        steer(citizen)
        form(citizen)
        down(citizen)
    print("done", flush=True)
    # Without taking everything apart: that is not what is looked at here.
    os._exit(0)


main()
