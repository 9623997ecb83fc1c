"""Data of a map along a GPS track: limits, lights, signs, altitudes (``pip install '.[map]'``).

From files of yours alone, never from a web service: Valhalla's tiles, which
``valhalla_build_tiles`` makes of an OpenStreetMap extract, and rasters of altitudes. Valhalla's
wheel needs Python 3.12.

Examples
--------
>>> import ocmc
>>> track = {"lat": [60.1664, 60.1675], "lon": [24.9376, 24.9361]}
>>> found = ocmc.map.route(track, "valhalla.json")  # doctest: +SKIP
>>> found.write("route.csv")  # doctest: +SKIP
"""

import csv
import importlib
import itertools
import json
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ocmc._matched import Floats, along_m, at, decoded, found

__all__ = ["Route", "route"]

_STEP_M = 25.0  # between altitudes
_SIGNS_AT_ONCE = 500
_MOST = {
    "max_distance": 1e7,
    "max_shape": 1_000_000,
}  # of a track, in m and places: for services, less


@dataclass(frozen=True)
class Route:
    """A route by rows; `Study.drive` and ``ocmc drive`` read the file that `write` makes.

    Parameters
    ----------
    columns : dict of str to list
        One value a row: ``lat`` and ``lon`` in degrees, ``road_type``, and where they are known
        ``speed_limit_kmh``, ``map_object`` (empty where nothing stands) and ``altitude_m``.
    account : list of str
        What was found and what was not, a sentence each.

    Examples
    --------
    >>> import ocmc
    >>> ocmc.map.Route({"lat": [52.0, 52.01], "lon": [9.0, 9.0]}, ["1.1 km"]).account
    ['1.1 km']
    """

    columns: dict[str, list[Any]]
    account: list[str]

    def write(self, path: str | PathLike[str]) -> None:
        """Write the table as CSV, to a file that is replaced."""
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(self.columns)
            rows.writerows(zip(*self.columns.values(), strict=True))


def route(
    track: Any,  # noqa: ANN401 (whatever has columns)
    tiles: str | PathLike[str],
    *,
    elevation: Sequence[str | PathLike[str]] = (),
    fill_m: float = 500.0,
) -> Route:
    """Lay a GPS track on the roads of a map, and say what the map knows of them.

    Parameters
    ----------
    track : dict of str to sequence of float, or table
        Columns ``lat`` and ``lon`` in degrees (WGS 84). Rows are samples in the order of the drive,
        some 100 m apart at most.
    tiles : str or os.PathLike
        Valhalla's configuration (``valhalla.json``), which names the tiles.
    elevation : sequence of str or os.PathLike
        Rasters of altitudes in m (GeoTIFF, HGT and other files of GDAL's). The first that has a
        value counts. On bridges and in tunnels the altitude is straight between their ends.
    fill_m : float
        Longest stretch without a limit in the map, in m, that takes the limit before it, or at the
        start the one behind it. Where one is longer, the route has no column of limits: ``--draw
        limits`` draws them.

    Returns
    -------
    Route
        One row a point of the roads' geometry; with ``elevation``, at most 25 m apart.

    Raises
    ------
    ModuleNotFoundError
        Where the extra is not installed.
    ValueError
        Where a place is no place, or where the track leaves the map's roads for more than 200 m on
        the way or takes a ferry. Where rasters have no value or no coordinates, or where the
        configuration loads tiles from the web.
    OSError
        Where a file cannot be read.

    Warns
    -----
    UserWarning
        Where the limits are left out.

    Examples
    --------
    >>> import ocmc
    >>> track = {"lat": [60.1664, 60.1675], "lon": [24.9376, 24.9361]}
    >>> found = ocmc.map.route(track, "valhalla.json")  # doctest: +SKIP
    >>> found.write("route.csv")  # doctest: +SKIP
    """
    places = _places(track)
    actor = _actor(Path(tiles))
    shape = [{"lat": lat, "lon": lon} for lat, lon in places]
    try:
        answer = actor.trace_attributes(
            {"shape": shape, "costing": "auto", "shape_match": "map_snap"}
        )
    except RuntimeError as error:
        raise ValueError(
            f"track from {at(*places[0])} to {at(*places[-1])}: no way on the roads of {tiles} "
            f"({error}); "
            "its tiles have to cover the track"
        ) from error
    columns, account = found(
        answer, _signs(actor, answer), fill_m, _STEP_M if elevation else np.inf
    )
    bridged = columns.pop("bridged")
    if elevation:
        way = np.array([columns["lat"], columns["lon"]]).T
        columns["altitude_m"] = _altitudes(elevation, way, bridged)
    if "speed_limit_kmh" not in columns:
        warnings.warn("; ".join(text for text in account if "fill_m" in text), stacklevel=2)
    return Route(columns, account)


def _places(track: Any) -> list[tuple[float, float]]:  # noqa: ANN401
    """Check a track."""
    try:
        lat, lon = (np.asarray(track[name], dtype=float) for name in ("lat", "lon"))
    except KeyError as error:
        raise ValueError(
            f"track: no column {error}; it needs 'lat' and 'lon', in degrees"
        ) from error
    # two places make a way
    if lat.shape != lon.shape or lat.ndim != 1 or lat.size < 2:  # noqa: PLR2004
        raise ValueError(
            f"track: {lat.size} lat and {lon.size} lon; it needs as many of both, at least 2"
        )
    # degrees; nan is wrong, too
    wrong = ~((np.abs(lat) <= 90) & (np.abs(lon) <= 180))  # noqa: PLR2004
    if wrong.any():
        k = int(np.argmax(wrong))
        raise ValueError(
            f"track, row {k + 1}: lat {lat[k]}, lon {lon[k]}; allowed are -90 to 90 and -180 to "
            "180. "
            "Leave rows without a place out"
        )
    return list(zip(lat.tolist(), lon.tolist(), strict=True))


def _needed(module: str, package: str) -> Any:  # noqa: ANN401 (a module without types)
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"ocmc.map needs {package}: pip install '.[map]' (Python 3.12 or newer)"
        ) from error


def _actor(config: Path) -> Any:  # noqa: ANN401 (a class without types)
    """Open the tiles, for tracks of any length."""
    valhalla = _needed("valhalla", "pyvalhalla")
    try:
        settings = json.loads(config.read_text(encoding="utf-8"))
        from_web = settings["mjolnir"].get("tile_url")
        settings["service_limits"]["trace"] |= _MOST
        settings["logging"]["type"] = ""
    except (KeyError, TypeError, json.JSONDecodeError) as error:
        raise ValueError(
            f"{config}: no configuration of Valhalla ({error!r}); valhalla_build_config makes one"
        ) from error
    if from_web:
        raise ValueError(
            f"{config}: mjolnir.tile_url loads tiles from the web; name local ones in "
            "mjolnir.tile_dir"
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / config.name
        path.write_text(json.dumps(settings), encoding="utf-8")
        return valhalla.Actor(str(path))


def _signs(actor: Any, answer: Mapping[str, Any]) -> dict[int, str]:  # noqa: ANN401
    """Find the stop signs and give ways of the matched edges, by the edges' ids."""
    places, signs = decoded(answer["shape"]), {}
    middles = [places[e["begin_shape_index"] :][:2].mean(axis=0) for e in answer["edges"]]
    options = {"node_snap_tolerance": 0, "minimum_reachability": 0}
    locations = [{"lat": lat, "lon": lon} | options for lat, lon in middles]
    for k in range(0, len(locations), _SIGNS_AT_ONCE):
        request = {
            "locations": locations[k : k + _SIGNS_AT_ONCE],
            "costing": "auto",
            "verbose": True,
        }
        for edge in (edge for place in actor.locate(request) for edge in place["edges"] or []):
            for flag, word in [("yield_sign", "give_way"), ("stop_sign", "stop_sign")]:
                if edge["edge"][flag]:
                    signs[edge["edge_id"]["value"]] = word
    return signs


def _altitudes(
    files: Sequence[str | PathLike[str]], way: Floats, bridged: Sequence[bool]
) -> list[float]:
    """Give the altitude of each point in m, between the four cells around it."""
    rasterio = _needed("rasterio", "rasterio")
    warp = _needed("rasterio.warp", "rasterio")
    altitude = np.full(len(way), np.nan)
    for file in map(Path, files):
        if not file.is_file():
            raise FileNotFoundError(
                f"{file}: no such file; elevation takes files of this machine alone"
            )
        with rasterio.open(file) as raster:
            if raster.crs is None:
                raise ValueError(f"{file}: the raster does not say its coordinates (CRS)")
            x, y = map(np.array, warp.transform("EPSG:4326", raster.crs, way[:, 1], way[:, 0]))
            column, row = _affine(~raster.transform, x, y)
            inside = (column >= 0) & (column < raster.width) & (row >= 0) & (row < raster.height)
            need = np.flatnonzero(np.isnan(altitude) & inside)
            column = np.clip(column[need] - 0.5, 0, raster.width - 1)
            row = np.clip(row[need] - 0.5, 0, raster.height - 1)
            total = np.zeros(need.size)
            for dc, dr in itertools.product((0, 1), (0, 1)):
                at_column = np.minimum(np.floor(column) + dc, raster.width - 1)
                at_row = np.minimum(np.floor(row) + dr, raster.height - 1)
                weight = np.abs(1 - dc - column % 1) * np.abs(1 - dr - row % 1)
                cells = zip(*_affine(raster.transform, at_column + 0.5, at_row + 0.5), strict=True)
                values: Any = np.ma.array(
                    [value[0] for value in raster.sample(cells, masked=True)], dtype=float
                )
                total += np.where(weight > 0, weight * values.filled(np.nan), 0.0)
            altitude[need] = total
    if np.isnan(altitude).any():
        k = int(np.argmax(np.isnan(altitude)))
        raise ValueError(
            f"elevation: no value for {np.isnan(altitude).sum()} of {len(way)} points, the first "
            "at "
            f"{at(*way[k])}; name the tiles that cover it"
        )
    at_m, ground = along_m(way), ~np.array(bridged)
    return [round(float(z), 2) for z in np.interp(at_m, at_m[ground], altitude[ground])]


def _affine(transform: Sequence[float], u: Floats, v: Floats) -> tuple[Floats, Floats]:
    a, b, c, d, e, f = transform[:6]
    return a * u + b * v + c, d * u + e * v + f
