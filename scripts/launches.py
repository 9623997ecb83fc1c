#!/usr/bin/env python3
"""Measure launches from a standstill, and stops, in logs of speed.

    scripts/launches.py [LOG.csv ...]

Without a file it measures the trucks of `../shared/data` (or `OCMC_DATA`); with files, those, by
the same definition, so that traces of our own stand beside the logs. A file has columns of time and
of speed, and perhaps one of gears, 0 while none is engaged (names: `TIMES`, `SPEEDS`, `GEARS`).

A *launch* in a log at whole seconds (others are read there, linearly between their samples):

1. It begins at the last sample of a standstill, at most 0.5 km/h.
2. It lasts until the speed has fallen by more than 1 m/s below its highest so far, the truck stands
   or the log has a gap of more than 2 s. A gear change costs less than 1 m/s; who lifts for a queue
   loses more.
3. The time to a speed is that of its first crossing, between samples linearly; a launch that does
   not get there counts for the lower speeds only.
4. It is *free* as long as every 5 s bring at least 0.5 m/s: a full truck still gains that on a
   slope of 3 %, so what gains less is held by a limit, a bend or the traffic, not by its engine.
5. It is *sound* if no second changes the speed by more than 2.5 m/s: logs jump where their signal
   was lost. What is free is sound, too.

A *stop* is a launch read backwards: from a speed, last crossed, down to the first sample of the
standstill. The acceleration in a band of speeds is its width over the time from its first to its
second end. A *share* is that of VECTO's curve for trucks (Truck.vacc): the time from 0 to 50 km/h
by the curve over the launch's.
"""

import argparse
import csv
import gzip
import itertools
import math
import os
import pathlib
import statistics
from typing import NamedTuple

STANDING_MPS = 0.5 / 3.6
FALL_MPS = 1.0
GAP_S = 2.0
HELD_S, HELD_MPS = 5, 0.5
JUMP_MPS = 2.5
MANY = 100  # from which on a number is printed without decimals
SPEEDS_KMH = (20, 50, 80)
EDGES_KMH = range(0, 90, 10)
VECTO_50_S = 15.53  # Truck.vacc: 1 m/s² up to 25 km/h, then linearly down to 0.643 m/s² at 50 km/h

# columns by their names; speeds with the m/s of their unit
TIMES = ("time_s", "time [s]", "cycSecs", "time", "Time")
SPEEDS = {
    "speed_mps": 1.0,
    "cycMps": 1.0,
    "mps": 1.0,
    "v_act [km/h]": 1 / 3.6,
    "speed_kmh": 1 / 3.6,
}
GEARS = ("gear", "Gear [-]")

DATA = pathlib.Path(os.environ.get("OCMC_DATA", pathlib.Path(__file__).parents[2] / "shared/data"))
DECLARED = "vecto/results/declaration_40t/40t_Long_Haul_Truck_{}_Loading.vmod.gz"
LEVEL = "vecto/results/manoeuvres_40t/40t_Long_Haul_Truck_Cycle_Drive_stop_85_stop_85_level.vmod"
LOGS = {
    "T3CO regional haul": "cycles/t3co/regional_haul.csv.gz",
    "T3CO long haul": "cycles/t3co/long_haul_cyc.csv.gz",
    "FASTSim TSDC": "cycles/fastsim/TSDC_tripno_42648_cycle.csv",
    "VECTO level 33.9 t": LEVEL,
    "VECTO long 40.0 t": DECLARED.format("Long_Haul_Full"),
    "VECTO long 33.9 t": DECLARED.format("Long_Haul_Reference"),
    "VECTO region. 27.5 t": DECLARED.format("Regional_Delivery_Reference"),
    "VECTO region. 14.6 t": DECLARED.format("Regional_Delivery_Empty"),
}


class Log(NamedTuple):
    """Speed over time, with gears where they are known."""

    time_s: list[float]
    speed_mps: list[float]
    gear: list[int]


class Run(NamedTuple):
    """Samples of a launch, or of a stop backwards, and the last of them that is free."""

    log: Log
    free_end: int

    def time_to_s(self, kmh, *, free):
        """Time from the standstill to a speed, or None where it is not reached."""
        t, v = self.log.time_s, self.log.speed_mps
        for k in range(self.free_end if free else len(v) - 1):
            if v[k] < kmh / 3.6 <= v[k + 1]:
                return t[k] + (t[k + 1] - t[k]) * (kmh / 3.6 - v[k]) / (v[k + 1] - v[k]) - t[0]
        return None

    def band_mps2(self, low_kmh, high_kmh):
        """Mean acceleration between two speeds, or None where it is not free up to the second."""
        low_s = self.time_to_s(low_kmh, free=True) if low_kmh > 0 else 0.0
        high_s = self.time_to_s(high_kmh, free=True)
        return None if high_s is None else (high_kmh - low_kmh) / 3.6 / (high_s - low_s)

    def distance_m(self, until_s):
        """Distance driven in the first seconds."""
        t, v = self.log.time_s, self.log.speed_mps
        spans = (min(b, t[0] + until_s) - a for a, b in itertools.pairwise(t) if a < t[0] + until_s)
        return sum(
            span * (a + b) / 2 for span, (a, b) in zip(spans, itertools.pairwise(v), strict=False)
        )

    def shifts(self, until_s):
        """Gear changes in the first seconds, and samples without a gear since the first one."""
        t, gear = self.log.time_s, self.log.gear
        gears = [g for s, g in zip(t, gear, strict=True) if s <= t[0] + until_s]
        moving = list(itertools.dropwhile(lambda g: g == 0, gears))
        engaged = [g for g in moving if g > 0]
        return sum(a != b for a, b in itertools.pairwise(engaged)), moving.count(0)


def read(path):
    """Read the log of a file."""
    opened = gzip.open if path.suffix == ".gz" else open
    with opened(path, "rt", encoding="utf-8-sig", errors="replace") as file:
        head, *rows = csv.reader(file)
    table = dict(zip(head, zip(*rows, strict=True), strict=True))
    times = next(table[name] for name in TIMES if name in table)
    speeds, unit = next((table[name], unit) for name, unit in SPEEDS.items() if name in table)
    gears = next((table[name] for name in GEARS if name in table), ["0"] * len(times))
    return at_whole_seconds(
        Log(
            [float(t) for t in times],
            [unit * float(v) for v in speeds],
            [int(float(g or 0)) for g in gears],
        )
    )


def at_whole_seconds(log):
    """Take a log at whole seconds from its first sample, and from the first one after each gap."""
    t, v, gear = log
    out, k, at = Log([], [], []), 0, t[0]
    while at <= t[-1]:
        while k + 2 < len(t) and t[k + 1] <= at:
            k += 1
        step = t[k + 1] - t[k]
        if step > GAP_S and t[k] < at < t[k + 1]:
            at = t[k + 1]
            continue
        share = min(1.0, (at - t[k]) / step) if step > 0.0 else 0.0
        out.time_s.append(at)
        out.speed_mps.append(v[k] + share * (v[k + 1] - v[k]))
        out.gear.append(gear[k + (share == 1.0)])
        at += 1.0
    return out


def launches(log):
    """Find the launches of a log."""
    t, v, _ = log
    for begin, (here, ahead) in enumerate(itertools.pairwise(v)):
        if not here <= STANDING_MPS < ahead:
            continue
        end, least = begin, STANDING_MPS
        while end + 1 < len(v) and v[end + 1] > least and t[end + 1] - t[end] <= GAP_S:
            end += 1
            least = max(least, v[end] - FALL_MPS)
        driven = v[begin : end + 1]
        held = (k for k in range(len(driven) - HELD_S) if driven[k + HELD_S] - driven[k] < HELD_MPS)
        sound = all(abs(b - a) <= JUMP_MPS for a, b in itertools.pairwise(driven))
        yield Run(
            Log(*(column[begin : end + 1] for column in log)),
            next(held, end - begin) if sound else 0,
        )


def stops(log):
    """Find the stops of a log, each backwards."""
    return launches(Log([-t for t in reversed(log.time_s)], log.speed_mps[::-1], log.gear[::-1]))


def spread(values, digits=1):
    """Write the number of values, their median and their quartiles, 20 characters wide."""
    found = [value for value in values if value is not None]
    if not found:
        return f"{0:4}{'':16}"
    low, middle, high = (
        statistics.quantiles(found, method="inclusive") if len(found) > 1 else found * 3
    )
    least, most = (f"{value:.{digits if value < MANY else 0}f}" for value in (low, high))
    return f"{len(found):4}{middle:6.{digits}f} {f'{least}-{most}':9}"


def print_runs(kind, runs):
    """Print how long, and how hard, the launches or stops of each log accelerate."""
    for free in (False, True):
        print(f"\n{'free ' * free}{kind}: n, median and quartiles of the s between 0 and")
        print(" " * 20 + "".join(f"{kmh:6} km/h         " for kmh in SPEEDS_KMH).rstrip())
        for name, found in runs.items():
            times = ([run.time_to_s(kmh, free=free) for run in found] for kmh in SPEEDS_KMH)
            print(f"{name:20.20}" + "".join(map(spread, times)).rstrip())
    bands = list(itertools.pairwise(EDGES_KMH))
    print(f"\nfree {kind}: median m/s² in bands of km/h")
    print(" " * 20 + "".join(f"{f'{low}-{high}':>7}" for low, high in bands))
    for name, found in runs.items():
        columns = (
            [a for run in found if (a := run.band_mps2(*band)) is not None] for band in bands
        )
        print(
            f"{name:20.20}"
            + "".join(f"{statistics.median(c):7.2f}" if c else "      -" for c in columns)
        )


def print_launches(runs):
    """Print the shares of VECTO's curve, and the gears of the launches where a log has them."""
    print("\nfree launches to 50 km/h: share of VECTO's curve, and SD of its logarithm")
    for name, found in runs.items():
        shares = [VECTO_50_S / s for run in found if (s := run.time_to_s(50, free=True))]
        log_sd = statistics.stdev(map(math.log, shares)) if len(shares) > 1 else math.nan
        print(f"{name:20.20}{spread(shares, 2)} {log_sd:6.2f}")
    print("\nlaunches: gear changes, and s without a gear, to a speed")
    for name, found in runs.items():
        for kmh in SPEEDS_KMH:
            times = ((run, run.time_to_s(kmh, free=False)) for run in found if any(run.log.gear))
            counted = [run.shifts(s) for run, s in times if s is not None]
            if counted:
                row = "".join(spread(column, 0) for column in zip(*counted, strict=True))
                print(f"{name:20.20}{kmh:4} km/h{row}".rstrip())


def print_stops(runs):
    """Print the distances of the stops."""
    print("\nfree stops from 50 km/h: m")
    for name, found in runs.items():
        times = ((run, run.time_to_s(50, free=True)) for run in found)
        print(
            f"{name:20.20}"
            f"{spread([run.distance_m(s) for run, s in times if s is not None], 0)}".rstrip()
        )


def main():
    """Measure the files given, or the shared logs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("logs", nargs="*", type=pathlib.Path)
    logs = {path.stem: read(path) for path in parser.parse_args().logs}
    if not logs:
        logs = {name: read(DATA / path) for name, path in LOGS.items()}
    started = {name: list(launches(log)) for name, log in logs.items()}
    stopped = {name: list(stops(log)) for name, log in logs.items()}
    print_runs("launches", started)
    print_launches(started)
    print_runs("stops", stopped)
    print_stops(stopped)


if __name__ == "__main__":
    main()
