"""Identification: the gains of a driver who is known come back, and the answer is the command's."""

import csv
import json

import numpy as np
import ocmc
import pytest
from test_command import command, numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*do not explain their pedals:UserWarning")
COLUMNS = ["time_s", "speed_mps", "accelerator", "brake", "grade", "position_m", "gear"]
QUICK = {"starts": 2, "intervals": False, "speed_term": "none"}


@pytest.fixture(scope="module")
def simulator():
    return ocmc.Study("simulator-slopes")


def logged(study, driver):
    """The trace of a driver of the study as a log, and the gains behind it."""
    trace = study.trace(driver)
    record = study.run(cycles=1, first_cycle=driver)
    log = {name: trace[name] for name in COLUMNS} | {"driver": [f"driver {driver}"] * len(trace)}
    return log, {gain: record[f"driver_{gain}"][0] for gain in ("kp", "ki", "kd")}


@pytest.fixture(scope="module")
def log(simulator):
    return logged(simulator, 0)


@pytest.fixture(scope="module")
def answer(log, simulator):
    return ocmc.identify(log[0], simulator, **QUICK)


def test_the_gains_behind_a_trace_come_back(log, answer):
    fits = answer["fits"]
    assert len(fits) == 6
    assert {fit["driver"] for fit in fits} == {"driver 0"}
    free = [fit for fit in fits if fit["saturated_s"] == 0.0]
    assert len(free) >= 3
    errors = [abs(fit[gain] / log[1][gain] - 1.0) for fit in free for gain in ("kp", "ki")]
    # a log of 20 Hz without noise; the guide's table has all events
    assert np.median(errors) < 0.05
    assert answer["population"] is None, "it takes three drivers"
    assert "no population" in str(answer)


def test_the_command_gives_the_same_answer(log, simulator, tmp_path):
    # half of the drive
    log = {name: column[: len(column) // 2] for name, column in log[0].items()}
    answer = ocmc.identify(log, simulator, **QUICK)
    assert len(answer["fits"]) >= 2
    path = tmp_path / "log.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(log)
        rows.writerows(zip(*(np.asarray(column).tolist() for column in log.values()), strict=True))
    options = ["--starts", "2", "--no-intervals", "--speed-term", "none"]
    printed = json.loads(command("identify", path, *options, "--json").stdout)
    assert command("identify", path, *options).stdout == str(answer)
    assert ocmc.identify(path, simulator, **QUICK) == printed
    assert [note.replace(str(path), "logs") for note in printed.pop("notes")] == answer["notes"]
    assert numbers(printed) == {
        key: value for key, value in numbers(answer).items() if key != "notes"
    }


@pytest.fixture(scope="module")
def part(log):
    """The first slope of the drive, as an event with a name."""
    return {name: column[2400:3200] for name, column in log[0].items()} | {"event": ["first"] * 800}


def test_tables_of_any_library_give_the_same(part, simulator):
    options = QUICK | {"starts": 1}
    answer = ocmc.identify(part, simulator, **options)
    assert [fit["event"] for fit in answer["fits"]] == ["first"]
    for library, make in [("pyarrow", "table"), ("polars", "DataFrame"), ("pandas", "DataFrame")]:
        table = getattr(pytest.importorskip(library), make)(part)
        assert ocmc.identify(table, simulator, **options) == answer, library
    percent = dict(part)
    percent["pedal"] = 100.0 * percent.pop("accelerator")
    again = ocmc.identify(percent, simulator, columns={"accelerator_percent": "pedal"}, **options)
    assert again["fits"][0]["kp"] == pytest.approx(answer["fits"][0]["kp"], rel=1e-3)
    calls = []
    twice = ocmc.identify(
        [part, part], simulator, **options, progress=lambda *done: calls.append(done)
    )
    assert [fit["kp"] for fit in twice["fits"]] == [answer["fits"][0]["kp"]] * 2
    assert calls[-1] == (2, 2)


def test_delay_and_mass_are_estimated_and_the_speed_term_warns(part, simulator):
    options = QUICK | {"starts": 4}
    (fit,) = ocmc.identify(part, simulator, **options, unknown=["delay", "mass"])["fits"]
    # a driver of the program reacts at once, in the truck of the study
    assert fit["delay_s"] < 0.05
    assert fit["mass_kg"] == pytest.approx(40e3, rel=0.01)
    with pytest.warns(UserWarning, match="the speed term of the paper biases the gains"):
        answer = ocmc.identify(part, simulator, **(options | {"speed_term": "measured"}))
    assert "the speed term biases the gains" in answer["fits"][0]["no_intervals"]


def test_what_is_left_out_is_said(part, simulator):
    events = ["first"] * 790 + ["short"] * 10
    with pytest.warns(UserWarning, match="event `short` of .*`logs` is left out: 10 rows"):
        answer = ocmc.identify(part | {"event": events}, simulator, **(QUICK | {"starts": 1}))
    assert [left["reason"][:7] for left in answer["left_out"]] == ["10 rows"]
    assert answer["notes"] == []
    gaps = part | {"grade": np.where(np.arange(800) == 5, np.nan, part["grade"])}
    answer = ocmc.identify(gaps, simulator, **(QUICK | {"starts": 1}))
    assert answer["notes"] == ["`logs`: 1 row without slope: not used"]


@pytest.mark.parametrize(
    ("change", "options", "part"),
    [
        ({"brake": None}, {}, "no column for the brake pedal"),
        ({}, {"controller": "pi"}, "allowed is one of: pid, switched"),
        ({}, {"speed_term": "mean"}, "allowed is one of: none, measured, simulated"),
        ({}, {"unknown": ["wind"]}, "allowed is one of: delay, mass, resistance, none"),
        ({}, {"starts": 0}, "`starts` is 0, allowed is a whole number from 1 to 4096"),
        ({}, {"kp": (2.0, 1.0)}, r"bounds of kp are 2 and 1: they have to rise, from 0\.001 on"),
        ({}, {"kd": (0.0, float("inf"))}, "bounds of kd"),
        (
            {"event": ["short"] * 400, "time_s": np.arange(400) / 100},
            {},
            "event `short` of `logs`: 400 rows over",
        ),
        (
            {"grade": [0.0] * 400},
            {},
            "`logs`: no event in the rows that can be used: a log needs the label `event`",
        ),
        ({"accelerator": [90.0] * 400, "event": ["x"] * 400}, {}, "is it in percent"),
    ],
)
def test_what_is_wrong_is_said(log, simulator, change, options, part):
    table = {name: column[2400:2800] for name, column in log[0].items()} | change
    table = {name: column for name, column in table.items() if column is not None}
    with pytest.raises(ValueError, match=part):
        ocmc.identify(table, simulator, **options)


def test_a_study_is_needed(log):
    with pytest.raises(TypeError, match="study"):
        ocmc.identify(log[0])
    with pytest.raises(TypeError, match="study"):
        ocmc.identify(log[0], "simulator-slopes")


def test_other_threads_go_on_meanwhile(log, simulator, other_threads_go_on):
    with other_threads_go_on():
        ocmc.identify(log[0], simulator, **QUICK)
