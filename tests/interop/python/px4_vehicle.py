"""A multicopter as PX4 flies it, as much of it as a link sees: modes, arming, take-off, OFFBOARD with its loss, landing.

Knows nothing of DDS. Positions are north, east, down in metres from its launch place; times are seconds of the caller's clock.
"""

import math

HOLD, RETURN, OFFBOARD, TAKE_OFF, LAND = 4, 5, 14, 17, 18
ACCEPTED, TEMPORARILY_REJECTED, UNSUPPORTED = 0, 1, 3
# Of a DO_SET_MODE: main and sub mode to what it flies then; 0 stands for any sub mode.
MODES = {(1, 0): 0, (2, 0): 1, (3, 0): 2, (4, 2): TAKE_OFF, (4, 3): HOLD, (4, 4): 3, (4, 5): RETURN, (4, 6): LAND,
         (6, 0): OFFBOARD}
FORCED = 21196
STREAM_LOST_S = 1.0
SPEED_M_S, CLIMB_M_S, SINK_M_S, ACCELERATION_M_S2 = 5.0, 2.0, 1.5, 6.0
DISARMS_AFTER_S = 0.5


def finite(numbers):
    return all(math.isfinite(number) for number in numbers)


class Vehicle:
    def __init__(self, system_id, at):
        self.system_id = system_id
        self.position = [at[0], at[1], 0.0]
        self.velocity = [0.0, 0.0, 0.0]
        self.yaw = 0.3
        self.armed, self.landed, self.failsafe = False, True, False
        self.nav_state = HOLD
        self.goal = list(self.position)
        self.touched = None
        self.took_off_us = 0
        self.stream_heard = -math.inf
        self.mode_flags, self.setpoint = None, None
        self.counts = {"setpoints": 0, "infinite": 0, "idle": 0, "streams_lost": 0}

    def command(self, now, number, param):
        """Obeys or refuses; gives MAV_RESULT. `param` holds param1 to param7."""
        if number == 400:
            return self.arm(now) if param[0] == 1.0 else self.disarm(param[1] == FORCED)
        if number == 176:
            return self.set_mode(now, MODES.get((int(param[1]), int(param[2]))))
        if number == 22:
            self.climb_to(now, param[6])
            return ACCEPTED
        if number == 21:
            return self.set_mode(now, LAND)
        return UNSUPPORTED

    def climb_to(self, now, height):
        self.set_mode(now, TAKE_OFF)
        self.goal = [self.position[0], self.position[1], -height if math.isfinite(height) else -2.5]

    def arm(self, now):
        if self.nav_state == OFFBOARD and not self.streams(now):
            return TEMPORARILY_REJECTED
        self.armed = True
        return ACCEPTED

    def disarm(self, forced):
        if not self.landed and not forced:
            return TEMPORARILY_REJECTED
        self.armed, self.took_off_us = False, 0
        return ACCEPTED

    def set_mode(self, now, nav_state):
        if nav_state is None:
            return UNSUPPORTED
        if nav_state == OFFBOARD and not self.streams(now) and not self.landed:
            return TEMPORARILY_REJECTED
        self.nav_state, self.failsafe = nav_state, False
        self.goal = list(self.position)
        return ACCEPTED

    def streams(self, now):
        return self.setpoint is not None and now - self.stream_heard < STREAM_LOST_S

    def on_mode_flags(self, now, flags):
        self.mode_flags, self.stream_heard = flags, now
        self.counts["idle"] += not (flags["position"] or flags["velocity"])

    def on_setpoint(self, setpoint):
        self.setpoint = setpoint
        self.counts["setpoints"] += 1
        numbers = [*setpoint["position"], *setpoint["velocity"], setpoint["yaw"], setpoint["yawspeed"]]
        self.counts["infinite"] += any(math.isinf(number) for number in numbers)

    def step(self, now, now_us, dt):
        self.watch_stream(now)
        wanted = self.wanted_velocity() if self.armed else [0.0, 0.0, 0.0]
        for axis in range(3):
            change = max(-1.0, min(1.0, (wanted[axis] - self.velocity[axis]) / (ACCELERATION_M_S2 * dt)))
            self.velocity[axis] += change * ACCELERATION_M_S2 * dt
            self.position[axis] += self.velocity[axis] * dt
        if self.position[2] >= 0.0:
            self.position[2], self.velocity = 0.0, [0.0, 0.0, 0.0]
        self.touch(now, now_us)

    def watch_stream(self, now):
        if self.nav_state == OFFBOARD and not self.streams(now) and not self.landed:
            self.nav_state, self.failsafe = HOLD, True
            self.goal = list(self.position)
            self.counts["streams_lost"] += 1
        elif self.failsafe and self.streams(now):
            self.nav_state, self.failsafe = OFFBOARD, False

    def wanted_velocity(self):
        if self.nav_state == LAND:
            return [0.0, 0.0, SINK_M_S]
        if self.nav_state == OFFBOARD and self.setpoint and self.mode_flags:
            if not math.isnan(self.setpoint["yaw"]):
                self.yaw = self.setpoint["yaw"]
            forward = [0.0 if math.isnan(part) else part for part in self.setpoint["velocity"]]
            if not self.mode_flags["position"]:
                return forward if self.mode_flags["velocity"] else [0.0, 0.0, 0.0]
            if not finite(self.setpoint["position"]):
                return [0.0, 0.0, 0.0]
            return self.towards(self.setpoint["position"], forward)
        if self.nav_state == TAKE_OFF and self.position[2] - self.goal[2] < 0.25:
            self.nav_state = HOLD
        return self.towards(self.goal, [0.0, 0.0, 0.0])

    def towards(self, goal, forward):
        north, east, down = (1.2 * (goal[axis] - self.position[axis]) + forward[axis] for axis in range(3))
        fast = max(1.0, math.hypot(north, east) / SPEED_M_S)
        return [north / fast, east / fast, max(-CLIMB_M_S, min(SINK_M_S, down))]

    def touch(self, now, now_us):
        if self.position[2] < -0.1:
            if self.landed:
                self.landed, self.took_off_us = False, now_us
            self.touched = None
        elif self.nav_state == LAND and self.position[2] >= 0.0:
            self.landed, self.took_off_us = True, 0
            self.touched = self.touched or now
            if self.armed and now - self.touched > DISARMS_AFTER_S:
                self.armed = False

    def truth(self, now):
        return {"position": self.position, "velocity": self.velocity, "yaw": self.yaw, "nav_state": self.nav_state,
                "armed": self.armed, "landed": self.landed, "failsafe": self.failsafe, "streams": self.streams(now),
                **self.counts}
