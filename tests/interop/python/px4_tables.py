"""px4_msgs as tables of fields, by release, and the types that Cyclone DDS makes of them.

Written from the published interface, apart from the tables in core/link-dds: a mistake in one of them must not be in the other.
A line holds a type and the fields of it that follow each other; `x[3]` is an array.
"""

import types as python_types
from dataclasses import dataclass

from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl

KINDS = {
    "bool": bool, "u8": idl.uint8, "u16": idl.uint16, "u32": idl.uint32, "u64": idl.uint64,
    "i32": idl.int32, "i64": idl.int64, "f32": idl.float32, "f64": idl.float64,
}

STATUS_HEAD = """
u64 timestamp armed_time takeoff_time
u8 arming_state latest_arming_reason latest_disarming_reason
u64 nav_state_timestamp
u8 nav_state_user_intention nav_state executor_in_charge"""
STATUS_LINKS = """
u8 hil_state vehicle_type
bool failsafe failsafe_and_user_took_over
u8 failsafe_defer_state
bool gcs_connection_lost
u8 gcs_connection_lost_counter
bool high_latency_data_link_lost is_vtol is_vtol_tailsitter in_transition_mode in_transition_to_fw
u8 system_type system_id component_id
bool safety_button_available safety_off power_input_valid usb_connected
bool open_drone_id_system_present open_drone_id_system_healthy parachute_system_present parachute_system_healthy"""
STATUS_MASKS = """
u32 valid_nav_states_mask can_set_nav_states_mask"""
STATUS_TAIL = """
bool rc_calibration_in_progress calibration_enabled pre_flight_checks_pass"""
STATUS_FAILURES = """
u16 failure_detector_status"""

LOCAL_HEAD = """
u64 timestamp timestamp_sample
bool xy_valid z_valid v_xy_valid v_z_valid
f32 x y z delta_xy[2]
u8 xy_reset_counter
f32 delta_z
u8 z_reset_counter
f32 vx vy vz z_deriv delta_vxy[2]
u8 vxy_reset_counter
f32 delta_vz
u8 vz_reset_counter
f32 ax ay az heading heading_var unaided_heading delta_heading
u8 heading_reset_counter
bool heading_good_for_control
f32 tilt_var
bool xy_global z_global
u64 ref_timestamp
f64 ref_lat ref_lon
f32 ref_alt"""
LOCAL_TAIL = """
f32 eph epv evh evv
bool dead_reckoning
f32 vxy_max vz_max hagl_min"""

BATTERY_MIDDLE = """
f32 discharged_mah remaining scale time_remaining_s temperature
u8 cell_count source priority
u16 capacity cycle_count average_time_to_empty"""
BATTERY_HEALTH = """
u16 manufacture_date state_of_health max_error
u8 id
u16 interface_error
f32 voltage_cell_v[14] max_cell_voltage_delta
bool is_powering_off is_required"""
BATTERY_ESTIMATES = """
f32 full_charge_capacity_wh remaining_capacity_wh
u16 over_discharge_count
f32 nominal_voltage internal_resistance_estimate ocv_estimate ocv_estimate_filtered volt_based_soc_estimate
f32 voltage_prediction prediction_error estimation_covariance_norm"""

GPS_HEAD = """
u64 timestamp timestamp_sample
u32 device_id
f64 latitude_deg longitude_deg altitude_msl_m altitude_ellipsoid_m
f32 s_variance_m_s c_variance_rad
u8 fix_type
f32 eph epv hdop vdop
i32 noise_per_ms
u16 automatic_gain_control
u8 jamming_state
i32 jamming_indicator
u8 spoofing_state"""
GPS_MOTION = """
f32 vel_m_s vel_n_m_s vel_e_m_s vel_d_m_s cog_rad
bool vel_ned_valid
i32 timestamp_time_relative
u64 time_utc_usec
u8 satellites_used"""
GPS_TAIL = """
f32 heading heading_offset heading_accuracy rtcm_injection_rate
u8 selected_rtcm_instance
bool rtcm_crc_failed
u8 rtcm_msg_used"""

HOME_HEAD = "u64 timestamp\nf64 lat lon\nf32 alt x y z"

SHAPES = {
    "status 1.15": STATUS_HEAD + STATUS_MASKS + STATUS_FAILURES + STATUS_LINKS
    + "\nbool avoidance_system_required avoidance_system_valid" + STATUS_TAIL,
    "status v1": STATUS_HEAD + STATUS_MASKS + STATUS_FAILURES + STATUS_LINKS + STATUS_TAIL,
    "status v4": STATUS_HEAD + "\nu8 nav_state_display\nbool accepts_offboard_setpoints" + STATUS_MASKS + STATUS_LINKS
    + "\nbool traffic_avoidance_system_present" + STATUS_TAIL,
    "local 1.15": LOCAL_HEAD + "\nf32 dist_bottom\nbool dist_bottom_valid\nu8 dist_bottom_sensor_bitfield" + LOCAL_TAIL
    + "\nf32 hagl_max",
    "local": LOCAL_HEAD + "\nbool dist_bottom_valid\nf32 dist_bottom dist_bottom_var delta_dist_bottom"
    + "\nu8 dist_bottom_reset_counter dist_bottom_sensor_bitfield" + LOCAL_TAIL + "\nf32 hagl_max_z hagl_max_xy",
    "global 1.15": """u64 timestamp timestamp_sample
        f64 lat lon
        f32 alt alt_ellipsoid delta_alt
        u8 lat_lon_reset_counter alt_reset_counter
        f32 eph epv terrain_alt
        bool terrain_alt_valid dead_reckoning""",
    "global": """u64 timestamp timestamp_sample
        f64 lat lon
        f32 alt alt_ellipsoid
        bool lat_lon_valid alt_valid
        f32 delta_alt delta_terrain
        u8 lat_lon_reset_counter alt_reset_counter terrain_reset_counter
        f32 eph epv terrain_alt
        bool terrain_alt_valid dead_reckoning""",
    "battery 1.15": "u64 timestamp\nbool connected"
    + "\nf32 voltage_v voltage_filtered_v current_a current_filtered_a current_average_a" + BATTERY_MIDDLE
    + "\nu16 serial_number" + BATTERY_HEALTH + "\nu16 faults\nu32 custom_faults\nu8 warning mode"
    + "\nf32 average_power available_energy full_charge_capacity_wh remaining_capacity_wh design_capacity"
    + "\nu16 average_time_to_full over_discharge_count\nf32 nominal_voltage",
    "battery 1.16": "u64 timestamp\nbool connected\nf32 voltage_v current_a current_average_a" + BATTERY_MIDDLE
    + "\nu16 serial_number" + BATTERY_HEALTH + "\nu16 faults\nu8 warning" + BATTERY_ESTIMATES,
    "battery v1": "u64 timestamp\nbool connected\nf32 voltage_v current_a current_average_a" + BATTERY_MIDDLE
    + BATTERY_HEALTH + "\nu8 warning\nu16 faults" + BATTERY_ESTIMATES,
    "gps 1.15": GPS_HEAD + GPS_MOTION + GPS_TAIL,
    "gps 1.17": GPS_HEAD + "\nu8 authentication_state" + GPS_MOTION + "\nu32 system_error" + GPS_TAIL,
    "gps 1.18": GPS_HEAD + "\nu8 authentication_state" + GPS_MOTION + "\nu32 system_error" + GPS_TAIL
    + "\nf32 antenna_offset_x antenna_offset_y antenna_offset_z",
    "home": HOME_HEAD + " yaw\nbool valid_alt valid_hpos valid_lpos manual_home\nu32 update_count",
    "home v1": HOME_HEAD + " roll pitch yaw\nbool valid_alt valid_hpos valid_lpos manual_home\nu32 update_count",
    "home v2": HOME_HEAD + " roll pitch yaw\nbool valid_alt valid_hpos valid_lpos valid_attitude manual_home"
    + "\nu32 update_count",
    "attitude": "u64 timestamp timestamp_sample\nf32 q[4] delta_q_reset[4]\nu8 quat_reset_counter",
    "landed": """u64 timestamp
        bool freefall ground_contact maybe_landed landed in_ground_effect in_descend has_low_throttle
        bool vertical_movement horizontal_movement rotational_movement close_to_ground_or_skipped_check at_rest""",
    "timesync": """u64 timestamp
        u8 source_protocol
        u64 remote_timestamp
        i64 observed_offset estimated_offset
        u32 round_trip_time""",
    "ack": """u64 timestamp
        u32 command
        u8 result result_param1
        i32 result_param2
        u8 target_system
        u16 target_component
        bool from_external""",
    "command": """u64 timestamp
        f32 param1 param2 param3 param4
        f64 param5 param6
        f32 param7
        u32 command
        u8 target_system target_component source_system
        u16 source_component
        u8 confirmation
        bool from_external""",
    "mode": "u64 timestamp\nbool position velocity acceleration attitude body_rate thrust_and_torque direct_actuator",
    "setpoint": "u64 timestamp\nf32 position[3] velocity[3] acceleration[3] jerk[3] yaw yawspeed",
}

MESSAGES = {
    "vehicle_status": "VehicleStatus", "vehicle_local_position": "VehicleLocalPosition",
    "vehicle_land_detected": "VehicleLandDetected", "vehicle_command_ack": "VehicleCommandAck",
    "vehicle_attitude": "VehicleAttitude", "vehicle_global_position": "VehicleGlobalPosition",
    "battery_status": "BatteryStatus", "vehicle_gps_position": "SensorGps", "home_position": "HomePosition",
    "timesync_status": "TimesyncStatus", "vehicle_command": "VehicleCommand",
    "offboard_control_mode": "OffboardControlMode", "trajectory_setpoint": "TrajectorySetpoint",
}

# What PX4 reads, the same in all releases.
INCOMING = {"vehicle_command": "command", "offboard_control_mode": "mode", "trajectory_setpoint": "setpoint"}

COMMON = {"vehicle_attitude": ("attitude", 0), "timesync_status": ("timesync", 0)}
# What PX4 publishes as it ships: the shape and the version in the topic's name. 1.15 offers neither landing nor launch place.
RELEASES = {
    "1.15": COMMON | {
        "vehicle_status": ("status 1.15", 0), "vehicle_local_position": ("local 1.15", 0),
        "vehicle_command_ack": ("ack", 0), "vehicle_global_position": ("global 1.15", 0),
        "battery_status": ("battery 1.15", 0), "vehicle_gps_position": ("gps 1.15", 0),
    },
    "1.16": COMMON | {
        "vehicle_status": ("status v1", 1), "vehicle_local_position": ("local", 0), "vehicle_land_detected": ("landed", 0),
        "vehicle_command_ack": ("ack", 0), "vehicle_global_position": ("global", 0),
        "battery_status": ("battery 1.16", 0), "vehicle_gps_position": ("gps 1.15", 0), "home_position": ("home", 0),
    },
    "1.17": COMMON | {
        "vehicle_status": ("status v1", 1), "vehicle_local_position": ("local", 1), "vehicle_land_detected": ("landed", 0),
        "vehicle_command_ack": ("ack", 0), "vehicle_global_position": ("global", 0),
        "battery_status": ("battery v1", 1), "vehicle_gps_position": ("gps 1.17", 0), "home_position": ("home v1", 1),
    },
    "1.18": COMMON | {
        "vehicle_status": ("status v4", 4), "vehicle_local_position": ("local", 1), "vehicle_land_detected": ("landed", 0),
        "vehicle_command_ack": ("ack", 1), "vehicle_global_position": ("global", 0),
        "battery_status": ("battery v1", 1), "vehicle_gps_position": ("gps 1.18", 0), "home_position": ("home v1", 1),
    },
}
RELEASES["after 1.18"] = RELEASES["1.18"] | {"home_position": ("home v2", 2)}


def fields_of(shape):
    """Name, type and number of elements (0 for a plain field) of each field, in order."""
    for line in SHAPES[shape].strip().splitlines():
        kind, *names = line.split()
        for name in names:
            name, _, elements = name.rstrip("]").partition("[")
            yield name, KINDS[kind], int(elements or 0)


def type_name(message):
    return f"px4_msgs::msg::dds_::{message}_"


def struct(wire_name, fields):
    """A type of Cyclone DDS with this name on the wire."""
    made = python_types.new_class("Message", (IdlStruct,), {"typename": wire_name},
                                  lambda space: space.update(__annotations__=fields, __module__=__name__))
    return dataclass(made)


def message(shape, wire_name):
    annotations = {name: idl.array[kind, n] if n else kind for name, kind, n in fields_of(shape)}
    return struct(wire_name, annotations)


def octets(count, wire_name):
    """A type whose samples are any octets: for what a sound writer would never send."""
    return struct(wire_name, {"octets": idl.array[idl.uint8, count]})


def fill(kind, shape, values):
    """A sample with these values, the rest zero."""
    def zero(n, of):
        return [of()] * n if n else of()
    plain = {bool: bool, idl.float32: float, idl.float64: float}
    return kind(**{name: values.get(name, zero(n, plain.get(of, int))) for name, of, n in fields_of(shape)})
