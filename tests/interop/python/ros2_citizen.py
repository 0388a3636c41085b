"""An ordinary program of ROS 2 meets the swarm: looks at nodes, topics and services, listens, commands, steers by velocity."""

import math
import sys
import time

from geometry_msgs.msg import Twist
from skein_msgs.srv import Follow, GoTo, PointGimbal, SetFormation, TakeOff
from std_srvs.srv import SetBool, Trigger

from ros2_program import run
from ros2_reports import judged, report


def look(citizen):
    citizen.see()
    before = dict(citizen.count)
    begin = time.monotonic()
    citizen.spin(3)
    seconds = time.monotonic() - begin
    rates = {topic: (citizen.count[topic] - before.get(topic, 0)) / seconds for topic in citizen.count}
    report("rates", rates=rates, diagnostics=len(citizen.latest["/diagnostics"].status))
    judged("ground", poses=citizen.poses())


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
    judged("up", poses=citizen.poses())


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
    judged("there", goal=goal, yaw=2.0, poses=citizen.poses())


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
    judged("down", poses=citizen.poses())


def fly(citizen):
    look(citizen)
    refusals(citizen, citizen.vehicles[0])
    up(citizen)
    go(citizen)
    steer(citizen)
    form(citizen)
    down(citizen)


run({"look": look, "fly": fly}[sys.argv[1]], sys.argv[2:])
