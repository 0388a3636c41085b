"""A program of ROS 2 that looks through a vehicle's camera, turns its gimbal, follows its transforms and what is tracked."""

import math
import struct
import sys

from geometry_msgs.msg import Vector3
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, CompressedImage
from skein_msgs.msg import GimbalState
from skein_msgs.srv import PointGimbal
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection2DArray, Detection3DArray

from ros2_program import run
from ros2_reports import composed, judged, rotated, stamp_ns, stamp_s, xyz, yaw_rad

# Messages that belong together have one stamp; so many of each are kept until the other has come.
KEPT = 200


def size_of(jpeg):
    """Width and height from the head of a JPEG's picture; nothing if it is none, or not whole."""
    if jpeg[:3] != b"\xff\xd8\xff" or jpeg[-2:] != b"\xff\xd9":
        return None
    at = 2
    while at + 9 < len(jpeg) and jpeg[at] == 0xFF:
        kind, length = struct.unpack(">BH", jpeg[at + 1:at + 4])
        if kind in (0xC0, 0xC1, 0xC2):
            height, width = struct.unpack(">HH", jpeg[at + 5:at + 9])
            return [width, height]
        at += 2 + length
    return None


class Looker:
    def __init__(self, citizen):
        self.citizen, self.vehicle = citizen, citizen.vehicles[0]
        self.base = f"/skein/{self.vehicle}"
        self.transforms, self.pictures, self.infos, self.poses = {}, {}, {}, {}
        node = citizen.node
        self.keep(CompressedImage, f"{self.base}/camera/image_raw/compressed", qos_profile_sensor_data, self.pictures)
        self.keep(CameraInfo, f"{self.base}/camera/camera_info", qos_profile_sensor_data, self.infos)
        self.keep(type(citizen.message(self.vehicle, "pose")), f"{self.base}/pose", qos_profile_sensor_data, self.poses)
        citizen.hear(GimbalState, f"{self.base}/gimbal/state", 10)
        citizen.hear(Detection3DArray, "/skein/tracks", 10)
        citizen.hear(Detection2DArray, self.detections(), 10)
        node.create_subscription(TFMessage, "/tf", self.on_transforms, QoSProfile(depth=100))

    def keep(self, kind, topic, quality, into):
        def add(message):
            into[stamp_ns(message.header)] = message
            while len(into) > KEPT:
                del into[min(into)]

        self.citizen.node.create_subscription(kind, topic, add, quality)

    def on_transforms(self, message):
        for transform in message.transforms:
            known = self.transforms.setdefault((transform.header.frame_id, transform.child_frame_id), {})
            known[stamp_ns(transform.header)] = transform.transform
            while len(known) > KEPT:
                del known[min(known)]

    def of(self, outer, inner):
        return self.transforms.setdefault((outer, inner), {})

    def gimbal(self):
        return self.citizen.latest.get(f"{self.base}/gimbal/state")

    def axis(self):
        """Where the gimbal points, along map."""
        state = self.gimbal()
        return rotated(state.orientation, (1.0, 0.0, 0.0)) if state and state.orientation_known else None

    def stamp_of(self, what, kinds):
        """The newest stamp that all of these have."""

        def common():
            return set(kinds[0]).intersection(*kinds[1:])

        def known():
            return [f"{len(kind)} of {sorted(kind)[-2:]}" for kind in kinds] + [sorted(self.transforms)]

        self.citizen.wait(what, common, known=known)
        return max(common())

    def frames(self):
        """map to odom to base_link beside the pose of the same moment."""
        odom, base = f"{self.vehicle}/odom", f"{self.vehicle}/base_link"
        kinds = (self.of("map", odom), self.of(odom, base), self.poses)
        stamp = self.stamp_of("a pose with its transforms", kinds)
        outer, inner, pose = (kind[stamp] for kind in kinds)
        return {
            "composed": composed(outer, inner),
            "odom_at": xyz(outer.translation),
            "odom_yaw": yaw_rad(outer.rotation),
            "yaw": yaw_rad(inner.rotation),
            "pose": xyz(pose.pose.position),
            "pose_yaw": yaw_rad(pose.pose.orientation),
        }

    def picture(self):
        """The newest picture after now, with how it was taken."""
        optical = f"{self.vehicle}/camera_optical"
        kinds = (self.pictures, self.infos, self.of("map", optical))
        for kind in kinds:
            kind.clear()
        stamp = self.stamp_of("a picture, its camera_info and its transform", kinds)
        image, info, transform = (kind[stamp] for kind in kinds)
        return {
            "format": image.format,
            "bytes": len(image.data),
            "size": size_of(bytes(image.data)),
            "image_frame": image.header.frame_id,
            "info_frame": info.header.frame_id,
            "info_size": [info.width, info.height],
            "model": info.distortion_model,
            "k": list(info.k),
            "p": list(info.p),
            "at": xyz(transform.translation),
            "axis": rotated(transform.rotation, (0.0, 0.0, 1.0)),
            "right": rotated(transform.rotation, (1.0, 0.0, 0.0)),
        }

    def tracks(self):
        message = self.citizen.latest["/skein/tracks"]
        return [
            {
                "id": track.id,
                "frame": track.header.frame_id,
                "stamp_s": stamp_s(track.header),
                "position": xyz(track.results[0].pose.pose.position),
                "center": xyz(track.bbox.center.position),
            }
            for track in message.detections
        ]

    def detections(self):
        return f"{self.base}/frame_counter/detections"

    def detection(self):
        """The one that was found in a picture."""
        message = self.citizen.latest[self.detections()]
        (found,) = message.detections
        center, what = found.bbox.center.position, found.results[0].hypothesis
        return {
            "frame": message.header.frame_id,
            "id": found.id,
            "class": what.class_id,
            "score": what.score,
            "center": [center.x, center.y],
            "size": [found.bbox.size_x, found.bbox.size_y],
        }

    def point(self, phase, frame_id, wanted, in_map):
        """Turns the gimbal and waits until its state says that it looks there."""
        direction = Vector3(x=wanted[0], y=wanted[1], z=wanted[2])
        self.citizen.must(
            PointGimbal, f"{self.base}/point_gimbal", gimbal="gimbal", frame_id=frame_id, direction=direction)

        def looks_there():
            axis = self.axis()
            goal = in_map()
            length = math.hypot(*goal)
            return axis and sum(a * b / length for a, b in zip(axis, goal)) > math.cos(0.05)

        self.citizen.wait("the gimbal looks there", looks_there)
        # The motion has to come to its end, too.
        self.citizen.spin(1)
        judged(phase, wanted=wanted, axis=self.axis(), mode=self.gimbal().mode, picture=self.picture(),
               poses=self.citizen.poses())


def play(citizen):
    carried = {f"/skein/{citizen.vehicles[0]}/{topic}" for topic in ("gimbal/state", "camera/camera_info",
                                                               "frame_counter/detections")}
    citizen.wait("the payloads' topics", lambda: carried <= set(citizen.graph()[1]))
    citizen.see()
    looker = Looker(citizen)
    vehicle = looker.vehicle
    citizen.wait("the gimbal's state", lambda: looker.axis() is not None)
    citizen.wait("a track", lambda: "/skein/tracks" in citizen.latest and citizen.latest["/skein/tracks"].detections)
    citizen.wait("a detection", lambda: looker.detections() in citizen.latest)
    judged("ground", poses=citizen.poses(), frames=looker.frames(), axis=looker.axis(), tracks=looker.tracks(),
           detection=looker.detection())
    citizen.must(Trigger, f"{looker.base}/take_off")
    citizen.wait("it holds", lambda: citizen.state(vehicle) == "holding", 120)
    citizen.spin(2)
    judged("up", poses=citizen.poses(), frames=looker.frames(), axis=looker.axis(), tracks=looker.tracks(),
           detection=looker.detection())

    def ahead():
        """Ahead, to the left and down of the level vehicle, along map."""
        yaw = citizen.poses()[vehicle]["yaw"]
        forward, left, up = body
        return (forward * math.cos(yaw) - left * math.sin(yaw), forward * math.sin(yaw) + left * math.cos(yaw), up)

    body = (1.0, 0.5, -0.9)
    looker.point("pointed", f"{vehicle}/base_link", body, ahead)
    west = (-2.0, 0.3, -1.0)
    looker.point("pointed_in_map", "map", west, lambda: west)


run(play, sys.argv[1:])
