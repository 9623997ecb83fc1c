"""Examples in documentation run."""

import doctest
import re
from pathlib import Path

import ocmc
import pytest

README = Path(__file__).parents[2] / "README.md"

FOUND = [
    test
    for test in doctest.DocTestFinder(exclude_empty=False).find(ocmc, module=False, globs={})
    if not test.name.rpartition(".")[2].startswith("_")
]


@pytest.mark.parametrize("test", FOUND, ids=lambda test: test.name)
def test_examples_of_docstrings(test):
    assert test.docstring, "everything public is documented"
    told = []
    doctest.DocTestRunner().run(test, out=told.append)
    assert not told, "".join(told)


def test_examples_are_found():
    examples = {test.name for test in FOUND if test.examples}
    members = [
        "Study",
        "Study.set",
        "Study.run",
        "Study.operating_cycle",
        "Study.trace",
        "Run",
        "Run.summary",
        "Summary",
    ]
    assert examples == {"ocmc", *(f"ocmc.{member}" for member in members)}


def test_the_example_of_the_readme(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = re.findall(
        r"^```python\n(.*?)^```$", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    assert examples
    for example in examples:
        exec(compile(example, README, "exec"), {})  # noqa: S102 (our own)
