"""Pictures: what is drawn are the numbers, and axes have units."""

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


def drawn(ax):
    """The picture can be drawn, and nothing is told on the way."""
    ax.figure.canvas.draw()
    return ax


def line(ax, label):
    (found,) = [artist for artist in ax.lines if str(artist.get_label()).startswith(label)]
    return found


def test_the_consumption_of_a_run(run):
    ax = drawn(ocmc.plot.consumption(run))
    assert ax.get_xlabel() == "consumption, L/100 km"
    assert ax.get_ylabel() == "share of the cycles, %"
    assert sum(bar.get_height() for bar in ax.patches[: len(ax.containers[0])]) == pytest.approx(100.0)
    statistic = run.summary()["statistics"]["consumption_l_per_100km"]
    assert line(ax, "mean of the fleet").get_xdata()[0] == statistic["mean"]
    verticals = {artist.get_xdata()[0] for artist in ax.lines}
    assert {statistic[f"p{level}"] for level in (5, 25, 50, 75, 95)} <= verticals


def test_any_column_in_the_units_of_people(run):
    speed = ocmc.plot.consumption(run, column="mean_speed_mps")
    assert speed.get_xlabel() == "speed, km/h"
    mean = run.summary()["statistics"]["mean_speed_mps"]["mean"]
    assert line(speed, "mean of the fleet").get_xdata()[0] == pytest.approx(3.6 * mean)
    payload = ocmc.plot.consumption(run, column="payload_kg")
    assert payload.get_xlabel() == "payload, kg"
    assert ocmc.plot.consumption(run, column="n_stops").get_xlabel() == "n stops"


def test_the_axes_given_are_drawn_into(run):
    _, given = plt.subplots()
    assert ocmc.plot.consumption(run, ax=given) is given
    assert ocmc.plot.comparison(run, run, ax=given) is given
    assert len(plt.get_fignums()) == 1


def test_what_nobody_has_is_an_error(run):
    with pytest.raises(ValueError, match="no completed cycle has `battery_energy_j`"):
        ocmc.plot.consumption(run, column="battery_energy_j")
    with pytest.raises(ValueError, match="no completed cycle has `battery_energy_j`"):
        ocmc.plot.comparison(run, run, column="battery_energy_j")
    with pytest.raises(KeyError, match="no column 'fuel'"):
        ocmc.plot.consumption(run, column="fuel")


@pytest.mark.parametrize(("against", "factor"), [("position", 1e-3), ("time", 1 / 60)])
def test_the_trace_of_a_cycle(study, against, factor):
    trace = study.trace(3)
    panels = ocmc.plot.trace(trace, cycle=study.operating_cycle(3), against=against)
    drawn(panels[0])
    speed = next(a for a in panels[0].lines if a.get_label() == "speed")
    np.testing.assert_allclose(speed.get_ydata(), 3.6 * trace["speed_mps"])
    np.testing.assert_allclose(
        speed.get_xdata(), factor * trace[f"{against}_{'m' if against == 'position' else 's'}"]
    )
    limit = line(panels[0], "speed limit").get_ydata()
    track = study.operating_cycle(3)["speed_limit_mps"]
    assert set(limit) <= set(3.6 * track["value"])
    assert limit[0] == 3.6 * track["value"][0]
    np.testing.assert_array_equal(panels[3].lines[0].get_ydata(), trace["gear"])
    assert [ax.get_ylabel() for ax in panels] == ["speed, km/h", "slope, %", "pedals, %", "gear"]
    assert panels[3].get_xlabel() in {"position, km", "time, min"}


def test_a_part_of_a_trace_and_axes_of_the_caller(study):
    trace = study.trace(3)
    _, given = plt.subplots(2, 2)
    panels = ocmc.plot.trace(dict(trace), between=(1000, 2000), ax=given)
    assert panels == list(given.ravel())
    x = panels[3].lines[0].get_xdata()
    assert 1.0 <= x.min() < x.max() <= 2.0
    with pytest.raises(ValueError, match="no step lies between 6000 and 7000, the trace ends at 5000"):
        ocmc.plot.trace(trace, between=(6000, 7000))
    with pytest.raises(ValueError, match="`ax` has 1 axes"):
        ocmc.plot.trace(trace, ax=[given[0, 0]])
    with pytest.raises(ValueError, match="`against` is 'speed'"):
        ocmc.plot.trace(trace, against="speed")


def test_two_studies(study, run):
    other = study.set("study.name", "loaded").set("mission.payload_kg", 20000).run(cycles=300)
    ax = drawn(ocmc.plot.comparison(run, other))
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert [text.partition(":")[0] for text in texts] == ["field-truck", "loaded"]
    assert f"{other['consumption_l_per_100km'].mean():.4g}" in texts[1]
