"""Wheel: built, installed into an empty environment, quick to import, with the command."""

import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MOST_IMPORT_S = 0.150
MOST_MEGABYTES = 10.0


def quiet(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{command}: {done.stdout[-2000:]}{done.stderr[-4000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    pytest.importorskip("maturin", reason="the wheel is built by maturin")
    out = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "maturin", "build", "--quiet", "--compression-level", "9"]
    quiet(*build, "--out", out, cwd=ROOT)
    (built,) = out.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """The interpreter of an environment that holds the wheel, numpy and nothing else."""
    home = tmp_path_factory.mktemp("empty")
    venv.create(home, with_pip=True)
    python = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if subprocess.run([*pip, "numpy"], check=False, capture_output=True).returncode != 0:
        pytest.skip("numpy, which the wheel needs, cannot be downloaded")
    quiet(*pip, wheel)
    return python


def test_one_wheel_for_all_pythons_from_3_11(wheel):
    assert "-cp311-abi3-" in wheel.name
    megabytes = wheel.stat().st_size / 1e6
    print(f"{wheel.name}: {megabytes:.1f} MB")
    assert megabytes < MOST_MEGABYTES
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {
        "ocmc/__init__.py",
        "ocmc/_ocmc.pyi",
        "ocmc/py.typed",
        "ocmc/plot/__init__.py",
        "ocmc/dask.py",
        "ocmc/map.py",
    } <= names
    assert not [name for name in names if "tests" in name or name.endswith(".toml")]


def test_the_wheel_says_what_it_is_and_has_its_licences(wheel):
    with zipfile.ZipFile(wheel) as files:
        (metadata,) = [name for name in files.namelist() if name.endswith(".dist-info/METADATA")]
        lines = files.read(metadata).decode().splitlines()
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"]:
        assert f"License-File: {licence}" in lines
    assert "Author: The ocmc authors" in lines
    assert "Classifier: Topic :: Scientific/Engineering" in lines


def test_an_empty_environment_needs_no_more_than_numpy(python):
    printed = quiet(
        python, "-m", "pip", "list", "--format", "freeze", "--disable-pip-version-check"
    )
    names = {line.partition("==")[0].lower() for line in printed.splitlines()}
    assert names - {"pip", "setuptools"} == {"numpy", "ocmc"}
    script = (
        "import ocmc; print(len(ocmc.Study('field-truck').set('mission.length_m', "
        "2000).run(cycles=50)))"
    )
    assert quiet(python, "-c", script, cwd=python.parent) == "50\n"
    for name in ["plot", "dask"]:
        script = (
            f"import ocmc\ntry:\n    ocmc.{name}\nexcept ModuleNotFoundError as error:\n    "
            "print(error)"
        )
        assert f"pip install '.[{name}]'" in quiet(python, "-c", script, cwd=python.parent)


def test_its_command_is_the_native_program(python):
    command = python.with_name("ocmc")
    assert quiet(command, "--version", cwd=python.parent).startswith("ocmc ")
    answer = quiet(
        command, "--cycles", "50", "--set", "mission.length_m=2000", "--quiet", cwd=python.parent
    )
    assert answer.startswith("study ")


def test_the_import_is_quick(python):
    script = (
        "import time; begin = time.perf_counter(); import ocmc; print(time.perf_counter() - begin)"
    )
    times = [float(quiet(python, "-c", script, cwd=python.parent)) for _ in range(7)]
    print(
        f"import ocmc: {min(times) * 1e3:.0f} ms at best, {sorted(times)[3] * 1e3:.0f} ms in the "
        "middle"
    )
    assert sorted(times)[3] < MOST_IMPORT_S
