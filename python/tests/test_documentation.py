"""Documentation: examples run, docstrings are whole, the guide's pages are up to date."""

import doctest
import inspect
import re
import runpy
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import ocmc
import pytest

matplotlib = pytest.importorskip("matplotlib")
pytest.importorskip("distributed")
validate = pytest.importorskip("numpydoc.validate")
matplotlib.use("agg")

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
INDEX_PAGE = ROOT / "python" / "README.md"  # that of a package index
REFERENCE = ROOT / "docs" / "src" / "reference"

# what a docstring need not have: sections that most have no use for, and rules of style that ruff
# looks after
UNNEEDED = {
    "ES01",
    "SA01",
    "GL01",
    "GL02",
    "GL03",
    "GL08",
    "SS05",
    "SS06",
    "PR06",
    "PR08",
    "PR09",
    "RT02",
    "RT03",
}
UNNEEDED |= {"RT04", "RT05", "YD01"}


def public():
    """Yield everything that a user can reach, by its name."""
    for name in ocmc.__all__:
        thing = getattr(ocmc, name)
        if name == "__version__":
            continue
        yield f"ocmc.{name}", thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    yield f"ocmc.{name}.{member}", value
    for module in [ocmc.plot, ocmc.dask, ocmc.map]:
        yield module.__name__, module
        for name in module.__all__:
            yield f"{module.__name__}.{name}", getattr(module, name)


PUBLIC = dict(public())
CALLABLE = [
    name for name, thing in PUBLIC.items() if callable(thing) and not name.endswith(".keys")
]


@pytest.fixture(autouse=True)
def close():
    yield
    matplotlib.pyplot.close("all")


@pytest.mark.parametrize("name", PUBLIC)
@pytest.mark.filterwarnings("ignore:Port:UserWarning")
def test_examples_of_docstrings(name):
    thing = PUBLIC[name]
    assert thing.__doc__, "everything public is documented"
    printed = []
    test = doctest.DocTestParser().get_doctest(inspect.cleandoc(thing.__doc__), {}, name, None, 0)
    doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS).run(test, out=printed.append)
    assert not printed, "".join(printed)


@pytest.mark.parametrize("name", CALLABLE)
def test_what_can_be_called_has_an_example(name):
    assert ">>> " in PUBLIC[name].__doc__


@pytest.mark.parametrize("name", CALLABLE)
def test_docstrings_name_arguments_and_results(name):
    found = validate.validate(name)["errors"]
    assert [error for error in found if error[0] not in UNNEEDED] == []


def test_the_pages_of_the_guide_are_made_of_the_docstrings():
    pages = runpy.run_path(str(ROOT / "scripts" / "python_reference.py"))["pages"]()
    paths = [REFERENCE / "python.md", *(REFERENCE / "python").iterdir()]
    written = {
        path.relative_to(REFERENCE).as_posix(): path.read_text(encoding="utf-8") for path in paths
    }
    assert written == pages, "run scripts/python_reference.py again"
    for name in PUBLIC:
        short = name.removeprefix("ocmc.")
        heading = re.compile(rf"^##+ `(ocmc\.)?{re.escape(short)}`$", re.MULTILINE)
        assert sum(len(heading.findall(page)) for page in pages.values()) == 1, name
        assert re.search(
            rf"^\| \[`(ocmc\.)?{re.escape(short)}`\]", pages["python.md"], re.MULTILINE
        ), name


def test_pictures_keep_their_columns_in_any_browser():
    # Chromium does not take xml:space from a group over to its texts
    found = []
    for picture in (ROOT / "docs" / "images").glob("*.svg"):
        texts = ET.parse(picture).iter("{http://www.w3.org/2000/svg}text")  # noqa: S314 (our own)
        columns = [text for text in texts if "  " in (text.text or "")]
        found += columns
        space = "{http://www.w3.org/XML/1998/namespace}space"
        assert [text.text for text in columns if text.get(space) != "preserve"] == []
    assert found, "a terminal's picture has columns"


def test_what_is_cited_is_this_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", citation, re.MULTILINE).group(1) == ocmc.__version__


@pytest.mark.parametrize("page", [README, INDEX_PAGE])
def test_the_example_of_the_readme(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = re.findall(
        r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    assert examples
    for example in examples:
        exec(compile(example, page, "exec"), {})  # noqa: S102 (our own)


def test_the_page_of_a_package_index_has_no_relative_links():
    targets = re.findall(r"\]\(([^)\s]+)\)", INDEX_PAGE.read_text(encoding="utf-8"))
    assert [target for target in targets if not target.startswith("https://")] == []


MARKDOWN = [
    page
    for page in sorted(ROOT.rglob("*.md"))
    if not {"target", "node_modules", ".venv", ".git"} & set(page.relative_to(ROOT).parts)
]
FILES = {
    path.relative_to(ROOT).as_posix()
    for folder in ["crates", "tests", "docs", "configs", "scripts", "benches", "examples", "python"]
    for path in (ROOT / folder).rglob("*")
}
# a name of a source file between backticks, with its folders or a part of them
SOURCE = re.compile(r"`((?:[\w-]+/)*[\w-]+\.(?:rs|py))`")


def prose(page):
    """Give the text of a page without its blocks of code."""
    return re.sub(
        r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )


def anchor(heading):
    """Make the anchor of a heading as mdBook and most hosts of Markdown do."""
    plain = re.sub(r"[`*]|\]\([^)]*\)|\[", "", heading).strip().lower()
    return re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain))


def test_links_of_the_pages_lead_somewhere():
    missing = []
    for page in MARKDOWN:
        for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
            if target.startswith(("http://", "https://", "mailto:")):
                continue
            path, _, place = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            ok = file.exists()
            if ok and place:
                headings = re.findall(r"^#+ (.+)$", prose(file), flags=re.MULTILINE)
                ok = place in map(anchor, headings)
            if not ok:
                missing.append(f"{page.relative_to(ROOT)}: {target}")
    assert not missing


def test_source_files_that_the_pages_name_are_there():
    missing = [
        f"{page.relative_to(ROOT)}: {name}"
        for page in MARKDOWN
        # the history names files as they were
        if page.name != "CHANGELOG.md"
        for name in SOURCE.findall(prose(page))
        if not any(f"/{file}".endswith(f"/{name}") for file in FILES)
    ]
    assert not missing


GUIDE = [README, INDEX_PAGE, *sorted((ROOT / "docs" / "src").rglob("*.md"))]


def commands(page):
    """Give the commands of a page, those between backticks and those of its blocks for a shell."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    lines = "\n".join(blocks).replace("\\\n", " ").split("\n") + re.findall(
        r"`(ocmc [^`]*)`", prose(page)
    )
    return [line.partition(" #")[0] for line in lines if line.startswith("ocmc ")]


def test_the_commands_of_the_pages_and_their_options_exist():
    used = {}
    for page in GUIDE:
        for command in commands(page):
            # values in quotes have no options
            bare = re.sub(r"'[^']*'", "", command)
            names = re.match(r"ocmc((?: (?:study|fit|calibrate))?(?: [a-z][a-z-]*)?)(?= |$)", bare)[
                1
            ].split()
            used.setdefault(" ".join(names), set()).update(re.findall(r"(?<= )--[a-z-]+", bare))
    assert len(used) > 20
    for names, options in used.items():
        program = [
            sys.executable,
            "-c",
            "import sys, ocmc; sys.exit(ocmc._main())",
            *names.split(),
            "--help",
        ]
        done = subprocess.run(program, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"ocmc {names}: {done.stderr}"
        assert options <= set(re.findall(r"--[a-z-]+", done.stdout)), f"ocmc {names}: {options}"
