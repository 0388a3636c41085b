"""A peer that knows nothing of ROS 2: Cyclone DDS reads a vehicle by the names that ROS 2 gives its topics and types on the wire, and steers it."""

import os
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, sequence, uint8, uint16, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from ros2_reports import composed, described, judged, report, stamp_ns, xyz

PATIENCE_S = float(os.environ.get("SKEIN_TEST_PATIENCE_S", "60"))


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class PoseStamped(IdlStruct, typename="geometry_msgs::msg::dds_::PoseStamped_"):
    header: Header
    pose: Pose


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::PoseWithCovariance_"):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class Twist(IdlStruct, typename="geometry_msgs::msg::dds_::Twist_"):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs::msg::dds_::TwistWithCovariance_"):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct, typename="nav_msgs::msg::dds_::Odometry_"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class NavSatStatus(IdlStruct, typename="sensor_msgs::msg::dds_::NavSatStatus_"):
    status: int8
    service: uint16


@dataclass
class NavSatFix(IdlStruct, typename="sensor_msgs::msg::dds_::NavSatFix_"):
    header: Header
    status: NavSatStatus
    latitude: float64
    longitude: float64
    altitude: float64
    position_covariance: array[float64, 9]
    position_covariance_type: uint8


@dataclass
class BatteryState(IdlStruct, typename="sensor_msgs::msg::dds_::BatteryState_"):
    header: Header
    voltage: float32
    temperature: float32
    current: float32
    charge: float32
    capacity: float32
    design_capacity: float32
    percentage: float32
    power_supply_status: uint8
    power_supply_health: uint8
    power_supply_technology: uint8
    present: bool
    cell_voltage: sequence[float32]
    cell_temperature: sequence[float32]
    location: str
    serial_number: str


@dataclass
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)
LOOSE = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(20), PLAIN)
FIRM = Qos(Policy.Reliability.Reliable(1_000_000_000), Policy.History.KeepLast(100), PLAIN)


class Peer:
    def __init__(self, domain, vehicle):
        self.participant, self.vehicle = DomainParticipant(domain), vehicle
        base = f"rt/skein/{vehicle}"
        self.readers, self.latest, self.poses = {}, {}, {}
        for name, kind, quality in (
            (f"{base}/pose", PoseStamped, LOOSE), (f"{base}/odometry", Odometry, LOOSE),
            (f"{base}/nav_sat_fix", NavSatFix, FIRM), (f"{base}/battery", BatteryState, FIRM), ("rt/tf", TFMessage, FIRM),
        ):
            topic = Topic(self.participant, name, kind, qos=quality)
            self.readers[name.split("/")[-1]] = DataReader(self.participant, topic, qos=quality)
        topic = Topic(self.participant, f"{base}/cmd_vel", Twist, qos=LOOSE)
        self.stick = DataWriter(self.participant, topic, qos=LOOSE)
        self.transforms = {}

    def listen(self):
        for name, reader in self.readers.items():
            for sample in reader.take(N=64):
                if not sample.sample_info.valid_data:
                    continue
                self.latest[name] = sample
                if name == "pose":
                    self.poses[stamp_ns(sample.header)] = sample
                for transform in sample.transforms if name == "tf" else ():
                    frames = (transform.header.frame_id, transform.child_frame_id)
                    self.transforms[frames, stamp_ns(transform.header)] = transform.transform

    def wait(self, what, condition):
        end = time.monotonic() + 2 * PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                sys.exit(f"FAILED: waited in vain: {what}; heard {sorted(self.latest)}")
            time.sleep(0.01)
            self.listen()

    def together(self):
        """Both transforms and the pose of one moment, the newest there is."""
        odom, base = f"{self.vehicle}/odom", f"{self.vehicle}/base_link"
        for stamp in sorted(self.poses, reverse=True):
            keys = ((("map", odom), stamp), ((odom, base), stamp))
            if all(key in self.transforms for key in keys):
                return [self.transforms[key] for key in keys] + [self.poses[stamp]]
        return None

    def told(self):
        return described(*(self.latest[name] for name in ("pose", "odometry", "nav_sat_fix", "battery")))

    def speed(self):
        return self.told()["speed"]

    def tell(self, phase):
        self.poses, self.transforms = {}, {}
        self.wait("transforms of a pose", lambda: self.together() is not None)
        outer, inner, pose = self.together()
        told = self.told()
        judged(phase, poses={self.vehicle: told}, composed=composed(outer, inner), pose=xyz(pose.pose.position))


def main():
    domain, vehicle = int(sys.argv[1]), sys.argv[2]
    peer = Peer(domain, vehicle)
    peer.wait("everything is heard", lambda: len(peer.latest) == len(peer.readers))
    peer.tell("ground")
    ground_m = peer.latest["pose"].pose.position.z
    peer.wait("it is up", lambda: peer.latest["pose"].pose.position.z > ground_m + 4.0 and peer.speed() < 0.2)
    peer.tell("up")
    zero, forward = Vector3(0.0, 0.0, 0.0), Vector3(2.0, 0.0, 0.0)
    peer.wait("cmd_vel is heard", lambda: peer.stick.get_matched_subscriptions())
    speeds, begin = [], time.monotonic()
    while time.monotonic() - begin < 5:
        peer.stick.write(Twist(forward, zero))
        time.sleep(0.1)
        peer.listen()
        if time.monotonic() - begin > 2.5:
            speeds.append(peer.latest["odometry"].twist.twist.linear.x)
    report("steered", forward=sum(speeds) / len(speeds))
    peer.wait("it stands", lambda: peer.speed() < 0.2)
    peer.tell("stands")
    print("done", flush=True)


main()
