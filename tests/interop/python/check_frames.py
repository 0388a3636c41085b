"""Listens to vehicles with pymavlink and checks every frame: framing, checksum, known message, fields within reason.

Talks to one vehicle as well: rates, parameters, a command nobody knows. Ends with a failure on the first bad frame.
"""

import argparse
import json
import math
import os
import struct
import sys
import time
from collections import Counter, deque

os.environ["MAVLINK20"] = "1"

from pymavlink import mavutil  # noqa: E402
from pymavlink.dialects.v20 import common  # noqa: E402

# An answer comes at once. On a busy machine this program reads later than frames come, so it may stand far behind in the queue.
PATIENCE_S = 60


class Listener:
    """One UDP port; every datagram must hold whole frames that decode."""

    def __init__(self, port):
        self.link = mavutil.mavudp(f"127.0.0.1:{port}", input=True, source_system=250, source_component=191)
        self.decoder = common.MAVLink(None, srcSystem=250, srcComponent=191)
        self.sequences = {}
        self.counts = {}
        self.lost = 0
        self.frames = 0
        self.waiting = deque()

    def next(self):
        """The next message that has come; None if there is none."""
        if not self.waiting:
            data = self.link.recv(4096)
            self.waiting.extend(self.decode(data) if data else [])
        return self.waiting.popleft() if self.waiting else None

    def decode(self, data):
        found, at = [], 0
        while at < len(data):
            if data[at] != 0xFD:
                sys.exit(f"FAILED: not MAVLink 2 at byte {at} of {data.hex()}")
            length = 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0)
            frame = data[at:at + length]
            at += length
            # Raises on a wrong checksum, a wrong length, or an unknown message.
            message = self.decoder.decode(bytearray(frame))
            if message.get_type().startswith(("UNKNOWN", "BAD")):
                sys.exit(f"FAILED: {message} in {frame.hex()}")
            self.check(message)
            found.append(message)
        return found

    def check(self, message):
        self.frames += 1
        system = message.get_srcSystem()
        last = self.sequences.get(system)
        if last is not None:
            self.lost += (message.get_seq() - last - 1) % 256
        self.sequences[system] = message.get_seq()
        self.counts.setdefault(system, Counter())[message.get_type()] += 1
        kind = message.get_type()
        if message.get_srcComponent() != 1:
            sys.exit(f"FAILED: component {message.get_srcComponent()}")
        if kind == "HEARTBEAT" and (message.autopilot, message.type) != (12, 2):
            sys.exit(f"FAILED: not a PX4 quadrotor: {message}")
        if kind == "ATTITUDE_QUATERNION":
            norm = math.sqrt(message.q1**2 + message.q2**2 + message.q3**2 + message.q4**2)
            if abs(norm - 1.0) > 1e-3:
                sys.exit(f"FAILED: quaternion of length {norm}")
        if kind == "GLOBAL_POSITION_INT" and not (0 <= message.hdg < 36000 and abs(message.lat) < 9e8):
            sys.exit(f"FAILED: out of range: {message}")


def expect(listener, what, condition):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        message = listener.next()
        if message is None:
            time.sleep(0.002)
        elif condition(message):
            print(f"{what}: {message}")
            return message
    sys.exit(f"FAILED: waited {PATIENCE_S} s in vain for: {what}")


def converse(listener, system):
    """Commands and parameters with one vehicle, over the link it was heard on."""
    mav = listener.link.mav
    expect(listener, "heartbeat", lambda m: m.get_type() == "HEARTBEAT" and m.get_srcSystem() == system)

    def acknowledged(command):
        def condition(m):
            return (m.get_type() == "COMMAND_ACK" and m.command == command and m.get_srcSystem() == system
                    and (m.target_system, m.target_component) == (250, 191))
        return condition

    # The first datagrams of a link may go unanswered on a real one, so it is repeated there; ours must not need that.
    mav.command_long_send(system, 1, 31999, 0, 0, 0, 0, 0, 0, 0, 0)
    unknown = expect(listener, "unknown command", acknowledged(31999))
    mav.command_long_send(system, 1, 511, 0, 30, 20000, 0, 0, 0, 0, 0)
    expect(listener, "rate", acknowledged(511))
    mav.param_set_send(system, 1, b"COM_OBL_RC_ACT", struct.unpack("<f", struct.pack("<i", 3))[0], 6)
    for n in (1, 2):
        echo = expect(listener, f"echo {n}", lambda m: m.get_type() == "PARAM_VALUE" and m.param_id == "COM_OBL_RC_ACT")
    stored = struct.unpack("<i", struct.pack("<f", echo.param_value))[0]
    mav.timesync_send(0, 4242)
    expect(listener, "clock", lambda m: m.get_type() == "TIMESYNC" and m.ts1 == 4242 and m.tc1 > 0)
    mav.mission_request_list_send(system, 1)
    expect(listener, "no plan", lambda m: m.get_type() == "MISSION_COUNT" and m.count == 0)
    # Accepts the older framing too.
    mav.robust_parsing = True
    old = common.MAVLink(None, srcSystem=250, srcComponent=191)
    frame = old.command_long_encode(system, 1, 512, 0, 148, 0, 0, 0, 0, 0, 0).pack(old, force_mavlink1=True)
    listener.link.write(frame)
    version = expect(listener, "version", lambda m: m.get_type() == "AUTOPILOT_VERSION")
    return {"unknown_result": unknown.result, "stored": stored, "version": version.flight_sw_version}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("port", type=int)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--converse-with", type=int, default=None)
    arguments = parser.parse_args()
    listener = Listener(arguments.port)
    print("REPORT " + json.dumps({"phase": "listening"}))
    answers = converse(listener, arguments.converse_with) if arguments.converse_with else {}
    end = time.monotonic() + arguments.seconds
    while time.monotonic() < end:
        if listener.next() is None:
            time.sleep(0.002)
    for system, counts in sorted(listener.counts.items()):
        print(f"system {system}: {sum(counts.values())} frames, {len(counts)} kinds")
    print("REPORT " + json.dumps({
        "phase": "done",
        "frames": listener.frames,
        "lost": listener.lost,
        "systems": {str(s): dict(c) for s, c in listener.counts.items()},
        **answers,
    }))


if __name__ == "__main__":
    main()
