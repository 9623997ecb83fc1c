"""Go through a planner's afternoon on the page in Chromium; see ``scripts/check-page --help``."""

import argparse
import json
import os
import re
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from tab import LONGEST_S, Tab, chromium

ROOT = Path(__file__).resolve().parents[2]
EXPORT = ROOT / "docs" / "src" / "tutorial" / "export"
TRACKS = [EXPORT / "tracks" / f"2024-01-{name}.gpx" for name in ("04-023", "04-138", "06-161")]
WIDTHS = (1280, 390)
CHANGES = 200
MEASURED = 25
# what JavaScript may hold more behind so many changes, in bytes
MOST_GROWTH = 3_000_000
MOST_ELEMENTS = 200
# how soon a number is to stand after a change on a machine that does nothing else, in s; a median
# of so many times it, or one change of a second and a half, is a fault
SOON_S = 0.3
BUSY = 3.0
LATE_S = 1.5
# the same in a tab, whose engine is slower; a median of more, by the work that waits for a
# processor, is a fault
SOON_IN_TAB_S = 1.0
# lines of numbers that an answer has at least
FEWEST_LINES = 20

DONE = "document.getElementById('state').textContent.startsWith('All')"
COMPARED = "document.querySelectorAll('#compare table').length > 2"
AT_REST = "!document.querySelector('[aria-busy=true]')"
# the numbers of the page as the terminal prints them
TOTALS = """[...document.querySelectorAll('#totals > div')].map(card => {
    const [, number, half] = [card, card.querySelector('b'), card.querySelector('.soft')];
    const unit = number.textContent.replace(/^[\\d,.-]+ /, '');
    const name = card.firstChild.textContent;
    const width = half.textContent === '' ? '' : ' ' + half.textContent.replace(` ${unit}`, '');
    return name.padEnd(11) + ' ' + number.textContent.replace(` ${unit}`, '') + width + ' ' + unit;
})"""
# totals of the whole, of a fleet of groups
GROUPS = """[...document.querySelectorAll('#fleet tbody tr')].map(row => {
    const [name, unit] = row.cells[0].textContent.split(', ');
    return `${name} ${row.cells[1].textContent} ${unit}`.replaceAll('\\u00a0', ' ');
})"""
FLEET = """study = { base = "regional", name = "two kinds" }

[fleet]
trips_per_truck = 20

[[fleet.group]]
name = "diesel"
trucks = 4

[[fleet.group]]
name = "electric"
trucks = 3
vehicle = { base = "tractor-electric-40t" }
"""
ROWS = """[...document.querySelectorAll('#parts tbody tr, #tables tbody tr')]
    .map(row => [...row.cells].map(cell => cell.textContent).join(' '))"""
AXE = """axe.run().then(answer => answer.violations
    .filter(rule => ["serious", "critical"].includes(rule.impact))
    .map(rule => `${rule.id}: ${rule.help} (${rule.nodes.length}), `
        + rule.nodes[0].html.slice(0, 100)))"""
CONTROLS = """[...document.querySelectorAll(
    'a[href], button, input, select, textarea, summary, [tabindex="0"]')]
    .filter(e => !e.disabled && e.tabIndex >= 0 && e.checkVisibility({visibilityProperty: true}))"""
NAMED = (
    "e => e.id || e.getAttribute('aria-label') || e.textContent.trim().slice(0, 40) || e.tagName"
)
# Moves a slider and gives the time until the totals are other ones, in ms.
MOVE = """(value => new Promise((done, failed) => {
    const slider = document.querySelector('input[type="range"][aria-label^="Air drag"]');
    const begun = performance.now();
    const late = setTimeout(() => {
        seen.disconnect();
        failed(new Error('no number within 10 s'));
    }, 10000);
    const seen = new MutationObserver(() => {
        clearTimeout(late);
        seen.disconnect();
        done(performance.now() - begun);
    });
    seen.observe(document.getElementById('totals'), {childList: true});
    slider.value = value;
    slider.dispatchEvent(new Event('input', {bubbles: true}));
}))"""


class Served:
    """A program that serves the page, as a context manager."""

    def __init__(self, ocmc, folder):
        command = [ocmc, "page", "--no-open"]
        self._process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
        self.address = None
        for line in self._process.stdout:
            found = re.search(r"http://127\.0\.0\.1:\d+/\S*", line)
            if found:
                self.address = found.group()
                break
        if self.address is None:
            sys.exit("`ocmc page --no-open` has printed no address")

    def __enter__(self):
        """Give itself."""
        return self

    def __exit__(self, *_):
        """End the program."""
        self._process.terminate()
        self._process.wait()


class Quiet(SimpleHTTPRequestHandler):
    """Files of a folder, without a word."""

    def log_message(self, *_):
        """Say nothing."""


class Hosted:
    """A static host of the page with its engine for the tab, as a context manager."""

    def __init__(self, folder):
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder))
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()
        self.address = f"http://127.0.0.1:{self._server.server_port}/"

    def end(self):
        """Answer nobody any more."""
        self._server.shutdown()
        self._server.server_close()

    def __enter__(self):
        """Give itself."""
        return self

    def __exit__(self, *_):
        """End the host."""
        self.end()


class Check:
    """Findings of one pass over the page."""

    def __init__(self, tab, ocmc, options, folder):
        self.tab, self.ocmc, self.options, self.folder = tab, ocmc, options, folder
        self.width = None
        self.faults = []
        self.told = []

    def fault(self, words):
        """Keep what is wrong."""
        self.faults.append(words)
        print(f"{self.width} px: {words}", flush=True)

    def looks(self, step):
        """Look at the page as it stands: its width, axe, pictures."""
        for dark in (False, True):
            how = "dark" if dark else "light"
            self.tab.size(self.width, 900, dark=dark)
            over = self.tab.value(
                "document.documentElement.scrollWidth - document.documentElement.clientWidth"
            )
            if over > 0:
                self.fault(f"{step}: the page is {over} px wider than the screen")
            if self.options.axe:
                self.tab.value(self.options.axe.read_text(encoding="utf-8"))
                for rule in self.tab.value(AXE):
                    self.fault(f"{step}, {how}: axe {rule}")
            if self.options.pictures:
                self.options.pictures.mkdir(parents=True, exist_ok=True)
                path = self.options.pictures / f"{step}-{self.width}-{how}.png"
                self.tab.whole_picture(path, self.width, dark=dark)
        self.tab.size(self.width, 900)

    def opens(self, address):
        """Open the page without files and wait for its first numbers."""
        tab = self.tab
        tab.visit(address)
        first = tab.until("document.querySelector('#totals b')")
        self.told.append(f"first number {first:.2f} s after the page")
        # an engine in a tab takes several times as long
        tab.until(DONE, 3.0 * LONGEST_S)
        self.looks("1-opened")

    def afternoon(self, work):
        """Drop files, ask, save, compare, look at a trip."""
        tab = self.tab
        # the engine of the tab reads no workbooks
        given = TRACKS if self.options.tab else [*TRACKS, EXPORT / "trips.xlsx"]
        tab.give("#choose", given)
        tab.until(f"document.querySelectorAll('.file').length === {len(given)}")
        for reason in tab.value(
            "[...document.querySelectorAll('.file > .warning')].map(e => e.textContent)"
        ):
            self.fault(f"a file is not taken: {reason}")
        if tab.value("document.querySelectorAll('.file svg').length") < 2 * len(TRACKS):
            self.fault("a track has no sketch")
        self.settled()
        self.drops()
        self.looks("2-files")
        self.same_numbers(work)
        tab.click("#cost button")
        tab.until("document.querySelector('#cost table')")
        self.same_cost()
        tab.click("#electric")
        time.sleep(0.3)
        tab.until(f"{DONE} && {COMPARED}")
        if tab.value("document.getElementById('range-section').hidden"):
            self.fault("battery trucks are not asked how far they come")
        else:
            tab.click("#range-press button")
            tab.until("document.querySelector('#range p')")
        tab.click("#trip-form button[type=submit]")
        tab.until("document.querySelectorAll('#trip canvas').length > 2")
        self.settled()
        self.looks("3-compared")
        self.same_numbers(work / "electric")
        if self.width == WIDTHS[0] and not self.options.tab:
            self.other_files(work / "electric")
        self.fleet(work / "fleet")

    def drops(self):
        """Drop a file on the window, and take it away again."""
        tab = self.tab
        tab.value(
            """(() => {
                const data = new DataTransfer();
                data.items.add(new File(['no table'], 'note (1).txt'));
                const options = {bubbles: true, cancelable: true, dataTransfer: data};
                document.getElementById('drop').dispatchEvent(new DragEvent('drop', options));
            })()"""
        )
        card = "[...document.querySelectorAll('.file')].find(e => e.textContent.includes('note'))"
        tab.until(f"{card}?.querySelector(':scope > .warning')")
        tab.value(f"{card}.querySelector('.top button').click()")
        tab.until(f"!{card}")
        self.settled()

    def fleet(self, work):
        """Drive a fleet of groups as its file says, and take the file away."""
        tab = self.tab
        work.mkdir()
        (work / "groups.toml").write_text(FLEET, encoding="utf-8")
        tab.give("#choose", [work / "groups.toml"])
        card = (
            "[...document.querySelectorAll('.file')].find(e => "
            "e.textContent.includes('groups.toml'))"
        )
        buttons = f"[...({card})?.querySelectorAll('button') ?? []]"
        press = f"{buttons}.find(e => e.textContent.startsWith('Drive'))"
        tab.until(press)
        self.settled()
        tab.value(f"{press}.click()")
        tab.until("document.querySelector('#fleet table')")
        self.settled()
        self.looks("4-fleet")
        done = subprocess.run(
            [self.ocmc, "--study", "groups.toml"],
            cwd=work,
            capture_output=True,
            text=True,
            check=False,
        )
        printed = {" ".join(line.split()) for line in done.stdout.splitlines()}
        missing = [line for line in tab.value(GROUPS) if line not in printed]
        if missing:
            self.fault(f"totals of the fleet that the command does not print: {missing}")
        tab.value(f"{card}.querySelector('.top button').click()")
        tab.until(f"!{card} && document.getElementById('fleet-section').hidden")
        self.settled()

    def settled(self):
        """Wait until all is answered of what was asked last."""
        time.sleep(0.5)
        self.tab.until(f"{DONE} && {AT_REST}")

    def same_numbers(self, work):
        """Save the study, run the command beside it, and compare what both print."""
        tab = self.tab
        work.mkdir(parents=True)
        tab.keep_downloads(work)
        tab.click("#save-study")
        command = tab.value("document.getElementById('command').textContent")
        program, *arguments = shlex.split(command)
        study = work / arguments[arguments.index("--study") + 1]
        until = time.monotonic() + 20
        while not study.exists() and time.monotonic() < until:
            time.sleep(0.05)
        if not study.exists():
            self.fault("the study file does not come")
            return
        for track in TRACKS:
            shutil.copy(track, work)
        done = subprocess.run(
            [self.ocmc, *arguments], cwd=work, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            self.fault(f"{program} {shlex.join(arguments)}: {done.stderr.strip()}")
            return
        printed = {" ".join(line.split()) for line in done.stdout.splitlines()}
        tab.value("document.getElementById('all-trips').open = true")
        shown = [" ".join(line.split()) for line in tab.value(f"[...{TOTALS}, ...{ROWS}]")]
        missing = [line for line in shown if line not in printed]
        if missing or len(shown) < FEWEST_LINES:
            self.fault(
                f"{len(missing)} of {len(shown)} lines are not those of the command: {missing[:3]}"
            )
        self.told.append(f"{len(shown)} lines of numbers as of the command")

    def same_cost(self):
        """Compare the sum of the items with the total of the answer."""
        item = "[...document.querySelectorAll('#cost tbody tr')].at(-1).cells[1].textContent"
        total = "document.querySelector('[data-total=cost] b').textContent.split(' ')[0]"
        found, answered = self.tab.value(item), self.tab.value(total)
        if found != answered:
            self.fault(f"the items cost {found}, the fleet {answered}")

    def other_files(self, work):
        """Save the spreadsheet and the report, and look at how they begin."""
        for button, ending, begins in (("xlsx", "xlsx", b"PK"), ("report", "html", b"<!")):
            self.tab.click(f"#save-{button}")
            path = work / f"my-fleet.{ending}"
            until = time.monotonic() + LONGEST_S
            while not path.exists() and time.monotonic() < until:
                time.sleep(0.1)
            words = self.tab.value("document.getElementById('save-fault').textContent")
            if not path.exists():
                self.fault(f"the {button} does not come: {words}")
            elif not path.read_bytes().lstrip().lower().startswith(begins.lower()):
                self.fault(f"the {button} is none")

    def keys(self):
        """Reach every control by the Tab key alone, each with a visible focus."""
        tab = self.tab
        self.settled()
        tab.value("document.querySelectorAll('details').forEach(e => { e.open = false; })")
        tab.value("document.activeElement.blur(), scrollTo(0, 0), getSelection().removeAllRanges()")
        count = tab.value(f"window.toReach = {CONTROLS}, window.toReach.length")
        tab.value("window.reached = new Set(), window.unseen = []")
        # twice around, for the keys begin where the page was used last
        for _ in range(2 * count + 10):
            tab.key("Tab", "Tab", 9)
            reached = tab.value(
                """(() => {
                    const e = document.activeElement;
                    if (!e || e === document.body) return window.reached.size;
                    window.reached.add(e);
                    const style = getComputedStyle(e);
                    if (style.outlineStyle === 'none' && style.boxShadow === 'none')
                        window.unseen.push(e);
                    return window.reached.size;
                })()"""
            )
            if reached >= count:
                break
        for name in tab.value(f"window.toReach.filter(e => !window.reached.has(e)).map({NAMED})"):
            self.fault(f"Tab does not reach {name!r}")
        for name in tab.value(f"window.unseen.map({NAMED})"):
            self.fault(f"{name!r} does not show that it has the focus")
        self.told.append(f"{count} controls by Tab")

    def speed(self):
        """Measure how soon a slider moves the number."""
        times = []
        for k in range(MEASURED):
            times.append(self.tab.value(f"{MOVE}({-20 + k})") / 1000.0)
            time.sleep(0.4)
        median, longest = statistics.median(times), max(times)
        in_tab = self.options.tab
        aim = f"aim {SOON_IN_TAB_S if in_tab else SOON_S} s"
        self.told.append(
            f"number after a change: median {median:.2f} s, longest {longest:.2f} s, {aim}"
        )
        most, late = BUSY * SOON_S, LATE_S
        if in_tab:
            most = SOON_IN_TAB_S * max(1.0, os.getloadavg()[0] / os.cpu_count())
            late = 2.0 * most
        if median > most or longest > late:
            self.fault(
                f"the number comes {median:.2f} s after a change in the median, {longest:.2f} s at "
                "most"
            )

    def memory(self):
        """Measure what many changes leave behind."""

        def move(count):
            for k in range(count):
                self.tab.value(f"{MOVE}({-20 + k % 40})")

        move(30)
        self.settled()
        before, nodes = self.tab.heap(), self.tab.value("document.querySelectorAll('*').length")
        # each takes longer in a tab
        changes = CHANGES // 4 if self.options.tab else CHANGES
        move(changes)
        self.settled()
        growth = self.tab.heap() - before
        more = self.tab.value("document.querySelectorAll('*').length") - nodes
        self.told.append(f"{growth / 1e6:+.2f} MB and {more:+d} elements behind {changes} changes")
        if growth > MOST_GROWTH or more > MOST_ELEMENTS:
            self.fault(f"{changes} changes leave {growth / 1e6:.1f} MB and {more} elements")

    def calibrates(self):
        """Calibrate to the table of trips, and go on with that study."""
        tab = self.tab
        press = (
            "[...document.querySelectorAll('.file button')].find(e => "
            "e.textContent.startsWith('Calibrate'))"
        )
        tab.value(f"{press}.click()")
        took = tab.until(
            "[...document.querySelectorAll('option')].some(e => e.value.startsWith('calibrated-'))"
        )
        self.settled()
        if not tab.value("document.querySelector('#trucks select').value").startswith(
            "calibrated-"
        ):
            self.fault("the trucks do not start from the calibrated study")
        self.told.append(f"calibrated in {took:.0f} s")
        self.looks("5-calibrated")

    def refuses(self):
        """Show what the engine refuses, in its own words, and come back from it."""
        tab = self.tab
        tab.value(
            """(() => {
                const field = [...document.querySelectorAll('label')]
                    .find(e => e.textContent === 'Speed limiter').control;
                field.value = '1';
                field.dispatchEvent(new Event('input', {bubbles: true}));
            })()"""
        )
        tab.until("document.querySelector('#answer-fault .warning')")
        words = tab.value("document.getElementById('answer-fault').textContent")
        if "limiter_speed_mps" not in words:
            self.fault(f"the refusal does not name the key: {words}")
        tab.value("[...document.querySelectorAll('#trucks button')].at(-1).click()")
        self.settled()
        if tab.value("document.querySelector('#answer-fault .warning')"):
            self.fault("the refusal stays when its cause is gone")

    def offline(self, host):
        """End the host, load the page again, and ask."""
        tab = self.tab
        tab.until("navigator.serviceWorker.ready.then(ready => ready.active.state === 'activated')")
        # a page with files asks whether it may go
        away = "document.querySelector('.file .top button')"
        while tab.value(f"Boolean({away})"):
            count = tab.value("document.querySelectorAll('.file').length")
            tab.value(f"{away}.click()")
            tab.until(f"document.querySelectorAll('.file').length < {count}")
        host.end()
        tab.visit(f"{host.address}?again")
        first = tab.until("document.querySelector('#totals b')")
        tab.until(DONE)
        self.told.append(f"without a network first number {first:.2f} s after the page")

    def clean(self, address):
        """Look at what was logged, and whom the page asked."""
        for words in self.tab.logged:
            self.fault(f"console: {words}")
        own = re.match(r"https?://[^/]+", address).group()
        for asked in sorted(set(self.tab.asked)):
            if not asked.startswith((own, "data:", "blob:")):
                self.fault(f"the page asks {asked}")


def main():
    """Print each fault, and end with status 1 where there is one."""
    parser = argparse.ArgumentParser(
        prog="scripts/check-page",
        description="Goes through a planner's afternoon on the page of `ocmc page`, in Chromium at "
        f"{' and '.join(map(str, WIDTHS))} px: tracks and a table of trips, forty trucks, battery "
        "trucks "
        "instead, a trip, the saved study run by the command that the page shows, to the last "
        "digit.",
    )
    parser.add_argument("ocmc", help="the program")
    parser.add_argument("--axe", type=Path, help="axe.min.js of axe-core: its serious rules, too")
    parser.add_argument("--tab", type=Path, help="folder of scripts/build-tab: its engine answers")
    parser.add_argument(
        "--slow", action="store_true", help="calibrate to the table, too: half a minute"
    )
    parser.add_argument("--pictures", type=Path, help="where pictures of the whole page go")
    parser.add_argument("--json", type=Path, help="where what was measured goes")
    options = parser.parse_args()
    program = chromium()
    if program is None:
        print("skipped: no Chromium is installed")
        return
    ocmc = str(Path(options.ocmc).resolve())
    begun, faults, told = time.monotonic(), [], {}
    with tempfile.TemporaryDirectory(prefix="page-") as name:
        for width in WIDTHS:
            served = Hosted(options.tab) if options.tab else Served(ocmc, name)
            with served, Tab(program) as tab:
                tab.size(width, 900)
                check = Check(tab, ocmc, options, Path(name))
                check.width = width
                check.opens(served.address)
                check.afternoon(Path(name) / str(width))
                check.refuses()
                check.keys()
                if width == WIDTHS[0]:
                    check.speed()
                    check.memory()
                    if options.slow and not options.tab:
                        check.calibrates()
                check.clean(served.address)
                if options.tab:
                    check.offline(served)
                faults += check.faults
                told[width] = check.told
                print(f"{width} px: " + "; ".join(check.told), flush=True)
    if options.json:
        options.json.write_text(
            json.dumps({"faults": faults, "told": told}, indent=1), encoding="utf-8"
        )
    rules = "with axe" if options.axe else "axe skipped: --axe names no axe.min.js"
    print(f"page, {rules}: {len(faults)} faults, {time.monotonic() - begun:.0f} s")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
