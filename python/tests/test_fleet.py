"""Questions about a fleet: the answers are the command's, and have the right sign and size."""

import itertools
import json

import ocmc
import pytest
from test_command import SHORT, command


def without_times(answer):
    return {key: value for key, value in answer.items() if key not in {"wall_s", "threads"}}


@pytest.fixture(scope="module")
def loaded(study):
    return study.set("study.name", "loaded").set("mission.payload_kg", 20_000)


def test_a_comparison_is_paired(study, loaded, run):
    answer = ocmc.compare(study, loaded, cycles=300)
    other = loaded.run(cycles=300)
    assert (answer["study_a"], answer["study_b"]) == ("field-truck", "loaded")
    assert (answer["study_hash_a"], answer["study_hash_b"]) == (study.hash, loaded.hash)
    column = answer["column"]
    assert answer["a"] == pytest.approx(run.summary()["statistics"][column]["mean"], rel=1e-12)
    assert answer["b"] == pytest.approx(other.summary()["statistics"][column]["mean"], rel=1e-12)
    assert answer["difference"] == pytest.approx(answer["b"] - answer["a"], rel=1e-9)
    low, high = answer["ci95"]
    assert low < answer["difference"] < high
    assert answer["share_a_lower"] == (run[column] < other[column]).mean()
    assert answer["variance_reduction"] > 1.0
    assert "B - A" in str(answer)
    assert "<pre>" in answer._repr_html_()


def test_the_two_of_a_comparison_are_called_as_asked(study, tmp_path):
    other = study.set("mission.payload_kg", 20_000)
    answer = ocmc.compare(
        study, other, cycles=30, names=["empty", "full"], out=tmp_path / "compared"
    )
    assert (answer["study_a"], answer["study_b"]) == ("empty", "full")
    assert answer["difference"] == ocmc.compare(study, other, cycles=30)["difference"]
    for shown in [str(answer), (tmp_path / "compared" / "report.html").read_text(encoding="utf-8")]:
        assert "empty" in shown
        assert "full" in shown
    with pytest.raises(ValueError, match="`names` has 3 items, allowed are 2"):
        ocmc.compare(study, other, cycles=1, names=["a", "b", "c"])
    with pytest.raises(TypeError):
        ocmc.compare(study, other, cycles=1, names="ab")


def test_the_command_gives_the_same_comparison(study):
    other = study.set("driver.curve_speed.exponent", 0.5)
    answer = ocmc.compare(study, other, cycles=100, seed=3, column="mean_speed_mps")
    options = [*SHORT, "--cycles", "100", "--seed", "3", "--column", "mean_speed_mps", "--json"]
    printed = json.loads(command("compare", "field-truck", "field-truck", *options).stdout)
    assert printed["a"] == answer["a"]
    assert printed["difference"] == 0.0
    assert set(printed) == set(answer)


def test_a_study_compared_with_itself_does_not_differ(study):
    answer = ocmc.compare(study, study, cycles=50)
    assert (answer["difference"], answer["share_equal"]) == (0.0, 1.0)


def test_the_shares_of_the_factors_are_the_command_s(study):
    answer = study.sensitivity(cycles=64, factors=["road", "mission"])
    options = [*SHORT, "--cycles", "64", "--factor", "road,mission", "--json", "--quiet"]
    printed = json.loads(command("sensitivity", *options).stdout)
    assert without_times(printed) == without_times(answer)
    for share in answer["factors"]:
        low, high = share["total_ci95"]
        assert low <= share["total"] <= high
    assert "Shares of the variance" in str(answer)
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    ax = ocmc.plot.sensitivity(answer)
    assert {text.get_text() for text in ax.get_yticklabels()} == {"road", "mission"}
    matplotlib.pyplot.close("all")


PRICES = {
    "currency": "EUR",
    "fuel_per_l": {"distribution": "uniform", "lower": 1.2, "upper": 1.8},
    "driver_per_h": 30.0,
}


def test_the_costs_are_the_command_s(study):
    priced = study.set("cost", PRICES)
    answer = priced.cost(cycles=64)
    sets = [
        "cost.currency=EUR",
        'cost.fuel_per_l={ distribution = "uniform", lower = 1.2, upper = 1.8 }',
        "cost.driver_per_h=30.0",
    ]
    options = [*SHORT, *(word for text in sets for word in ("--set", text)), "--cycles", "64"]
    printed = json.loads(command("cost", *options, "--json", "--quiet").stdout)
    assert printed["total"] == answer["total"]
    assert printed["inputs"] == answer["inputs"]
    assert [item["item"] for item in answer["items"]] == ["fuel", "driver"]
    assert (
        answer["spread"]["per_km"]["p5"]
        < answer["total"]["per_km"]
        < answer["spread"]["per_km"]["p95"]
    )
    assert "truck-year" in str(answer)


def test_two_studies_are_costed_against_each_other(study):
    priced = study.set("cost", PRICES)
    answer = priced.cost(cycles=64, against=priced.set("cost.driver_per_h", 20.0))
    assert answer["difference"]["per_km"]["difference"] < 0.0
    assert answer["difference"]["per_km"]["probability_a_cheaper"] == 0.0
    assert answer["difference"]["share_of_trips_a_cheaper"] == 0.0
    with pytest.raises(ValueError, match="no prices"):
        priced.cost(cycles=10, against=study)
    with pytest.raises(ValueError, match=r"`cost\.driver_per_h` is -1"):
        priced.set("cost.driver_per_h", -1.0)


DRAG, PAYLOAD = "vehicle.drag_area_m2.median", "mission.payload_kg"


def test_a_sweep_is_the_command_s_and_a_comparison_of_two(study, tmp_path):
    answer = study.sweep({DRAG: [5.5, 4.5], PAYLOAD: [0, 9000]}, cycles=40, seed=3)
    sets = ["--set", f"{DRAG}=5.5,4.5", "--set", f"{PAYLOAD}=0,9000"]
    printed = json.loads(
        command("sweep", *SHORT, *sets, "--cycles", "40", "--seed", "3", "--json").stdout
    )
    assert printed["points"] == answer["points"]
    assert set(printed) == set(answer)
    two = ocmc.compare(
        study.set(DRAG, 5.5).set(PAYLOAD, 0),
        study.set(DRAG, 4.5).set(PAYLOAD, 9000),
        cycles=40,
        seed=3,
    )
    last = answer["points"][3]
    assert last["values"] == {DRAG: 4.5, PAYLOAD: 9000}
    assert (last["difference"], last["difference_ci95"]) == (two["difference"], two["ci95"])
    assert answer["points"][0]["difference"] is None
    assert "how it differs from the first point" in str(answer)
    rows = [{DRAG: drag, PAYLOAD: payload} for drag in (5.5, 4.5) for payload in (0, 9000)]
    file = tmp_path / "points.csv"
    file.write_text(
        f"{DRAG},{PAYLOAD}\n" + "".join(f"{row[DRAG]},{row[PAYLOAD]}\n" for row in rows),
        encoding="utf-8",
    )
    for points in (rows, file):
        assert study.sweep(points, cycles=40, seed=3)["points"] == answer["points"]


def test_a_sweep_of_words_of_what_is_missing_and_of_data_frames(study):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    vehicles = ["tractor-40t", "rigid-12t"]
    answer = study.sweep(
        {"vehicle.base": vehicles, "study.name": "short"}, cycles=10, against="base"
    )
    assert answer["study"] == "short"
    assert answer["base"]["mean"] == answer["points"][0]["mean"]
    assert answer["points"][0]["difference"] == 0.0
    frame = pandas.DataFrame({"vehicle.base": vehicles})
    listed = study.sweep(frame, cycles=10)
    means = [point["mean"] for point in answer["points"]]
    assert [point["mean"] for point in listed["points"]] == means
    partly = study.sweep([{PAYLOAD: 0}, {"vehicle.base": "rigid-12t"}], cycles=10)
    assert partly["points"][1]["values"] == {PAYLOAD: None, "vehicle.base": "rigid-12t"}
    assert partly["points"][1]["mean"] == means[1]
    flat = pandas.json_normalize(answer["points"])
    assert list(flat["values.vehicle.base"]) == vehicles


@pytest.mark.parametrize(
    ("points", "kind", "message"),
    [
        ({DRAG: [5.5]}, ValueError, "give a key several values"),
        ({DRAG: []}, ValueError, "give a key several values"),
        ([], ValueError, "`points` is empty"),
        ([1, 2], TypeError, r"`points\[0\]` is 1, allowed is a dictionary"),
        (5, TypeError, "`points` is 5, allowed is a dictionary of lists"),
        ({DRAG: [5.5, "x"]}, ValueError, r"point 2 of 2 .*drag_area_m2"),
        ({DRAG: [5.5, 5.5]}, ValueError, "the same study as point 1 of 2"),
        ({"vehicle.mas": [1, 2]}, ValueError, "is not a key of a study"),
        ({DRAG: [float("nan"), 5.0]}, ValueError, "allowed is a finite number"),
        (
            {"mission.length_m": itertools.count(5000)},
            ValueError,
            "1001 points, allowed are at most 1000",
        ),
    ],
)
def test_what_cannot_be_swept_is_said(study, points, kind, message):
    with pytest.raises(kind, match=message):
        study.sweep(points, cycles=10**9)


def test_what_is_wrong_is_said(study):
    with pytest.raises(ValueError, match=r'`column` is "fuel" \(did you mean `fuel_kg`'):
        ocmc.compare(study, study, cycles=10, column="fuel")
    with pytest.raises(ValueError, match=r"`factors` has .roads., allowed are: road, weather"):
        study.sensitivity(cycles=10, factors=["roads"])
    with pytest.raises(ValueError, match="`cycles` is 0"):
        study.sensitivity(cycles=0)
    with pytest.raises(TypeError):
        ocmc.compare(study, "field-truck", cycles=10)
    with pytest.raises(ValueError, match="1 cycle with"):
        study.sensitivity(cycles=1)
    with pytest.raises(ValueError, match='`against` is "last", allowed is one of: first, base'):
        study.sweep({DRAG: [5.5, 5.0]}, cycles=10, against="last")


def test_progress_counts_all_cycles(study, loaded):
    calls = []
    ocmc.compare(study, loaded, cycles=50, progress=lambda done, total: calls.append((done, total)))
    study.sensitivity(cycles=20, factors=["road"], progress=lambda *done: calls.append(done))
    assert (100, 100) in calls
    assert calls[-1] == (60, 60)

    def stop(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        ocmc.compare(study, loaded, cycles=10**9, progress=stop)


def test_the_report_is_the_command_s(run, tmp_path):
    run.save(tmp_path / "run")
    done = command("report", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run" / "report.html").read_text(encoding="utf-8") == run.report()


def test_the_range_is_the_command_s():
    key, value = "vehicle.powertrain.battery_electric.battery.capacity_j", 1.8e8
    answer = ocmc.Study("battery-truck").set(key, value).range(cycles=32, seed=5)
    options = [
        "--study",
        "battery-truck",
        "--set",
        f"{key}={value}",
        "--cycles",
        "32",
        "--seed",
        "5",
    ]
    printed = json.loads(command("range", *options, "--json", "--quiet").stdout)
    assert answer == printed | {"source": answer["source"]}
    with pytest.raises(ValueError, match="has no battery"):
        ocmc.Study("field-truck").range(cycles=2)


def test_the_size_is_the_command_s():
    key, value = "mission.length_m", 20_000.0
    study = ocmc.Study("battery-truck").set(key, value)
    answer = study.size(cycles=32, seed=5, arrive=[0.5, 0.9])
    options = [
        "--study",
        "battery-truck",
        "--set",
        f"{key}={value}",
        "--cycles",
        "32",
        "--seed",
        "5",
    ]
    shares = ["--arrive", "50%", "--arrive", "90%"]
    printed = json.loads(command("size", *options, *shares, "--json", "--quiet").stdout)
    assert answer == printed | {"source": answer["source"]}
    assert study.size(cycles=32, seed=5, arrive=0.9)["sizes"][0]["share"] == 0.9
    with pytest.raises(ValueError, match="`arrive` is 1"):
        study.size(cycles=2, arrive=1.0)
    with pytest.raises(ValueError, match="has no battery"):
        ocmc.Study("field-truck").size(cycles=2)
