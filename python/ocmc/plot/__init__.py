"""Pictures of runs, traces, fits and answers, with matplotlib (``pip install '.[plot]'``).

Each function draws into the axes that it is given or into new ones, and returns them. Axes carry
units; speeds are in km/h, as people read them.

Examples
--------
>>> import matplotlib
>>> matplotlib.use("agg")
>>> import ocmc
>>> run = ocmc.Study("field-truck").set("mission.length_m", 5000.0).run(cycles=100)
>>> ocmc.plot.consumption(run).get_xlabel()
'consumption, L/100 km'
"""

try:
    import matplotlib as mpl  # noqa: F401 (only to say what is missing)
except ModuleNotFoundError as _error:
    raise ModuleNotFoundError("ocmc.plot needs matplotlib: pip install '.[plot]'") from _error

from ocmc.plot._arrivals import arrivals
from ocmc.plot._charging import loads, seasons, state_of_charge
from ocmc.plot._comparison import comparison
from ocmc.plot._consumption import consumption
from ocmc.plot._cost import cost
from ocmc.plot._curve_fit import curve_fit, curve_fit_by_driver
from ocmc.plot._differences import differences
from ocmc.plot._doubt import doubt
from ocmc.plot._identified import identified
from ocmc.plot._sensitivity import sensitivity
from ocmc.plot._sweep import sweep
from ocmc.plot._trace import trace
from ocmc.plot._trucks import shares, trucks
from ocmc.plot._validation import validation

__all__ = [
    "arrivals",
    "comparison",
    "consumption",
    "cost",
    "curve_fit",
    "curve_fit_by_driver",
    "differences",
    "doubt",
    "identified",
    "loads",
    "seasons",
    "sensitivity",
    "shares",
    "state_of_charge",
    "sweep",
    "trace",
    "trucks",
    "validation",
]
