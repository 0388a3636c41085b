"""Flies one vehicle with the real MAVSDK: connect, arm, take off, OFFBOARD by position and by velocity, land.

Prints what it does; a line `REPORT {...}` holds what MAVSDK itself says at that moment. Ends with a failure as soon as
anything is refused or takes too long.
"""

import argparse
import json
import math
import sys
import threading
import time

from mavsdk import ComponentType, Configuration, ConnectionResult, Mavsdk
from mavsdk.plugins.action import Action, ActionError
from mavsdk.plugins.info import Info
from mavsdk.plugins.offboard import Offboard, OffboardError, PositionNedYaw, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry


class State:
    """The latest of everything MAVSDK tells of."""

    def __init__(self, telemetry):
        self.changed = threading.Condition()
        self.values = {}
        self.texts = []
        telemetry.subscribe_position_velocity_ned(self.keep("ned"))
        telemetry.subscribe_position(self.keep("position"))
        telemetry.subscribe_armed(self.keep("armed"))
        telemetry.subscribe_in_air(self.keep("in_air"))
        telemetry.subscribe_landed_state(self.keep("landed"))
        telemetry.subscribe_flight_mode(self.keep("mode"))
        telemetry.subscribe_health(self.keep("health"))
        telemetry.subscribe_home(self.keep("home"))
        telemetry.subscribe_battery(self.keep("battery"))
        telemetry.subscribe_gps_info(self.keep("gps"))
        telemetry.subscribe_attitude_euler(self.keep("attitude"))
        telemetry.subscribe_status_text(self.keep_text)

    def keep(self, name):
        def callback(value, _user_data):
            with self.changed:
                self.values[name] = value
                self.changed.notify_all()

        return callback

    def keep_text(self, text, _user_data):
        print(f"vehicle says: {text.text.strip()}")
        self.texts.append(text.text.strip())

    def wait(self, what, condition, limit_s):
        begin = time.monotonic()
        with self.changed:
            while not self.holds(condition):
                left = begin + limit_s - time.monotonic()
                if left <= 0:
                    sys.exit(f"FAILED: waited {limit_s} s in vain: {what}; last known: " + ", ".join(
                        f"{k}={v}" for k, v in self.values.items()))
                self.changed.wait(min(left, 0.5))
        print(f"{what}: after {time.monotonic() - begin:.1f} s")

    def holds(self, condition):
        try:
            return condition(self.values)
        except KeyError:
            return False

    def report(self, phase, **more):
        with self.changed:
            v = dict(self.values)
        p, s = v["ned"].position, v["ned"].velocity
        print("REPORT " + json.dumps({
            "phase": phase,
            "ned": [p.north_m, p.east_m, p.down_m],
            "velocity": [s.north_m_s, s.east_m_s, s.down_m_s],
            "geodetic": [v["position"].latitude_deg, v["position"].longitude_deg, v["position"].absolute_altitude_m],
            "relative_altitude": v["position"].relative_altitude_m,
            "armed": bool(v["armed"]),
            "mode": FlightMode(v["mode"]).name,
            "landed": LandedState(v["landed"]).name,
            "battery": v["battery"].remaining_percent,
            "satellites": v["gps"].num_satellites,
            "waits": True,
            **more,
        }), flush=True)
        # Nothing is done before it has been held against the truth of that moment.
        sys.stdin.readline()


def near(values, goal, metres):
    p, s = values["ned"].position, values["ned"].velocity
    distance = math.dist((p.north_m, p.east_m, p.down_m), goal)
    return distance < metres and math.hypot(s.north_m_s, s.east_m_s, s.down_m_s) < 0.25


def fly(url):
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    result = mavsdk.add_any_connection(url)
    if result != ConnectionResult.SUCCESS:
        sys.exit(f"FAILED: cannot open {url}: {result!r}")
    print(f"MAVSDK {mavsdk.version()} listens on {url}")
    system = mavsdk.first_autopilot(30.0)
    if system is None:
        sys.exit("FAILED: no autopilot was discovered within 30 s")
    print(f"discovered system {system.get_system_id()}: {system.autopilot_type()!r}, {system.vehicle_type()!r}")
    telemetry, action, offboard = Telemetry(system), Action(system), Offboard(system)
    state = State(telemetry)
    version = Info(system).get_version()
    print(f"flight software {version.flight_sw_major}.{version.flight_sw_minor}.{version.flight_sw_patch}")

    try:
        action.arm()
        sys.exit("FAILED: it could be armed before its estimator was ready")
    except ActionError as refused:
        print(f"arming too early is refused: {refused}")

    state.wait("ready to be armed", lambda v: v["health"].is_armable and v["health"].is_global_position_ok
               and v["health"].is_home_position_ok and v["health"].is_local_position_ok, 30)
    state.wait("everything was heard of", lambda v: all(
        k in v for k in ("ned", "position", "armed", "landed", "mode", "battery", "gps", "attitude", "home")), 20)

    param = Param(system)
    param.set_param_float("MIS_TAKEOFF_ALT", 5.0)
    param.set_param_int("COM_OBL_RC_ACT", 5)
    if (param.get_param_float("MIS_TAKEOFF_ALT"), param.get_param_int("COM_OBL_RC_ACT")) != (5.0, 5):
        sys.exit("FAILED: parameters did not take the values they were set to")
    names = [p.name for p in param.get_all_params().int_params]
    print(f"{len(names)} integer parameters")
    state.report("ready", version=[version.flight_sw_major, version.flight_sw_minor], int_params=len(names))

    action.arm()
    state.wait("armed", lambda v: v["armed"], 5)
    action.takeoff()
    state.wait("in the air", lambda v: v["in_air"], 15)
    state.wait("holds at the top", lambda v: v["mode"] == FlightMode.HOLD and v["position"].relative_altitude_m > 4.7, 30)
    state.report("hovering")

    try:
        offboard.start()
        sys.exit("FAILED: OFFBOARD was entered without a setpoint")
    except OffboardError as refused:
        print(f"OFFBOARD without a setpoint is refused: {refused}")

    here = state.values["ned"].position
    offboard.set_position_ned(PositionNedYaw(here.north_m, here.east_m, here.down_m, 0.0))
    time.sleep(1.0)
    offboard.start()
    state.wait("in OFFBOARD", lambda v: v["mode"] == FlightMode.OFFBOARD, 5)
    goal = (here.north_m + 10.0, here.east_m, -5.0)
    offboard.set_position_ned(PositionNedYaw(*goal, 90.0))
    state.wait("ten metres north", lambda v: near(v, goal, 0.35), 20)
    state.report("north", goal=goal)
    state.wait("nose to the east", lambda v: abs(v["attitude"].yaw_deg - 90.0) < 5.0, 10)

    begin = time.monotonic()
    offboard.set_velocity_ned(VelocityNedYaw(0.0, 2.0, 0.0, 90.0))
    state.wait("two metres per second east", lambda v: abs(v["ned"].velocity.east_m_s - 2.0) < 0.2, 10)
    time.sleep(max(0.0, 4.0 - (time.monotonic() - begin)))
    state.report("eastward")
    there = state.values["ned"].position
    goal = (goal[0], there.east_m + 2.0, goal[2])
    offboard.set_position_ned(PositionNedYaw(*goal, 90.0))
    state.wait("stopped", lambda v: near(v, goal, 0.4), 20)
    state.report("stopped", goal=goal)

    offboard.stop()
    state.wait("holds again", lambda v: v["mode"] == FlightMode.HOLD, 5)
    action.land()
    state.wait("lands", lambda v: v["landed"] == LandedState.LANDING, 10)
    state.wait("disarmed on the ground", lambda v: not v["armed"] and v["landed"] == LandedState.ON_GROUND, 40)
    state.report("landed", texts=state.texts)
    mavsdk.destroy()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url", help="where MAVSDK listens, as in udpin://127.0.0.1:14540")
    fly(parser.parse_args().url)


if __name__ == "__main__":
    main()
