"""Roads from logs, and measured drives over simulated ones."""

import json
import warnings

import numpy as np
import ocmc
import pytest

# what was not used of a log is not the matter here
pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

COLUMNS = [
    "time_s",
    "speed_mps",
    "position_m",
    "yaw_rate_radps",
    "limit_mps",
    "grade",
    "fuel_rate_kgps",
]


@pytest.fixture(scope="module")
def study():
    study = ocmc.Study("field-truck").set("mission.length_m", 4000.0)
    return study.set("simulation.step_s", 0.5)


def log(study, cycle_id, columns=COLUMNS):
    trace = study.trace(cycle_id, seed=7)
    return {name: trace[name] for name in columns}


def test_a_road_is_driven_again(study, tmp_path):
    answer = ocmc.road(log(study, 3))
    (road,) = answer["roads"]
    assert road["limit_source"] == "column"
    assert road["length_m"] == pytest.approx(4000.0, abs=5.0)
    path = tmp_path / "road.json"
    path.write_text(json.dumps(road))
    run = ocmc.Study("field-truck").drive(path, cycles=10)
    assert run.summary()["outcomes"]["completed"] == 10
    with pytest.raises(ValueError, match="the speed limit, in m/s, is 900"):
        ocmc.road(log(study, 3, COLUMNS[:4]), limit_mps=900.0)


def test_drives_are_laid_over_trips(study, tmp_path):
    (road,) = ocmc.road(log(study, 3))["roads"]
    path = tmp_path / "road.json"
    path.write_text(json.dumps(road))
    out = tmp_path / "out"
    with pytest.warns(UserWarning, match="60 trips: bands and ranks want 2000"):
        answer = ocmc.validate(
            [log(study, 3), log(study, 3)],
            study,
            road=path,
            trips=60,
            seed=11,
            out=out,
            progress=False,
        )
    assert answer["pooled"][0]["quantity"] == "speed"
    assert len(answer["drives"]) == 2
    # limits came from a column, stops from the drive itself
    assert set(answer["circular"]) <= {"stops"}
    values = answer["drives"][0]["values"]
    assert values["energy"]["measured"] > 0.1
    assert 0.0 < values["duration"]["pit"] < 1.0
    assert (out / "report.html").read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(FileExistsError, match="is not empty"):
        ocmc.validate(log(study, 3), study, trips=60, out=out)
    with pytest.raises(ValueError, match="`run_in_m` is -1"):
        ocmc.validate(log(study, 3), study, trips=60, run_in_m=-1.0)


def test_limits_of_the_speed_are_circular_and_drawn(study):
    pytest.importorskip("matplotlib").use("agg")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        answer = ocmc.validate(log(study, 3, COLUMNS[:3]), study, trips=60)
    assert "limits" in answer["circular"]
    assert any("no validation" in str(warning.message) for warning in caught)
    ax = ocmc.plot.validation(answer)
    median = next(line for line in ax.lines if line.get_label() == "median")
    np.testing.assert_allclose(median.get_ydata(), 3.6 * np.array(answer["roads"][0]["p50_mps"]))
    with pytest.raises(ValueError, match="`road` is 1"):
        ocmc.plot.validation(answer, road=1)
