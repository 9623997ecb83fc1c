"""Pictures: what is drawn are the numbers, and axes have units."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import ocmc
import pytest

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("agg")
from matplotlib import pyplot as plt  # noqa: E402 (after the choice of the backend)

CURVES = Path(__file__).parents[2] / "examples" / "data" / "simulator_curves.csv"


@pytest.fixture(autouse=True)
def close():
    yield
    plt.close("all")


def drawn(ax):
    """The picture can be drawn, and nothing is printed on the way."""
    ax.figure.canvas.draw()
    return ax


def line(ax, label):
    (found,) = [artist for artist in ax.lines if str(artist.get_label()).startswith(label)]
    return found


def test_the_consumption_of_a_run(run):
    ax = drawn(ocmc.plot.consumption(run))
    assert ax.get_xlabel() == "consumption, L/100 km"
    assert ax.get_ylabel() == "share of the cycles, %"
    assert sum(bar.get_height() for bar in ax.patches[: len(ax.containers[0])]) == pytest.approx(
        100.0
    )
    statistic = run.summary()["statistics"]["consumption_l_per_100km"]
    assert line(ax, "mean of the fleet").get_xdata()[0] == statistic["mean"]
    verticals = {artist.get_xdata()[0] for artist in ax.lines}
    assert {statistic[f"p{level}"] for level in (5, 25, 50, 75, 95)} <= verticals


def test_names_of_quantiles_do_not_touch(run, study):
    for column in ["n_stops", "consumption_l_per_100km"]:
        ax = drawn(ocmc.plot.consumption(run, column=column))
        boxes = sorted((text.get_window_extent() for text in ax.texts), key=lambda box: box.x0)
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes)), column
        legend = ax.get_legend().get_window_extent() if ax.get_legend() else None
        assert legend is None or legend.y0 > max(box.y1 for box in boxes), (
            "the legend stands above them"
        )
    assert [text.get_text() for text in ax.texts] == ["P5", "P25", "P50", "P75", "P95"]
    same = drawn(ocmc.plot.consumption(study.run(cycles=1)))
    assert [text.get_text() for text in same.texts] == ["P5 to P95"]


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
    labels = ["speed, km/h", "slope, %", "pedals, %", "gear", "braking, kW"]
    assert [ax.get_ylabel() for ax in panels] == labels
    assert panels[-1].get_xlabel() in {"position, km", "time, min"}


@pytest.mark.parametrize("name", ["field-truck", "battery-truck"])
def test_the_trace_shows_what_brakes_and_the_charge(name):
    electric = name == "battery-truck"
    trace = ocmc.Study(name).set("mission.length_m", 5000.0).trace(3)
    panels = ocmc.plot.trace(trace)
    own = "regenerated" if electric else "engine brake"
    column = "regenerated_energy_added_j" if electric else "engine_brake_energy_added_j"
    drawn_areas = {area.get_label(): area for area in panels[4].collections}
    assert set(drawn_areas) == {"service brakes", own}
    moving = trace["step_s"] > 0.0
    most = (trace[column][moving] / trace["step_s"][moving]).max() / 1000.0
    assert most > 10.0
    top = drawn_areas[own].get_paths()[0].vertices[:, 1].max()
    np.testing.assert_allclose(top, most)
    assert len(panels) == (6 if electric else 5)
    if electric:
        np.testing.assert_allclose(panels[5].lines[0].get_ydata(), 100.0 * trace["state_of_charge"])


def test_a_part_of_a_trace_and_axes_of_the_caller(study):
    trace = study.trace(3)
    _, given = plt.subplots(2, 2)
    panels = ocmc.plot.trace(dict(trace), between=(1000, 2000), ax=given)
    assert panels == list(given.ravel())
    x = panels[3].lines[0].get_xdata()
    assert 1.0 <= x.min() < x.max() <= 2.0
    with pytest.raises(
        ValueError, match="no step lies between 6000 and 7000, the trace ends at 5000"
    ):
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
    statistic = other.summary()["statistics"]["consumption_l_per_100km"]
    low, high = statistic["ci95"]
    assert texts[1] == f"loaded: {statistic['mean']:.4g} ± {(high - low) / 2:.2g}"
    assert "95 %" in ax.get_legend().get_title().get_text()
    assert ax.lines[1].get_xdata()[0] == pytest.approx(statistic["mean"])


def test_the_two_of_a_comparison_have_two_names(study, run):
    def names(*runs, **options):
        legend = ocmc.plot.comparison(*runs, **options).get_legend()
        return [text.get_text().partition(":")[0] for text in legend.get_texts()]

    loaded = study.set("mission.payload_kg", 20000).run(cycles=100)
    assert names(run, loaded) == ["field-truck A", "field-truck B"]
    assert names(run, loaded, names=["empty", "full"]) == ["empty", "full"]
    for wrong in ["ab", ["a"], ["a", "b", "c"]]:
        with pytest.raises(ValueError, match="allowed are 2 names"):
            ocmc.plot.comparison(run, loaded, names=wrong)


def test_a_single_cycle_is_drawn(study):
    one = study.run(cycles=1)
    ax = drawn(ocmc.plot.comparison(one, one))
    value = one["consumption_l_per_100km"][0]
    wanted = [f"field-truck {side}: {value:.4g}" for side in "AB"]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == wanted
    quantiles = {artist.get_xdata()[0] for artist in drawn(ocmc.plot.consumption(one)).lines}
    assert len(quantiles) == 1
    assert quantiles.pop() == pytest.approx(value)


def test_differences_are_those_of_the_pairs(run, study):
    loaded = study.set("mission.payload_kg", 20_000.0).run(cycles=len(run))
    ax = drawn(ocmc.plot.differences(run, loaded))
    change = loaded["consumption_l_per_100km"] - run["consumption_l_per_100km"]
    mean, counted = ax.lines[1].get_xdata()[0], sum(bar.get_height() for bar in ax.patches)
    assert np.isclose(mean, change.mean())
    assert 0.98 * len(run) <= counted <= len(run)
    drawn(ocmc.plot.differences(run, run))
    with pytest.raises(ValueError, match="other cycles"):
        ocmc.plot.differences(run, study.run(cycles=3))


def test_curves_and_their_fit():
    table = pytest.importorskip("pandas").read_csv(CURVES)
    fit = ocmc.fit_curve_speed(table)
    ax = drawn(ocmc.plot.curve_fit(table, fit))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("curve radius, m", "speed in the curve, km/h")
    law = line(ax, "$v_0$ 60.0 km/h, δ 0.231")
    radius, speed = law.get_data()
    np.testing.assert_allclose(radius[[0, -1]], [125, 250])
    assert speed[-1] == pytest.approx(3.6 * fit["estimated"]["reference_speed_mps"])
    assert np.polyfit(np.log(radius), np.log(speed), 1)[0] == pytest.approx(
        fit["estimated"]["exponent"]
    )
    points = np.concatenate([a.get_xydata() for a in ax.lines if a.get_linestyle() == "None"])
    assert sorted(points[:, 1]) == pytest.approx(sorted(3.6 * table["speed_mps"]))
    outer, inner = ax.collections[:2]
    bands = [band.get_paths()[0].get_extents() for band in (outer, inner)]
    spread = np.log(bands[1].ymax / speed[-1])
    assert spread == pytest.approx(1.96 * fit["estimated"]["driver_sd"], rel=1e-4)
    assert bands[0].ymax > bands[1].ymax

    for other in [dict(table), pytest.importorskip("pyarrow").Table.from_pandas(table)]:
        same = ocmc.plot.curve_fit(other, fit)
        assert len(same.lines) == len(ax.lines)
    bare = {name: table[name] for name in ("radius_m", "speed_mps")}
    assert len(drawn(ocmc.plot.curve_fit(bare, fit)).lines) < len(ax.lines)


def test_each_driver_has_a_panel_with_its_own_regression():
    table = pytest.importorskip("pandas").read_csv(CURVES)
    fit = ocmc.fit_curve_speed(table)
    panels = ocmc.plot.curve_fit_by_driver(table, fit)
    drawn(panels[0])
    names = sorted(set(table["driver"]))
    assert [panel.get_title(loc="left").split(":")[0] for panel in panels] == names
    for name, panel in zip(names, panels, strict=True):
        own = table[table["driver"] == name]
        (regression,) = (a for a in panel.lines if a.get_linestyle() == "-")
        slope, height = np.polyfit(np.log(own["radius_m"]), np.log(3.6 * own["speed_mps"]), 1)
        radius, speed = regression.get_data()
        np.testing.assert_allclose(np.log(speed), height + slope * np.log(radius))
        points = np.concatenate(
            [a.get_xydata() for a in panel.lines if a.get_linestyle() == "None"]
        )
        assert sorted(points[:, 1]) == pytest.approx(sorted(3.6 * own["speed_mps"]))
    with pytest.raises(ValueError, match=f"`ax` has 2 axes, the drivers need {len(names)}"):
        ocmc.plot.curve_fit_by_driver(table, fit, ax=panels[:2])


def test_many_curves_of_many_drivers_are_small_points():
    draw = np.random.default_rng(1)
    drivers = draw.integers(0, 25, 2000)
    radius = np.exp(draw.uniform(np.log(20), np.log(500), 2000))
    speed = (
        15.0
        * (radius / 250) ** 0.46
        * np.exp(0.06 * draw.normal(size=25)[drivers] + 0.17 * draw.normal(size=2000))
    )
    curves = {"driver": [f"truck {k}" for k in drivers], "radius_m": radius, "speed_mps": speed}
    ax = drawn(ocmc.plot.curve_fit(curves, ocmc.fit_curve_speed(curves)))
    assert {a.get_rasterized() for a in ax.lines if a.get_linestyle() == "None"} == {True}
    assert len(ax.get_legend().get_texts()) == 4


def factor(name, first, total):
    ends = [-0.03, 0.04]
    return {
        "factor": name,
        "first": first,
        "first_ci95": [first + end for end in ends],
        "total": total,
        "total_ci95": [total + end for end in ends],
    }


def test_the_shares_of_the_factors():
    factors = [
        factor("weather", 0.1, 0.15),
        factor("road", 0.5, 0.6),
        factor("driver_pedals", -0.01, 0.02),
    ]
    ax = drawn(ocmc.plot.sensitivity({"column": "consumption_l_per_100km", "factors": factors}))
    assert [text.get_text() for text in ax.get_yticklabels()] == [
        "driver pedals",
        "weather",
        "road",
    ]
    assert ax.get_xlabel() == "share of the variance of consumption, %"
    widths = [
        [bar.get_width() for bar in bars] for bars in ax.containers if hasattr(bars, "patches")
    ]
    np.testing.assert_allclose(widths, [[2, 15, 60], [-1, 10, 50]])
    whiskers = ax.collections[0].get_segments()
    np.testing.assert_allclose(np.array(whiskers)[:, :, 0], [[-1, 6], [12, 19], [57, 64]])


def swept(values, mean, difference=None):
    point = {
        "values": values,
        "mean": mean,
        "ci95": [mean - 2.0, mean + 2.0],
        "difference": difference,
    }
    return point | {
        "difference_ci95": None if difference is None else [difference - 0.5, difference + 0.5]
    }


def test_a_sweep_of_numbers_has_a_line_for_each_value_of_the_second_key():
    keys = ["vehicle.curb_mass_kg", "vehicle.base"]
    points = [
        (8000, "a", 30.0, None),
        (8000, "b", 31.0, 1.0),
        (7000, "a", 28.0, -2.0),
        (7000, "b", 29.0, -1.0),
    ]
    points = [swept(dict(zip(keys, point[:2], strict=True)), *point[2:]) for point in points]
    answer = {"column": "consumption_l_per_100km", "keys": keys, "points": points}
    above, below = ocmc.plot.sweep(answer)
    drawn(above)
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["a", "b"]
    means = [
        (list(artists[0].get_xdata()), list(artists[0].get_ydata())) for artists in above.containers
    ]
    assert means == [([7000, 8000], [28, 30]), ([7000, 8000], [29, 31])]
    changes = [list(artists[0].get_ydata()) for artists in below.containers]
    np.testing.assert_equal(changes, [[-2, np.nan], [-1, 1]])
    whiskers = below.containers[1].lines[2][0].get_segments()
    np.testing.assert_allclose(np.array(whiskers)[:, :, 1], [[-1.5, -0.5], [0.5, 1.5]])
    assert (below.get_xlabel(), below.get_ylabel()) == (keys[0], "difference, L/100 km")
    with pytest.raises(ValueError, match="has 3 keys"):
        ocmc.plot.sweep(answer | {"keys": [*keys, "c"]})


def test_a_sweep_of_words_has_a_place_for_each():
    points = [
        swept({"k": word}, 30.0 + place) for place, word in enumerate(["x", None, {"law": 1}])
    ]
    base = swept({"k": None}, 33.0)
    answer = {"column": "consumption_l_per_100km", "keys": ["k"], "points": points, "base": base}
    above, below = ocmc.plot.sweep(answer)
    drawn(above)
    assert [text.get_text() for text in below.get_xticklabels()] == ["x", "as it is", "{'law': 1}"]
    np.testing.assert_array_equal(above.containers[0][0].get_ydata(), [30.0, 31.0, 32.0])
    assert above.get_legend() is None
    assert 33.0 in {artist.get_ydata()[0] for artist in above.lines}


def test_lines_of_the_axes_are_seen_on_a_dark_style(study):
    curve = [{"distance_m": 1e3 * k, "share": 1.0 - k / 10, "ci95": [0.5, 1.0]} for k in range(11)]
    with plt.style.context("dark_background"):
        ax = ocmc.plot.arrivals({"source": "mine", "curve": curve, "arriving": []})
        panels = ocmc.plot.trace(study.trace(3))
        shares = ocmc.plot.sensitivity(
            {"column": "duration_s", "factors": [factor("road", 0.5, 0.6)]}
        )
        fleet = ocmc.plot.trucks(study.set("mission.length_m", 3000.0).run(trucks=3, trips=2))
        quantiles = ocmc.plot.consumption(study.set("mission.length_m", 3000.0).run(cycles=20))
        assert matplotlib.colors.to_rgb(quantiles.lines[0].get_color()) == (1.0, 1.0, 1.0)
        assert matplotlib.colors.to_rgb(panels[3].lines[0].get_color()) == (1.0, 1.0, 1.0)
        assert matplotlib.colors.to_rgb(shares.lines[-1].get_color()) == (1.0, 1.0, 1.0)
        assert matplotlib.colors.to_rgb(line(fleet, "mean of the fleet").get_color()) == (
            1.0,
            1.0,
            1.0,
        )
        drawn(ax)
    assert all(float(tick).is_integer() for tick in fleet.get_xticks()), "trucks are counted"


def test_a_path_where_a_table_is_drawn_is_refused_by_name():
    with pytest.raises(TypeError, match=r"`.*simulator_curves.csv` is a path"):
        ocmc.plot.curve_fit(CURVES, {"fit": None})


def test_judged_numbers_have_a_bar_to_each_end():
    def entry(name, low, high):
        ends = [
            None if by is None else {"mean": {"by": by, "standard_error": None}}
            for by in (low, high)
        ]
        return {"name": name, "low": ends[0], "high": ends[1], "share": 0.5}

    numbers = [entry("payload", -3.0, 2.0), entry("road_sequence", None, 1.0)]
    ax = drawn(ocmc.plot.doubt({"column": "consumption_l_per_100km", "numbers": numbers}))
    assert [label.get_text() for label in ax.get_yticklabels()] == ["road sequence", "payload"]
    low, high = ax.containers
    assert low[1].get_width() == -3.0
    assert [bar.get_width() for bar in high] == [1.0, 2.0]


def test_the_items_of_a_cost():
    def study(name, items):
        listed = [{"item": item, "per_km": value} for item, value in items.items()]
        return {
            "study": name,
            "currency": "EUR",
            "items": listed,
            "total": {"per_km": sum(items.values())},
        }

    a = study("diesel", {"fuel": 0.4, "purchase": 0.3, "residual": -0.1})
    b = study("electric", {"depot_charging": 0.2, "purchase": 0.5, "residual": -0.2})
    ax = drawn(ocmc.plot.cost({"a": a, "b": b, "difference": {}}))
    assert [text.get_text() for text in ax.get_yticklabels()] == ["diesel", "electric"]
    bars = {
        str(bars.get_label()): [(bar.get_x(), bar.get_width()) for bar in bars]
        for bars in ax.containers
    }
    np.testing.assert_allclose(bars["fuel"], [(0.0, 0.4), (0.0, 0.0)])
    np.testing.assert_allclose(bars["depot charging"], [(0.7, 0.0), (0.5, 0.2)])
    np.testing.assert_allclose(bars["purchase"], [(0.4, 0.3), (0.0, 0.5)])
    np.testing.assert_allclose(bars["residual"], [(0.0, -0.1), (0.0, -0.2)])
    np.testing.assert_allclose([line.get_xdata()[0] for line in ax.lines[:2]], [0.6, 0.5])


def test_identified_gains_uphill_and_downhill():
    def fit(driver, grade, kp, lost=()):
        fitted = {"name": "kp", "interval": [0.9 * kp, 1.2 * kp]}
        gains = {"kp": kp, "ki": 0.1, "kd": None, "at_bound": list(lost)}
        return {"driver": driver, "grade": grade, "parameters": [fitted]} | gains

    fits = [
        fit("driver 10", 0.03, 5.0, ["kp"]),
        fit("driver 2", -0.03, 0.5),
        fit("driver 2", 0.03, 0.7),
    ]
    panels = ocmc.plot.identified({"fits": fits})
    drawn(panels[0])
    assert [text.get_text() for text in panels[-1].get_xticklabels()] == ["driver 2", "driver 10"]
    points = [a for a in panels[0].lines if a.get_marker() == "o"]
    found = {a.get_ydata()[0]: (a.get_xdata()[0], a.get_markerfacecolor()) for a in points}
    assert found.keys() == {5.0, 0.5, 0.7}
    assert found[5.0][1] == "none", "not identified"
    assert found[0.5][1] != found[0.7][1], "one is uphill, the other downhill"
    assert 0.0 < found[0.5][0] < 0.5
    assert -0.5 < found[0.7][0] < 0.0
    ends = [list(a.get_ydata()) for a in panels[0].lines if a.get_marker() != "o"]
    np.testing.assert_allclose(sorted(ends), [[0.45, 0.6], [0.63, 0.84], [4.5, 6.0]])
    printed = [text.get_text() for text in panels[0].get_legend().get_texts()]
    assert printed == ["uphill", "uphill, not identified", "downhill"]
    assert len(panels[1].lines) == 3
    assert len(panels[2].lines) == 0, "nobody has a K_D"
    with pytest.raises(ValueError, match="`ax` has 2 axes"):
        ocmc.plot.identified({"fits": fits}, ax=panels[:2])


def test_a_switched_controller_has_its_threshold():
    def fit(grade, kp, threshold_mps):
        gains = {"kp": kp, "ki": None, "kd": None, "threshold_mps": threshold_mps, "at_bound": []}
        return {"driver": "a", "grade": grade} | gains

    panels = ocmc.plot.identified({"fits": [fit(0.03, 0.7, 0.0), fit(-0.03, 0.5, 0.8)]})
    assert [panel.get_ylabel() for panel in panels] == ["$K_P$, s/m", "$e_{SW}$, m/s"]
    assert [panel.get_yscale() for panel in panels] == ["log", "linear"], "a threshold may be 0"
    thresholds = {a.get_ydata()[0] for a in drawn(panels[1]).lines if a.get_marker() == "o"}
    assert thresholds == {0.0, 0.8}


def test_the_share_that_arrives():
    curve = [
        {"distance_m": 0.0, "share": 1.0, "ci95": [0.9, 1.0]},
        {"distance_m": 1e5, "share": 0.5, "ci95": [0.4, 0.6]},
        {"distance_m": 2e5, "share": 0.0, "ci95": [0.0, 0.1]},
    ]
    arriving = [{"share": 0.95, "range_m": 6e4, "ci95_m": [5e4, 7e4]}]
    ax = drawn(ocmc.plot.arrivals({"source": "mine", "curve": curve, "arriving": arriving}))
    km, percent = ax.lines[0].get_data()
    assert (list(km), list(percent)) == ([0.0, 100.0, 200.0], [100.0, 50.0, 0.0])
    assert [text.get_text() for text in ax.texts] == ["95 %: 60 km"]
