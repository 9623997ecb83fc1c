"""Monte Carlo simulation of the energy use of fleets of trucks over stochastic operating cycles.

A study describes the fleet: operating cycles, drivers, vehicles. A run drives many cycles of it and keeps one
record a cycle. SI units throughout, with the unit as a name's suffix.

Examples
--------
>>> import ocmc
>>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
>>> run = study.run(cycles=100, seed=1)
>>> run["consumption_l_per_100km"].shape
(100,)
>>> run.summary()["outcomes"]["completed"]
100
"""

import signal
import sys
from typing import NoReturn

from ocmc._ocmc import Run, Study, __version__, load, run_from
from ocmc._summary import Summary

__all__ = ["Run", "Study", "Summary", "__version__", "load"]


def _main() -> NoReturn:
    """Run the ``ocmc`` command: the same program as the native one."""
    # the command listens for Ctrl-C itself; Python would only note it until the command has ended
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_from(sys.argv))
