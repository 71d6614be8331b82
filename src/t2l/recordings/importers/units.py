"""Units that other recorders use, as factors to SI and radians."""

import math

_RAD = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180}  # format: in rad
# format: in rad/s
_RAD_S = {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.pi / 180, "rpm": math.pi / 30}
_NM = {"N·m": 1.0, "N*m": 1.0, "Nm": 1.0, "mN·m": 1e-3, "mNm": 1e-3}  # format: in N·m

# format: by what a column of a recording holds
FACTORS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9},
    "q_des": _RAD,
    "dq_des": _RAD_S,
    "tau_ff": _NM,
    "tau_des": _NM,
    "duty": {"1": 1.0, "%": 0.01},
    "q": _RAD,
    "dq": _RAD_S,
    "current": {"A": 1.0, "mA": 1e-3},
    "supply_voltage": {"V": 1.0, "mV": 1e-3},
    "temperature": {"°C": 1.0, "C": 1.0},
    "torque_enabled": {"1": 1.0},
    "tau": _NM,
}
