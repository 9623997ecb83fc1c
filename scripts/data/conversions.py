"""Conversions of others' files to tables of the tests: formats and columns, never numbers."""

import csv
import gzip
import io
import math
import xml.etree.ElementTree as ET

import r_data

MAIN_ROADS = {"motorway", "trunk", "primary", "secondary"}
TAGS = ("ref", "maxspeed", "oneway", "junction", "lanes")
DRIVE_COLUMNS = (
    "drive", "time_utc", "gps_long", "gps_lat", "gps_elevation", "gps_heading", "gps_hdop",
    "speed_mph", "speed_source", "accel_x", "accel_y", "gyro_z", "pitch", "engine_rpm",
    "engine_throttle",
)  # fmt: skip
LOADS = ("3-1", "3-2", "3-4")


def udacity(data: bytes) -> bytes:
    """Drop the paths of images, sort by time, and round: angles to 6 decimals, others to 4."""
    rows = sorted(
        csv.DictReader(io.StringIO(data.decode())), key=lambda row: float(row["timestamp"])
    )
    lines = ["t_unix_ns,steering_wheel_angle_rad,steering_torque_nm,speed_mps"]
    for row in rows:
        time, angle, torque, speed = (
            float(row[name]) for name in ("timestamp", "angle", "torque", "speed")
        )
        lines.append(f"{time!r},{round(angle, 6)!r},{round(torque, 4)!r},{round(speed, 4)!r}")
    return "".join(line + "\n" for line in lines).encode()


def driveplotr(data: bytes) -> bytes:
    """Take 15 of the 35 columns of R's table; what is missing is empty."""
    table = r_data.table(data, "nds_data")

    def cell(value: float | str | None) -> str:
        if isinstance(value, str):
            return value
        return "" if value is None or math.isnan(value) else repr(value)

    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(DRIVE_COLUMNS)
    rows.writerows(
        [cell(value) for value in row]
        for row in zip(*(table[name] for name in DRIVE_COLUMNS), strict=True)
    )
    return text.getvalue().encode()


def open_street_map(data: bytes) -> bytes:
    """Take the main roads, a row a node, without links, users and nodes beyond the extract."""
    root = ET.fromstring(gzip.decompress(data))  # noqa: S314 (its hash was checked)
    places = {node.get("id"): (node.get("lat"), node.get("lon")) for node in root.iter("node")}
    text = io.StringIO()
    rows = csv.writer(text)
    rows.writerow(["way_id", "highway", *TAGS, "seq", "node_id", "lat", "lon"])
    for way in root.iter("way"):
        tags = {tag.get("k"): tag.get("v") for tag in way.iter("tag")}
        if tags.get("highway") not in MAIN_ROADS:
            continue
        nodes = [node.get("ref") for node in way.iter("nd") if node.get("ref") in places]
        for k, node in enumerate(nodes):
            described = [tags.get(tag, "") for tag in TAGS]
            rows.writerow([way.get("id"), tags["highway"], *described, k, node, *places[node]])
    return text.getvalue().encode()


def vecto_sums(data: bytes) -> bytes:
    """Take the head and the rows of the three loads that a test drives."""
    head, *rows = data.decode().splitlines()
    kept = [row for row in rows if row.split(",")[0] in LOADS]
    return "".join(row + "\n" for row in [head, *kept]).encode()


CONVERSIONS = {
    "driveplotr": driveplotr,
    "open_street_map": open_street_map,
    "udacity": udacity,
    "vecto_sums": vecto_sums,
}
