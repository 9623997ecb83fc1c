"""Given routes and given speeds: the same records as the command's, from files and from tables."""

import json

import numpy as np
import ocmc
import pytest
from test_command import command

SPEED = {
    "time_s": [0.0, 40.0, 160.0, 180.0, 200.0, 240.0, 300.0, 320.0],
    "speed_kmh": [0.0, 72.0, 72.0, 0.0, 0.0, 54.0, 54.0, 0.0],
    "grade": [0.0, 0.0, 0.01, 0.0, 0.0, 0.0, -0.02, 0.0],
}
METRES = 400 + 2400 + 200 + 300 + 900 + 150


@pytest.fixture(scope="module")
def truck():
    return ocmc.Study("field-truck-loaded")


@pytest.fixture(scope="module")
def speed_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("speed") / "cycle.csv"
    rows = zip(*SPEED.values(), strict=True)
    path.write_text("\n".join([",".join(SPEED), *(",".join(map(str, row)) for row in rows)]))
    return path


@pytest.fixture(scope="module")
def route(tmp_path_factory):
    path = tmp_path_factory.mktemp("route") / "route.csv"
    done = command("cycle", "--set", "mission.length_m=4000", "--cycle-id", "5", "--out", path)
    assert done.returncode == 0, done.stderr
    return path


def test_limits_above_those_of_the_class_are_said(truck, tmp_path):
    path = tmp_path / "coach.csv"
    rows = "".join(f"{k},100,0,0,0\n" for k in range(0, 6001, 50))
    path.write_text("position_m,limit_kmh,altitude_m,curvature_per_m,stop_s\n" + rows)
    with pytest.warns(UserWarning, match="limit-above-class"):
        truck.drive(path, cycles=2)
    told = command("drive", path, "--cycles", "2", "--quiet")
    assert told.stderr.count("limit-above-class") == 1


def same(run, other):
    assert run.columns == other.columns
    for name in run.columns:
        np.testing.assert_array_equal(run[name], other[name], err_msg=name)


def by_command(tmp_path, *arguments):
    out = tmp_path / "command"
    done = command("drive", *arguments, "--cycles", "20", "--seed", "3", "--quiet", "--out", out)
    assert done.returncode == 0, done.stderr
    return ocmc.load(out), json.loads((out / "manifest.json").read_text())


@pytest.mark.parametrize("follow", ["exact", "driver"])
def test_a_speed_is_followed_as_by_the_command(truck, speed_file, tmp_path, follow):
    run = truck.drive(speed_file, cycles=20, seed=3, follow_speed=follow)
    study = ["--study", "field-truck-loaded"]
    other, manifest = by_command(tmp_path, speed_file, *study, "--follow-speed", follow)
    same(run, other)
    assert manifest["followed"]["how"] == follow
    assert manifest["followed"]["cycle"].startswith("time_s,speed_mps,slope")
    assert manifest["study"] == f"field-truck-loaded following {speed_file} ({follow})"
    run.save(tmp_path / "python")
    for name in ["records.parquet", "manifest.json"]:
        assert (tmp_path / "python" / name).read_bytes() == (
            tmp_path / "command" / name
        ).read_bytes()
    assert run.study.name == "field-truck-loaded"
    np.testing.assert_allclose(run["distance_m"], METRES, rtol=1e-12 if follow == "exact" else 1e-2)
    if follow == "exact":
        assert set(run["duration_s"]) == {320.0}
        assert set(run["n_stops"]) == {1}
        assert np.isnan(run["driver_kp"]).all(), "nobody drives"
        assert np.isnan(run["n_curves"]).all(), "nobody drives"
    else:
        assert run["n_curves"].dtype == np.uint64
        assert (run["driver_kp"] > 0.0).all()
        assert (run["duration_s"] > 315.0).all(), "a truck with a driver is hardly faster"
    assert len(set(run["fuel_kg"])) == 20, "trucks and weathers are the study's"


@pytest.mark.parametrize("follow", ["exact", "driver"])
def test_a_table_is_followed_like_its_file(truck, speed_file, follow):
    run = truck.drive(speed_file, cycles=10, follow_speed=follow)
    same(run, truck.drive(SPEED, cycles=10, follow_speed=follow))
    for library, make in [("pyarrow", "table"), ("polars", "DataFrame"), ("pandas", "DataFrame")]:
        table = getattr(pytest.importorskip(library), make)(SPEED)
        same(run, truck.drive(table, cycles=10, follow_speed=follow, threads=1))


def test_a_route_is_driven_as_by_the_command(route, tmp_path):
    study = ocmc.Study("field-truck")
    run = study.drive(route, cycles=20, seed=3, keep=["traffic"])
    other, manifest = by_command(tmp_path, route, "--keep", "traffic")
    same(run, other)
    assert "followed" not in manifest
    assert manifest["study"] == run.summary()["study"] == f"field-truck on {route}"
    np.testing.assert_allclose(run["distance_m"], 4000.0, rtol=1e-3)
    same(run, run.study.run(cycles=20, seed=3))
    drawn = study.drive([route], cycles=20, seed=3)
    assert (drawn["duration_s"] != run["duration_s"]).any(), "with traffic of the study"


def test_a_mission_without_its_departure_is_told(route, recwarn):
    study = ocmc.Study("field-truck")
    study.drive(route, cycles=1)
    assert not recwarn, "nothing of the mission is kept"
    with pytest.warns(UserWarning, match="holds no departure, which is drawn from the study"):
        study.drive(route, cycles=1, keep=["mission"])


def test_the_speed_planned_on_a_route_is_kept_exactly(route, tmp_path):
    run = ocmc.Study("field-truck").drive(route, cycles=20, seed=3, follow_speed="exact")
    other, _ = by_command(tmp_path, route, "--follow-speed", "exact")
    same(run, other)
    np.testing.assert_allclose(run["distance_m"], 4000.0, rtol=1e-6)


def test_a_drive_is_interrupted_by_what_its_progress_raises(truck):
    calls = []

    def stop(done, total):
        calls.append((done, total))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        truck.drive(SPEED, cycles=10**9, follow_speed="exact", progress=stop)
    assert len(calls) == 1
    truck.drive(SPEED, cycles=50, follow_speed="exact", progress=lambda *done: calls.append(done))
    assert calls[-1] == (50, 50)


def test_what_is_wrong_is_said(truck, route, speed_file, tmp_path):
    def wrong(error, part, files, **options):
        with pytest.raises(error, match=part):
            truck.drive(files, **({"cycles": 1} | options))

    wrong(FileNotFoundError, r"cannot read `.*absent\.csv`", tmp_path / "absent.csv")
    wrong(FileNotFoundError, r"absent\.csv", tmp_path / "absent.csv", follow_speed="exact")
    wrong(IsADirectoryError, "cannot read", tmp_path)
    wrong(
        ValueError,
        "`follow_speed`: a speed is followed of one file",
        [route, speed_file],
        follow_speed="exact",
    )
    wrong(
        ValueError,
        "`follow_speed`: `driver` takes a drive cycle over time",
        route,
        follow_speed="driver",
    )
    for cycle in [speed_file, SPEED]:
        wrong(
            ValueError, "to keep: leave `keep` out", cycle, follow_speed="exact", keep=["weather"]
        )
    wrong(ValueError, "in Python follow_speed", SPEED)
    wrong(ValueError, "several items, allowed are paths", [SPEED, route], follow_speed="exact")
    wrong(
        ValueError,
        '`follow_speed` is "fast", allowed is one of: driver, exact',
        route,
        follow_speed="fast",
    )
    wrong(
        ValueError,
        '`keep` is "road", allowed is one of: weather, traffic, mission',
        route,
        keep=["road"],
    )
    wrong(ValueError, "`files` is empty", [])
    wrong(TypeError, "`files` is 3, allowed is a path", 3)
    wrong(ValueError, "`cycles` is 0", route, cycles=0)
    wrong(ValueError, "no column for the speed", {"time_s": [0.0, 1.0]}, follow_speed="exact")
    backwards = SPEED | {"time_s": SPEED["time_s"][::-1]}
    wrong(ValueError, "`files`: ", backwards, follow_speed="exact")
    standing = {"time_s": [0.0, 1.0], "speed_mps": [0.0, 0.0]}
    wrong(ValueError, "`files` as a route", standing, follow_speed="driver")
    (tmp_path / "route.txt").write_text("x")
    wrong(ValueError, "unknown column `x`; allowed are", tmp_path / "route.txt")


def test_what_was_read_of_a_route_is_told(route, tmp_path, capsys):
    study = ocmc.Study("field-truck")
    run = study.drive(route, cycles=2, progress=True)
    [told] = run.routes
    assert set(told) >= {
        "file",
        "length_m",
        "climb_m",
        "steepest_grade",
        "n_curves",
        "n_stops",
        "told",
    }
    assert told["warnings"] == []
    assert "km, " in told["told"][0]
    assert told["told"][0] in capsys.readouterr().err
    assert abs(told["length_m"] - run["distance_m"][0]) < 1.0
    quiet = study.drive(route, cycles=2, progress=False)
    assert capsys.readouterr().err == ""
    assert quiet.routes == run.routes
    run.save(tmp_path / "run")
    assert ocmc.load(tmp_path / "run").routes == []
    assert study.run(cycles=2).routes == []
