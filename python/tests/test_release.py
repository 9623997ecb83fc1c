"""Parts of a release: links that work on a package index, one version, pinned actions."""

import re
import shutil
import struct
import subprocess
import sys
import tomllib
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HOME = "https://example.org/someone/ocmc"


def script(name):
    loader = SourceFileLoader(name.replace("-", "_"), str(ROOT / "scripts" / name))
    module = module_from_spec(spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


@pytest.fixture(scope="module", autouse=True)
def _no_bytecode():
    before, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    yield
    sys.dont_write_bytecode = before


def test_each_link_of_the_readme_works_on_a_package_index():
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    absolute = script("with-home").with_links(page, HOME, "v1", ROOT / "README.md")
    targets = re.findall(
        r"\]\(([^)\s]+)\)", re.sub(r"```.*?```|`[^`\n]*`", "", absolute, flags=re.DOTALL)
    )
    assert len(targets) > 10
    assert not [target for target in targets if not re.match(r"https?://|#", target)]
    assert f"{HOME}/blob/v1/docs/src/SUMMARY.md" in targets
    assert [target for target in targets if target.startswith(f"{HOME}/raw/v1/docs/images/")]


def test_code_and_links_elsewhere_stay_as_they_are():
    with_links = script("with-home").with_links
    page = ROOT / "README.md"
    for text in ["```\nx[0](a.md)\n```\n", "[a](https://example.org/b.md)", "[a](#below)"]:
        assert with_links(text, HOME, "v1", page) == text
    assert (
        with_links("[`a`](LICENSE-MIT)", HOME, "v1", page) == f"[`a`]({HOME}/blob/v1/LICENSE-MIT)"
    )
    picture = f"[![a]({HOME}/raw/v1/LICENSE-MIT)](https://example.org)"
    assert with_links("[![a](LICENSE-MIT)](https://example.org)", HOME, "v1", page) == picture
    inside = with_links("[a](../LICENSE-MIT#b)", HOME, "v1", ROOT / "python/README.md")
    assert inside == f"[a]({HOME}/blob/v1/LICENSE-MIT#b)"
    with pytest.raises(ValueError, match=r"links to lost.md, which is not there"):
        with_links("[a](lost.md)", HOME, "v1", page)


def test_the_package_gets_its_urls():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    before, after = (
        tomllib.loads(text),
        tomllib.loads(script("with-home").with_urls(text, HOME, "v1")),
    )
    assert after["project"].pop("urls")["Source"] == HOME
    assert after == before


def tree(folder, cargo="1.2.3", citation="1.2.3", title="1.2.3 - 2026-11-24", text="- a thing\n"):
    (folder / "Cargo.toml").write_text(f'[workspace.package]\nversion = "{cargo}"\n')
    (folder / "CITATION.cff").write_text(f"cff-version: 1.2.0\nversion: {citation}\n")
    (folder / "CHANGELOG.md").write_text(
        f"# C\n\n## Unreleased\n\n## {title}\n\n{text}\n## 1.2.2 - 2026-01-01\n\n- old\n"
    )
    return folder


def test_notes_of_a_release_are_its_section_of_the_changelog(tmp_path):
    notes = script("release-notes").notes
    assert notes("1.2.3", tree(tmp_path)) == "- a thing\n"
    for wrong, said in [
        ({"cargo": "1.2.4"}, "Cargo.toml has version 1.2.4, not 1.2.3"),
        ({"citation": "1.2.2"}, "CITATION.cff has version 1.2.2, not 1.2.3"),
        ({"title": "1.2.3"}, "CHANGELOG.md has no section"),
        ({"text": ""}, "CHANGELOG.md has no section"),
    ]:
        with pytest.raises(ValueError, match=said):
            notes("1.2.3", tree(tmp_path, **wrong))


def test_the_program_and_its_citation_have_one_version():
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.skipif(not shutil.which("cargo"), reason="cargo says what is used")
def test_the_bill_of_materials_has_what_is_shipped_and_nothing_of_the_tests():
    version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    bill = script("release-files").bill_of_materials(version)
    scopes = {component["name"]: component["scope"] for component in bill["components"]}
    for scope, some in {
        "required": ["ocmc-core", "parquet", "pyo3", "zstd-sys", "numpy"],
        "excluded": ["cc", "serde_derive"],
        "optional": ["matplotlib"],
    }.items():
        assert {scopes[name] for name in some} == {scope}
    assert not scopes.keys() & {"assert_cmd", "criterion", "proptest", "pytest", "windows-sys"}
    library = next(c for c in bill["components"] if c["name"] == "zstd-sys")
    assert library["hashes"]
    assert library["licenses"]
    assert "+" not in library["purl"]


def test_a_program_that_asks_for_a_library_is_not_static():
    module = script("release-files")
    segment = struct.pack("<IIQQQQQQ", module.DYNAMIC, 0, 120, 0, 0, 32, 32, 8)  # the one there is
    fields = struct.pack("<HHIQQQIHHHHHH", 3, 62, 1, 0, 64, 0, 0, 64, 56, 1, 0, 0, 0)
    header = b"\x7fELF\x02\x01".ljust(16, b"\0") + fields + segment
    static, dynamic = (header + struct.pack("<QQQQ", tag, 0, 0, 0) for tag in [0, module.NEEDED])
    module.check_machine_code(static, "x86_64", static=True)
    module.check_machine_code(dynamic, "x86_64")
    with pytest.raises(module.FailedError, match="is not static"):
        module.check_machine_code(dynamic, "x86_64", static=True)
    with pytest.raises(module.FailedError, match="no program for aarch64"):
        module.check_machine_code(static, "aarch64")
    with pytest.raises(module.FailedError, match="has the path"):
        module.check_machine_code(static + f"{ROOT}/a.rs".encode(), "x86_64")


def test_actions_of_others_are_pinned_to_a_commit():
    used = [
        line.partition("uses:")[2].strip()
        for path in sorted((ROOT / ".github/workflows").glob("*.yml"))
        for line in path.read_text().splitlines()
        if "uses:" in line
    ]
    assert len(used) > 10
    for action in used:
        pinned = re.fullmatch(r"(?!actions/)\S+@[0-9a-f]{40} # v\d+\.\d+\.\d+", action)
        assert pinned or re.fullmatch(r"actions/[\w-]+@v\d+|\./\S+\.yml", action), action


def test_scripts_say_how_they_are_called():
    for name in ["with-home", "release-notes"]:
        called = subprocess.run(
            [sys.executable, ROOT / "scripts" / name], capture_output=True, text=True, check=False
        )
        assert called.returncode == 2
        assert f"scripts/{name}" in called.stdout
