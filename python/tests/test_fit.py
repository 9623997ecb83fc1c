"""Fits: tables of any library go in, the paper's tables come out, and what is wrong is said."""

import csv
import json
from pathlib import Path

import numpy as np
import ocmc
import pytest
from test_command import command, numbers

CURVES = Path(__file__).parents[2] / "examples" / "data" / "simulator_curves.csv"


@pytest.fixture(scope="module")
def curves():
    """Curves whose regression equals the paper's simulator tables, as a dictionary of columns."""
    with CURVES.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    words = {name: [row[name] for row in rows] for name in ("driver", "direction")}
    return words | {name: [float(row[name]) for row in rows] for name in ("radius_m", "speed_mps")}


@pytest.fixture(scope="module")
def fit(curves):
    return ocmc.fit_curve_speed(curves)


def test_the_paper_s_simulator_tables(fit):
    f = {row["term"]: row["f"] for row in fit["anova"] if row["f"] is not None}
    # the data were made of the printed mean squares, which have four digits, for the direction
    # three
    assert (f["radius"], f["driver"]) == pytest.approx((87.6916, 65.7463), rel=2e-4)
    assert f["direction"] == pytest.approx(0.0882, rel=3e-3)
    estimated, fixed = fit["estimated"], fit["fixed"]
    assert round(estimated["exponent"], 2) == 0.23
    assert [round(end, 2) for end in estimated["exponent_ci95"]] == [0.18, 0.28]
    assert round(3.6 * estimated["reference_speed_mps"]) == 60
    assert (round(100 * estimated["driver_sd"]), round(100 * estimated["residual_sd"], 1)) == (
        16,
        4.8,
    )
    assert (fixed["exponent"], round(3.6 * fixed["reference_speed_mps"])) == (0.5, 66)
    assert round(100 * fixed["residual_sd"], 1) == 9.6


def test_the_answer_is_the_command_s(fit):
    printed = json.loads(command("fit", "curve-speed", CURVES, "--json").stdout)
    assert printed == ocmc.fit_curve_speed(CURVES)
    assert numbers(printed) == numbers(fit)
    assert command("fit", "curve-speed", CURVES).stdout == str(fit)


def tables(curves):
    yield "a file", CURVES
    yield "its name", str(CURVES)
    yield "arrays", {name: np.array(column) for name, column in curves.items()}
    for library, make in [("pyarrow", "table"), ("polars", "DataFrame"), ("pandas", "DataFrame")]:
        yield library, getattr(pytest.importorskip(library), make)(curves)
    pyarrow = pytest.importorskip("pyarrow")
    table = pyarrow.table(curves)
    yield "batch", table.to_batches()[0]
    yield "stream", table.to_reader(max_chunksize=7)
    coded = table.set_column(0, "driver", table["driver"].dictionary_encode())
    yield "coded", coded.set_column(2, "radius_m", table["radius_m"].cast(pyarrow.int32()))
    duckdb = pytest.importorskip("duckdb")
    made = [f"('{d}', '{t}', {r}, {v})" for d, t, r, v in zip(*curves.values(), strict=True)]
    query = f"SELECT * FROM (VALUES {','.join(made)}) t({','.join(curves)})"  # noqa: S608
    yield "duckdb", duckdb.sql(query)


def test_tables_of_any_library_give_the_same(curves, fit):
    for name, table in tables(curves):
        assert numbers(ocmc.fit_curve_speed(table)) == numbers(fit), name


def test_the_fit_makes_a_study(fit):
    study = ocmc.Study({"study": {"base": "simulator-truck"}} | fit["study"])
    law = study.to_dict()["driver"]["curve_speed"]
    assert law["exponent"] == pytest.approx(fit["estimated"]["exponent"], rel=1e-5)
    assert len(study.set("mission.length_m", 2000).run(cycles=10)) == 10


def test_options_and_the_base(curves, fit):
    with pytest.warns(
        UserWarning, match="reference radius of 250 m lies outside|table.exponent"
    ) as warned:
        narrow = ocmc.fit_curve_speed(curves, radius_range_m=(100.0, 200.0), fixed_exponent=0.4)
    warned = " ".join(str(warning.message) for warning in warned)
    assert "reference radius of 250 m lies outside" in warned
    # two radii tell one driver an exponent below 0, which no study takes
    assert "`driver.curve_speed.table.exponent` is -0.0" in warned
    assert "table" not in narrow["study"]["driver"]["curve_speed"]
    assert narrow["n"] == 32
    assert narrow["dropped"] == {"radius_too_large": 16}
    assert narrow["fixed"]["exponent"] == 0.4
    base = ocmc.Study("field-truck").set("driver.curve_speed.guard_lateral_mps2", 2.5)
    kept = ocmc.fit_curve_speed(curves, base=base)["study"]["driver"]["curve_speed"]
    assert kept["guard_lateral_mps2"] == 2.5
    assert fit["study"]["driver"]["curve_speed"]["exponent"] == kept["exponent"]


@pytest.mark.parametrize(
    ("change", "options", "error", "part"),
    [
        ({"speed_mps": None}, {}, ValueError, "no column for the speed: name it `speed_mps`"),
        ({"direction": ["up"] * 48}, {}, ValueError, "`up`; allowed is `left` or `right`"),
        ({"radius_m": [100.0] * 48}, {}, ValueError, "same radius"),
        ({"radius_m": [1e6] * 48}, {}, ValueError, "no curve is left of 48 rows"),
        ({"radius_m": ["wide"] * 48}, {}, ValueError, "`wide`; allowed is a number"),
        ({"radius_m": [1.0]}, {}, ValueError, "column `radius_m` has 1 rows"),
        ({"radius_m": [[1.0]] * 48}, {}, ValueError, "column `radius_m` is "),
        ({"radius_m": 7.0}, {}, ValueError, "column `radius_m` is 7.0"),
        ({}, {"coding": "dummy"}, ValueError, "allowed is one of: sum_to_zero, treatment"),
        ({}, {"reference_radius_m": -1.0}, ValueError, "reference radius is -1"),
        ({}, {"tobit": True}, ValueError, "needs a column limit_mps"),
        ({}, {"fixed_exponent": float("nan")}, ValueError, "fixed exponent"),
        ({}, {"base": "field-truck"}, TypeError, "base"),
        ({3: [1.0] * 48}, {}, TypeError, "allowed is a text"),
    ],
)
def test_what_is_wrong_is_said(curves, change, options, error, part):
    table = {name: column for name, column in (curves | change).items() if column is not None}
    with pytest.raises(error, match=part):
        ocmc.fit_curve_speed(table, **options)


@pytest.mark.parametrize("table", [3, None, [1, 2], object()])
def test_what_is_no_table_is_a_type_error(table):
    with pytest.raises(TypeError, match=r"`curves` is .*, allowed is a path, a table"):
        ocmc.fit_curve_speed(table)
    with pytest.raises(TypeError, match=r"`log` is .*, allowed is a path, a table"):
        ocmc.detect_curves(table)


def test_files_that_cannot_be_read_are_os_errors(tmp_path):
    for read in [ocmc.fit_curve_speed, ocmc.detect_curves]:
        with pytest.raises(FileNotFoundError, match=r"absent\.csv"):
            read(tmp_path / "absent.csv")
        (tmp_path / "empty.csv").write_text("")
        with pytest.raises(ValueError, match=r"empty\.csv"):
            read(tmp_path / "empty.csv")
    with pytest.raises(ValueError, match=r"empty|no column"):
        ocmc.fit_curve_speed({})


@pytest.fixture(scope="module")
def log():
    """Two drives at 10 m/s on straights, with a left curve of 100 m and a right one of 50 m."""
    time = np.arange(0.0, 80.0, 0.1)
    rate = np.where((time > 20) & (time < 30), 0.1, 0.0) - np.where(
        (time > 50) & (time < 56), 0.2, 0.0
    )
    return {
        "driver": ["x"] * time.size + ["y"] * time.size,
        "drive": ["1"] * time.size + ["2"] * time.size,
        "time_s": np.tile(time, 2),
        "v": np.full(2 * time.size, 36.0),
        "gyro": np.tile(-rate, 2),
    }


MEANING = {"speed_kmh": "v", "yaw_rate_radps": "-gyro"}


def test_curves_of_a_log(log, tmp_path):
    curves = ocmc.detect_curves(log, columns=MEANING, gyro_bias_radps=0.0)
    assert curves["driver"].tolist() == ["x", "x", "y", "y"]
    assert curves["direction"].tolist() == ["left", "right"] * 2
    np.testing.assert_allclose(curves["radius_m"], [100, 50] * 2, rtol=1e-6)
    np.testing.assert_allclose(curves["speed_mps"], 10.0, rtol=1e-9)
    assert np.isnan(curves["limit_mps"]).all()

    pyarrow = pytest.importorskip("pyarrow")
    other = ocmc.detect_curves(pyarrow.table(log), columns=MEANING, gyro_bias_radps=0.0)
    assert pyarrow.table(other).equals(pyarrow.table(curves))
    path = tmp_path / "log.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(log)
        rows.writerows(zip(*log.values(), strict=True))
    maps = [f"--map={name}={column}" for name, column in MEANING.items()]
    answered = command("curves", path, *maps, "--gyro-bias-radps=0", "--quiet").stdout
    lines = list(csv.DictReader(answered.splitlines()))
    assert list(lines[0]) == curves.columns
    for name in ["radius_m", "start_m", "turn_rad"]:
        assert [float(line[name]) for line in lines] == curves[name].tolist()


def test_detectors_and_radii(log):
    for options in [{"detector": "threshold"}, {"detector": "trained"}, {"radius": "mean"}]:
        curves = ocmc.detect_curves(log, columns=MEANING, gyro_bias_radps=0.0, **options)
        np.testing.assert_allclose(curves["radius_m"], [100, 50] * 2, rtol=0.01)


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({}, "no column for the speed"),
        ({"columns": {"sped_mps": "v"}}, "did you mean"),
        ({"columns": MEANING | {"speed_kmh": "w"}}, "there is no column `w`"),
        (
            {"columns": MEANING, "detector": "eye"},
            "allowed is one of: hidden_markov, trained, threshold",
        ),
        ({"columns": MEANING, "radius": "wide"}, "allowed is one of: turn, mean, positions"),
        ({"columns": MEANING, "radius": "positions"}, "latitude"),
        (
            {"columns": MEANING, "steering_ratio": 0.0, "wheelbase_m": 3.0},
            "is 0: allowed is 1 to 100",
        ),
        (
            {"columns": MEANING, "steering_ratio": 15.0, "wheelbase_m": np.nan},
            "allowed is 0.5 to 20",
        ),
        ({"columns": MEANING, "central_share": 2.0}, "central"),
        ({"columns": MEANING, "wheelbase_m": 3.6}, "belong together"),
    ],
)
def test_what_is_wrong_with_a_log_is_said(log, options, part):
    with pytest.raises(ValueError, match=part):
        ocmc.detect_curves(log, **options)


def test_a_drive_that_is_left_out_is_a_warning(log):
    broken = dict(log)
    broken["time_s"] = np.where(np.array(log["drive"]) == "2", np.nan, log["time_s"])
    with pytest.warns(UserWarning, match="drive `2` of `log` is left out"):
        curves = ocmc.detect_curves(broken, columns=MEANING, gyro_bias_radps=0.0)
    assert set(curves["drive"]) == {"1"}
