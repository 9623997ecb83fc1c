"""Load curves, chargings, and their pictures."""

import numpy as np
import ocmc
import pytest

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402 (after the choice of the backend)


@pytest.fixture(autouse=True)
def close():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def charged():
    study = ocmc.Study("electric-long-haul").set("mission.length_m", 500e3)
    return study.run(cycles=60)


def test_the_curves_hold_what_meters_counted(charged):
    table, chargings = charged.loads(), charged.chargings()
    places = np.asarray(table["place"])
    for place in set(places):
        own = places == place
        assert own.sum() == 96
        assert set(np.asarray(table["days"])[own]) == {365}
        below = np.asarray(table["mean_power_w"])[own].sum() * 900.0 * 365.0
        counted = np.nansum(charged[f"grid_energy_{place}_j"])
        assert below == pytest.approx(counted, rel=1e-9)
        of_events = np.asarray(chargings["grid_energy_j"])[
            np.asarray(chargings["place"]) == place
        ].sum()
        assert of_events == pytest.approx(counted, rel=1e-9)
    assert sorted(set(places)) == ["depot", "public"]
    stops = np.asarray(chargings["place"]) != "depot"
    assert stops.sum() == np.nansum(charged["n_charging_stops"])
    assert (np.asarray(chargings["end_charge"]) > np.asarray(chargings["begin_charge"])).all()


def test_runs_keep_them(charged, tmp_path):
    charged.save(tmp_path / "a")
    again = ocmc.load(tmp_path / "a")
    for table, other in [
        (charged.loads(), again.loads()),
        (charged.chargings(), again.chargings()),
    ]:
        for name in table.columns:
            assert np.array_equal(table[name], other[name]), name
    parquet = pytest.importorskip("pyarrow.parquet")
    file = parquet.read_table(tmp_path / "a" / "loads.parquet")
    assert file.column("mean_power_w").to_pylist() == list(charged.loads()["mean_power_w"])


def test_without_a_policy_there_are_none(run):
    assert run.loads() is None
    assert len(run.chargings()) == 0
    for draw in (ocmc.plot.loads, ocmc.plot.state_of_charge):
        with pytest.raises(ValueError, match=r"\[charging\]"):
            draw(run)
    with pytest.raises(ValueError, match="summer and winter"):
        ocmc.plot.seasons(run)


def test_the_picture_of_a_load_curve(charged):
    ax = ocmc.plot.loads(charged, place="depot")
    ax.figure.canvas.draw()
    assert ax.get_ylabel() == "power of depots at the meter, kW"
    band, mean = ax.patches
    table = charged.loads()
    own = np.asarray(table["place"]) == "depot"
    assert mean.get_data().values == pytest.approx(np.asarray(table["mean_power_w"])[own] / 1000.0)
    assert band.get_data().values == pytest.approx(np.asarray(table["p95_power_w"])[own] / 1000.0)
    assert "public" in ocmc.plot.loads(charged).get_ylabel()
    with pytest.raises(ValueError, match="only at depot, public"):
        ocmc.plot.loads(charged, place="stop")


def test_the_picture_of_the_state_of_charge(charged):
    ax = ocmc.plot.state_of_charge(charged)
    ax.figure.canvas.draw()
    median = next(line for line in ax.lines if line.get_label() == "median")
    charge = median.get_ydata()
    assert charge[0] == pytest.approx(100.0 * np.median(charged["departure_charge"]))
    assert charge.min() > 15.0
    assert charge.max() <= 90.0
    # it falls, and rises where trucks are charged
    assert np.diff(charge).min() < 0.0 < np.diff(charge).max()


def test_the_picture_of_winter_and_summer():
    run = ocmc.Study("battery-truck").set("mission.length_m", 10e3).run(cycles=300)
    ax = ocmc.plot.seasons(run)
    ax.figure.canvas.draw()
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert (names[0], names[-1]) == ("summer", "winter")
    assert "auxiliaries" in names
    widths = [bar.get_width() for bar in ax.patches]
    # the steps lead from one season to the other: no term of the balance is left out
    assert widths[0] + sum(widths[1:-1]) == pytest.approx(widths[-1], rel=1e-9)
    assert widths[-1] > widths[0]


def test_the_battery_for_a_season():
    study = ocmc.Study("battery-truck").set("mission.length_m", 20e3)
    winter, summer = (
        study.size(cycles=120, arrive=0.9, season=season) for season in ("winter", "summer")
    )
    assert winter["season"] == "winter"
    assert 10 < winter["trips"] < 60
    assert winter["sizes"][0]["capacity_j"] > summer["sizes"][0]["capacity_j"]
    with pytest.raises(ValueError, match="allowed is one of: winter, spring, summer, autumn"):
        study.size(cycles=10, season="monsoon")
