"""Data frames as users of pandas and polars expect them: out of runs, and into drives and fits."""

import datetime as dt
import subprocess
import sys
import zoneinfo

import numpy as np
import ocmc
import pytest
from test_drive import SPEED, same

ROUTE = {
    "position_m": np.arange(0.0, 3001.0, 100.0),
    "speed_limit_kmh": np.repeat([50.0, 80.0, 50.0], [8, 15, 8]),
    "altitude_m": 10.0 + np.sin(np.arange(31) / 5.0),
    "curvature_per_m": np.zeros(31),
    "stop_s": np.where(np.arange(31) == 12, 12.0, np.nan),
    "road_type": ["urban"] * 8 + ["rural"] * 15 + ["urban"] * 8,
}
LIBRARIES = [("pandas", "DataFrame"), ("polars", "DataFrame"), ("pyarrow", "table")]


def frames(columns):
    for library, make in LIBRARIES:
        yield getattr(pytest.importorskip(library), make)(columns)


def test_pandas_takes_a_run_as_rows_with_all_columns(run):
    pandas = pytest.importorskip("pandas")
    for frame in [pandas.DataFrame(run), pandas.DataFrame(run.records), run.to_pandas()]:
        assert frame.shape == (len(run), len(run.columns))
        assert list(frame) == run.columns
        for name in run.columns:
            if run[name].dtype.kind == "U":
                assert frame[name].fillna("").tolist() == run[name].tolist()
            else:
                np.testing.assert_array_equal(
                    frame[name].to_numpy(np.float64, na_value=np.nan), run[name]
                )
    some = pandas.DataFrame(run, columns=["fuel_kg", "outcome"])
    assert some["fuel_kg"].tolist() == run["fuel_kg"].tolist()


def test_words_that_are_missing_are_missing_in_a_frame(study):
    pandas = pytest.importorskip("pandas")
    table = study.operating_cycle(3).to_table()
    for frame in [
        pandas.DataFrame(table),
        pandas.DataFrame(study.operating_cycle(3)),
        table.to_pandas(),
    ]:
        assert frame["name"].isna().tolist() == (table["name"] == "").tolist()
        assert 0 < frame["name"].isna().sum() < len(table)


def test_polars_arrow_and_duckdb_take_a_run_itself(run):
    polars = pytest.importorskip("polars")
    for frame in [polars.DataFrame(run), run.to_polars(), run.records.to_polars()]:
        assert frame.columns == run.columns
        assert frame["battery_energy_j"].null_count() == len(run)
        assert frame["fuel_kg"].to_list() == run["fuel_kg"].tolist()
    pa = pytest.importorskip("pyarrow")
    assert pa.table(run).equals(pa.table(run.records))
    duckdb = pytest.importorskip("duckdb")
    assert duckdb.sql("SELECT count(*), sum(cycle_id) FROM run").fetchall() == [
        (len(run), run["cycle_id"].sum())
    ]


def test_numpy_takes_rows(run):
    rows = np.asarray(run)
    assert rows.shape == (len(run),)
    assert rows[7].cycle_id == run["cycle_id"][7]
    with pytest.raises(ValueError, match="take a column"):
        np.asarray(run, dtype=float)
    with pytest.raises(ValueError, match="a copy"):
        np.array(run, copy=False)


def test_without_the_library_it_is_named():
    script = """
import sys
sys.modules["pandas"] = sys.modules["polars"] = None
import ocmc
run = ocmc.Study("field-truck").set("mission.length_m", 2000.0).run(cycles=5, progress=False)
for made in [run.to_pandas, run.records.to_pandas, run.to_polars, run.records.to_polars]:
    try:
        made()
    except ModuleNotFoundError as error:
        print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    [pandas, polars] = [
        f"to_{name} needs {name}: pip install {name}" for name in ["pandas", "polars"]
    ]
    assert done.stdout.splitlines() == [pandas, pandas, polars, polars]


def test_pandas_alone_is_enough(monkeypatch, run):
    pytest.importorskip("pandas")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    frame = run.to_pandas()
    assert frame.shape == (len(run), len(run.columns))
    assert frame["fuel_kg"].tolist() == run["fuel_kg"].tolist()


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """The route as a file."""
    path = tmp_path_factory.mktemp("route") / "route.csv"
    cells = [
        ["" if str(cell) == "nan" else str(cell) for cell in column] for column in ROUTE.values()
    ]
    path.write_text("\n".join(map(",".join, [list(ROUTE), *zip(*cells, strict=True)])))
    return ocmc.Study("field-truck").drive(path, cycles=20, seed=3)


def test_a_table_is_a_route_like_its_file(driven, tmp_path):
    study = ocmc.Study("field-truck")
    run = study.drive(ROUTE, cycles=20, seed=3)
    same(run, driven)
    for frame in frames(ROUTE):
        same(study.drive(frame, cycles=20, seed=3), driven)
    assert run.summary()["study"] == "field-truck on files"
    [told] = run.routes
    assert told["length_m"] == 3000.0
    # the study holds the route: it can be driven again, and read back anywhere
    same(run.study.run(cycles=20, seed=3), driven)
    run.save(tmp_path / "run")
    loaded = ocmc.load(tmp_path / "run")
    same(loaded, driven)
    same(loaded.study.run(cycles=20, seed=3), driven)


def test_what_a_route_lacks_and_its_columns_are_said_of_tables_too():
    study = ocmc.Study("field-truck")
    renamed = {"km": [0.0, 1.0, 3.0], "vmax": [50.0, 80.0, 80.0]}
    columns, parts = {"position_km": "km", "speed_limit_kmh": "vmax"}, ["stops", "hills", "curves"]
    run = study.drive(renamed, cycles=3, columns=columns, draw=parts)
    np.testing.assert_allclose(run["distance_m"], 3000.0, rtol=1e-3)
    drawn = study.drive({"position_m": [0.0, 3000.0]}, cycles=3, draw=["limits", *parts])
    np.testing.assert_allclose(drawn["distance_m"], 3000.0, rtol=1e-3)
    planned = study.drive(ROUTE, cycles=3, follow_speed="exact")
    np.testing.assert_allclose(planned["distance_m"], 3000.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("route", "options", "wanted"),
    [
        (ROUTE | {"colour": ["red"] * 31}, {}, "unknown column `colour`"),
        (ROUTE | {"position_m": [0.0, 100.0, *range(31, 60)]}, {}, "row 3: position 31 m"),
        ({"position_m": [0.0, 1.0]}, {}, "(?s)no column for the .*limit.*in Python draw"),
        (ROUTE, {"follow_speed": "driver"}, "`driver` takes a drive cycle over time"),
        (SPEED, {}, "in Python follow_speed"),
    ],
)
def test_what_is_wrong_with_a_route_in_a_table_is_said(route, options, wanted):
    with pytest.raises(ValueError, match=wanted):
        ocmc.Study("field-truck").drive(route, cycles=1, **options)


BEGIN = dt.datetime(2024, 3, 31, 1, 58, tzinfo=zoneinfo.ZoneInfo("Europe/Berlin"))


@pytest.mark.parametrize("zone", [None, "UTC", "Europe/Berlin"])
def test_columns_of_dates_are_times(zone):
    """Seconds since the first row, over the change to summer time, by each library's dates."""
    truck = ocmc.Study("field-truck-loaded")
    wanted = truck.drive(SPEED, cycles=3, follow_speed="exact")
    at = [BEGIN.astimezone(dt.UTC) + dt.timedelta(seconds=second) for second in SPEED["time_s"]]
    place = zoneinfo.ZoneInfo(zone) if zone else None
    at = [time.astimezone(place) if place else time.replace(tzinfo=None) for time in at]
    rest = {name: column for name, column in SPEED.items() if name != "time_s"}
    pandas, polars, pa = (pytest.importorskip(name) for name in ["pandas", "polars", "pyarrow"])
    columns = [
        at,
        pandas.Series(at),
        polars.Series(at),
        pa.array(at),
        pandas.Series(at, dtype=object),
    ]
    if zone is None:
        columns += [np.array(at, dtype=f"datetime64[{unit}]") for unit in ["s", "ms", "us", "ns"]]
    for time in columns:
        same(truck.drive({"time": time} | rest, cycles=3, follow_speed="exact"), wanted)
    for frame in frames({"time": at} | rest):
        same(truck.drive(frame, cycles=3, follow_speed="exact"), wanted)


def test_a_date_that_is_missing_is_no_time():
    time = np.array(["2024-03-01T08:00:00", "NaT", "2024-03-01T08:01:00"], dtype="datetime64[ns]")
    with pytest.raises(ValueError, match=r"row 2, column `time`"):
        ocmc.Study("field-truck").drive(
            {"time": time, "speed_mps": [0.0, 5.0, 0.0]}, cycles=1, follow_speed="exact"
        )
