"""Hostile inputs: the engine never panics, but gives a result or an ordinary exception."""

import pickle

import numpy as np
import ocmc
import pytest
from ocmc import _ocmc

pa = pytest.importorskip("pyarrow")

ORDINARY = (ValueError, TypeError, OSError, KeyError, OverflowError, AttributeError)


class Liar:
    """Says that it exports Arrow, and does not."""

    def __arrow_c_stream__(self, requested_schema=None):
        return "a stream"

    def __arrow_c_schema__(self):
        return 3


class Endless:
    def keys(self):
        return self

    def __getitem__(self, key):
        return self

    def __iter__(self):
        raise RuntimeError("no end")


VALUES = [
    None,
    True,
    0,
    -1,
    2**70,
    10**400,
    0.0,
    -0.0,
    1e308,
    5e-324,
    float("nan"),
    float("inf"),
    "",
    "\0",
    "\udc80",
    "x" * 100_000,
    b"\xff",
    [],
    {},
    (1e308, -1e308),
    (float("nan"),) * 2,
    np.array([]),
    np.zeros((2, 2)),
    object(),
    Liar(),
    Liar,
    len,
]

N = 12
TABLES = [
    {"driver": ["a"] * N, "radius_m": value, "speed_mps": speed}
    for value in [
        [1e308] * N,
        [5e-324] * N,
        [-1.0] * N,
        [0.0] * N,
        [np.nan] * N,
        list(range(N)),
        [100.0, np.inf] * 6,
    ]
    for speed in [[1e308] * N, [0.0] * N, [-5.0] * N, [np.inf] * N, [10.0] * N, [5e-324] * N]
]
LOGS = [
    {"time_s": time, "speed_mps": speed, "yaw_rate_radps": rate}
    for time in [
        [0.0] * N,
        [1e308, -1e308] * 6,
        np.arange(N),
        -np.arange(N),
        [5e-324] * N,
        [0, 1e300] * 6,
    ]
    for speed in [[1e308] * N, [np.nan] * N, [-1.0] * N, [10.0] * N]
    for rate in [[1e308] * N, [0.0] * N, [np.inf] * N, np.linspace(-9, 9, N)]
]
PEDALS = {"time_s": np.arange(40) / 2, "speed_mps": [20.0] * 40, "accelerator": [0.4] * 40} | {
    "brake": [0.0] * 40,
    "grade": [0.0] * 40,
}
WITH_PEDALS = {
    "accelerator": [0.5] * N,
    "brake": [0.0] * N,
    "grade": [0.01] * N,
    "event": ["x"] * N,
}
SPEEDS = [
    {"time_s": time, "speed_mps": speed, "grade": grade}
    for time in [[0.0] * N, [1e308, -1e308] * 6, np.arange(N), [5e-324] * N, np.arange(N) * 1e300]
    for speed in [[1e308] * N, [np.nan] * N, [-1.0] * N, [0.0] * N, [10.0] * N, [1e-300, 1e300] * 6]
    for grade in [[1e308] * N, [0.0] * N, [np.inf] * N, [-1.0] * N]
]


def tried(call, *arguments, **options):
    """Call it: a result or an ordinary exception will do, a panic (no Exception) will not."""
    try:
        return call(*arguments, **options)
    except ORDINARY:
        return None


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("value", VALUES, ids=lambda value: repr(value)[:20])
def test_hostile_arguments(study, run, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ["seed", "first_cycle", "threads", "progress"]:
        tried(study.run, cycles=1, **{name: value})
    if not (isinstance(value, int) and value > 1):
        tried(study.run, cycles=value)
    for call in [study.trace, study.operating_cycle, ocmc.Study, ocmc.load, ocmc.detect_curves]:
        tried(call, value)
    tried(study.trace, 1, seed=value)
    tried(study.set, "mission.length_m", value)
    tried(study.set, value, 1)
    tried(run.save, value)
    tried(run.save, tmp_path / "x", format=value)
    for table in [run, run.records, study.operating_cycle(0)]:
        tried(lambda table=table: table[value])
        tried(lambda table=table: value in table)
    tried(run.records.__arrow_c_stream__, value)
    tried(ocmc.fit_curve_speed, value)
    tried(_ocmc.unpickled, value, 1.0, 1, b"", b"")
    tried(_ocmc.unpickled, "{}", 1.0, 1, value, value)
    tried(_ocmc.unpickled_table, value, value)
    tried(_ocmc.joined, value, 1.0, 1)
    good = {"driver": ["a"] * 4, "radius_m": [50.0, 100, 200, 400], "speed_mps": [9.0, 14, 20, 27]}
    for name in [
        "base",
        "tobit",
        "reference_radius_m",
        "radius_range_m",
        "minimum_route_m",
        "isolated_m",
        "least_lateral_mps2",
        "fixed_exponent",
    ]:
        tried(ocmc.fit_curve_speed, good, **{name: value})
    for name in ["significance", "limit_share", "coding"]:
        tried(ocmc.fit_curve_speed, good, **{name: value})
    log = {"time_s": np.arange(20.0), "speed_mps": [10.0] * 20, "yaw_rate_radps": [0.1] * 20}
    for name in [
        "columns",
        "detector",
        "radius",
        "central_share",
        "split_ratio",
        "gyro_bias_radps",
    ]:
        tried(ocmc.detect_curves, log, **{name: value})
    for name in ["speed_lag_s", "steering_ratio", "wheelbase_m"]:
        tried(ocmc.detect_curves, log, **{name: value})


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("value", VALUES, ids=lambda value: repr(value)[:20])
def test_hostile_arguments_of_fits_and_drives(study, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for call in [
        ocmc.fit_speed_change,
        ocmc.fit_operating_cycle,
        ocmc.fit_weather,
        ocmc.fit_traffic,
        ocmc.fit_fleet,
    ]:
        tried(call, value)
        tried(call, [value, value])
    changes = {"acceleration_mps2": [0.5, -0.6]}
    for name in ["columns", "base", "untruncated", "window_s", "smallest_acceleration_mps2"]:
        tried(ocmc.fit_speed_change, changes, **{name: value})
    tried(ocmc.fit_operating_cycle, study.operating_cycle(0), base=value)
    records = {"truck": ["a", "a", "b", "b"], "consumption_l_per_100km": [30.0, 31.0, 33.0, 32.5]}
    for name in ["columns", "column", "weight", "own_drivers", "month", "differ", "power"]:
        tried(ocmc.fit_fleet, records, **{name: value})
    for name in ["next_trips", "best", "seed"]:
        tried(ocmc.fit_fleet, records, **{name: value})
    if not (isinstance(value, int) and value > 1):
        tried(ocmc.fit_fleet, records, draws=value)
    moving = {"time_s": np.arange(40.0), "speed_mps": [10.0] * 40}
    for name in ["columns", "radius_range_m", "road_type", "altitude_average_m", "mission_stop_s"]:
        tried(ocmc.fit_operating_cycle, moving, **{"road_type": "rural"} | {name: value})
    tried(ocmc.identify, value, study)
    tried(ocmc.identify, PEDALS, value)
    pedals = PEDALS | {"event": ["x"] * 40}
    for name in ["columns", "controller", "speed_term", "kp", "ki", "kd", "progress"]:
        tried(ocmc.identify, pedals, study, starts=1, intervals=False, **{name: value})
    if value is not True:
        tried(ocmc.identify, PEDALS, study, starts=value, intervals=value)
    for options in [
        {},
        {"follow_speed": "exact"},
        {"follow_speed": "driver"},
        {"follow_speed": value},
    ]:
        tried(study.drive, value, cycles=1, **options)
    tried(
        study.drive, {"time_s": [0.0, 9.0], "speed_mps": [0.0, 9.0]}, cycles=1, follow_speed=value
    )
    tried(study.drive, {"time_s": value, "speed_mps": value}, cycles=1, follow_speed="exact")


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_hostile_tables():
    for table in TABLES:
        tried(ocmc.fit_curve_speed, table)
        tried(ocmc.fit_curve_speed, table | {"speed_limit_mps": table["speed_mps"]}, tobit=True)
        tried(ocmc.fit_curve_speed, pa.table(table))
    for log in LOGS:
        for detector in ["hidden_markov", "trained", "threshold"]:
            tried(ocmc.detect_curves, log, detector=detector)
    for log in LOGS:
        tried(
            ocmc.identify, log | WITH_PEDALS, ocmc.Study("field-truck"), starts=1, intervals=False
        )
        tried(ocmc.fit_speed_change, log | {"limit_mps": log["speed_mps"]})
        tried(
            ocmc.fit_operating_cycle,
            log | {"limit_mps": log["speed_mps"], "altitude_m": log["speed_mps"]},
        )
        tried(ocmc.fit_operating_cycle, log | {"grade": log["speed_mps"]}, road_type="rural")
        tried(ocmc.fit_speed_change, {"acceleration_mps2": log["speed_mps"]})
    study = ocmc.Study("field-truck").set("mission.length_m", 2000)
    for speed in SPEEDS:
        for follow in ["exact", "driver"]:
            tried(study.drive, speed, cycles=1, threads=1, follow_speed=follow)
    odd = [
        pa.table({}),
        pa.table({"a": pa.array([], pa.null())}),
        pa.table([pa.array([[1]])], ["driver"]),
    ]
    odd += [
        pa.table({"driver": [None] * 3, "radius_m": [None] * 3, "speed_mps": [None] * 3}),
        pa.array([1.0]),
    ]
    odd += [
        pa.table([[1.0]] * 3, ["radius_m"] * 3),
        pa.table({"radius_m": pa.array([1], pa.timestamp("s"))}),
    ]
    for table in odd:
        for call in [
            ocmc.fit_curve_speed,
            ocmc.detect_curves,
            ocmc.fit_speed_change,
            ocmc.fit_weather,
            ocmc.fit_traffic,
            ocmc.fit_fleet,
        ]:
            tried(call, table)
    with pytest.raises(RuntimeError, match="no end"):
        ocmc.fit_curve_speed(Endless())


def test_broken_pickles(run):
    whole = pickle.dumps(run)
    for place in range(0, len(whole), max(1, len(whole) // 150)):
        broken = bytearray(whole)
        broken[place] ^= 0x55
        try:
            other = pickle.loads(bytes(broken))
        except Exception:  # noqa: BLE001, S112 (whatever pickle says, but no panic)
            continue
        if isinstance(other, ocmc.Run):
            same = all(
                (other[name] == run[name]).all() for name in ("cycle_id", "fuel_kg", "outcome")
            )
            assert same, "what is read back is what was written"
