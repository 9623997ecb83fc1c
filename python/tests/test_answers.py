"""Answers of the command that Python gives: precision, resume, out, merge, crossed, lists."""

import json
import pickle

import numpy as np
import ocmc
import pytest
from test_command import SHORT, command


def test_a_run_ends_at_a_precision_as_the_commands_does(study):
    run = study.run(precision="3%", cycles=20_000)
    printed = json.loads(command(*SHORT, "--precision", "3%", "--cycles", "20000", "--json").stdout)
    assert len(run) == printed["cycles"] < 20_000
    assert run.summary()["precision"] == printed["precision"]
    with pytest.raises(ValueError, match=r"type 0\.2%"):
        study.run(precision="0.2")


def test_a_run_is_written_while_it_is_driven_and_resumed(study, tmp_path):
    out = tmp_path / "run"

    def stop(done, _):
        if done >= 500:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        study.run(cycles=8_000, out=out, progress=stop)
    status = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    assert status["status"] == "interrupted"
    assert 0 < status["completed"] < 8_000
    with pytest.raises(FileExistsError):
        study.run(cycles=8_000, out=out)
    with pytest.raises(ValueError, match="seed"):
        study.run(out=out, resume=True, seed=9)
    with pytest.raises(ValueError, match="length_m"):
        study.set("mission.length_m", 6000.0).run(out=out, resume=True)
    run = study.run(cycles=8_000, out=out, resume=True)
    whole = study.run(cycles=8_000)
    np.testing.assert_array_equal(run["fuel_kg"], whole["fuel_kg"])
    assert run.summary()["ended_at"].endswith("Z")
    again = study.run(cycles=8_000, out=out, resume=True)
    np.testing.assert_array_equal(again["fuel_kg"], whole["fuel_kg"])


def test_out_is_the_directory_of_save(study, tmp_path):
    run = study.run(cycles=30, out=tmp_path / "a", format="csv")
    run.save(tmp_path / "b", format="csv")
    for name in ["records.csv", "manifest.json"]:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    assert (tmp_path / "a" / "summary.json").read_bytes() == (
        tmp_path / "b" / "summary.json"
    ).read_bytes()
    for wrong in [{"resume": True}, {"format": "csv"}]:
        with pytest.raises(ValueError, match="goes with `out`"):
            study.run(cycles=3, **wrong)


def test_a_workbook_is_that_of_the_command(study, tmp_path):
    run = study.run(cycles=30, out=tmp_path / "run")
    run.to_excel(tmp_path / "a.xlsx")
    command("report", str(tmp_path / "run"), "--xlsx", str(tmp_path / "b.xlsx"))
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()
    with pytest.raises(FileNotFoundError, match="none"):
        run.to_excel(tmp_path / "none" / "a.xlsx")


def test_parts_are_merged_to_the_run_of_one_machine(study, tmp_path):
    parts = [tmp_path / "first", tmp_path / "second"]
    study.run(cycles=20, out=parts[0])
    study.run(cycles=30, first_cycle=20, out=parts[1])
    merged = ocmc.merge(parts[::-1], out=tmp_path / "whole")
    whole = study.run(cycles=50)
    np.testing.assert_array_equal(merged["fuel_kg"], whole["fuel_kg"])
    with pytest.raises(ValueError, match="overlap"):
        ocmc.merge([parts[0], parts[0]], out=tmp_path / "twice")


def test_a_comparison_keeps_its_runs_and_has_a_page(study, tmp_path):
    loaded = study.set("study.name", "loaded").set("mission.payload_kg", 20_000.0)
    out = tmp_path / "compared"
    answer = ocmc.compare(study, loaded, cycles=60, out=out)
    a, b = ocmc.load(out / "a"), ocmc.load(out / "b")
    assert (a.study, b.study) == (study, loaded)
    assert json.loads((out / "comparison.json").read_text(encoding="utf-8")) == answer
    pairs = np.genfromtxt(out / "pairs.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(pairs["b"], b["consumption_l_per_100km"])
    np.testing.assert_allclose(pairs["b_less_a"], pairs["b"] - pairs["a"])
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "more than A" in page
    assert "Differences, pair by pair" in page
    assert ocmc.Study(out / "b.toml") == loaded
    with pytest.raises(FileExistsError, match="not empty"):
        ocmc.compare(study, loaded, cycles=2, out=out)


def test_judged_numbers_are_in_doubt_until_they_are_typed(study, tmp_path):
    answer = study.doubt(cycles=8, out=tmp_path / "d")
    names = [numbers["name"] for numbers in answer["numbers"]]
    assert "payload" in names
    assert sorted(file.name for file in (tmp_path / "d").iterdir()) == [
        "doubt.csv",
        "doubt.json",
        "report.html",
        "study.toml",
    ]
    typed = study.set("mission.payload_kg", 1000.0)
    assert "payload" not in [numbers["name"] for numbers in typed.doubt(cycles=8)["numbers"]]
    difference = study.doubt(cycles=8, against=study)
    assert difference["mean"] == difference["together"]["mean"] == 0.0
    with pytest.raises(ValueError, match="colum"):
        study.doubt(cycles=8, column="colour")


def test_a_sensitivity_analysis_keeps_its_design(study, tmp_path):
    answer = study.sensitivity(
        cycles=40, factors=["mission", "driver"], crossed=10, out=tmp_path / "s"
    )
    assert answer["two_way"]["drivers"] == 30
    design = np.genfromtxt(tmp_path / "s" / "design.csv", delimiter=",", names=True)
    assert design.dtype.names == ("cycle_id", "a", "b", "mission", "driver")
    both = np.concatenate([design["a"], design["b"]])
    assert np.isclose(both.mean(), answer["mean"])
    assert "would go with the mission" in (tmp_path / "s" / "report.html").read_text(
        encoding="utf-8"
    )
    assert ocmc.Study(tmp_path / "s" / "study.toml") == study
    with pytest.raises(ValueError, match="crossed"):
        study.sensitivity(cycles=40, crossed=1)


def test_what_is_built_in_is_listed():
    assert all(ocmc.Study(name).name == name for name in ocmc.studies())
    assert next(iter(ocmc.studies())) == "field-truck"
    listed = command("study", "vehicles").stdout.splitlines()
    assert [line.split()[0] for line in listed] == list(ocmc.vehicles())
    for name, said in (ocmc.studies() | ocmc.vehicles()).items():
        assert len(said) > 10, name


def test_values_are_attributes_and_can_be_completed(study):
    assert study.mission.length_m == study["mission.length_m"] == 5000.0
    assert (
        study.road.types.urban.mean_length_m
        == study.to_dict()["road"]["types"]["urban"]["mean_length_m"]
    )
    assert study.mission.payload_kg["distribution"] == "mixture"
    assert study.set("mission.payload_kg", study.mission.payload_kg) == study
    assert {"vehicle", "driver", "run"} <= set(dir(study))
    assert "drag_area_m2" in dir(study.vehicle)
    assert "drag_area_m2" in study.vehicle
    assert "vehicle.drag_area_m2" in study._ipython_key_completions_()
    assert callable(study.cost)
    assert study["simulation"].step_s == study.simulation.step_s
    assert pickle.loads(pickle.dumps(study.vehicle)) == study.vehicle
    with pytest.raises(AttributeError, match="did you mean 'drag_area_m2'"):
        _ = study.vehicle.drag_area
    with pytest.raises(AttributeError, match="vehicel"):
        _ = study.vehicel
    with pytest.raises(KeyError, match="did you mean 'length_m'"):
        study["mission.length"]
    with pytest.raises(AttributeError, match=r"study\.set\('vehicle\.drag_area_m2', 5\.0\)"):
        study.vehicle.drag_area_m2 = 5.0


def test_notebooks_show_values_and_complete_columns(study, run):
    html = study._repr_html_()
    assert "driver" in html
    assert "curve_speed.exponent" in html
    assert "5000" in html
    assert "drag_area_m2" in study.vehicle._repr_html_()
    assert run._ipython_key_completions_() == run.columns
    assert run.records._ipython_key_completions_() == run.columns
