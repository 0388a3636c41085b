"""What programs of ROS 2 report, whichever implementation they are made with: messages by their fields alone.

A line `REPORT {...}` holds what is seen at that moment.
"""

import json
import math
import sys
import time


def report(phase, **facts):
    print("REPORT " + json.dumps({"phase": phase, **facts}), flush=True)


def judged(phase, **facts):
    """The same, and nothing is done before it has been held against the truth of that moment."""
    report(phase, waits=True, **facts)
    sys.stdin.readline()


def stamp_s(header):
    return header.stamp.sec + header.stamp.nanosec * 1e-9


def stamp_ns(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def yaw_rad(q):
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def rotated(q, v):
    """A vector turned by a quaternion."""
    x, y, z = v
    # Twice the cross product of the quaternion's vector with the vector.
    t = (2 * (q.y * z - q.z * y), 2 * (q.z * x - q.x * z), 2 * (q.x * y - q.y * x))
    return [
        x + q.w * t[0] + q.y * t[2] - q.z * t[1],
        y + q.w * t[1] + q.z * t[0] - q.x * t[2],
        z + q.w * t[2] + q.x * t[1] - q.y * t[0],
    ]


def xyz(v):
    return [v.x, v.y, v.z]


def composed(outer, inner):
    """Where the end of two transforms lies, one after the other."""
    return [a + b for a, b in zip(xyz(outer.translation), rotated(outer.rotation, xyz(inner.translation)))]


def described(pose, odometry, fix, battery):
    """How a vehicle is told to be."""
    twist = odometry.twist.twist.linear
    return {
        "stamp_age_s": time.time() - stamp_s(pose.header),
        "frame": pose.header.frame_id,
        "position": xyz(pose.pose.position),
        "yaw": yaw_rad(pose.pose.orientation),
        "odometry_frames": [odometry.header.frame_id, odometry.child_frame_id],
        "speed": math.hypot(*xyz(twist)),
        "forward": twist.x,
        "fix": [fix.latitude, fix.longitude, fix.altitude, fix.status.status],
        "battery": [battery.voltage, battery.percentage],
    }
