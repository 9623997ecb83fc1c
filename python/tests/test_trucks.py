"""Trucks that make several trips: runs, their tables, their pictures."""

import numpy as np
import ocmc
import pyarrow as pa
import pytest


@pytest.fixture(scope="module")
def study():
    return ocmc.Study("field-truck").set("mission.length_m", 4000.0)


@pytest.fixture(scope="module")
def fleet(study):
    return study.run(trucks=12, trips=10, seed=3)


def test_trucks_and_trips_are_cycles(study, fleet):
    assert len(fleet) == 120
    assert (fleet["truck_id"] == np.repeat(np.arange(12), 10)).all()
    assert (fleet["trip"] == np.tile(np.arange(10), 12)).all()
    # a truck keeps its drag area and its driver
    assert len(np.unique(fleet["drag_area_m2"])) == len(np.unique(fleet["driver_effect"])) == 12
    # the first trip is that of a study without trucks
    alone = study.run(cycles=12, seed=3)
    assert (alone["fuel_kg"] == fleet["fuel_kg"][::10]).all()
    assert alone.trucks is None
    # set in the study, it is the same run
    same = study.set("fleet.trips_per_truck", 10).run(cycles=120, seed=3)
    assert (same["fuel_kg"] == fleet["fuel_kg"]).all()


def test_the_table_of_trucks_is_made_of_the_records(fleet):
    trucks = pa.table(fleet.trucks)
    assert trucks.num_rows == 12
    completed = np.asarray(fleet["outcome"]) == "completed"
    for row in trucks.to_pylist():
        own = (fleet["truck_id"] == row["truck_id"]) & completed
        assert row["n_trips"] == own.sum()
        assert row["fuel_kg"] == pytest.approx(fleet["fuel_kg"][own].sum(), rel=1e-12)
        litres = np.average(fleet["consumption_l_per_100km"][own], weights=fleet["distance_m"][own])
        assert row["consumption_l_per_100km"] == pytest.approx(litres, rel=1e-12)
        assert row["battery_energy_j"] is None


def test_the_summary_knows_trucks(fleet):
    trucks = fleet.summary()["trucks"]
    assert trucks["trucks"] == 12
    values = fleet.trucks["consumption_l_per_100km"]
    assert trucks["truck_years"]["consumption_l_per_100km"]["sd"] == pytest.approx(
        values.std(ddof=1)
    )
    total = trucks["fleet_year"]["fuel_l"]
    assert total["total"] == pytest.approx(fleet.trucks["fuel_l"].sum())
    low, high = total["prediction95"]
    # t of 11 degrees of freedom: 2.20099
    assert (high - low) / 2 == pytest.approx(
        2.20099 * fleet.trucks["fuel_l"].std(ddof=1) * np.sqrt(24), rel=1e-4
    )


def test_shares_over_trucks(study):
    nested = study.set("fleet.trips_per_truck", 10)
    trips = nested.sensitivity(cycles=400, factors=["driver", "mission"])
    trucks = nested.sensitivity(cycles=400, factors=["driver", "mission"], over="truck")
    assert (trips["over"], trips["rows"], trucks["over"], trucks["rows"]) == (
        "trip",
        400,
        "truck",
        40,
    )

    def driver(answer):
        return next(share["total"] for share in answer["factors"] if share["factor"] == "driver")

    # a driver stays, missions change: his part of a year is larger than of a trip
    assert driver(trucks) > driver(trips)


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        ({"cycles": 10, "trucks": 2}, "`cycles` or `trucks`"),
        ({"cycles": 7, "trips": 5}, "`cycles` is 7"),
        ({"trucks": 0}, "`trucks`"),
        ({"trucks": 2, "trips": 0}, "`trips`"),
    ],
)
def test_what_is_no_fleet_is_refused_by_name(study, arguments, wanted):
    with pytest.raises(ValueError, match=wanted):
        study.run(**arguments)


def test_a_run_has_a_number_of_something(study):
    with pytest.raises(TypeError, match="or give `trucks`"):
        study.run()


def test_pictures(fleet):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    ax = ocmc.plot.trucks(fleet)
    points = ax.lines[0].get_ydata()
    assert (np.diff(points) >= 0).all()
    assert sorted(fleet.trucks["consumption_l_per_100km"]) == pytest.approx(list(points))
    with pytest.raises(ValueError, match="a truck of its own"):
        ocmc.plot.trucks(ocmc.Study("field-truck").set("mission.length_m", 3000.0).run(cycles=3))


def test_shares_stand_beside_one_another():
    """Estimates of first-order shares may sum to more than the whole: nothing is stacked."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    road = {"factor": "road", "first": 0.7, "first_ci95": [0.6, 0.9]}
    driver, part = {"factor": "driver", "first": 0.52}, {"factor": "driver.pedals", "first": 0.1}
    ax = ocmc.plot.shares(
        {"trips": {"factors": [road, driver, part]}, "years": {"factors": [driver]}}
    )
    bars = [bar for bar in ax.patches if np.isfinite(bar.get_height())]
    assert [(bar.get_y(), bar.get_height()) for bar in bars] == [
        (0.0, 70.0),
        (0.0, 52.0),
        (0.0, 52.0),
    ]
    lefts = sorted(bar.get_x() for bar in bars)
    assert (np.diff(lefts) >= bars[0].get_width() - 1e-9).all(), "they do not cover one another"
    whisker = ax.collections[0].get_segments()[0]
    assert whisker[:, 1] == pytest.approx([60.0, 90.0])
    assert [label.get_text() for label in ax.get_xticklabels()] == ["road", "driver"]
