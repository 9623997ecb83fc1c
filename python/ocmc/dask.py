"""Runs on a Dask cluster (``pip install '.[dask]'``): the same bytes as one run on one machine.

A run is cut into shards of consecutive cycles. A worker drives one shard on each of its threads, so
that together they use the threads that the worker was given. The shards of a worker that is lost
are driven again by others.
"""

import json
import shutil
import time
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any, overload
from uuid import uuid4

try:
    import distributed
except ModuleNotFoundError as _error:
    raise ModuleNotFoundError("ocmc.dask needs Dask: pip install '.[dask]'") from _error

from ocmc._ocmc import Run, Study, joined
from ocmc._progress import progress as progress_of

__all__ = ["run"]

_SHARDS_A_THREAD = 8  # so that the last shards do not keep the others waiting for long
_FEWEST_CYCLES, _MOST_CYCLES = 64, 8192  # of a shard, where nothing else is asked for
_RETRIES = 2


@overload
def run(
    study: Study,
    *,
    cycles: int,
    client: "distributed.Client | None" = None,
    seed: int = 1,
    first_cycle: int = 0,
    shard_cycles: int | None = None,
    out: None = None,
    progress: bool | Callable[[int, int], object] | None = None,
) -> Run: ...
@overload
def run(
    study: Study,
    *,
    cycles: int,
    client: "distributed.Client | None" = None,
    seed: int = 1,
    first_cycle: int = 0,
    shard_cycles: int | None = None,
    out: str | PathLike[str],
    progress: bool | Callable[[int, int], object] | None = None,
) -> list[Path]: ...
def run(  # noqa: PLR0913 (the arguments of `Study.run`, and the cluster's)
    study: Study,
    *,
    cycles: int,
    client: "distributed.Client | None" = None,
    seed: int = 1,
    first_cycle: int = 0,
    shard_cycles: int | None = None,
    out: str | PathLike[str] | None = None,
    progress: bool | Callable[[int, int], object] | None = None,
) -> Run | list[Path]:
    """Drive a range of cycles on a Dask cluster.

    Parameters
    ----------
    study : Study
        The study.
    cycles : int
        Number of cycles, at least 1.
    client : distributed.Client, optional
        The cluster's client; by default the one that is open.
    seed : int
        Master seed.
    first_cycle : int
        Id of the first cycle.
    shard_cycles : int, optional
        Cycles of a shard; by default enough shards to keep all threads busy. The records do not
        depend on it.
    out : str or os.PathLike, optional
        A folder that all workers and this program see. Each shard is written there as a run
        directory of its own, and nothing is sent here: for runs that do not fit into memory. Shards
        that are there already are kept.
    progress : bool or callable, optional
        As for `Study.run`.

    Returns
    -------
    Run or list of pathlib.Path
        The run; or, with `out`, the directories of its parts in the order of their cycle ids.

    Raises
    ------
    ValueError
        Where a number is out of its range, or where there is no client.
    OSError
        Where a part cannot be written, or where `out` holds a part of another run.

    Examples
    --------
    >>> import ocmc
    >>> from distributed import Client
    >>> study = ocmc.Study("field-truck").set("mission.length_m", 5000.0)
    >>> with Client(processes=False, n_workers=1, dashboard_address=None) as client:
    ...     run = ocmc.dask.run(study, cycles=200, client=client)
    >>> len(run)
    200
    """
    client = distributed.get_client() if client is None else client
    threads = max(1, sum(client.nthreads().values()))
    if shard_cycles is None:
        shard_cycles = min(
            max(cycles // (_SHARDS_A_THREAD * threads), _FEWEST_CYCLES), _MOST_CYCLES
        )
    for name, number in [("cycles", cycles), ("shard_cycles", shard_cycles)]:
        if number < 1:
            raise ValueError(f"`{name}` is {number}, allowed is a whole number from 1")
    # a shard holds whole trucks
    trips = study.to_dict().get("fleet", {}).get("trips_per_truck", 1)
    shard_cycles = -(-shard_cycles // trips) * trips
    begin = time.monotonic()
    # a task, not a value: what is lost with a worker is made again; with the ranges of judged
    # numbers
    make, arguments = study.__reduce__()
    model = client.submit(make, *arguments, pure=False)
    ranges = [
        (first, min(shard_cycles, first_cycle + cycles - first))
        for first in range(first_cycle, first_cycle + cycles, shard_cycles)
    ]
    retried = {"pure": False, "retries": _RETRIES}
    if out is not None:
        folder = str(Path(out).resolve())
        parts = [client.submit(_part, model, *place, seed, folder, **retried) for place in ranges]
        return [Path(part) for part in _gathered(client, parts, ranges, progress)]
    shards = [client.submit(_drive, model, *place, seed, **retried) for place in ranges]
    return joined(_gathered(client, shards, ranges, progress), time.monotonic() - begin, threads)


def _gathered(
    client: "distributed.Client",
    shards: "list[distributed.Future[Any]]",
    ranges: list[tuple[int, int]],
    progress: bool | Callable[[int, int], object] | None,  # noqa: FBT001
) -> list[Any]:
    """Take the results as they come, and put them into the order of their cycle ids."""
    places = {shard.key: k for k, shard in enumerate(shards)}
    results: list[Any] = [None] * len(shards)
    cycles, done = sum(n for _, n in ranges), 0
    bar = progress_of(progress, cycles)
    try:
        for shard in distributed.as_completed(shards):
            place = places[shard.key]
            results[place] = shard.result()
            shard.release()
            done += ranges[place][1]
            bar.reach(done)
    finally:
        bar.finish(done)
        if done < cycles:
            client.cancel(shards)
    return results


def _drive(study: Study, first_cycle: int, cycles: int, seed: int) -> Run:
    """Drive one shard on this thread of the worker."""
    return study.run(cycles=cycles, first_cycle=first_cycle, seed=seed, threads=1, progress=False)


def _part(study: Study, first_cycle: int, cycles: int, seed: int, out: str) -> str:
    """Drive one shard and keep it as a run directory, which is there as a whole or not at all."""
    part = Path(out) / f"part-{first_cycle:018}"
    wanted = {
        "study_hash": study.hash,
        "seed": seed,
        "first_cycle": first_cycle,
        "cycles": cycles,
        "status": "complete",
    }
    if not _holds(part, wanted):
        shard = _drive(study, first_cycle, cycles, seed)
        unfinished = part.with_name(f".{part.name}-{uuid4().hex}")
        try:
            shard.save(unfinished)
            unfinished.rename(part)
        except OSError:
            shutil.rmtree(unfinished, ignore_errors=True)
            if not _holds(part, wanted):  # another worker may have been quicker
                raise
    return str(part)


def _holds(part: Path, wanted: dict[str, object]) -> bool:
    """Whether the part is there already."""
    try:
        manifest = json.loads((part / "manifest.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return False
    other = {key: manifest.get(key) for key in wanted}
    if other != wanted:
        raise FileExistsError(f"`{part}` holds another run: {other}, wanted is {wanted}")
    return True
