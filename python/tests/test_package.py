"""The package itself: what it lists, and what importing it does not import."""

import importlib.util
import subprocess
import sys

import ocmc
import pytest

PARTS = {"dask": "distributed", "plot": "matplotlib"}


def printed(script):
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.parametrize(("part", "needed"), PARTS.items())
def test_help_works_without_the_extras(part, needed):
    """Both import all that the package lists: a part whose library is absent is not listed."""
    script = f"""
import sys
sys.modules[{needed!r}] = None
import inspect, ocmc, pydoc
print({part!r} in dict(inspect.getmembers(ocmc)), {part!r} in dir(ocmc))
print(len(pydoc.render_doc(ocmc)) > 10_000)
try:
    ocmc.{part}
except ModuleNotFoundError as error:
    print(error)
"""
    listed, documented, error = printed(script).splitlines()
    assert (listed, documented) == ("False False", "True")
    assert f"pip install '.[{part}]'" in error


def test_the_parts_are_listed_where_they_can_be_imported():
    installed = {part for part, needed in PARTS.items() if importlib.util.find_spec(needed)}
    assert set(dir(ocmc)) == {*ocmc.__all__, "map", *installed}


def test_importing_it_imports_no_library_of_tables():
    script = "import sys, ocmc; print(*sys.modules)"
    loaded = set(printed(script).split())
    assert "ocmc._ocmc" in loaded
    assert not loaded & {
        "pandas",
        "polars",
        "pyarrow",
        "duckdb",
        "dask",
        "distributed",
        "matplotlib",
    }
