"""Studies: where they come from, what differs, and what is refused."""

import copy
import pickle
import tomllib
from pathlib import Path
from types import MappingProxyType

import numpy as np
import ocmc
import pytest

EXPONENT = "driver.curve_speed.exponent"


def test_a_study_is_a_built_in_name_a_file_or_a_dictionary(study, tmp_path):
    path = tmp_path / "a study.toml"
    path.write_text(study.to_toml())
    same = [
        path,
        str(path),
        study.to_dict(),
        tomllib.loads(study.to_toml()),
        MappingProxyType(study.to_dict()),
    ]
    for source in same:
        assert ocmc.Study(source) == study
        assert ocmc.Study(source).hash == study.hash
    assert study.name == "field-truck"
    assert repr(study) == f'<ocmc.Study "field-truck", hash {study.hash[:8]}>'


def test_a_dictionary_may_say_only_what_differs(study):
    source = {"study": {"base": "field-truck"}, "mission": {"length_m": np.float32(5000)}}
    assert ocmc.Study(source) == study


def test_set_makes_another_study():
    study = ocmc.Study("field-truck")
    other = study.set(EXPONENT, 0.5)
    assert other != study
    assert other.to_dict()["driver"]["curve_speed"]["exponent"] == 0.5
    assert study == ocmc.Study("field-truck")
    assert len({study, other, study.set(EXPONENT, 0.5)}) == 2
    assert study != "field-truck"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("mission.length_m", 7000),
        ("mission.length_m", np.int64(7000)),
        ("mission.length_m", {"distribution": "uniform", "lower": 5e3, "upper": 7e3}),
        ("study.description", 'with "quotes", = and\na line end, å'),
        ("study.sources", ["one", "two"]),
        ("simulation.without", ("slope", "traffic")),
        ("driver.curve_speed.exponent", np.array(0.4)),
        ("driver.curve_speed.exponent", 1 / 3),
    ],
)
def test_values_of_any_kind_arrive_exactly(path, value):
    found = ocmc.Study("field-truck").set(path, value).to_dict()
    for key in path.split("."):
        found = found[key]
    if isinstance(value, dict):
        value |= {"distribution": "uniform"}
        assert {key: found[key] for key in value} == value
    else:
        assert found == (list(value) if isinstance(value, tuple) else value)


def test_a_vehicle_can_be_replaced(tmp_path):
    text = Path(__file__).parents[2].joinpath("configs/vehicles/tractor-40t.toml").read_text()
    lighter = tmp_path / "lighter.toml"
    lighter.write_text(text.replace("curb_mass_kg = ", "curb_mass_kg = 1000.0 # "))
    study = ocmc.Study("field-truck").set("vehicle.base", str(lighter))
    assert study.to_dict()["vehicle"]["curb_mass_kg"] == 1000.0


def test_studies_can_be_pickled_and_copied(study):
    for other in [pickle.loads(pickle.dumps(study)), copy.copy(study), copy.deepcopy(study)]:
        assert other == study
        assert other.set(EXPONENT, 0.5) == study.set(EXPONENT, 0.5)


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        (
            "driver.curve_speed.exponnt",
            0.5,
            ["`driver.curve_speed.exponnt`", "did you mean `exponent`"],
        ),
        (EXPONENT, 99, [EXPONENT, "99", "allowed is"]),
        (EXPONENT, "fast", [EXPONENT, "fast", "allowed is"]),
        (EXPONENT, float("nan"), [EXPONENT, "nan", "finite"]),
        (EXPONENT, 10**400, [EXPONENT, "finite"]),
        (EXPONENT, None, [EXPONENT, "None", "allowed is"]),
        (EXPONENT, object(), [EXPONENT, "object", "allowed is"]),
        (EXPONENT, b"0.5", [EXPONENT, "b'0.5'", "allowed is"]),
        ("", 1, ["dotted key"]),
        ("a=b", 1, ["`a`"]),
        ("a\n[b]\nc", 1, ["dotted key"]),
        ("x" * 10_000, 1, ["xxx"]),
        (EXPONENT, [[[]]], [EXPONENT]),
        (EXPONENT, "\udc80", []),
    ],
)
def test_a_wrong_setting_is_a_value_error_that_says_what_is_allowed(study, path, value, parts):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (the parts are checked)
        study.set(path, value)
    assert len(str(caught.value)) < 5000
    for part in parts:
        assert part in str(caught.value)


class Hostile(dict):
    """A mapping whose parts fail."""

    def items(self):
        raise RuntimeError("not today")

    def __repr__(self):
        raise RuntimeError("not shown")


class Unshowable:
    def __repr__(self):
        raise RuntimeError("not shown")


class Endless:
    def tolist(self):
        return Endless()


def endless():
    table = {}
    table["a"] = table["b"] = table
    return table


def deep():
    table = {}
    for _ in range(100_000):
        table = {"a": table}
    return table


def wide():
    items = [1]
    for _ in range(30):
        items = [items, items]
    return {"study": items}


@pytest.mark.parametrize(
    "source",
    [
        {},
        {"study": 3},
        {"study": None},
        {"mission": {3: 4}},
        {"mission": {"length_m": float("inf")}},
        {"mission": {"length_m": Unshowable()}},
        {"mission": {"length_m": Endless()}},
        {"study": {"base": 3}},
        {"study": {"base": "no-such-study"}},
        {"no": {"such": "table"}},
        {"\udc80": 1},
        endless(),
        deep(),
        wide(),
        "",
        "field-truk",
    ],
    ids=lambda source: type(source).__name__,
)
def test_a_wrong_source_is_a_value_error(source):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (any text, but a short one)
        ocmc.Study(source)
    assert 0 < len(str(caught.value)) < 5000


def test_the_message_names_what_was_probably_meant():
    with pytest.raises(ValueError, match="did you mean `field-truck`"):
        ocmc.Study("field-truk")


def test_what_a_source_itself_raises_is_raised():
    with pytest.raises(RuntimeError, match="not today"):
        ocmc.Study(Hostile(study=1))


@pytest.mark.parametrize("source", [3, None, ["field-truck"], b"\xff"])
def test_what_is_no_source_at_all_is_a_type_error(source):
    with pytest.raises(TypeError):
        ocmc.Study(source)


def test_files_that_cannot_be_read_are_os_errors(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"absent\.toml"):
        ocmc.Study(tmp_path / "absent.toml")
    with pytest.raises(IsADirectoryError):
        ocmc.Study(tmp_path)
    with pytest.raises(OSError, match="cannot read"):
        ocmc.Study("a\0b")


def test_a_wrong_file_is_a_value_error_with_line_and_column(study, tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(study.to_toml().replace("length_m = 5000", "length_m = -5000"))
    with pytest.raises(ValueError, match=r"study\.toml:\d+:\d+: `mission.length_m` is -5000"):
        ocmc.Study(path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match="UTF-8"):
        ocmc.Study(path)


@pytest.mark.filterwarnings("ignore::UserWarning")  # five roads do not tell everything
def test_the_birds_eye_view_of_its_roads(study):
    answer = study.birds_eye(cycles=5)
    assert (answer["cycles"], answer["study_hash"]) == (5, study.hash)
    view = answer["birds_eye"]
    assert view["hilliness"] == "predominantly_flat"
    assert sum(view["road_type_share"].values()) == pytest.approx(1.0)
    assert "predominantly flat" in str(answer)
    cycles = [study.operating_cycle(k) for k in range(5)]
    fitted = ocmc.fit_operating_cycle(cycles, base=study)["birds_eye"]
    assert fitted["curves_per_km"] == view["curves_per_km"]
    with pytest.raises(ValueError, match="cycles"):
        study.birds_eye(cycles=0)
    laws = study.birds_eye(laws=True)
    assert "cycles" not in laws
    assert laws["birds_eye"]["hilliness"] == view["hilliness"]
    with pytest.raises(ValueError, match="given routes"):
        ocmc.Study("simulator-study").birds_eye(laws=True)


def test_a_study_of_a_stranger_names_no_file(tmp_path):
    secret = tmp_path / "secret.toml"
    secret.write_text("not a study")
    for source in [
        str(secret),
        {"study": {"base": str(secret)}},
        {"study": {"base": "field-truck"}, "vehicle": {"base": str(secret)}},
        {
            "study": {"base": "field-truck"},
            "mission": {"routes": [{"file": str(secret), "weight": 1.0}]},
        },
    ]:
        with pytest.raises(ValueError, match="no file may be read here") as error:
            ocmc.Study(source, allow_files=False)
        assert "not a study" not in str(error.value)
    study = ocmc.Study({"study": {"base": "field-truck"}}, allow_files=False)
    for other in [study, pickle.loads(pickle.dumps(study))]:
        with pytest.raises(ValueError, match="no file may be read here"):
            other.set("mission.routes", [{"file": str(secret), "weight": 1.0}])
