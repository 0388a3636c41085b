"""One of the programs that the figures of ROS 2 are taken with: `answer`, `ask` or `listen`, as its first argument says.

`answer` gives messages and calls back. `ask` sends them, to that program and to Skein, and takes the times. `listen` takes the poses of vehicles.
Orders come on the standard input: `b` begins a window, `e` ends it and prints what it held as one line of JSON. Before that every line but `ready` says
what is still waited for.

Must never do: judge; wait for one answer before the next question is due.
"""

import json
import os
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

# As Skein offers poses, and PX4 its topics.
QUALITY = QoSProfile(depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)
PERIOD_S = 0.02
# Below what one service of Skein answers in the long run, ten a second.
CALLS_EVERY_S = 0.16
# A call that got no answer is given up.
GIVEN_UP_AFTER_S = 5.0


def now_us():
    """The system's clock, the same for all programs of this computer."""
    return time.time_ns() // 1000


def stamp(message, at_us):
    message.header.stamp.sec, rest_us = divmod(at_us, 1_000_000)
    message.header.stamp.nanosec = rest_us * 1000


def stamped_us(message):
    return message.header.stamp.sec * 1_000_000 + message.header.stamp.nanosec // 1000


class Answerer:
    """At once on one topic, every period on another: as programs do that stream setpoints by a timer."""

    def __init__(self, node):
        self.at_once = node.create_publisher(PoseStamped, "/bench/at_once", QUALITY)
        self.by_timer = node.create_publisher(PoseStamped, "/bench/by_timer", QUALITY)
        self.latest = None
        node.create_subscription(PoseStamped, "/bench/question", self.answer, QUALITY)
        node.create_timer(PERIOD_S, self.tick)
        node.create_service(Trigger, "/bench/trigger", self.serve)

    def answer(self, message):
        stamp(message, now_us())
        self.at_once.publish(message)
        self.latest = message

    def tick(self):
        if self.latest is not None:
            self.by_timer.publish(self.latest)

    def serve(self, _request, response):
        response.success = True
        response.message = "taken up"
        return response


class Calls:
    """One service, asked again and again."""

    def __init__(self, node, name):
        self.name = name
        self.client = node.create_client(Trigger, name)
        self.asked_us = None
        self.begin()

    def begin(self):
        self.took_us, self.refused, self.unanswered = [], 0, 0

    def ask(self):
        at_us = now_us()
        if self.asked_us is not None:
            if at_us - self.asked_us < GIVEN_UP_AFTER_S * 1e6:
                return
            self.unanswered += 1
        if not self.client.service_is_ready():
            return
        self.asked_us = at_us
        self.client.call_async(Trigger.Request()).add_done_callback(lambda future: self.answered(future, at_us))

    def answered(self, future, at_us):
        if at_us != self.asked_us:
            return
        self.asked_us = None
        self.took_us.append(now_us() - at_us)
        self.refused += not future.result().success


class Asker:
    def __init__(self, node, vehicle):
        self.questions = node.create_publisher(PoseStamped, "/bench/question", QUALITY)
        node.create_subscription(PoseStamped, "/bench/at_once", self.at_once, QUALITY)
        node.create_subscription(PoseStamped, "/bench/by_timer", self.by_timer, QUALITY)
        node.create_subscription(PoseStamped, f"/skein/{vehicle}/pose", self.pose, QUALITY)
        self.calls = {"rclpy": Calls(node, "/bench/trigger"), "skein": Calls(node, f"/skein/{vehicle}/hold")}
        node.create_timer(PERIOD_S, self.question)
        node.create_timer(CALLS_EVERY_S, self.calls["rclpy"].ask)
        node.create_timer(CALLS_EVERY_S, self.calls["skein"].ask)
        self.number = 0
        self.begin()

    def begin(self):
        # When each was asked; those that the timed answers have not reached yet.
        self.sent_us, self.open = {}, []
        self.one_way_us, self.there_and_back_us, self.by_timer_us = [], [], []
        self.pose_age_us, self.pose_every_us, self.pose_at_us = [], [], None
        for calls in self.calls.values():
            calls.begin()

    def missing(self):
        yield from ([] if self.there_and_back_us else ["answers at once"])
        yield from ([] if self.by_timer_us else ["answers by a timer"])
        yield from ([] if self.pose_age_us else ["poses"])
        yield from (calls.name for calls in self.calls.values() if not calls.took_us)

    def question(self):
        self.number += 1
        message = PoseStamped()
        message.header.frame_id = str(self.number)
        self.sent_us[self.number] = now_us()
        self.open.append(self.number)
        self.questions.publish(message)

    def at_once(self, message):
        at_us, asked_us = now_us(), self.sent_us.get(int(message.header.frame_id))
        if asked_us is not None:
            self.there_and_back_us.append(at_us - asked_us)
            self.one_way_us.append(at_us - stamped_us(message))

    def by_timer(self, message):
        at_us, number = now_us(), int(message.header.frame_id)
        while self.open and self.open[0] <= number:
            self.by_timer_us.append(at_us - self.sent_us[self.open.pop(0)])

    def pose(self, message):
        at_us = now_us()
        self.pose_age_us.append(at_us - stamped_us(message))
        if self.pose_at_us is not None:
            self.pose_every_us.append(at_us - self.pose_at_us)
        self.pose_at_us = at_us

    def end(self):
        rclpy_calls, skein_calls = self.calls["rclpy"], self.calls["skein"]
        return {
            "questions": len(self.sent_us),
            "one_way_us": self.one_way_us,
            "there_and_back_us": self.there_and_back_us,
            "by_timer_us": self.by_timer_us,
            "pose_age_us": self.pose_age_us,
            "pose_every_us": self.pose_every_us,
            "rclpy_call_us": rclpy_calls.took_us,
            "skein_call_us": skein_calls.took_us,
            "refused": skein_calls.refused,
            "unanswered": rclpy_calls.unanswered + skein_calls.unanswered,
        }


class Listener:
    def __init__(self, node, vehicles):
        self.counts = {}
        for vehicle in vehicles:
            self.counts[vehicle] = 0
            node.create_subscription(PoseStamped, f"/skein/{vehicle}/pose", lambda _, v=vehicle: self.pose(v), QUALITY)

    def pose(self, vehicle):
        self.counts[vehicle] += 1

    def begin(self):
        self.counts = dict.fromkeys(self.counts, 0)

    def missing(self):
        return [vehicle for vehicle, count in self.counts.items() if count == 0]

    def end(self):
        return {"poses": sum(self.counts.values())}


def orders(given):
    for line in sys.stdin:
        given.append(line.strip())
    os._exit(0)


def main():
    role, *rest = sys.argv[1:]
    rclpy.init(args=[])
    node = rclpy.create_node(f"bench_{role}_{os.getpid()}")
    part = Answerer(node) if role == "answer" else Asker(node, rest[0]) if role == "ask" else Listener(node, rest)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    given = []
    threading.Thread(target=orders, args=(given,), daemon=True).start()
    told, ready = time.monotonic(), role == "answer"
    while True:
        executor.spin_once(timeout_sec=0.1)
        if not ready and not (missing := list(part.missing())):
            ready = True
            print("ready", flush=True)
        elif not ready and time.monotonic() - told > 5:
            told = time.monotonic()
            print("waits for " + ", ".join(missing), flush=True)
        while given:
            if given.pop(0) == "b":
                part.begin()
            else:
                print(json.dumps(part.end()), flush=True)


main()
