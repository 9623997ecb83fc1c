"""The command that the package installs is the native one."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import ocmc
import pytest

COMMAND = Path(sys.executable).with_name("ocmc")
SHORT = ["--set", "mission.length_m=5000"]


def command(*arguments):
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False)


def numbers(answer):
    """An answer without what was read, which has the names of files and tables."""
    return {key: value for key, value in answer.items() if key != "inputs"}


def test_the_command_gives_the_same_records(run, tmp_path):
    by_command, by_python = tmp_path / "command", tmp_path / "python"
    done = command(*SHORT, "--cycles", "300", "--quiet", "--out", by_command)
    assert done.returncode == 0, done.stderr
    run.save(by_python)
    for name in ["records.parquet", "manifest.json"]:
        assert (by_command / name).read_bytes() == (by_python / name).read_bytes(), name
    np.testing.assert_array_equal(ocmc.load(by_command)["fuel_kg"], run["fuel_kg"])


def test_the_command_gives_the_same_summary(run):
    answer = json.loads(command(*SHORT, "--cycles", "300", "--json").stdout)
    summary = run.summary()
    for key in ["wall_s", "threads", "ended_at"]:
        del answer[key], summary[key]
    assert answer == summary


def test_the_command_gives_the_same_text(run):
    text = command(*SHORT, "--cycles", "300", "--quiet").stdout.splitlines()
    printed = str(run.summary()).splitlines()
    assert len(text) > 20
    assert [line for line in text if "took" not in line] == [
        line for line in printed if "took" not in line
    ]


def test_the_command_gives_the_same_operating_cycle(study):
    text = command("cycle", *SHORT, "--cycle-id", "3", "--seed", "2").stdout.splitlines()[1:]
    rows = [
        (name, track["rule"], position, value)
        for name, track in study.operating_cycle(3, seed=2).items()
        for position, value in zip(track["position_m"], track["value"], strict=True)
    ]
    assert len(rows) > 50
    for line, (name, rule, position, value) in zip(text, rows, strict=True):
        their_name, their_rule, their_position, their_value = line.split(",")
        assert (their_name, their_rule, float(their_position)) == (name, rule, position)
        assert their_value == value if isinstance(value, str) else float(their_value) == value


@pytest.mark.parametrize(
    ("arguments", "status"),
    [(["--version"], 0), (["--study", "field-truk"], 1), (["--cycles", "0"], 2), (["\udcff"], 2)],
)
def test_exit_statuses(arguments, status):
    done = command(*arguments)
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    assert (done.stdout == "") == (status != 0)


def test_messages_are_those_of_the_exceptions():
    with pytest.raises(ValueError, match="did you mean") as caught:
        ocmc.Study("field-truck").set("driver.curve_sped.exponent", 0.5)
    text = command("--set", "driver.curve_sped.exponent=0.5").stderr
    assert text == f"error: {caught.value}\n"


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is a signal elsewhere")
def test_ctrl_c_ends_the_command_within_a_second(tmp_path):
    out = tmp_path / "run"
    arguments = [COMMAND, *SHORT, "--cycles", "1000000000", "--out", out, "--quiet"]
    with subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        while not (out / "chunks" / "00000000.parquet").exists():
            assert process.poll() is None
            time.sleep(0.05)
        time.sleep(1.0)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, text = process.communicate(timeout=30)
        elapsed = time.monotonic() - begin
    assert process.returncode == 128 + signal.SIGINT
    assert "interrupted" in text
    assert "Traceback" not in text
    assert elapsed < 1.5, "a second, and the end of the interpreter"
    assert len(ocmc.load(out)) > 0
