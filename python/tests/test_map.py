"""A map's limits, lights and altitudes: of answers as Valhalla gives them, without it."""

import csv
import json
import sys
import types
from pathlib import Path

import numpy as np
import ocmc
import ocmc.map
import pytest
from ocmc import _matched

STEP = 0.001  # degrees to the north, some 111 m


def polyline(places):
    """Write places as Valhalla does."""
    text, before = "", (0, 0)
    for place in places:
        now = tuple(round(1e6 * degrees) for degrees in place)
        for a, b in zip(before, now, strict=True):
            number = (b - a) << 1 if b >= a else ~((b - a) << 1)
            while number >= 32:
                text, number = text + chr((number & 31 | 32) + 63), number >> 5
            text += chr(number + 63)
        before = now
    return text


def answer(*edges):
    """Give an answer of edges due north, two points a piece of 111 m."""
    places, made = [(60.0, 25.0)], []
    for k, (pieces, edge) in enumerate(edges):
        begin = len(places) - 1
        places += [(places[-1][0] + STEP * (i + 1), 25.0) for i in range(pieces)]
        made.append(
            {
                "id": k,
                "begin_shape_index": begin,
                "end_shape_index": len(places) - 1,
                "road_class": "primary",
            }
            | edge
        )
    points = [{"type": "matched"}, {"type": "interpolated"}, {"type": "unmatched"}]
    return {"shape": polyline(places), "edges": made, "matched_points": points}


def found(*edges, signs=None, fill_m=500.0, step_m=np.inf):
    return _matched.found(answer(*edges), signs or {}, fill_m, step_m)


def test_a_polyline_has_the_places_of_the_published_example():
    # of the format's description, which has five decimals
    places = 10 * _matched.decoded("_p~iF~ps|U_ulLnnqC_mqNvxq`@")
    assert places == pytest.approx(np.array([[38.5, -120.2], [40.7, -120.95], [43.252, -126.453]]))


def test_limits_types_and_objects_begin_where_their_edges_do():
    columns, account = found(
        (2, {"speed_limit": 50, "traffic_signal": True}),
        (1, {"speed_limit": 80}),
        (
            1,
            {
                "speed_limit": "unlimited",
                "road_class": "motorway",
                "end_node": {"traffic_signal": True},
            },
        ),
        (1, {"speed_limit": 100, "road_class": "trunk"}),
        (1, {"speed_limit": 30, "road_class": "residential"}),
        signs={1: "give_way", 4: "stop_sign"},
    )
    assert columns["lat"] == pytest.approx([60.0 + STEP * k for k in range(7)])
    assert columns["speed_limit_kmh"] == [50, 50, 80, 130, 100, 30, 30]
    assert columns["road_type"] == [
        "urban",
        "urban",
        "rural",
        "motorway",
        "motorway",
        "urban",
        "urban",
    ]
    # where the track ends nothing is met
    assert columns["map_object"] == ["", "", "traffic_light", "give_way", "traffic_light", "", ""]
    assert "0.67 km" in account[0]
    assert "2 of the track's 3" in account[1]
    assert "without any limit (130 km/h here)" in account[3]


def test_a_short_gap_takes_the_limit_beside_it_and_says_so():
    columns, account = found((1, {}), (1, {"speed_limit": 60}), (3, {}), (1, {"speed_limit": 70}))
    assert columns["speed_limit_kmh"] == [60, 60, 60, 60, 60, 70, 70]
    assert "the map has 0.22 km of 0.67 km; 2 gaps, the longest of 0.33 km" in account[3]


def test_limits_are_left_out_where_a_gap_is_long():
    columns, account = found(
        (1, {"speed_limit": 60}), (5, {}), (1, {"speed_limit": 70, "road_class": "motorway"})
    )
    assert "speed_limit_kmh" not in columns
    assert "--draw limits" in account[3]
    assert set(columns["road_type"]) == {"rural", "motorway"}
    assert "speed_limit_kmh" not in found((1, {}))[0]
    assert "speed_limit_kmh" in found((1, {"speed_limit": 60}), (5, {}), fill_m=1e4)[0]


def test_lights_of_one_crossing_are_one():
    light = {"speed_limit": 50, "traffic_signal": True}
    case = answer((1, light), (1, light), (1, light), (1, {"speed_limit": 50}))
    places = [
        60.0,
        60.001,
        60.0013,
        60.002,
        60.003,
    ]  # the second 33 m behind the first, the third 111 m
    case["shape"] = polyline([(lat, 25.0) for lat in places])
    columns, account = _matched.found(case, {}, 500.0, np.inf)
    assert columns["map_object"] == ["", "traffic_light", "", "traffic_light", ""]
    assert "2 traffic_light" in account[4]
    assert "1 light less than 40 m behind one" in account[4]


def test_a_way_that_the_map_lacks_and_a_ferry_are_refused_with_their_place():
    case = answer((1, {}), (3, {}))
    case["edges"][1]["begin_shape_index"] = 3
    with pytest.raises(
        ValueError, match=r"60\.00100, 25\.00000: .* to 60\.00300, 25\.00000, 222 m .* Cut"
    ):
        _matched.found(case, {}, 500.0, np.inf)
    case["edges"][1]["begin_shape_index"] = 2
    assert "0.11 km of it straight" in _matched.found(case, {}, 500.0, np.inf)[1][0]
    with pytest.raises(ValueError, match="two places along one"):
        found()
    with pytest.raises(ValueError, match="two places along one"):
        _matched.found(case | {"shape": polyline(5 * [(60.0, 25.0)])}, {}, 500.0, np.inf)
    with pytest.raises(ValueError, match=r"60\.00100, 25\.00000: a ferry"):
        found((1, {}), (1, {"use": "ferry"}))


def test_points_between_carry_no_objects_and_bridges_begin_on_the_ground():
    light = {"speed_limit": 50, "traffic_signal": True}
    columns, _ = found(
        (1, light), (1, {"speed_limit": 50, "bridge": True}), (1, {"speed_limit": 50}), step_m=30.0
    )
    assert columns["map_object"].count("traffic_light") == 1
    assert columns["bridged"] == 5 * [False] + 3 * [True] + 5 * [False]
    assert np.diff(columns["lat"]) == pytest.approx(STEP / 4, abs=1e-7)


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "valhalla.json"
    settings = {"mjolnir": {"tile_dir": "tiles"}, "service_limits": {"trace": {}}, "logging": {}}
    path.write_text(json.dumps(settings))
    return path


class Actor:
    """Stand-in for Valhalla's answers."""

    given = None

    def __init__(self, path):
        assert json.loads(Path(path).read_text())["service_limits"]["trace"]["max_shape"] > 1e5

    def trace_attributes(self, request):
        assert request["costing"] == "auto"
        if self.given is None:
            raise RuntimeError("no path")
        return self.given

    def locate(self, request):
        assert len(request["locations"]) == len(self.given["edges"])
        edge = {"edge_id": {"value": 1}, "edge": {"stop_sign": True, "yield_sign": False}}
        return [{"edges": None}, {"edges": [edge]}]


@pytest.fixture
def valhalla(monkeypatch):
    module = types.ModuleType("valhalla")
    module.Actor = type("Actor", (Actor,), {})
    monkeypatch.setitem(sys.modules, "valhalla", module)
    return module


TRACK = {"lat": [60.0, 60.01], "lon": [25.0, 25.0]}


def test_the_table_is_a_route_that_is_driven(valhalla, config, tmp_path):
    valhalla.Actor.given = answer(
        (9, {"speed_limit": 50, "traffic_signal": True}), (9, {"speed_limit": 60}), (9, {})
    )
    with pytest.warns(UserWarning, match="left out"):
        ocmc.map.route(TRACK, config)
    route = ocmc.map.route(TRACK, config, fill_m=1100.0)
    path = tmp_path / "route.csv"
    route.write(path)
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["lat", "lon", "speed_limit_kmh", "road_type", "map_object"]
    assert [row["map_object"] for row in rows if row["map_object"]] == [
        "traffic_light",
        "stop_sign",
    ]
    run = ocmc.Study("field-truck").drive(path, cycles=20, draw=["stops", "hills"])
    assert run["distance_m"] == pytest.approx(27 * 111.2, rel=1e-3)


@pytest.mark.usefixtures("valhalla")
def test_messages_say_where_what_and_what_to_do(config):
    with pytest.raises(ValueError, match=r"60\.00000, 25\.00000 to .* its tiles have to cover"):
        ocmc.map.route(TRACK, config)
    with pytest.raises(ValueError, match="no column 'lon'"):
        ocmc.map.route({"lat": [1.0, 2.0]}, config)
    with pytest.raises(ValueError, match="row 2: lat nan"):
        ocmc.map.route({"lat": [60.0, np.nan], "lon": [25.0, 25.0]}, config)
    with pytest.raises(ValueError, match="at least 2"):
        ocmc.map.route({"lat": [60.0], "lon": [25.0]}, config)
    settings = json.loads(config.read_text())
    settings["mjolnir"]["tile_url"] = "tiles.invalid/{tilePath}"
    config.write_text(json.dumps(settings))
    with pytest.raises(
        ValueError, match=r"valhalla\.json: mjolnir\.tile_url loads tiles from the web"
    ):
        ocmc.map.route(TRACK, config)
    config.write_text("{}")
    with pytest.raises(ValueError, match="valhalla_build_config makes one"):
        ocmc.map.route(TRACK, config)


def test_a_missing_extra_is_named(monkeypatch, config, valhalla):
    valhalla.Actor.given = answer((1, {"speed_limit": 50}))
    monkeypatch.setitem(sys.modules, "rasterio", None)
    with pytest.raises(ModuleNotFoundError, match=r"needs rasterio: pip install '\.\[map\]'"):
        ocmc.map.route(TRACK, config, elevation=["a.tif"])
    monkeypatch.setitem(sys.modules, "valhalla", None)
    with pytest.raises(
        ModuleNotFoundError, match=r"needs pyvalhalla: pip install '\.\[map\]' \(Python 3\.12"
    ):
        ocmc.map.route(TRACK, config)


def test_altitudes_are_linear_between_cells_and_straight_on_bridges(valhalla, config, tmp_path):
    rasterio = pytest.importorskip("rasterio")
    # cells of 0.001 degrees: a plane in the south, a valley for the bridge, and another file in the
    # north
    bridge = {"speed_limit": 50, "bridge": True}
    valhalla.Actor.given = answer((5, {"speed_limit": 50}), (2, bridge), (5, {"speed_limit": 50}))
    files = [tmp_path / "south.tif", tmp_path / "north.tif"]
    row, column = np.mgrid[:20, :10]
    plane = 2.0 * row + 5.0 * column
    plane[10:14] -= 100.0
    for k, path in enumerate(files):
        cells = {
            "width": 10,
            "height": 20,
            "count": 1,
            "dtype": "float64",
            "crs": "EPSG:4326",
            "nodata": -999,
        }
        # north is up; a row's middle is at 60.0185 less its number
        corner = rasterio.Affine(0.001, 0.0, 24.9953, 0.0, -0.001, 60.019 - 0.001 * 0.3 + 0.011 * k)
        with rasterio.open(path, "w", driver="GTiff", transform=corner, **cells) as raster:
            raster.write(plane if k == 0 else np.full((20, 10), 7.0), 1)
    route = ocmc.map.route(TRACK, config, elevation=files)
    lat, altitude = (np.array(route.columns[name]) for name in ("lat", "altitude_m"))
    assert "bridged" not in route.columns
    assert np.diff(lat).max() * 111_195 < 25.1
    rows = (60.0187 - lat) / 0.001 - 0.5
    south = (rows > 14.0) | (rows < 9.0)
    on_plane = 2.0 * rows + 5.0 * (0.0047 / 0.001 - 0.5)
    assert altitude[south] == pytest.approx(on_plane[south], abs=0.02)
    with pytest.raises(
        ValueError, match=r"no value for \d+ of \d+ points, the first at 60\.0\d+, 25\.0+; name"
    ):
        ocmc.map.route(TRACK, config, elevation=files[1:])
    with pytest.raises(FileNotFoundError, match=r"none\.tif: no such file"):
        ocmc.map.route(TRACK, config, elevation=[tmp_path / "none.tif"])
