"""A program of ROS 2 that has three vehicles follow each other and steers a fourth one, until it is killed; and the one that is started then."""

import sys
import time

from geometry_msgs.msg import Twist
from skein_msgs.srv import Follow, GoTo, TakeOff
from std_srvs.srv import Trigger

from ros2_program import run
from ros2_reports import judged, report


def steer(citizen, publisher, forward_m_s, seconds):
    velocity = Twist()
    velocity.linear.x = forward_m_s
    begin = time.monotonic()
    while time.monotonic() - begin < seconds:
        publisher.publish(velocity)
        citizen.spin(0.1)


def stick(citizen, vehicle):
    publisher = citizen.node.create_publisher(Twist, f"/skein/{vehicle}/cmd_vel", 10)
    citizen.wait("cmd_vel is heard", lambda: publisher.get_subscription_count() > 0)
    return publisher


def lead(citizen):
    *column, alone = citizen.vehicles
    citizen.see()
    for vehicle in citizen.vehicles:
        citizen.must(TakeOff, f"/skein/{vehicle}/take_off_to", height_m=5.0)
    citizen.wait("all hold", lambda: all(citizen.state(v) == "holding" for v in citizen.vehicles), 180)
    ids = [citizen.message(v, "state").id for v in column]
    citizen.must(Follow, "/skein/follow", leader=ids[0], followers=ids[1:], spacing_m=6.0)
    citizen.wait("the column flies", lambda: all(citizen.message(v, "state").in_formation for v in column))
    publisher = stick(citizen, alone)
    steer(citizen, publisher, 2.0, 3)
    report("steering", poses=citizen.poses())
    # Until it is killed.
    steer(citizen, publisher, 2.0, 600)


def resume(citizen):
    *column, alone = citizen.vehicles
    citizen.see()
    judged("seen", poses=citizen.poses(), states={v: citizen.state(v) for v in citizen.vehicles},
           members=list(citizen.latest["/skein/formation"].members))
    publisher = stick(citizen, alone)
    before = citizen.poses()
    steer(citizen, publisher, 2.0, 4)
    report("steered", before=before[alone], poses=citizen.poses())
    citizen.wait("stands", lambda: citizen.poses()[alone]["speed"] < 0.2)
    judged("stands", poses=citizen.poses())
    target = citizen.message(alone, "pose").pose.position
    goal = [target.x - 6.0, target.y + 4.0, target.z + 1.0]
    request = GoTo.Request(speed_m_s=4.0)
    request.position.x, request.position.y, request.position.z = goal
    citizen.must(GoTo, f"/skein/{alone}/go_to", position=request.position, speed_m_s=4.0)
    citizen.wait("goes", lambda: citizen.state(alone) == "going_to")
    citizen.wait("is there", lambda: citizen.state(alone) == "holding")
    citizen.spin(1)
    judged("there", goal=goal, poses=citizen.poses())
    citizen.must(Trigger, "/skein/land")
    citizen.wait("all are down", lambda: all(citizen.state(v) == "idle" for v in citizen.vehicles), 180)
    judged("down", poses=citizen.poses())


run({"lead": lead, "resume": resume}[sys.argv[1]], sys.argv[2:], sys.argv[1])
