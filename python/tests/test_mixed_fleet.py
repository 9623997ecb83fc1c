"""A fleet of groups of trucks."""

import ocmc
import pytest

FLEET = {
    "study": {"base": "field-truck", "name": "ours"},
    "mission": {"length_m": 5000.0},
    "cost": {"currency": "EUR", "fuel_per_l": 1.5, "charging_efficiency": 0.9},
    "fleet": {
        "trips_per_truck": 4,
        "group": [
            {"name": "diesel", "trucks": 5},
            {"name": "electric", "trucks": 2, "vehicle": {"base": "tractor-electric-40t"}},
        ],
    },
}


def test_groups_add_up(tmp_path):
    answer = ocmc.mixed_fleet(FLEET, seed=3, out=tmp_path / "fleet", format="csv", progress=False)
    assert answer["trucks"] == 7
    totals = {total["name"]: total for total in answer["totals"]}
    assert totals["cost"]["unit"] == "EUR"
    diesel, electric = answer["groups"]
    assert totals["fuel"]["total"] == pytest.approx(
        next(total["total"] for total in diesel["totals"] if total["name"] == "fuel")
    )
    # the run of a group is there, and says the same
    run = ocmc.load(tmp_path / "fleet" / "electric")
    own = run.summary()["trucks"]["fleet_year"]["distance_m"]["total"] / 1000
    found = next(total["total"] for total in electric["totals"] if total["name"] == "distance")
    assert found == pytest.approx(own, rel=1e-12)


def test_a_study_is_one_study():
    with pytest.raises(ValueError, match="fleet of groups"):
        ocmc.Study(FLEET)
    with pytest.raises(ValueError, match="no `"):
        ocmc.mixed_fleet("field-truck")


def test_the_cost_of_trucks():
    study = ocmc.Study({key: FLEET[key] for key in ("study", "mission", "cost")})
    answer = study.cost(trucks=5, trips=4, seed=3, progress=False)
    assert answer["fleet"]["trucks"] == 5
    assert answer["total"]["all_trips"] == pytest.approx(
        answer["fleet"]["cost"]["total"], rel=1e-12
    )
    with pytest.raises(ValueError, match="not both"):
        study.cost(cycles=5, trucks=2)
