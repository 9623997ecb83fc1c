"""`ocmc ask`: every message is of the schema, and answers are those of the commands."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

jsonschema = pytest.importorskip("jsonschema")

SCHEMA = Path(__file__).resolve().parents[2] / "docs" / "src" / "reference" / "ask.schema.json"
COMMAND = [Path(sys.executable).with_name("ocmc")]
FEW = {"cycles": 40, "seed": 3}
SHORT = "mission.length_m=6000"
STUDY = {"study": "field-truck", "set": [SHORT], "name": "mine"}
PRICED = [SHORT, "cost.currency=EUR", "cost.fuel_per_l=1.5"]
OPTIONS = ["--cycles", "40", "--seed", "3", "--set", SHORT]
# what an answer says of its time, and what names a study
OF_THE_MOMENT = {"wall_s", "ended_at", "threads", "study", "study_a", "study_b"}

QUESTIONS = [
    (
        {"ask": "run", "study": STUDY, "plan": FEW},
        ["--study", "field-truck", *OPTIONS],
    ),
    (
        {"ask": "compare", "studies": ["field-truck", "long-haul"], "plan": FEW},
        ["compare", "field-truck", "long-haul", *OPTIONS[:4]],
    ),
    (
        {"ask": "sweep", "study": STUDY, "points": ["vehicle.drag_area_m2=5,4"], "plan": FEW},
        ["sweep", *OPTIONS, "--set", "vehicle.drag_area_m2=5,4"],
    ),
    (
        {"ask": "sensitivity", "study": STUDY, "plan": FEW, "shapley": True, "factors": ["driver"]},
        ["sensitivity", *OPTIONS, "--shapley", "--factor", "driver"],
    ),
    ({"ask": "doubt", "study": STUDY, "plan": FEW}, ["doubt", *OPTIONS]),
    ({"ask": "range", "study": "battery-truck", "plan": FEW}, ["range", *OPTIONS[:4]]),
    (
        {"ask": "size", "study": "battery-truck", "arrive": [0.9], "plan": FEW},
        ["size", "--study", "battery-truck", *OPTIONS[:4], "--arrive", "90%"],
    ),
    (
        {"ask": "bound", "study": STUDY, "plan": {"cycles": 4}},
        ["bound", "--cycles", "4", "--set", SHORT],
    ),
    (
        {
            "ask": "cost",
            "study": {**STUDY, "set": [SHORT, "cost.currency=EUR", "cost.fuel_per_l=1.5"]},
            "plan": FEW,
        },
        ["cost", *OPTIONS, *(word for price in PRICED[1:] for word in ("--set", price))],
    ),
]


@pytest.fixture(scope="module")
def schema():
    if not SCHEMA.exists():
        pytest.skip("the guide is not here")
    return json.loads(SCHEMA.read_text(encoding="utf-8"))


def of_schema(schema, name):
    """A validator of one of the definitions."""
    whole = {"$ref": f"#/$defs/{name}", "$defs": schema["$defs"]}
    return jsonschema.Draft202012Validator(whole)


def asked(question, *options):
    text = question if isinstance(question, str) else json.dumps(question)
    done = subprocess.run(
        [*COMMAND, "ask", *options], input=text, capture_output=True, text=True, check=False
    )
    return done, [json.loads(line) for line in done.stdout.splitlines()]


def lasting(value):
    """A value without what is of the moment."""
    if isinstance(value, dict):
        return {key: lasting(below) for key, below in value.items() if key not in OF_THE_MOMENT}
    return [lasting(below) for below in value] if isinstance(value, list) else value


@pytest.mark.parametrize(("question", "arguments"), QUESTIONS, ids=lambda case: str(case)[:24])
def test_an_answer_is_that_of_the_command_and_of_the_schema(schema, question, arguments):
    of_schema(schema, "Ask").validate(question)
    done, messages = asked(question)
    assert done.returncode == 0, done.stderr
    for message in messages:
        of_schema(schema, "Message").validate(message)
    last = messages[-1]
    assert (last["message"], last["version"], last["of"]) == ("answer", 1, question["ask"])
    command = [*COMMAND, *arguments, "--json", "--quiet"]
    printed = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert lasting(last["answer"]) == lasting(printed)


def test_a_fleet_of_groups_is_a_run(schema):
    group = [
        {"name": "diesel", "trucks": 2},
        {"name": "electric", "trucks": 2, "study": "electric-regional"},
    ]
    keys = {
        "study": {"name": "mixed", "base": "regional"},
        "mission": {"length_m": 6000.0},
        "fleet": {"trips_per_truck": 3, "group": group},
    }
    done, messages = asked({"ask": "run", "study": {"study": keys}})
    assert done.returncode == 0, done.stderr
    of_schema(schema, "Message").validate(messages[-1])
    assert messages[-1]["of"] == "fleet"
    done, messages = asked({"ask": "run", "study": {"study": keys}, "plan": {"cycles": 5}})
    assert done.returncode == 1
    assert "fleet.group" in messages[-1]["reason"]


EXPORT = SCHEMA.parents[1] / "tutorial" / "export"


def answered(schema, question, folder):
    """The answer of a question that is asked in a folder."""
    of_schema(schema, "Ask").validate(question)
    done = subprocess.run(
        [*COMMAND, "ask"],
        input=json.dumps(question),
        capture_output=True,
        text=True,
        cwd=folder,
        check=True,
    )
    messages = [json.loads(line) for line in done.stdout.splitlines()]
    for message in messages:
        of_schema(schema, "Message").validate(message)
    assert messages[-1]["of"] == question["ask"]
    return messages[-1]["answer"]


def test_files_are_told_what_they_are(schema, tmp_path):
    (tmp_path / "odd.csv").write_text("a,b\n1,2\n")
    (tmp_path / "mine.toml").write_text('[study]\nname = "mine"\nbase = "regional"\n')
    (tmp_path / "wrong.toml").write_text('[study]\nname = "mine"\nbase = "regionall"\n')
    rows = [f"{90 * k},{k},50" for k in range(11)]
    (tmp_path / "route.csv").write_text("\n".join(["position_m,altitude_m,speed_limit_kmh", *rows]))
    (tmp_path / "trips.xlsx").write_bytes((EXPORT / "trips.xlsx").read_bytes())
    track = next(iter(sorted((EXPORT / "tracks").glob("*.gpx"))))
    (tmp_path / "track.gpx").write_bytes(track.read_bytes())
    files = {file["file"]: file for file in answered(schema, {"ask": "files"}, tmp_path)["files"]}
    kinds = {name: file["kind"] for name, file in files.items()}
    assert kinds == {
        "mine.toml": "study",
        "odd.csv": "unknown",
        "route.csv": "route",
        "track.gpx": "route",
        "trips.xlsx": "totals",
        "wrong.toml": "study",
    }
    assert {name for name, file in files.items() if file["reason"]} == {"odd.csv", "wrong.toml"}
    assert files["route.csv"]["route"]["draw"] == ["stops", "curves"]
    assert files["route.csv"]["length_m"] == pytest.approx(900)
    assert files["route.csv"]["profile"]["altitude_m"][-1] == pytest.approx(10)
    assert files["route.csv"]["map"] is None
    track = files["track.gpx"]
    assert set(track["route"]["draw"]) == {"stops", "limits"}
    assert 2 < len(track["map"]["latitude_deg"]) <= 400
    one = answered(schema, {"ask": "files", "files": ["track.gpx"]}, tmp_path)["files"]
    assert one == [track]


def test_a_study_is_told_with_its_text_and_its_differences(schema, tmp_path):
    keys = {"study": {"name": "mine", "base": "regional"}, "vehicle": {"curb_mass_kg": 14000.0}}
    question = {"ask": "study", "study": {"study": keys}, "against": "regional"}
    told = answered(schema, question, tmp_path)
    assert told["values"]["vehicle.curb_mass_kg"] == 14000
    assert told["values"]["mission.payload_kg"]["distribution"]
    assert "vehicle.curb_mass_kg" in [difference["key"] for difference in told["differences"]]
    (tmp_path / "mine.toml").write_text(told["toml"])
    again = answered(schema, {"ask": "study", "study": "mine.toml"}, tmp_path)
    assert again["values"] == told["values"]


def test_a_trip_is_that_of_trace(schema, tmp_path):
    short = {"study": "field-truck", "set": [SHORT]}
    trip = answered(schema, {"ask": "trip", "study": short, "cycle": 5, "seed": 3}, tmp_path)
    command = [
        *COMMAND,
        "trace",
        "--cycle-id",
        "5",
        "--seed",
        "3",
        "--set",
        SHORT,
        "--json",
        "--quiet",
    ]
    trace = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    assert trip["columns"].keys() == trace.keys()
    steps = len(trip["columns"]["time_s"])
    assert steps == min(2000, len(trace["time_s"]))
    assert trip["columns"]["position_m"][-1] == trace["position_m"][-1]
    assert sum(trip["columns"]["fuel_added_kg"]) == pytest.approx(sum(trace["fuel_added_kg"]))


@pytest.mark.parametrize(
    ("question", "words"),
    [
        ("", "no question"),
        ("[1]", "no question"),
        ('{"ask": "wonder"}', "unknown variant"),
        ({"ask": "run", "study": "field-truck", "cycle": 3}, "unknown field `cycle`"),
        ({"ask": "run", "study": "field-truk"}, "field-truck"),
        (
            {"ask": "run", "study": {"study": "field-truck", "set": ["vehicle.mass=1"]}},
            "vehicle.mass",
        ),
        ({"ask": "range", "study": "field-truck"}, "no battery"),
        ({"ask": "range", "study": "battery-truck", "plan": {"cycles": 0}}, "one cycle at least"),
        ({"ask": "compare", "studies": ["field-truck"]}, "two at least"),
        ({"ask": "run", "study": "field-truck", "precision": "much"}, "precision"),
    ],
)
def test_what_cannot_be_answered_is_refused_in_words(schema, question, words):
    done, messages = asked(question)
    assert done.returncode == 1
    assert len(messages) == 1
    of_schema(schema, "Message").validate(messages[0])
    assert messages[0]["message"] == "refused"
    assert words in messages[0]["reason"]
    assert words in done.stderr


def test_no_files_are_read_for_strangers(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text('[study]\nname = "own"\nbase = "field-truck"\n')
    question = {"ask": "run", "study": str(file), "plan": {"cycles": 3}}
    assert asked(question)[0].returncode == 0
    assert asked(question, "--no-files")[0].returncode == 1
    assert asked({"ask": "files"}, "--no-files")[0].returncode == 1
    assert asked({"ask": "files", "files": [str(file)]}, "--no-files")[0].returncode == 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_progress_is_told_and_a_signal_ends_the_work(schema):
    question = json.dumps({"ask": "run", "study": "field-truck", "plan": {"cycles": 1_000_000}})
    work = subprocess.Popen(
        [*COMMAND, "ask"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with work:
        work.stdin.write(question)
        work.stdin.close()
        first = json.loads(work.stdout.readline())
        assert first["message"] == "progress"
        assert first["total"] == 1_000_000
        work.send_signal(signal.SIGINT)
        begun = time.monotonic()
        rest = [json.loads(line) for line in work.stdout]
        assert work.wait() == 128 + signal.SIGINT
        assert time.monotonic() - begun < 20
    for message in [first, *rest]:
        of_schema(schema, "Message").validate(message)
    assert rest[-1]["message"] in {"interrupted", "progress"}
