"""SUMO on the exported roads: one truck on each, EIDM as its driver.

The energy model is that of battery-electric vehicles.

The limits are the planned static speeds, signs, curves and traffic together; the slope is the
exported one; stops last a second. Efficiencies of one, no recuperation and no auxiliaries make its
energy the positive work at the wheels.
"""

import math
import os
import resource
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

from scenarios import DWELL, GRADE, LENGTH, LIMIT, TRUCK, Scenarios

GRAVITY_MPS2 = 9.80665
# the density of air that SUMO takes; its gravity is ours
SUMO_AIR_KGPM3 = 1.2041
SHORTEST_EDGE_M = 10.0
ROLLING_COEFFICIENT = 0.0065
FRONT_M2 = 10.0


def home() -> Path:
    """Find where the package keeps SUMO."""
    import sumo

    return Path(sumo.SUMO_HOME)


class Roads:
    """A network of disjoint roads, and a truck on each."""

    def __init__(self, scenarios: Scenarios, folder: Path, trucks: int) -> None:
        self.folder = folder
        self.sumo = home() / "bin" / "sumo"
        self.environment = os.environ | {"SUMO_HOME": str(home())}
        folder.mkdir(parents=True, exist_ok=True)
        nodes, edges, routes = ET.Element("nodes"), ET.Element("edges"), ET.Element("routes")
        self.bodies = []
        for k in range(trucks):
            self.bodies.append(self._road(scenarios, k, nodes, edges, routes))
        for name, root in (("nod", nodes), ("edg", edges), ("rou", routes)):
            ET.ElementTree(root).write(folder / f"roads.{name}.xml")
        self._call(
            [
                home() / "bin" / "netconvert",
                *(
                    "-n",
                    folder / "roads.nod.xml",
                    "-e",
                    folder / "roads.edg.xml",
                    "-o",
                    folder / "roads.net.xml",
                ),
                *(
                    "--no-internal-links",
                    "true",
                    "--no-turnarounds",
                    "true",
                    "--geometry.max-grade",
                    "30",
                ),
                *("--offset.disable-normalization", "true", "--no-warnings", "true"),
            ]
        )

    def _road(
        self, scenarios: Scenarios, k: int, nodes: ET.Element, edges: ET.Element, routes: ET.Element
    ) -> dict:
        first = scenarios.first_row[k]
        rows = scenarios.rows[first : first + scenarios.n_rows[k]]
        truck = dict(zip(TRUCK, scenarios.trucks[k].tolist(), strict=True))
        y = f"{200.0 * k:.1f}"
        x = z = start_x = 0.0
        shape: list[str] = []
        names: list[str] = []
        stops: list[str] = []
        limit = rows[0, LIMIT]

        def node() -> str:
            name = f"n{k}_{len(names)}"
            ET.SubElement(nodes, "node", id=name, x=f"{x:.3f}", y=y, z=f"{z:.3f}")
            return name

        here = node()
        shape.append(f"{x:.3f},{y},{z:.3f}")
        for i, row in enumerate(rows):
            slope = row[GRADE] / GRAVITY_MPS2
            x += row[LENGTH] * math.sqrt(1.0 - slope * slope)
            z += row[LENGTH] * slope
            shape.append(f"{x:.3f},{y},{z:.3f}")
            is_last = i + 1 == len(rows)
            changes = is_last or row[DWELL] >= 0.0 or rows[i + 1, LIMIT] != limit
            if not changes or (x - start_x < SHORTEST_EDGE_M and not is_last):
                limit = min(limit, row[LIMIT])
                continue
            names.append(f"e{k}_{len(names)}")
            there = node()
            attributes = {
                "from": here,
                "to": there,
                "numLanes": "1",
                "speed": f"{math.sqrt(limit):.4f}",
            }
            ET.SubElement(edges, "edge", {"id": names[-1], "shape": " ".join(shape)} | attributes)
            if row[DWELL] >= 0.0 and not is_last:
                stops.append(names[-1])
            here, shape, start_x = there, [shape[-1]], x
            limit = 0.0 if is_last else rows[i + 1, LIMIT]
        body = {
            "mass_kg": truck["mass_kg"],
            "wheel_mass_kg": 1000.0,
            "drag_area_m2": truck["drag_area_m2"],
            "rolling_coefficient": ROLLING_COEFFICIENT,
        }
        kind = ET.SubElement(
            routes,
            "vType",
            id=f"t{k}",
            carFollowModel="EIDM",
            length="16.5",
            maxSpeed="24.7",
            accel=f"{1.0 / truck['rise_from_rest']:.4f}",
            decel=f"{truck['deceleration_mps2']:.4f}",
            speedFactor="1",
            emissionClass="Energy/unknown",
            mass=f"{body['mass_kg']:.3f}",
        )
        energy = {
            "frontSurfaceArea": FRONT_M2,
            "airDragCoefficient": body["drag_area_m2"] / FRONT_M2,
            "rotatingMass": body["wheel_mass_kg"],
            "rollDragCoefficient": ROLLING_COEFFICIENT,
            "radialDragCoefficient": 0.0,
            "constantPowerIntake": 0.0,
            "propulsionEfficiency": 1.0,
            "recuperationEfficiency": 0.0,
        }
        for key, value in energy.items():
            ET.SubElement(kind, "param", key=key, value=f"{value:.6f}")
        vehicle = ET.SubElement(
            routes,
            "vehicle",
            id=f"v{k}",
            type=f"t{k}",
            depart="0",
            departPos="base",
            departSpeed="0",
        )
        ET.SubElement(vehicle, "route", edges=" ".join(names))
        for name in stops:
            ET.SubElement(
                vehicle, "stop", lane=f"{name}_0", endPos="-0.1", duration="1", friendlyPos="true"
            )
        return body

    def _call(self, words: list[Any]) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        done = subprocess.run(
            [str(word) for word in words],
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise RuntimeError(done.stderr[-2000:])
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    def _sumo(self, step_s: float, *more: Any) -> float:
        words = [
            *("-n", self.folder / "roads.net.xml", "-r", self.folder / "roads.rou.xml"),
            *("--step-length", step_s, "--no-step-log", "true", "--no-warnings", "true"),
            *("--device.emissions.probability", "1", "--time-to-teleport", "-1"),
            *("--tripinfo-output", self.folder / "trips.xml", "--precision", "8"),
        ]
        return self._call([self.sumo, *words, *more])

    def one_round(self, step_s: float, cycles: int) -> dict[str, Any]:  # noqa: ARG002
        """Drive all roads, however many cycles are asked for; loading the network is taken off."""
        loading = self._sumo(step_s, "--end", step_s)
        spent = self._sumo(step_s) - loading
        trips = ET.parse(self.folder / "trips.xml").getroot().findall("tripinfo")
        seconds = [float(trip.get("duration", "nan")) for trip in trips]
        return {
            "cpu_s": spent,
            "simulated_s": seconds,
            "distance_m": sum(float(trip.get("routeLength", "nan")) for trip in trips),
            "steps": sum(seconds) / step_s,
        }

    def checks(self, step_s: float, trucks: int) -> list[dict[str, Any]]:
        """Give some trucks' speeds and slopes, and SUMO's energy over them."""
        fcd = self.folder / "fcd.xml"
        self._sumo(step_s, "--fcd-output", fcd, "--fcd-output.attributes", "speed,slope")
        names = {f"v{k}": k for k in range(trucks)}
        drives = [([0.0], [0.0], [0.0]) for _ in range(trucks)]
        for _, step in ET.iterparse(fcd):
            if step.tag != "timestep":
                continue
            for vehicle in step:
                k = names.get(vehicle.get("id", ""))
                if k is not None:
                    at, speed, slope = drives[k]
                    at.append(float(step.get("time", "nan")) + step_s)
                    speed.append(float(vehicle.get("speed", "nan")))
                    slope.append(math.sin(math.radians(float(vehicle.get("slope", "nan")))))
            step.clear()
        wheel_j = {}
        for trip in ET.parse(self.folder / "trips.xml").getroot().findall("tripinfo"):
            emissions = trip.find("emissions")
            if emissions is not None:
                wheel_j[trip.get("id")] = float(emissions.get("electricity_abs", "nan")) * 3600.0
        return [
            {
                "wheel_j": wheel_j[f"v{k}"],
                "follow": self.bodies[k]
                | {
                    "time_s": at,
                    "speed_mps": speed,
                    "slope": slope,
                    "air_density_kgpm3": SUMO_AIR_KGPM3,
                },
            }
            for k, (at, speed, slope) in enumerate(drives)
        ]
