"""Monte Carlo simulation of the energy use of fleets of trucks over stochastic operating cycles.

A study describes the fleet: operating cycles, drivers, vehicles. A run drives many cycles of it and
keeps one record a cycle. SI units throughout, with the unit as a name's suffix.

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

import importlib
import importlib.util
import signal
import sys
from types import ModuleType
from typing import TYPE_CHECKING, NoReturn

from ocmc._answer import Answer
from ocmc._ocmc import (
    OperatingCycle,
    Run,
    Study,
    Table,
    __version__,
    benchmark,
    calibrate_curve_speed,
    compare,
    detect_curves,
    fit_curve_speed,
    fit_fleet,
    fit_operating_cycle,
    fit_speed_change,
    fit_traffic,
    fit_weather,
    identify,
    learn,
    load,
    merge,
    mixed_fleet,
    road,
    run_from,
    simulator_study,
    studies,
    validate,
    vehicles,
)
from ocmc._summary import Summary

if TYPE_CHECKING:
    from ocmc import dask as dask
    from ocmc import map as map  # noqa: A004 (a part of this package)
    from ocmc import plot as plot

__all__ = [
    "Answer",
    "OperatingCycle",
    "Run",
    "Study",
    "Summary",
    "Table",
    "__version__",
    "benchmark",
    "calibrate_curve_speed",
    "compare",
    "detect_curves",
    "fit_curve_speed",
    "fit_fleet",
    "fit_operating_cycle",
    "fit_speed_change",
    "fit_traffic",
    "fit_weather",
    "identify",
    "learn",
    "load",
    "merge",
    "mixed_fleet",
    "road",
    "simulator_study",
    "studies",
    "validate",
    "vehicles",
]

# what each part cannot be imported without
_WITH_EXTRAS = {"dask": "distributed", "map": None, "plot": "matplotlib"}


def __getattr__(name: str) -> ModuleType:
    """Import the parts that need extras where they are first used."""
    if name in _WITH_EXTRAS:
        return importlib.import_module(f"ocmc.{name}")
    raise AttributeError(f"module 'ocmc' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List what is public, and can be imported here: ``help`` and ``inspect`` import all of it."""
    parts = _WITH_EXTRAS.items()
    return [
        *__all__,
        *(part for part, needs in parts if needs is None or importlib.util.find_spec(needs)),
    ]


def _main() -> NoReturn:
    """Run the ``ocmc`` command: the same program as the native one."""
    # the command listens for Ctrl-C itself; Python would only note it until the command has ended
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:  # as in the background of a script
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_from(sys.argv))
