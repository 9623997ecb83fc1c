"""Fits of speed changes and operating cycles: the command's answers, for any form of data."""

import csv
import json

import numpy as np
import ocmc
import pytest
from test_command import command, numbers


def write(path, columns):
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))
    return path


@pytest.fixture(scope="module")
def changes():
    """Accelerations and decelerations of four drivers."""
    draw = np.random.default_rng(1)
    up, down = 0.6 * np.exp(0.3 * draw.normal(size=40)), -0.8 * np.exp(0.3 * draw.normal(size=40))
    return {
        "driver": [f"driver {k % 4}" for k in range(80)],
        "category": ["40-to-70"] * 40 + ["70-to-40"] * 40,
        "acceleration_mps2": np.concatenate([up, down]).tolist(),
    }


@pytest.mark.filterwarnings("ignore:the REML fit")  # their drivers do not differ
def test_speed_changes_of_a_table(changes, tmp_path):
    fit = ocmc.fit_speed_change(changes)
    for law, rows, threshold in [
        ("acceleration", slice(40), 0.2),
        ("deceleration", slice(40, 80), 0.4),
    ]:
        size = np.abs(changes["acceleration_mps2"][rows])
        counted = np.log(size[size > threshold])
        assert fit[law]["n"] == counted.size
        assert abs(fit[law]["median_mps2"]) == pytest.approx(np.exp(counted.mean()), rel=1e-9)
        assert fit[law]["log_sd"] == pytest.approx(counted.std(ddof=1), rel=1e-9)
    path = write(tmp_path / "changes.csv", changes)
    assert numbers(json.loads(command("fit", "speed-change", path, "--json").stdout)) == numbers(
        fit
    )
    assert command("fit", "speed-change", path).stdout == str(fit)
    assert numbers(ocmc.fit_speed_change(path)) == numbers(fit)
    assert (fit["inputs"][0]["rows"], fit["inputs"][0]["left_out"]) == (80, [])


@pytest.mark.filterwarnings("ignore:the REML fit")  # their drivers do not differ
def test_speed_changes_of_any_library(changes):
    fit = ocmc.fit_speed_change(changes)
    for library, make in [("pyarrow", "table"), ("polars", "DataFrame"), ("pandas", "DataFrame")]:
        given = getattr(pytest.importorskip(library), make)(changes)
        assert numbers(ocmc.fit_speed_change(given)) == numbers(fit), library
    halves = [{name: list(column[k::2]) for name, column in changes.items()} for k in (0, 1)]
    both = ocmc.fit_speed_change(halves)
    assert both["n"] == fit["n"]
    assert both["acceleration"]["median_mps2"] == pytest.approx(
        fit["acceleration"]["median_mps2"], rel=1e-12
    )


@pytest.mark.filterwarnings("ignore:.*rows? with the time of the row before")  # steps of no length
@pytest.mark.filterwarnings("ignore:there is one driver only")  # one of the logs has all changes
def test_speed_changes_of_logs(study, tmp_path):
    study = study.set("mission.length_m", 25_000)
    traces = [study.trace(k) for k in range(3)]
    fit = ocmc.fit_speed_change(traces)
    assert fit["n"] > 5
    paths = [write(tmp_path / f"log-{k}.csv", trace.to_dict()) for k, trace in enumerate(traces)]
    assert numbers(ocmc.fit_speed_change(paths)) == numbers(fit)
    assert numbers(json.loads(command("fit", "speed-change", *paths, "--json").stdout)) == numbers(
        fit
    )
    time_s = traces[0].to_dict()["time_s"]
    assert fit["inputs"][0]["extent"]["duration_s"] == pytest.approx(time_s[-1] - time_s[0])
    # a mean over less time
    sharp = ocmc.fit_speed_change(traces, window_s=1.0)
    assert sharp["deceleration"]["median_mps2"] < fit["deceleration"]["median_mps2"]
    kmh = [{"t": t["time_s"], "v": 3.6 * t["speed_mps"], "l": 3.6 * t["limit_mps"]} for t in traces]
    renamed = ocmc.fit_speed_change(
        kmh, columns={"time_s": "t", "speed_kmh": "v", "limit_kmh": "l"}
    )
    assert (renamed["n"], renamed["dropped"]) == (fit["n"], fit["dropped"])


@pytest.mark.filterwarnings("ignore:the REML fit")  # their drivers do not differ
def test_speed_changes_make_a_study(changes):
    base = ocmc.Study("field-truck").set("driver.speed_change.rise", "paper")
    only_up = {name: column[:40] for name, column in changes.items()}
    with pytest.warns(UserWarning, match="no deceleration was measured"):
        fit = ocmc.fit_speed_change(only_up, base=base)
    law = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"]).to_dict()["driver"][
        "speed_change"
    ]
    assert law["rise"] == "paper"
    # drivers who do not differ have one number, not a law
    assert law["acceleration_mps2"] == pytest.approx(fit["acceleration"]["median_mps2"], rel=1e-6)
    assert law["deceleration_mps2"] == base.to_dict()["driver"]["speed_change"]["deceleration_mps2"]


@pytest.mark.parametrize(
    ("table", "options", "error", "part"),
    [
        (
            {"acceleration_mps2": [0.01, -0.01]},
            {},
            ValueError,
            "`table`: no speed change is left of 2",
        ),
        (
            {"acceleration_mps2": ["fast"]},
            {},
            ValueError,
            "`table`, row 1, .*`fast`; allowed is a number",
        ),
        ({"acceleration": [1.0]}, {}, ValueError, "neither a table of speed changes"),
        ({"acceleration_mps2": [1.0]}, {"window_s": -1.0}, ValueError, "window"),
        ({"acceleration_mps2": [1.0]}, {"columns": {"sped_mps": "v"}}, ValueError, "did you mean"),
        ({"acceleration_mps2": [1.0]}, {"base": "field-truck"}, TypeError, "base"),
        ([], {}, ValueError, "`table` is empty"),
        ([3], {}, TypeError, r"`table\[0\]` is 3, allowed is a path"),
        ("absent.csv", {}, FileNotFoundError, r"absent\.csv"),
    ],
)
def test_what_is_wrong_with_speed_changes_is_said(table, options, error, part):
    with pytest.raises(error, match=part):
        ocmc.fit_speed_change(table, **options)


@pytest.fixture(scope="module")
def roads():
    study = ocmc.Study("field-truck").set("mission.length_m", 30_000)
    return [study.operating_cycle(k) for k in range(12)]


@pytest.mark.filterwarnings("ignore::UserWarning")  # few roads do not tell everything
def test_roads_are_fitted_as_by_the_command(roads, tmp_path):
    fit = ocmc.fit_operating_cycle(roads)
    assert (fit["cycles"], fit["length_m"]) == (12, 12 * 30_000.0)
    paths = [tmp_path / f"road-{k}.json" for k in range(12)]
    for k, path in enumerate(paths):
        made = command(
            "cycle", "--set", "mission.length_m=30000", "--cycle-id", str(k), "--out", path
        )
        assert made.returncode == 0, made.stderr
    assert numbers(ocmc.fit_operating_cycle(paths)) == numbers(fit)
    done = command("fit", "operating-cycle", *paths, "--json")
    assert numbers(json.loads(done.stdout)) == numbers(fit)
    assert command("fit", "operating-cycle", *paths).stdout == str(fit)
    assert ocmc.fit_operating_cycle(roads[0])["cycles"] == 1
    for warning in fit["warnings"]:
        assert warning in done.stderr
    study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
    assert len(study.set("mission.length_m", 2000).run(cycles=10)) == 10


def test_what_the_roads_do_not_tell_is_a_warning(roads):
    with pytest.warns(UserWarning) as warned:  # noqa: PT030 (what it says is compared below)
        fit = ocmc.fit_operating_cycle(roads[0])
    assert [str(warning.message) for warning in warned] == fit["warnings"] != []


def test_what_is_wrong_with_roads_is_said(roads, tmp_path):
    base = ocmc.Study("urban-delivery")
    with pytest.raises(ValueError, match=r"`cycles`: the road type `.*` is not in the base study"):
        ocmc.fit_operating_cycle(roads, base=base)
    with pytest.raises(FileNotFoundError, match=r"absent\.json"):
        ocmc.fit_operating_cycle(tmp_path / "absent.json")
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(ValueError, match=r"broken\.json.* is not an operating cycle"):
        ocmc.fit_operating_cycle([roads[0], tmp_path / "broken.json"])
    with pytest.raises(ValueError, match="`cycles` is empty"):
        ocmc.fit_operating_cycle([])
    for wrong in [3, None, [3]]:
        with pytest.raises(TypeError, match=r"allowed is a path, a log or an ocmc\.OperatingCycle"):
            ocmc.fit_operating_cycle(wrong)
    with pytest.raises(ValueError, match=r"`cycles\[0\]` has no column for the time"):
        ocmc.fit_operating_cycle({"grade": [1.0]})


@pytest.mark.filterwarnings("ignore::UserWarning")  # a log does not tell everything
def test_roads_of_logs_are_fitted_as_by_the_command(tmp_path):
    study = ocmc.Study("field-truck").set("mission.length_m", 30_000)
    traces = [study.trace(k) for k in range(3, 6)]
    fit = ocmc.fit_operating_cycle(traces, road_type="rural")
    assert (fit["cycles"], [road["road_type"] for road in fit["types"]]) == (3, ["rural"])
    assert (fit["told"]["signs"], fit["told"]["events"], fit["told"]["slopes"]) == (
        True,
        False,
        True,
    )
    assert fit["told"]["curves"]["within"]["radius_m"] == [20.0, 500.0]
    assert any(
        "a standstill alone does not tell a sign from a queue" in text for text in fit["warnings"]
    )
    assert fit["birds_eye"]["stops_per_km"] > 0
    paths = [tmp_path / f"{k}.csv" for k in range(3)]
    for k, path in enumerate(paths):
        write(path, traces[k].to_dict())
    done = command("fit", "operating-cycle", *paths, "--road-type", "rural", "--json")
    assert done.returncode == 0, done.stderr
    by_files = ocmc.fit_operating_cycle(paths, road_type="rural")
    assert numbers(json.loads(done.stdout)) == numbers(fit) == numbers(by_files)
    few = ocmc.fit_operating_cycle(traces, road_type="rural", radius_range_m=(20, 100))
    assert few["birds_eye"]["curves_per_km"] < fit["birds_eye"]["curves_per_km"]
    times = {"time_s": traces[0]["time_s"], "v": traces[0]["speed_mps"]}
    bare = ocmc.fit_operating_cycle(times, columns={"speed_mps": "v"}, road_type="rural")
    assert bare["told"]["curves"] == "none"
    with pytest.raises(ValueError, match="no road type is known"):
        ocmc.fit_operating_cycle(times, columns={"speed_mps": "v"})


def hours():
    """Four years of hours, from plain functions of the clock."""
    time = 3600.0 * np.arange(4 * 8766)
    year, day = 2 * np.pi * time / (365.25 * 86400), 2 * np.pi * time / 86400
    wave = np.sin(time / 3600 / 21)
    return {
        "time_s": time,
        "temperature_c": 8 - 9 * np.cos(year) - 2 * np.cos(day) + 3 * wave,
        "wind_speed_mps": 4 + 3 * wave,
    }


@pytest.mark.filterwarnings("ignore::UserWarning")  # what was not recorded stays
def test_weather_is_fitted_as_by_the_command(tmp_path):
    fit = ocmc.fit_weather(hours())
    assert fit["hours"] == 4 * 8766
    assert fit["study"]["weather"]["temperature"]["mean_k"] == pytest.approx(281.15, abs=0.1)
    path = tmp_path / "hours.csv"
    write(path, hours())
    done = command("fit", "weather", path, "--json")
    assert json.loads(done.stdout) == ocmc.fit_weather(path)
    assert numbers(ocmc.fit_weather(path)) == numbers(fit)
    assert command("fit", "weather", path).stdout == str(fit)
    table = hours()
    wind = {name: table.pop(name) for name in ["wind_speed_mps"]} | {"time_s": table["time_s"]}
    assert numbers(ocmc.fit_weather([table, wind])) == numbers(fit)
    study = ocmc.Study({"study": {"base": "field-truck"}} | fit["study"])
    assert len(study.set("mission.length_m", 2000).run(cycles=2)) == 2
    with pytest.raises(ValueError, match="name it `time`, `date`, `time_s`"):
        ocmc.fit_weather({"temperature_c": [1.0]})
    with pytest.raises(FileNotFoundError, match="absent"):
        ocmc.fit_weather(tmp_path / "absent.csv")


@pytest.mark.filterwarnings("ignore::UserWarning")  # what was not recorded stays
def test_times_in_utc_need_the_zone_of_the_place():
    table = hours()
    local = ocmc.fit_weather(table)["study"]["weather"]["temperature"]
    stamps = np.datetime64("2019-01-01T00:00:00") + table["time_s"].astype("timedelta64[s]")
    utc = table | {"time": np.datetime_as_string(stamps - np.timedelta64(2, "h"), timezone="UTC")}
    del utc["time_s"]
    fitted = ocmc.fit_weather(utc, utc_offset_h=2)["study"]["weather"]["temperature"]
    assert fitted["mean_k"] == pytest.approx(local["mean_k"], abs=0.05)
    assert fitted["summer_daily_amplitude_k"] == pytest.approx(
        local["summer_daily_amplitude_k"], abs=0.05
    )
    with pytest.raises(ValueError, match=r"row 1.*UTC.*utc_offset_h"):
        ocmc.fit_weather(utc)
    with pytest.raises(ValueError, match="`utc_offset_h` is 99, allowed are hours from -12 to 14"):
        ocmc.fit_weather(utc, utc_offset_h=99)
    zoned = ocmc.fit_weather(utc, zone="Africa/Maputo")["study"]["weather"]["temperature"]
    assert zoned == fitted
    with pytest.raises(ValueError, match="`zone` is Mars, `Mars` is no time zone"):
        ocmc.fit_weather(utc, zone="Mars")
    with pytest.raises(ValueError, match="not both"):
        ocmc.fit_weather(utc, zone="UTC", utc_offset_h=0)
    with pytest.raises(ValueError, match="`temperature_bar` has a unit that is not read"):
        ocmc.fit_weather({"time_s": [0.0], "temperature_bar": [50.0]})


@pytest.mark.filterwarnings("ignore::UserWarning")  # densities without a correlation
def test_traffic_is_fitted_as_by_the_command(tmp_path):
    time = 900.0 * np.arange(10 * 96)
    ripple = np.where(np.arange(time.size) % 2 == 0, 1.05, 1 / 1.05)
    table = {"time_s": time, "road_type": ["rural"] * time.size, "density_share": 0.1 * ripple}
    fit = ocmc.fit_traffic(table)
    assert fit["n"] == time.size
    assert fit["study"]["traffic"]["types"]["rural"]["off_peak_share"] == pytest.approx(
        0.1, abs=1e-3
    )
    path = tmp_path / "traffic.csv"
    write(path, table)
    done = command("fit", "traffic", path, "--json")
    assert json.loads(done.stdout) == ocmc.fit_traffic(path)
    assert numbers(ocmc.fit_traffic(path)) == numbers(fit)
    with pytest.raises(ValueError, match="road_type"):
        ocmc.fit_traffic({"time_s": [0.0], "density_share": [0.1]})


@pytest.fixture(scope="module")
def records():
    """Trips of eight trucks with two drivers each: SDs of 1, 0.7 and 2."""
    draw = np.random.default_rng(3)
    trucks, drivers = 30 + draw.normal(size=8), 0.7 * draw.normal(size=16)
    truck, driver = np.repeat(np.arange(8), 40), np.repeat(np.arange(16), 20)
    return {
        "truck_id": truck.tolist(),
        "driver_id": driver.tolist(),
        "consumption_l_per_100km": (
            trucks[truck] + drivers[driver] + 2 * draw.normal(size=320)
        ).tolist(),
    }


def test_a_fleet_is_fitted_as_by_the_command(records, tmp_path):
    fit = ocmc.fit_fleet(records)
    assert (fit["n"], fit["trucks"], fit["drivers"], fit["design"]) == (
        320,
        8,
        16,
        "drivers_in_trucks",
    )
    # balanced: the analysis of variance
    value = np.array(records["consumption_l_per_100km"]).reshape(8, 2, 20)
    trips = value.var(axis=2, ddof=1).mean()
    drivers = 20 * value.mean(axis=2).var(axis=1, ddof=1).mean()
    assert fit["components"][2]["sd"] == pytest.approx(np.sqrt(trips), rel=1e-5)
    assert fit["components"][1]["sd"] == pytest.approx(np.sqrt((drivers - trips) / 20), rel=1e-5)
    path = write(tmp_path / "records.csv", records)
    assert json.loads(command("fit", "fleet", path, "--json").stdout) == ocmc.fit_fleet(path)
    assert numbers(ocmc.fit_fleet(path)) == numbers(fit)
    assert command("fit", "fleet", path).stdout == str(fit)
    for library, make in [("pyarrow", "table"), ("polars", "DataFrame"), ("pandas", "DataFrame")]:
        other = ocmc.fit_fleet(getattr(pytest.importorskip(library), make)(records))
        assert numbers(other) == numbers(fit), library
    # the same with drivers numbered within trucks, and other names
    own = {
        "plate": records["truck_id"],
        "driver": [driver % 2 for driver in records["driver_id"]],
        "l": records["consumption_l_per_100km"],
    }
    other = ocmc.fit_fleet(own, columns={"truck": "plate"}, column="l", own_drivers=True)
    assert other["reml_criterion"] == pytest.approx(fit["reml_criterion"], rel=1e-12)
    with pytest.raises(ValueError, match='`best` is "fastest", allowed is one of: lowest, highest'):
        ocmc.fit_fleet(records, best="fastest")
    with pytest.raises(ValueError, match="power is 2; allowed is a share above 0 and below 1"):
        ocmc.fit_fleet(records, power=2.0)
    with pytest.raises(ValueError, match="1 trucks; allowed are two trucks or more"):
        ocmc.fit_fleet({"truck": ["a", "a"], "consumption_l_per_100km": [30.0, 31.0]})
    with pytest.raises(ValueError, match="no column for the truck"):
        ocmc.fit_fleet({"consumption_l_per_100km": [30.0, 31.0]})
