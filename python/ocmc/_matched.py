"""Rows of a route from what Valhalla says of a track that it has laid on its roads."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_EARTH_M = 6371008.8
_UNLIMITED_KMH = (
    130.0  # where the map says that there is no limit: that of the vehicle's class holds
)
_ONE_CROSSING_M = 40.0  # signals so close behind one another are those of one crossing (judgement)
_ACROSS_M = 200.0  # longest way that the map may lack between two of its roads (judgement)
_URBAN_KMH, _MOTORWAY_KMH = 55.0, 82.0  # as `ocmc drive` has them, where a file names no road types


def found(
    answer: Mapping[str, Any], signs: Mapping[int, str], fill_m: float, step_m: float
) -> tuple[dict[str, list[Any]], list[str]]:
    """Give columns and account of a route: `bridged` is for its altitudes, no column of a file."""
    shape, points = decoded(answer["shape"]), answer["matched_points"]
    edges = [e for e in answer["edges"] if e["end_shape_index"] > e["begin_shape_index"]]
    if not edges or bool((shape == shape[0]).all()):
        raise ValueError(
            "track: it has no way on the roads of the map; it needs two places along one"
        )
    ways = [
        _spread(shape[e["begin_shape_index"] : e["end_shape_index"] + 1], step_m) for e in edges
    ]
    across_m = sum(
        _checked_gap(before[-1], after[0], edge)
        for before, after, edge in zip([ways[0][:1], *ways], ways, edges, strict=False)
    )
    lengths_m = [_length_m(way) for way in ways]
    limits, account_of_limits = _limits([e.get("speed_limit") for e in edges], lengths_m, fill_m)
    types = [_road_type(edge, limit) for edge, limit in zip(edges, limits, strict=True)]
    objects, account_of_objects = _objects(edges, signs, lengths_m)
    rows: list[tuple[float, float, float | None, str, str, bool]] = []
    before, was_bridged = "", False
    for way, edge, limit, kind, after in zip(ways, edges, limits, types, objects, strict=True):
        bridged = bool(edge.get("bridge") or edge.get("tunnel"))
        for k, (lat, lon) in enumerate(way[:-1].round(7).tolist()):
            # the first point of a bridge is on the ground
            rows.append(
                (lat, lon, limit, kind, "" if k else before, bridged and (k > 0 or was_bridged))
            )
        before, was_bridged = after, bridged
    lat, lon = ways[-1][-1].round(7).tolist()
    rows.append((lat, lon, *rows[-1][2:4], "", False))
    names = ["lat", "lon", "speed_limit_kmh", "road_type", "map_object", "bridged"]
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    if None in limits:
        del columns["speed_limit_kmh"]
    if not any(objects):
        del columns["map_object"]
    shares = {
        kind: sum(m for m, t in zip(lengths_m, types, strict=True) if t == kind)
        for kind in set(types)
    }
    on = sum(point["type"] != "unmatched" for point in points)
    account = [
        (
            f"road: {_km(sum(lengths_m) + across_m)}, {_km(across_m)} of it straight where the "
            "map has no way"
        ),
        f"places: {on} of the track's {len(points)} are on it",
        "road types: "
        + ", ".join(f"{kind} {_km(share)}" for kind, share in sorted(shares.items())),
    ]
    return columns, [*account, account_of_limits, account_of_objects]


def _checked_gap(before: Floats, after: Floats, edge: Mapping[str, Any]) -> float:
    """Give the way between edges that need not meet, in m; refuse a long one, and a ferry."""
    gap_m = _length_m(np.array([before, after]))
    place = f"track, at {at(*before)}"
    if gap_m > _ACROSS_M:
        raise ValueError(
            f"{place}: the map has no way on to {at(*after)}, {gap_m:.0f} m away; allowed are "
            f"{_ACROSS_M:.0f} m. Cut the track there, or use an extract that has the road"
        )
    if edge.get("use") in ("ferry", "rail_ferry"):
        raise ValueError(f"{place}: a ferry, which no vehicle drives on; cut the track there")
    return gap_m


def _limits(
    given: Sequence[float | str | None], lengths_m: Sequence[float], fill_m: float
) -> tuple[list[float | None], str]:
    """Give the limit of each edge in km/h, and say what is missing.

    There is none in a gap too long to be filled.
    """
    limits = [
        None if v is None else _UNLIMITED_KMH if v == "unlimited" else float(v) for v in given
    ]
    gaps, before = [], None
    for missing, group in itertools.groupby(range(len(limits)), key=lambda k: given[k] is None):
        edges = list(group)
        if missing:
            gaps.append(sum(lengths_m[k] for k in edges))
            after = limits[edges[-1] + 1] if edges[-1] + 1 < len(limits) else None
            value = (after if before is None else before) if gaps[-1] <= fill_m else None
            for k in edges:
                limits[k] = value
        before = limits[edges[-1]] if not missing else before
    whole_m, lost_m = sum(lengths_m), sum(gaps)
    text = f"limits: the map has {_km(whole_m - lost_m)} of {_km(whole_m)}"
    if free_m := sum(m for m, limit in zip(lengths_m, given, strict=True) if limit == "unlimited"):
        text += f", {_km(free_m)} without any limit ({_UNLIMITED_KMH:.0f} km/h here)"
    if None in limits:
        text += (
            f"; left out, as the longest of {_count(len(gaps), 'gap')} has {_km(max(gaps))} "
            f"(fill_m={fill_m:g}): draw them (--draw limits), or raise fill_m"
        )
    elif gaps:
        text += f"; {_count(len(gaps), 'gap')}, the longest of {_km(max(gaps))}: the limit beside"
    return limits, text


def _road_type(edge: Mapping[str, Any], limit_kmh: float | None) -> str:
    """Give the road type: of the map's class, and where that leaves it open, of the limit."""
    kind = edge["road_class"]
    if kind == "motorway" or (kind == "trunk" and (limit_kmh or 0.0) >= _MOTORWAY_KMH):
        return "motorway"
    if kind in ("residential", "service_other") or (limit_kmh or _MOTORWAY_KMH) <= _URBAN_KMH:
        return "urban"
    return "rural"


def _objects(
    edges: Sequence[Mapping[str, Any]], signs: Mapping[int, str], lengths_m: Sequence[float]
) -> tuple[list[str], str]:
    """Give what stands at the end of each edge, and say how many there are."""
    objects, merged, since_m = [], 0, np.inf
    for edge, length_m in zip(edges, lengths_m, strict=True):
        word, since_m = signs.get(edge.get("id", -1), ""), since_m + length_m
        if edge.get("traffic_signal") or edge.get("end_node", {}).get("traffic_signal"):
            if since_m < _ONE_CROSSING_M:
                word, merged = "", merged + 1
            else:
                word, since_m = "traffic_light", 0.0
        objects.append("" if edge.get("target_percent_along", 1.0) < 1.0 else word)
    objects[-1] = ""  # where the track ends nothing is met
    counts = [
        f"{objects.count(word)} {word}" for word in ("traffic_light", "stop_sign", "give_way")
    ]
    return objects, f"objects: {', '.join(counts)}" + (
        f"; {_count(merged, 'light')} less than {_ONE_CROSSING_M:.0f} m behind one: of its crossing"
        if merged
        else ""
    )


def decoded(polyline: str) -> Floats:
    """Give latitudes and longitudes of a polyline of six decimals, one row a point."""
    numbers, number, shift = [], 0, 0
    for code in polyline.encode():
        number |= ((code - 63) & 31) << shift
        shift += 5
        if code < 63 + 32:
            numbers.append(~(number >> 1) if number & 1 else number >> 1)
            number, shift = 0, 0
    return np.cumsum(np.array(numbers, dtype=float).reshape(-1, 2), axis=0) / 1e6


def _spread(way: Floats, step_m: float) -> Floats:
    """Put points between those of a way, so that none is further than a step from the next."""
    pieces = [
        np.linspace(
            a, b, max(int(np.ceil(_length_m(np.array([a, b])) / step_m)), 1), endpoint=False
        )
        for a, b in itertools.pairwise(way)
    ]
    return np.concatenate([*pieces, way[-1:]])


def along_m(way: Floats) -> Floats:
    """Position of each point, in m."""
    step = np.diff(np.radians(way), axis=0)
    middle = np.cos(np.radians(way[1:, 0] + way[:-1, 0]) / 2)
    return np.concatenate([[0.0], np.cumsum(_EARTH_M * np.hypot(step[:, 0], step[:, 1] * middle))])


def _length_m(way: Floats) -> float:
    return float(along_m(way)[-1])


def _count(number: int, word: str) -> str:
    return f"{number} {word}" + "s" * (number != 1)


def _km(way_m: float) -> str:
    return f"{way_m / 1e3:.2f} km"


def at(lat: float, lon: float) -> str:
    """Write a place."""
    return f"{lat:.5f}, {lon:.5f}"
