"""The simulator study: the command's answer, and what is refused."""

import json

import ocmc
import pytest
from test_command import command


def test_the_answer_is_the_commands(tmp_path):
    study = ocmc.Study("simulator-study").set("simulation.step_s", 0.5)
    answer = ocmc.simulator_study(study, repetitions=2, seed=3, gains=False, out=tmp_path / "out")
    assert {curve["driver"] for curve in answer["curves"]} == set(range(1, 9))
    options = [
        "--repetitions",
        "2",
        "--seed",
        "3",
        "--no-gains",
        "--set",
        "simulation.step_s=0.5",
        "--json",
    ]
    printed = json.loads(command("simulator-study", *options).stdout)
    for key in ["wall_s", "threads"]:
        del printed[key], answer[key]
    assert answer == printed
    assert (tmp_path / "out" / "report.html").exists()
    with pytest.raises(FileExistsError, match="not empty"):
        ocmc.simulator_study(study, repetitions=1, gains=False, out=tmp_path / "out")
    with pytest.raises(ValueError, match="repetitions"):
        ocmc.simulator_study(study, repetitions=0)
    with pytest.raises(ValueError, match="speed_term"):
        ocmc.simulator_study(study, speed_term="both")
