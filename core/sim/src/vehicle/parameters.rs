//! Parameters, as PX4 keeps them: sorted by name, 32-bit integers or floats, and on the wire always the bytes of the
//! value in a field declared as float.

use crate::airframe::Airframe;
use crate::parameter_value::ParameterValue;

/// One parameter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameter {
    /// Name, at most 16 characters.
    pub name: String,
    /// Value.
    pub value: ParameterValue,
}

/// All parameters of one vehicle, sorted by name.
#[derive(Debug, Clone)]
pub(crate) struct Parameters {
    list: Vec<Parameter>,
}

impl Parameters {
    pub(crate) fn new(system_id: u8, airframe: Airframe, changes: &[(String, ParameterValue)]) -> Self {
        let mut list: Vec<Parameter> = DEFAULTS
            .iter()
            .map(|(name, value)| Parameter {
                name: (*name).to_owned(),
                value: *value,
            })
            .collect();
        list.push(Parameter {
            name: "MAV_SYS_ID".to_owned(),
            value: ParameterValue::Int(i32::from(system_id)),
        });
        let of_airframe = airframe.parameters();
        let changes = changes.iter().map(|(name, value)| (name.as_str(), *value));
        for (name, value) in of_airframe.into_iter().chain(changes) {
            match list.iter_mut().find(|p| p.name == name) {
                Some(parameter) => parameter.value = value,
                None => list.push(Parameter {
                    name: name.chars().take(16).collect(),
                    value,
                }),
            }
        }
        list.sort_by(|a, b| a.name.cmp(&b.name));
        Self { list }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.list.len()
    }

    /// The one at an index.
    pub(crate) fn at(&self, index: usize) -> Option<&Parameter> {
        self.list.get(index)
    }

    /// Where a name stands.
    pub(crate) fn index(&self, name: &str) -> Option<usize> {
        self.list.binary_search_by(|p| p.name.as_str().cmp(name)).ok()
    }

    /// The number of a parameter; 0 if there is none of that name.
    pub(crate) fn number(&self, name: &str) -> f64 {
        self.index(name)
            .and_then(|i| self.at(i))
            .map_or(0.0, |p| p.value.number())
    }

    /// Sets a value.
    pub(crate) fn set(&mut self, index: usize, value: ParameterValue) {
        if let Some(parameter) = self.list.get_mut(index) {
            parameter.value = value;
        }
    }

    /// Those that PX4 tells of by itself soon after its start: calibration and identity.
    pub(crate) fn announced(&self) -> impl Iterator<Item = usize> + '_ {
        let told = |name: &str| name.starts_with("CAL_") || matches!(name, "MAV_SYS_ID" | "SYS_AUTOSTART");
        self.list
            .iter()
            .enumerate()
            .filter(move |(_, p)| told(&p.name))
            .map(|(i, _)| i)
    }

    /// A number that changes with any value, by which a ground station knows whether its copy is still good.
    pub(crate) fn hash(&self) -> u32 {
        // FNV-1a over names and values.
        let mut hash = 0x811c_9dc5_u32;
        let mut eat = |byte: u8| hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        for parameter in &self.list {
            parameter.name.bytes().for_each(&mut eat);
            parameter
                .value
                .on_wire()
                .to_bits()
                .to_le_bytes()
                .into_iter()
                .for_each(&mut eat);
        }
        hash
    }
}

use ParameterValue::{Int, Real};

/// The parameters this vehicle has, with PX4's default values. Some do what they do there (speeds, losses, batteries); the others are kept
/// and nothing else.
const DEFAULTS: &[(&str, ParameterValue)] = &[
    ("BAT1_CAPACITY", Real(5000.0)),
    ("BAT1_N_CELLS", Int(4)),
    ("BAT_CRIT_THR", Real(0.07)),
    ("BAT_EMERGEN_THR", Real(0.05)),
    ("BAT_LOW_THR", Real(0.15)),
    ("CAL_ACC0_ID", Int(1_310_988)),
    ("CAL_GYRO0_ID", Int(1_310_988)),
    ("CAL_MAG0_ID", Int(197_388)),
    ("CBRK_SUPPLY_CHK", Int(0)),
    ("COM_ARM_WO_GPS", Int(1)),
    ("COM_CPU_MAX", Real(95.0)),
    ("COM_DISARM_LAND", Real(2.0)),
    ("COM_DISARM_PRFLT", Real(10.0)),
    ("COM_DL_LOSS_T", Int(10)),
    ("COM_FLTMODE1", Int(-1)),
    ("COM_FLTMODE2", Int(-1)),
    ("COM_FLTMODE3", Int(-1)),
    ("COM_KILL_DISARM", Real(5.0)),
    ("COM_LOW_BAT_ACT", Int(0)),
    ("COM_OBL_RC_ACT", Int(0)),
    ("COM_OF_LOSS_T", Real(1.0)),
    ("COM_RCL_EXCEPT", Int(0)),
    ("COM_RC_IN_MODE", Int(4)),
    ("COM_RC_LOSS_T", Real(0.5)),
    ("COM_RC_OVERRIDE", Int(1)),
    ("COM_SPOOLUP_TIME", Real(1.0)),
    ("COM_TAKEOFF_ACT", Int(0)),
    ("EKF2_BARO_NOISE", Real(3.5)),
    // Not PX4's default: without the estimation of the drag a multicopter knows of no wind.
    ("EKF2_DRAG_CTRL", Int(1)),
    ("EKF2_GPS_CHECK", Int(245)),
    ("EKF2_GPS_DELAY", Real(110.0)),
    ("EKF2_HGT_REF", Int(1)),
    ("EKF2_MAG_TYPE", Int(0)),
    ("GF_ACTION", Int(2)),
    ("GF_MAX_HOR_DIST", Real(0.0)),
    ("GF_MAX_VER_DIST", Real(0.0)),
    ("GF_SOURCE", Int(0)),
    ("IMU_GYRO_CUTOFF", Real(40.0)),
    ("IMU_GYRO_RATEMAX", Int(400)),
    ("LNDMC_XY_VEL_MAX", Real(1.5)),
    ("LNDMC_Z_VEL_MAX", Real(0.25)),
    ("MAV_0_CONFIG", Int(101)),
    ("MAV_0_RATE", Int(1_200)),
    ("MAV_COMP_ID", Int(1)),
    ("MAV_TYPE", Int(2)),
    ("MC_AIRMODE", Int(0)),
    ("MC_PITCHRATE_D", Real(0.003)),
    ("MC_PITCHRATE_I", Real(0.2)),
    ("MC_PITCHRATE_P", Real(0.15)),
    ("MC_PITCH_P", Real(6.5)),
    ("MC_ROLLRATE_D", Real(0.003)),
    ("MC_ROLLRATE_I", Real(0.2)),
    ("MC_ROLLRATE_P", Real(0.15)),
    ("MC_ROLL_P", Real(6.5)),
    ("MC_YAWRATE_I", Real(0.1)),
    ("MC_YAWRATE_P", Real(0.2)),
    ("MC_YAW_P", Real(2.8)),
    ("MIS_TAKEOFF_ALT", Real(2.5)),
    ("MPC_ACC_HOR", Real(3.0)),
    ("MPC_ACC_HOR_MAX", Real(5.0)),
    ("MPC_JERK_AUTO", Real(4.0)),
    ("MPC_LAND_ALT1", Real(10.0)),
    ("MPC_LAND_ALT2", Real(5.0)),
    ("MPC_LAND_CRWL", Real(0.3)),
    ("MPC_LAND_SPEED", Real(0.7)),
    ("MPC_POS_MODE", Int(4)),
    ("MPC_THR_HOVER", Real(0.5)),
    ("MPC_THR_MAX", Real(1.0)),
    ("MPC_THR_MIN", Real(0.12)),
    ("MPC_TILTMAX_AIR", Real(45.0)),
    ("MPC_TKO_RAMP_T", Real(3.0)),
    ("MPC_TKO_SPEED", Real(1.5)),
    ("MPC_VEL_MANUAL", Real(10.0)),
    ("MPC_XY_CRUISE", Real(5.0)),
    ("MPC_XY_P", Real(0.95)),
    ("MPC_XY_VEL_MAX", Real(12.0)),
    ("MPC_XY_VEL_P_ACC", Real(1.8)),
    ("MPC_YAWRAUTO_MAX", Real(60.0)),
    ("MPC_Z_P", Real(1.0)),
    ("MPC_Z_VEL_MAX_DN", Real(1.5)),
    ("MPC_Z_VEL_MAX_UP", Real(3.0)),
    ("MPC_Z_VEL_P_ACC", Real(4.0)),
    ("MPC_Z_V_AUTO_DN", Real(1.5)),
    ("MPC_Z_V_AUTO_UP", Real(3.0)),
    ("NAV_ACC_RAD", Real(2.0)),
    ("NAV_DLL_ACT", Int(0)),
    ("NAV_MC_ALT_RAD", Real(0.8)),
    ("NAV_RCL_ACT", Int(2)),
    ("RC_MAP_PITCH", Int(2)),
    ("RC_MAP_ROLL", Int(1)),
    ("RC_MAP_THROTTLE", Int(3)),
    ("RC_MAP_YAW", Int(4)),
    ("RTL_DESCEND_ALT", Real(30.0)),
    ("RTL_LAND_DELAY", Real(0.0)),
    ("RTL_RETURN_ALT", Real(30.0)),
    ("SDLOG_MODE", Int(0)),
    ("SDLOG_PROFILE", Int(1)),
    ("SENS_BOARD_ROT", Int(0)),
    ("SYS_AUTOSTART", Int(10_040)),
    ("SYS_HAS_GPS", Int(1)),
    ("SYS_HAS_MAG", Int(1)),
    ("SYS_HITL", Int(0)),
];
