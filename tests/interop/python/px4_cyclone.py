"""PX4 vehicles behind their uXRCE-DDS agent, played over Cyclone DDS: one participant each, as the agent has.

Told what to do by lines of JSON on standard input, tells the truth by lines `REPORT {...}`. What can be asked stands at `Play`.
As PX4 does, a topic is offered from its first message on: the one for acknowledgements only after the first command.
"""

import gc
import json
import math
import queue
import sys
import threading
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

import px4_tables as tables
from px4_vehicle import Vehicle

STEP_S = 0.01
TRUTH_S = 0.05
# Messages a second; those that PX4 publishes when something changes come then as well.
RATES_HZ = {"vehicle_local_position": 50.0, "vehicle_attitude": 50.0, "vehicle_global_position": 10.0, "vehicle_status": 2.0,
            "vehicle_land_detected": 1.0, "battery_status": 1.0, "vehicle_gps_position": 5.0, "home_position": 0.5,
            "timesync_status": 1.0}
METRES_A_DEGREE = 6_378_137.0 * math.pi / 180.0
PLAIN = Policy.DataRepresentation(use_cdrv0_representation=True)
SECOND = Policy.DataRepresentation(use_xcdrv2_representation=True)


def quality(durability, representation=PLAIN):
    return Qos(Policy.Reliability.BestEffort, durability, Policy.History.KeepLast(10), representation)


def report(**what):
    print("REPORT " + json.dumps(what), flush=True)


def offset_of(shape, wanted):
    """Where a field begins in a sample, after the head of four octets."""
    size = {"bool": 1, "u8": 1, "u16": 2, "u32": 4, "u64": 8, "i32": 4, "i64": 8, "f32": 4, "f64": 8}
    size = {tables.KINDS[word]: octets for word, octets in size.items()}
    at = 0
    for name, kind, elements in tables.fields_of(shape):
        at += -at % size[kind]
        if name == wanted:
            return at
        at += size[kind] * max(elements, 1)
    raise KeyError(wanted)


class Writer:
    """Writes one topic: whole messages, or any octets."""

    def __init__(self, participant, topic, wire_name, shape=None, representation=PLAIN):
        self.participant, self.topic, self.wire_name, self.shape = participant, topic, wire_name, shape
        self.quality = quality(Policy.Durability.TransientLocal, representation)
        self.kinds, self.writers = {}, {}

    def writer(self, key, kind):
        if key not in self.writers:
            topic = Topic(self.participant, self.topic, kind, qos=self.quality)
            self.kinds[key], self.writers[key] = kind, DataWriter(self.participant, topic, qos=self.quality)
        return self.writers[key]

    def message(self, values):
        kind = self.kinds.get("whole") or tables.message(self.shape, self.wire_name)
        self.writer("whole", kind).write(tables.fill(kind, self.shape, values))

    def octets(self, octets):
        kind = self.kinds.get(len(octets)) or tables.octets(len(octets), self.wire_name)
        self.writer(len(octets), kind).write(kind(octets=list(octets)))

    def encoded(self, values):
        kind = tables.message(self.shape, self.wire_name)
        return bytearray(tables.fill(kind, self.shape, values).serialize()[4:])


class Px4:
    """One vehicle with its participant."""

    def __init__(self, domain, namespace, release, system_id, place, at=(0.0, 0.0), stamps="boot", faults=None, silent=(),
                 unread=(), versions=None, types=None, representation="plain", participant=None):
        self.participant = participant or DomainParticipant(domain)
        self.prefix = f"rt/{namespace}/fmu" if namespace else "rt/fmu"
        self.vehicle = Vehicle(system_id, at)
        self.place, self.stamps = place, stamps
        self.faults, self.silent = faults or {}, silent
        self.begun, self.stepped = time.monotonic() - 30.0, time.monotonic()
        self.due = dict.fromkeys(RATES_HZ, 0.0)
        self.told = None
        self.stamps_off, self.misdirected = 0, 0
        versions, types = versions or {}, types or {}
        self.writers = {}
        for topic, (shape, version) in tables.RELEASES[release].items():
            version = versions.get(topic, version)
            name = f"{self.prefix}/out/{topic}" + (f"_v{version}" if version else "")
            wire_name = types.get(topic, tables.type_name(tables.MESSAGES[topic]))
            of = SECOND if representation == "second" else PLAIN
            self.writers[topic] = Writer(self.participant, name, wire_name, shape, of)
        self.readers = {topic: self.reader(topic, shape) for topic, shape in tables.INCOMING.items() if topic not in unread}

    def reader(self, topic, shape):
        kind = tables.message(shape, tables.type_name(tables.MESSAGES[topic]))
        volatile = quality(Policy.Durability.Volatile)
        return DataReader(self.participant, Topic(self.participant, f"{self.prefix}/in/{topic}", kind, qos=volatile), qos=volatile)

    def now_us(self):
        since = time.time() if self.stamps == "agent" else time.monotonic() - self.begun
        return int(since * 1e6)

    def take(self, topic):
        if topic not in self.readers:
            return []
        found = [sample for sample in self.readers[topic].take(N=64) if sample.sample_info.valid_data]
        # Nobody needs to stamp; who does must mean this vehicle's clock.
        self.stamps_off += sum(abs(sample.timestamp - self.now_us()) > 500_000 for sample in found if sample.timestamp)
        return found

    def step(self, who):
        now = time.monotonic()
        for sample in self.take("offboard_control_mode"):
            self.vehicle.on_mode_flags(now, vars(sample))
        for sample in self.take("trajectory_setpoint"):
            self.vehicle.on_setpoint(vars(sample))
        for sample in self.take("vehicle_command"):
            self.on_command(who, now, sample)
        self.vehicle.step(now, self.now_us(), now - self.stepped)
        self.stepped = now
        self.publish(now)

    def on_command(self, who, now, command):
        if command.target_system not in (0, self.vehicle.system_id) or not command.from_external:
            self.misdirected += 1
            return
        param = [getattr(command, f"param{i}") for i in range(1, 8)]
        if command.command == 22:
            # A take-off says how high above the sea.
            param[6] -= self.place[2]
        result = self.vehicle.command(now, command.command, param)
        report(who=who, command=command.command, result=result, confirmation=command.confirmation)
        self.write("vehicle_command_ack", {
            "timestamp": self.now_us(), "command": command.command, "result": result, "target_system": command.source_system,
            "target_component": command.source_component})

    def publish(self, now):
        state = (self.vehicle.armed, self.vehicle.nav_state, self.vehicle.landed, self.vehicle.failsafe)
        if state != self.told:
            self.told = state
            self.due["vehicle_status"] = self.due["vehicle_land_detected"] = 0.0
        for topic, due in self.due.items():
            if now >= due and topic in self.writers:
                self.due[topic] = max(due + 1.0 / RATES_HZ[topic], now)
                self.write(topic, self.values(topic))

    def values(self, topic):
        v, us = self.vehicle, self.now_us()
        latitude, longitude, altitude = self.place
        north, east, down = v.position
        lat = latitude + north / METRES_A_DEGREE
        lon = longitude + east / METRES_A_DEGREE / math.cos(math.radians(latitude))
        known = {"timestamp": us, "timestamp_sample": us - 4000}
        return known | {
            "vehicle_local_position": lambda: dict(
                x=north, y=east, z=down, vx=v.velocity[0], vy=v.velocity[1], vz=v.velocity[2], heading=v.yaw, xy_valid=True,
                z_valid=True, v_xy_valid=True, v_z_valid=True, xy_global=True, z_global=True, ref_lat=latitude,
                ref_lon=longitude, ref_alt=altitude, eph=0.4, epv=0.6, vxy_max=math.nan),
            "vehicle_attitude": lambda: dict(q=[math.cos(v.yaw / 2), 0.0, 0.0, math.sin(v.yaw / 2)]),
            "vehicle_global_position": lambda: dict(
                lat=lat, lon=lon, alt=altitude - down, lat_lon_valid=True, alt_valid=True, eph=0.4),
            "vehicle_status": lambda: dict(
                arming_state=2 if v.armed else 1, nav_state=v.nav_state, failsafe=v.failsafe, system_id=v.system_id,
                component_id=1, takeoff_time=v.took_off_us, vehicle_type=1, pre_flight_checks_pass=True),
            "vehicle_land_detected": lambda: dict(landed=v.landed, maybe_landed=v.landed),
            "battery_status": lambda: dict(id=1, connected=True, voltage_v=15.5, current_a=7.5, remaining=0.75),
            "vehicle_gps_position": lambda: dict(
                fix_type=3, satellites_used=14, eph=0.7, latitude_deg=lat, longitude_deg=lon, altitude_msl_m=altitude - down),
            "home_position": lambda: dict(
                lat=latitude, lon=longitude, alt=altitude, valid_alt=True, valid_hpos=True, valid_lpos=True),
            "timesync_status": lambda: dict(
                source_protocol=2, estimated_offset=int((time.monotonic() - self.begun) * 1e6) - us, round_trip_time=700),
        }[topic]()

    def write(self, topic, values):
        if topic in self.silent or topic not in self.writers:
            return
        writer, fault = self.writers[topic], self.faults.get(topic)
        if not fault:
            writer.message(values)
            return
        # `float` reads "nan", "inf" and "1e308" too, which JSON has no numbers for.
        values = values | {name: float(value) for name, value in fault.get("fields", {}).items()}
        octets = writer.encoded(values)
        for name, octet in fault.get("octets", {}).items():
            octets[offset_of(writer.shape, name)] = octet
        octets = octets[:len(octets) - fault.get("cut", 0)] + bytes(fault.get("more", 0))
        writer.octets(octets)

    def truth(self):
        return self.vehicle.truth(time.monotonic()) | {"stamps_off": self.stamps_off, "misdirected": self.misdirected}


class Play:
    """Does what the lines say: `do` names the method, the rest are its arguments."""

    def __init__(self):
        self.vehicles, self.strangers = {}, {}

    def start(self, who, beside=None, **how):
        """Switches one on, on the participant of another one if it is said beside which."""
        participant = self.vehicles[beside].participant if beside else None
        self.vehicles[who] = Px4(participant=participant, **how)

    def stop(self, who):
        self.vehicles.pop(who, None)
        self.strangers.pop(who, None)
        gc.collect()

    def change(self, who, **how):
        """Sets `faults` or `silent` of one that is there."""
        for name, value in how.items():
            setattr(self.vehicles[who], name, value)

    def pilot(self, who, nav_state):
        self.vehicles[who].vehicle.nav_state = nav_state

    def stranger(self, who, domain, topic, message, shape=None, values=None, octets=None, each_step=1, reads=False):
        """Another program, which writes to a topic or reads it."""
        participant = DomainParticipant(domain)
        wire_name = message if "::" in message else tables.type_name(message)
        if reads:
            volatile = quality(Policy.Durability.Volatile)
            kind = tables.message(shape, wire_name) if shape else tables.octets(8, wire_name)
            self.strangers[who] = (DataReader(participant, Topic(participant, topic, kind, qos=volatile), qos=volatile), None, 0)
            return
        writer = Writer(participant, topic, wire_name, shape)
        if octets is None:
            values = {name: [float(v) for v in value] if isinstance(value, list) else value for name, value in values.items()}
            octets = writer.encoded(values)
        self.strangers[who] = (writer, bytes(octets), each_step)

    def step(self):
        for who, vehicle in self.vehicles.items():
            vehicle.step(who)
        for writer, octets, each_step in self.strangers.values():
            for _ in range(each_step):
                writer.octets(octets)


def hear(lines):
    for line in sys.stdin:
        lines.put(line)
    lines.put(None)


def main():
    play, lines = Play(), queue.Queue()
    threading.Thread(target=hear, args=(lines,), daemon=True).start()
    told = 0.0
    while True:
        while not lines.empty():
            line = lines.get()
            if line is None:
                return
            asked = json.loads(line)
            getattr(play, asked.pop("do"))(**asked)
        play.step()
        if time.monotonic() - told > TRUTH_S:
            told = time.monotonic()
            report(truth={who: vehicle.truth() for who, vehicle in play.vehicles.items()})
        time.sleep(STEP_S)


if __name__ == "__main__":
    main()
