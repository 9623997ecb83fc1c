"""Make a report of every kind and look at it in Chromium; see ``scripts/check-reports --help``."""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from browser import Browser, chromium

ROOT = Path(__file__).resolve().parents[2]
EXPORT = ROOT / "docs" / "src" / "tutorial" / "export"
WIDTHS = (1280, 390)
# A4 within margins of 10 mm
PAPER = 718
_FAULTS = Path(__file__).with_name("report.js").read_text(encoding="utf-8").strip()

PLANNER = """\
[study]
base = "regional"
name = "planner"
[fleet]
trips_per_truck = 30
[[fleet.group]]
name = "diesel"
trucks = 6
[[fleet.group]]
name = "electric"
study = "electric-regional"
trucks = 3
"""
# commands by the kind of the report: each writes KIND/report.html, or the run that `ocmc report`
# reads
COMMANDS = {
    "run": ["--cycles", 400],
    "one-cycle": ["--cycles", 1],
    "trucks": ["--study", "long-haul", "--trucks", 20, "--trips", 30],
    "charging": ["--study", "electric-regional", "--trucks", 8, "--trips", 30],
    "fuel-cell": ["--study", "fuel-cell-truck", "--cycles", 100],
    "compare-key": [
        "compare",
        "field-truck",
        "--set",
        "vehicle.drag_area_m2.median=4.5",
        "--cycles",
        200,
    ],
    "compare-studies": ["compare", "field-truck", "long-haul", "battery-truck", "--cycles", 200],
    "sensitivity": ["sensitivity", "--cycles", 100, "--shapley"],
    "doubt": ["doubt", "--cycles", 100],
    "doubt-against": ["doubt", "--against", "long-haul", "--cycles", 100],
    "validate": ["validate", EXPORT / "telematics-HL06.csv"],
    "benchmark": ["benchmark", EXPORT / "trips.xlsx", "--since", "2024-07-01", "--cycles", 800],
    "simulator-study": ["simulator-study", "--repetitions", 1],
}
SLOW = {"learn": ["learn", EXPORT, "--out", "learnt.toml", "--page", "learn.html", "--quiet"]}


def make(ocmc, folder, *, slow):
    """Yield the kind and the file of each report."""

    def run(*arguments):
        done = subprocess.run(
            [ocmc, *map(str, arguments)], cwd=folder, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            sys.exit(f"ocmc {' '.join(map(str, arguments))}: {done.stderr}")

    for kind, arguments in COMMANDS.items():
        run(*arguments, "--out", kind, "--quiet")
        if not (folder / kind / "report.html").exists():
            run("report", kind)
        yield kind, folder / kind / "report.html"
    (folder / "planner.toml").write_text(PLANNER, encoding="utf-8")
    run("--study", "planner.toml", "--out", "groups", "--quiet")
    yield "groups", folder / "groups" / "report.html"
    for group in sorted(path for path in (folder / "groups").iterdir() if path.is_dir()):
        run("report", group)
        yield f"group-{group.name}", group / "report.html"
    if slow:
        run(*SLOW["learn"])
        yield "learn", folder / "learn.html"


def faults(browser, path, axe):
    """Yield what is wrong with a report, at both widths, in both colours and on paper."""
    ways = [(width, how) for width in WIDTHS for how in ("light", "dark")]
    for width, how in [*ways, (PAPER, "print")]:
        browser.size(width, dark=how == "dark", media="print" if how == "print" else "")
        browser.open(path)
        for fault in browser.value(f"({_FAULTS})()"):
            yield f"{width} px, {how}: {fault}"
        if axe and how != "print":
            browser.value(axe)
            for rule in browser.value(_RULES):
                yield f"{width} px, {how}: axe {rule}"


_RULES = """axe.run().then(answer => answer.violations
    .filter(rule => ["serious", "critical"].includes(rule.impact))
    .map(rule => `${rule.id}: ${rule.help} (${rule.nodes.length}), `
        + rule.nodes[0].html.slice(0, 80)))"""


def main():
    """Print each fault, and end with status 1 where there is one."""
    parser = argparse.ArgumentParser(
        prog="scripts/check-reports",
        description="Makes a report of every kind and looks at it in Chromium, at "
        f"{' and '.join(map(str, WIDTHS))} px, light, dark and on paper: no text over "
        "another, nothing cut, bars as long as their numbers.",
    )
    parser.add_argument("ocmc", help="the program")
    parser.add_argument("--axe", type=Path, help="axe.min.js of axe-core: its serious rules, too")
    parser.add_argument(
        "--slow", action="store_true", help="the page of `ocmc learn`, too: a minute"
    )
    parser.add_argument("--pictures", type=Path, help="where pictures of the whole pages go")
    options = parser.parse_args()
    program = chromium()
    if program is None:
        print("skipped: no Chromium is installed")
        return
    begun, wrong = time.monotonic(), 0
    axe = options.axe.read_text(encoding="utf-8") if options.axe else None
    with tempfile.TemporaryDirectory(prefix="reports-") as name, Browser(program) as browser:
        ocmc = str(Path(options.ocmc).resolve())
        seen = 0
        for kind, path in make(ocmc, Path(name), slow=options.slow):
            seen += 1
            for fault in faults(browser, path, axe):
                wrong += 1
                print(f"{kind}: {fault}")
            if options.pictures:
                options.pictures.mkdir(parents=True, exist_ok=True)
                for width in WIDTHS:
                    browser.size(width)
                    browser.open(path)
                    browser.size(width, browser.value("document.documentElement.scrollHeight"))
                    browser.picture(options.pictures / f"{kind}-{width}.png")
    rules = "with axe" if axe else "axe skipped: --axe names no axe.min.js"
    print(f"{seen} reports, {rules}: {wrong} faults, {time.monotonic() - begun:.0f} s")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
