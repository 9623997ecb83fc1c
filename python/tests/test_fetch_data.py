"""`scripts/fetch-data` against a server on this machine, with files and a wheel made here."""

import bz2
import csv
import functools
import gzip
import hashlib
import http.server
import json
import os
import struct
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "scripts/data"))
import conversions  # noqa: E402

RAW = b"s,v\n0,1\n"
SPEED = b"1,2\n3,4\n"


def sha256(data):
    return hashlib.sha256(data).hexdigest()


class Handler(http.server.SimpleHTTPRequestHandler):
    def do_GET(self):
        self.server.asked.append(self.path)
        if self.server.busy:
            self.server.busy -= 1
            self.send_error(503)
            return
        super().do_GET()

    def log_message(self, *_):
        pass


@pytest.fixture
def server(tmp_path):
    folder = tmp_path / "served"
    files = folder / "someone/something/0123abc/a folder"
    files.mkdir(parents=True)
    (files / "raw.csv").write_bytes(RAW)
    (files / "speed.csv").write_bytes(SPEED)
    (files / "rambo.txt").write_text(
        "timestamp,angle,torque,speed\n2,0.12345678,1,3\n1,0,0.00004,2.5\n"
    )
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(Handler, directory=str(folder))
    )
    server.asked, server.busy, server.files = [], 0, files
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


UDACITY = b"t_unix_ns,steering_wheel_angle_rad,steering_torque_nm,speed_mps\n1.0,0.0,0.0,2.5\n"
UDACITY += b"2.0,0.123457,1.0,3.0\n"


def sources(tmp_path, *files, **wheel):
    path = tmp_path / "sources.toml"
    rows = [
        "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in file.items()) + "}"
        for file in files
    ]
    text = (
        '[[repository]]\nname = "Something"\nrepository = "someone/something"\ncommit = "0123abc"\n'
    )
    text += 'licence = "MIT"\nholder = "Someone"\nfiles = [' + ", ".join(rows) + "]\n"
    if wheel:
        text += (
            '[[package]]\nname = "Made"\nrequirement = "made==1"\nwheel_sha256 = '
            f'"{wheel["wheel"]}"\n'
        )
        text += 'licence = "MIT"\nholder = "Someone"\n'
        text += f'files = [{{to = "p/x.csv", from = "made/x.csv", sha256 = "{sha256(RAW)}"}}]\n'
    text += '[[by_hand]]\nto = "hand.json"\nfrom = "a book"\nhow = "typed"\n'
    path.write_text(text)
    return path


RAW_FILE = {"to": "a/raw.csv", "from": "a folder/raw.csv", "sha256": sha256(RAW)}
GZIP_FILE = {"to": "a/speed.csv.gz", "from": "a folder/speed.csv", "sha256": sha256(SPEED)}


def fetch(server, listed, folder, *options, env=None):
    raw = f"http://127.0.0.1:{server.server_address[1]}" if server else "http://127.0.0.1:1"
    command = [
        sys.executable,
        ROOT / "scripts/fetch-data",
        folder,
        "--sources",
        listed,
        "--raw",
        raw,
    ]
    command += ["--pause-s", "0.01", *options]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | (env or {})
    )


def test_files_arrive_whole_converted_and_compressed(server, tmp_path):
    rambo = (server.files / "rambo.txt").read_bytes()
    converted = {"to": "a/u.csv", "from": "a folder/rambo.txt", "sha256": sha256(rambo)}
    converted |= {"convert": "udacity", "content_sha256": sha256(UDACITY)}
    called = fetch(server, sources(tmp_path, RAW_FILE, GZIP_FILE, converted), tmp_path / "data")
    assert called.returncode == 0, called.stderr
    assert (tmp_path / "data/a/raw.csv").read_bytes() == RAW
    assert gzip.decompress((tmp_path / "data/a/speed.csv.gz").read_bytes()) == SPEED
    assert (tmp_path / "data/a/u.csv").read_bytes() == UDACITY
    assert "Something: MIT, (c) Someone" in called.stdout
    assert "made by hand, not fetched: hand.json (a book, typed)" in called.stdout
    assert "3 fetched, 0 were there, 0 could not be had" in called.stdout


def test_a_second_call_loads_only_what_is_missing(server, tmp_path):
    listed = sources(tmp_path, RAW_FILE, GZIP_FILE)
    assert fetch(server, listed, tmp_path / "data", "--only", "a/raw").returncode == 0
    assert len(server.asked) == 1
    (tmp_path / "data/a/speed.csv.gz.part").write_bytes(b"half")  # of a call that was killed
    called = fetch(server, listed, tmp_path / "data")
    assert called.returncode == 0, called.stderr
    assert "1 fetched, 1 were there" in called.stdout
    assert server.asked[1:] == ["/someone/something/0123abc/a%20folder/speed.csv"]
    assert not list(tmp_path.glob("data/**/*.part"))


def test_another_hash_is_refused_and_nothing_is_kept(server, tmp_path):
    wrong = RAW_FILE | {"sha256": sha256(b"another")}
    called = fetch(server, sources(tmp_path, wrong, GZIP_FILE), tmp_path / "data")
    assert called.returncode == 1
    assert f"its SHA-256 is {sha256(RAW)}, and {sha256(b'another')} was expected" in called.stderr
    assert not (tmp_path / "data/a/raw.csv").exists()
    assert (tmp_path / "data/a/speed.csv.gz").exists()  # the others are fetched all the same
    assert "1 fetched, 0 were there, 1 could not be had" in called.stdout


def test_another_result_of_a_conversion_is_refused(server, tmp_path):
    file = {
        "to": "u.csv",
        "from": "a folder/rambo.txt",
        "convert": "udacity",
        "content_sha256": sha256(b""),
    }
    called = fetch(server, sources(tmp_path, file), tmp_path / "data")
    assert called.returncode == 1
    assert f"u.csv: its SHA-256 is {sha256(UDACITY)}" in called.stderr


def test_a_file_that_its_origin_lacks_is_named(server, tmp_path):
    gone = RAW_FILE | {"from": "a folder/gone.csv"}
    called = fetch(server, sources(tmp_path, gone), tmp_path / "data")
    assert called.returncode == 1
    assert "a%20folder/gone.csv: HTTP Error 404" in called.stderr
    assert len(server.asked) == 1  # no second try of what is not there


def test_a_busy_server_is_asked_again(server, tmp_path):
    server.busy = 2
    called = fetch(server, sources(tmp_path, RAW_FILE), tmp_path / "data")
    assert called.returncode == 0, called.stderr
    assert len(server.asked) == 3


def test_a_file_of_ones_own_is_left_alone(server, tmp_path):
    own = tmp_path / "data/a/raw.csv"
    own.parent.mkdir(parents=True)
    own.write_bytes(b"mine")
    called = fetch(server, sources(tmp_path, RAW_FILE), tmp_path / "data")
    assert called.returncode == 1
    assert "other content than expected; delete it to fetch it" in called.stderr
    assert own.read_bytes() == b"mine"
    assert not server.asked


def test_without_a_network_it_says_so_once(tmp_path):
    called = fetch(None, sources(tmp_path, RAW_FILE, GZIP_FILE), tmp_path / "data")
    assert called.returncode == 1
    assert called.stderr.count("no connection") == 1
    assert "FAILED 2 files of Something: no connection to 127.0.0.1:1" in called.stderr


def made_wheel(folder):
    folder.mkdir()
    path = folder / "made-1-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        wheel.writestr("made/x.csv", RAW)
        wheel.writestr(
            "made-1.dist-info/METADATA", "Metadata-Version: 2.1\nName: made\nVersion: 1\n"
        )
        wheel.writestr(
            "made-1.dist-info/WHEEL",
            "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        )
        wheel.writestr("made-1.dist-info/RECORD", "")
    return sha256(path.read_bytes())


@pytest.mark.skipif(
    subprocess.run(
        [sys.executable, "-m", "pip", "--version"], capture_output=True, check=False
    ).returncode
    != 0,
    reason="this environment has no pip",
)
def test_files_of_a_package_come_from_its_wheel_of_that_hash(server, tmp_path):
    wheel = made_wheel(tmp_path / "wheels")
    offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(tmp_path / "wheels")}
    called = fetch(server, sources(tmp_path, wheel=wheel), tmp_path / "data", env=offline)
    assert called.returncode == 0, called.stderr
    assert (tmp_path / "data/p/x.csv").read_bytes() == RAW
    refused = fetch(server, sources(tmp_path, wheel="0" * 64), tmp_path / "other", env=offline)
    assert refused.returncode == 1
    assert "FAILED p/x.csv: made==1" in refused.stderr


def test_every_listed_file_has_its_hash_and_no_two_go_to_one_place():
    listed = subprocess.run(
        [sys.executable, ROOT / "scripts/fetch-data", "--list"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    files = [line.strip() for line in listed.splitlines() if line.startswith("  ")]
    assert len(files) > 200
    assert len(set(files)) == len(files)
    assert not [file for file in files if file.startswith("/") or ".." in file]


def r_text(text):
    return struct.pack(">ii", 9, len(text)) + text


def r_list(tag, value, rest):
    return struct.pack(">iii", 0x402, 1, 0)[:8] + r_text(tag) + value + rest


NIL = struct.pack(">i", 254)


def test_a_table_of_r_is_read():
    """Two columns as R writes them: numbers, one missing, and integers in the short form."""
    numbers = struct.pack(">ii3d", 14, 3, 1.5, float("nan"), -2.0)
    symbol = struct.pack(">i", 1) + r_text(b"compact_intseq")
    info = struct.pack(">i", 2) + symbol + NIL
    sequence = struct.pack(">i", 238) + info + struct.pack(">ii3d", 14, 3, 3.0, 7.0, 1.0) + NIL
    names = struct.pack(">ii", 16, 2) + r_text(b"x") + r_text(b"n")
    table = struct.pack(">ii", 0x200 | 19, 2) + numbers + sequence + r_list(b"names", names, NIL)
    head = b"RDX3\nX\n" + struct.pack(">iiii", 3, 0x40403, 0x30500, 5) + b"UTF-8"
    data = bz2.compress(head + r_list(b"t", table, NIL))
    read = conversions.r_data.table(data, "t")
    assert read["n"] == [7, 8, 9]
    assert read["x"][0] == 1.5
    assert read["x"][1] != read["x"][1]  # NaN
    with pytest.raises(ValueError, match="no R data file"):
        conversions.r_data.table(bz2.compress(b"PK"), "t")


def test_roads_of_a_map_are_its_main_ones_inside_the_extract():
    ways = "".join(
        f'<way id="{k}">{"".join(f"""<nd ref="{n}"/>""" for n in nodes)}<tag k="highway" '
        f'v="{kind}"/></way>'
        for k, (kind, nodes) in enumerate(
            [("motorway", (1, 9, 2)), ("motorway_link", (1, 2)), ("primary", (2,))]
        )
    )
    nodes = '<node id="1" lat="52.0" lon="9.5"/><node id="2" lat="52.1" lon="9.6"/>'
    rows = conversions.open_street_map(gzip.compress(f"<osm>{nodes}{ways}</osm>".encode()))
    rows = list(csv.DictReader(rows.decode().splitlines()))
    assert [(row["way_id"], row["seq"], row["node_id"]) for row in rows] == [
        ("0", "0", "1"),
        ("0", "1", "2"),
        ("2", "0", "2"),
    ]
    assert rows[1]["lat"] == "52.1"


@pytest.mark.skipif(os.name == "nt", reason="scripts/check is for bash")
def test_tests_that_compared_nothing_are_named(tmp_path):
    """Notes that tests leave, as `tests/it/others_data.rs` has them, and output of pytest."""
    check = [ROOT / "scripts/check", "--skipped"]
    notes = tmp_path / "tmp"
    notes.mkdir()
    environment = os.environ | {"CARGO_TARGET_DIR": str(tmp_path)}
    assert (
        subprocess.run(check, capture_output=True, text=True, check=True, env=environment).stdout
        == ""
    )
    lines = [
        "ocmc a::b\tno c in OCMC_DATA",
        "ocmc a::b\tno d in OCMC_DATA",
        "ocmc-core e\tno strace",
    ]
    (notes / "skipped-tests.txt").write_text("".join(line + "\n" for line in [*lines, lines[0]]))
    (notes / "pytest.txt").write_text("..s\nSKIPPED [1] a.py:3: no duckdb\n3 passed, 1 skipped\n")
    said = subprocess.run(check, capture_output=True, text=True, check=True, env=environment).stdout
    assert said.splitlines() == [
        "skipped: 2 Rust tests (counted as passed above) compared nothing or not all:",
        "    ocmc a::b: no c in OCMC_DATA",
        "    ocmc a::b: no d in OCMC_DATA",
        "    ocmc-core e: no strace",
        "    (scripts/fetch-data fetches the data of others)",
        "skipped in pytest:",
        "    [1] a.py:3: no duckdb",
    ]
