"""Runs: columns, summaries, directories, threads and Ctrl-C."""

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import ocmc
import pytest


def test_columns_are_numpy_arrays(run):
    assert len(run) == 300
    assert len(run.columns) > 40
    for name in run.columns:
        column = run[name]
        assert isinstance(column, np.ndarray)
        assert column.shape == (300,)
        assert column.dtype.kind == {"outcome": "U", "cycle_id": "u"}.get(name, column.dtype.kind)
        assert column.dtype.kind in "fuU"
    assert run["cycle_id"].tolist() == list(range(300))
    assert set(run["outcome"]) <= {"completed", "stalled", "timed_out", "depleted"}
    assert run["distance_m"].dtype == np.float64
    assert (run["distance_m"] > 0).all()
    assert "300 cycles" in repr(run)


def test_what_a_truck_does_not_have_is_nan(run):
    assert np.isnan(run["battery_energy_j"]).all()
    assert np.isfinite(run["fuel_kg"]).all()


def test_arrays_are_the_callers_own(run):
    run["distance_m"][:] = 0
    assert (run["distance_m"] > 0).all()


def test_records_depend_on_neither_threads_nor_range(study, run):
    for other in [study.run(cycles=300, seed=1, threads=threads) for threads in (1, 3)]:
        for name in run.columns:
            np.testing.assert_array_equal(other[name], run[name])
    part = study.run(cycles=50, first_cycle=100)
    np.testing.assert_array_equal(part["fuel_kg"], run["fuel_kg"][100:150])
    assert (study.run(cycles=300, seed=2)["fuel_kg"] != run["fuel_kg"]).any()


def test_whole_numbers_of_numpy_are_whole_numbers(study):
    assert len(study.run(cycles=np.int32(20), seed=np.uint64(2**64 - 1))) == 20


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ({"cycles": 0}, "`cycles` is 0, allowed is a whole number from 1"),
        ({"cycles": -1}, "`cycles` is -1"),
        ({"cycles": 2**64}, "`cycles` is 18446744073709551616"),
        ({"cycles": 1, "seed": -1}, "`seed` is -1, allowed is a whole number from 0"),
        ({"cycles": 1, "threads": 0}, "`threads` is 0, allowed is a whole number from 1 to 1024"),
        ({"cycles": 1, "threads": 1025}, "`threads` is 1025"),
        ({"cycles": 2, "first_cycle": 2**64 - 1}, "`first_cycle` is 18446744073709551615"),
    ],
)
def test_wrong_numbers_are_value_errors(study, arguments, part):
    with pytest.raises(ValueError, match=part):
        study.run(**arguments)


@pytest.mark.parametrize("cycles", [1.5, "10", None, [1]])
def test_what_is_no_number_is_a_type_error(study, cycles):
    with pytest.raises(TypeError, match=r"`cycles` is .*, allowed is a whole number"):
        study.run(cycles=cycles)
    with pytest.raises(TypeError):
        study.run(10)


def test_the_last_cycle_ids_can_be_driven(study):
    end = 2**58 - 1
    last = study.run(cycles=2, first_cycle=end - 2)
    assert last["cycle_id"].tolist() == [end - 2, end - 1]
    assert study.trace(end - 1)["distance_added_m"].sum() == pytest.approx(
        last["distance_m"][1], rel=1e-12
    )
    with pytest.raises(ValueError, match="`first_cycle` is "):
        study.run(cycles=2, first_cycle=end - 1)
    with pytest.raises(ValueError, match="`cycle_id` is "):
        study.trace(end)


@pytest.mark.parametrize("name", ["fuel", "", 0, None, "\udc80", slice(3)])
def test_an_unknown_column_is_a_key_error(run, name):
    with pytest.raises(KeyError, match="no column"):
        run[name]


def test_the_summary_is_a_dictionary_that_prints(run):
    summary = run.summary()
    assert isinstance(summary, dict)
    assert summary["cycles"] == 300
    mean = summary["statistics"]["consumption_l_per_100km"]["mean"]
    litres, distance = run["consumption_l_per_100km"], run["distance_m"]
    assert mean == pytest.approx((litres * distance).sum() / distance.sum(), rel=1e-12)
    assert str(summary).startswith("study      field-truck\n")
    assert repr(summary) == str(summary)


def test_a_trace_sums_up_to_its_record(study, run):
    trace = study.trace(17)
    assert {trace[name].dtype.name for name in trace} == {"float64"}
    assert {len(trace[name]) for name in trace} == {len(trace)}
    assert trace["distance_added_m"].sum() == pytest.approx(run["distance_m"][17], rel=1e-12)
    assert (study.trace(17, seed=2)["time_s"][-1]) != trace["time_s"][-1]
    with pytest.raises(ValueError, match="`cycle_id` is -1"):
        study.trace(-1)


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_a_run_is_saved_and_loaded(run, tmp_path, form):
    path = tmp_path / "new" / "run"
    run.save(path, format=form)
    assert sorted(file.name for file in path.iterdir()) == [
        "checksums.sha256",
        "manifest.json",
        f"records.{form}",
        "summary.json",
    ]
    loaded = ocmc.load(path)
    assert loaded.columns == run.columns
    for name in run.columns:
        np.testing.assert_array_equal(loaded[name], run[name])
    assert loaded.summary() == run.summary() == json.loads((path / "summary.json").read_text())
    with pytest.raises(FileExistsError, match="already holds a run"):
        run.save(path)


def test_wrong_directories_are_os_errors(run, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileNotFoundError, match=r"manifest\.json"):
        ocmc.load(tmp_path / "absent")
    with pytest.raises(NotADirectoryError):
        run.save(tmp_path / "file")
    with pytest.raises(OSError, match="file"):
        run.save(tmp_path / "file" / "below")
    with pytest.raises(ValueError, match="parquet, csv"):
        run.save(tmp_path / "new", format="xlsx")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("name", ["manifest.json", "summary.json", "records.parquet"])
@pytest.mark.parametrize("content", [b"", b"{}", b"\xff\x00PAR1", b"PAR1" * 100])
def test_broken_files_are_errors_that_name_them(run, tmp_path, name, content):
    run.save(tmp_path / "run")
    (tmp_path / "run" / name).write_bytes(content)
    with pytest.raises((ValueError, OSError), match="run"):
        ocmc.load(tmp_path / "run")


def test_other_threads_go_on_during_a_run(study, other_threads_go_on):
    with other_threads_go_on():
        study.run(cycles=40_000, threads=1)


def test_runs_in_two_threads_at_once(study, run):
    results = []
    threads = [
        threading.Thread(target=lambda: results.append(study.run(cycles=300))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        np.testing.assert_array_equal(result["fuel_kg"], run["fuel_kg"])


LONG = """
import ocmc, sys
from ocmc import Study
SPEED = {{"time_s": [0.0, 40.0, 160.0], "speed_mps": [0.0, 20.0, 20.0]}}
print("started", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.exit(7)
"""


@pytest.mark.parametrize(
    "call",
    [
        "ocmc.Study('long-haul').run(cycles=10**12)",
        (
            "ocmc.identify(ocmc.Study('simulator-slopes').trace(0), "
            "ocmc.Study('simulator-slopes'), starts=4096)"
        ),
        "ocmc.Study('field-truck').drive(SPEED, cycles=10**12, follow_speed='exact')",
        "ocmc.Study('field-truck').sensitivity(cycles=10**9)",
        "ocmc.Study('field-truck').bound(cycles=100)",
        "ocmc.simulator_study(ocmc.Study('simulator-study'), repetitions=5000)",
        (
            "ocmc.calibrate_curve_speed(Study('field-truck-printed'), Study('field-truck'), "
            "drivers=2000)"
        ),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is a signal elsewhere")
def test_ctrl_c_ends_it_within_a_second(call):
    script = LONG.format(call=call)
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "started\n"
        time.sleep(1.0)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=60)
        elapsed = time.monotonic() - begin
    assert (rest, process.returncode) == ("interrupted\n", 7)
    assert elapsed < 1.5, "a second, and the end of the interpreter"


def test_the_stub_is_shipped():
    package = Path(ocmc.__file__).parent
    assert (package / "py.typed").exists()
    assert (package / "_ocmc.pyi").exists()
