"""Words that a reader types into the guide's search, each with the page it has to find."""

import json
import shutil
import subprocess
from pathlib import Path

HITS = 3

# words of people who have not read the guide: a hit in any part of one of the pages will do
EXPECTED = {
    "gpx": ["how-to/given-cycle.html"],
    "excel": ["how-to/spreadsheet.html"],
    "results in excel": ["how-to/spreadsheet.html"],
    "install": ["install.html"],
    "my own truck": ["how-to/vehicle.html"],
    "fuel card": ["how-to/calibrate-totals.html"],
    "kilometres and litres": ["how-to/calibrate-totals.html"],
    "electric": ["how-to/range.html", "tutorial/electric.html"],
    "driver training": ["how-to/training.html"],
    "tyres": ["how-to/vehicle.html", "how-to/aerodynamics.html"],
    "what do better tyres save": ["how-to/aerodynamics.html"],
    "toll": ["how-to/cost.html"],
    "CO2": ["reference/study-cost.html"],
    "charging": ["theory/charging.html", "reference/study-charging.html"],
    "parquet": ["tutorial/records.html"],
    "winter": ["how-to/seasons.html"],
}


def faults(book, expected=EXPECTED):
    """Give the number of questions that were typed, and what is wrong, each as (page, sentence)."""
    node = shutil.which("node")
    if node is None:
        return 0, []
    script = Path(__file__).with_suffix(".js")
    answer = subprocess.run(
        [node, script, book, str(HITS), *expected], capture_output=True, text=True, check=True
    )
    found = []
    for (typed, pages), hits in zip(expected.items(), json.loads(answer.stdout), strict=True):
        if not {hit.partition("#")[0] for hit in hits} & set(pages):
            found.append(
                (book / pages[0], f"`{typed}` in the search finds {', '.join(hits) or 'nothing'}")
            )
    return len(expected), found
