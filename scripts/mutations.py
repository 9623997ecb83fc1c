#!/usr/bin/env python3
"""Show which subtle changes to physics, statistics, planning and sampling the tests notice.

    scripts/mutations.py            all of them, a table on standard output
    scripts/mutations.py 3 17      these two
    scripts/mutations.py --list     what would be changed, nothing is built
    scripts/mutations.py --draw 60 --seed 1     changes that nobody chose

Each row of MUTATIONS is one change. The tree is copied to a temporary folder, all changes are
written into it at once, each behind `if mutant(number)`, and compiled once; then the tests run
with one change turned on at a time by an environment variable. Tests of value stability, which
notice that anything changed, are left out. The tests named in a row are those that should notice
it on principle; where they do not, all others run.

`--draw` draws as many changes from the code of each of SUBJECTS: a site uniformly, then one of its
changes. One that does not compile is drawn again. The tests beside the changed code run first,
then those of its subject; at the end, for what they have not noticed, the rest of its crate and of
`tests/it`. A test that has not ended after five times what it takes without a change has noticed
it.

The code of a row must occur exactly once in the sources (white space does not matter, tests beside
the code do not count), or the script stops: a row whose code was renamed is to be mended.
"""

import argparse
import contextlib
import dataclasses
import functools
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from mutation_sites import closing, code_only, sites

VARIABLE = "OCMC_MUTANT"
SKIPPED = "value_stability"
LIMIT_S = 900
LEAST_LIMIT_S = 60
MOST_BYTES = 12 << 30  # of memory, of a test


@dataclasses.dataclass
class Mutation:
    """One change: `code` has the expression to be replaced between `{{` and `}}`."""

    what: str
    code: str
    new: str
    tests: str  # "EXECUTABLE FILTER..." separated by ";", the executables as in EXECUTABLES


# ------------------------------------------------------------------------------------------ the
# list
PHYSICS = [
    Mutation(
        "empty cells of a fuel map: the row's mean slope in place of its last",
        "let slope = {{(full[k - 1] - full[k - 2]) / (torques[k - 1] - torques[k - 2])}};",
        "(full[k - 1] - full[0]) / (torques[k - 1] - torques[0])",
        "core engine::tests",
    ),
    Mutation(
        "the battery's limit without auxiliaries, where a torque is brought back",
        "let most = {{battery.discharge_limit_w(charge) - auxiliary_w}};",
        "battery.discharge_limit_w(charge)",
        "it electric::motor_and_auxiliaries",
    ),
    Mutation(
        "the battery's limit without auxiliaries, where it is looked for",
        "let drawn = "
        "{{speed * torque + self.motor.losses_w(speed, torque) + state.auxiliary_power}};",
        "speed * torque + self.motor.losses_w(speed, torque)",
        "it electric::motor_and_auxiliaries",
    ),
    Mutation(
        "no bound of tyre grip on the brake",
        "{{(control.braking * parameters.brake_mps2).at_most(row[RoadRow::GRIP])}},",
        "(control.braking * parameters.brake_mps2)",
        "it forces::",
    ),
    Mutation(
        "pressure falls with altitude as at 288.15 K",
        "libm::exp(-9.80665 * climb_m / (287.05 * {{self.temperature_k}}))",
        "288.15",
        "core weather::tests",
    ),
    Mutation(
        "the shift interval counts from the shift's end",
        "motion.up_left[lane.number] = {{up_s}};",
        "up_s + shift.duration_s",
        "it shift_strategy::",
    ),
    Mutation(
        "the overspeed band acts on braking ramps, too",
        "let in_band = {{speed.simd_gt(pedals.overspeed_from_mps)\n            & !stance.ramps}}",
        "speed.simd_gt(pedals.overspeed_from_mps)",
        "it closed_loop::overspeed_band",
    ),
    Mutation(
        "no step is cut where the gearbox decides",
        "let earliest = {{driver.or_earlier(gear)}}.or_earlier(plan);",
        "driver",
        "it shift_strategy::",
    ),
    Mutation(
        "no step is cut where a driver changes pedals",
        "let earliest = {{driver.or_earlier(gear)}}.or_earlier(plan);",
        "gear",
        "it closed_loop:: step_bias::",
    ),
    Mutation(
        "rolling resistance of the empty truck",
        "rolling_coefficient(&self.axles, {{mass_kg}}, self.load_range(), "
        "self.rolling_load_exponent)",
        "self.curb_mass_kg",
        "core-it sampled::driver",
    ),
    Mutation(
        "half of the engine brake",
        "engine_brake: demand.brake.at_most({{engine_speed * state.engine_brake}}),",
        "engine_speed * state.engine_brake * 0.5",
        "it forces::",
    ),
    Mutation(
        "drag without the square of the cross wind",
        "half_density * ({{relative_mps * relative_mps + cross_mps * cross_mps}});",
        "relative_mps * relative_mps",
        "it forces:: energy_balance:: closed_form::",
    ),
    Mutation(
        "the cross-wind increment beyond its largest angle",
        "let t = {{tangent.at_most(self.maximum_tangent)}};",
        "tangent",
        "it forces::",
    ),
    Mutation(
        "gearbox loss with the sign of the torque",
        "let gearbox_nm = loss_share * {{torque_nm.abs()}}.at_least(self.floor_nm) + turning_nm;",
        "torque_nm",
        "core gearbox::tests",
    ),
    Mutation(
        "the temperature coefficient of rolling is not halved far from 25 degC",
        "coefficient_per_k * (near + {{0.5}} * (difference - near))",
        "1.0",
        "core resistance::tests",
    ),
    Mutation(
        "full exposure to cross wind",
        "= {{(exposure * head, exposure * cross.abs())}};",
        "(exposure * head, cross.abs())",
        "it road_rows::",
    ),
    Mutation(
        "a left curve turns the heading the other way",
        "curve.map_or(0.0, |k| {{-road.curves[k].curvature_per_m()}} * segment.length_m)",
        "road.curves[k].curvature_per_m()",
        "it road_rows::",
    ),
    Mutation(
        "rolling without the slope's cosine",
        "GRAVITY_MPS2 * sine, around.rolling * {{cosine}},",
        "1.0",
        "it road_rows::",
    ),
    Mutation(
        "air density of the start all the way up",
        "if new_weather || {{self.has_climbed(altitude_m)}} {",
        "false",
        "it road_rows::",
    ),
    Mutation(
        "a slipping clutch brakes the wheels",
        "let gearbox_torque = coupling.closed.select(driving, {{driving.at_least(0.0)}});",
        "driving",
        "it closed_loop::launch",
    ),
    Mutation(
        "no lower clamp of the integral part",
        "clip(integral, {{pid.integral_minimum}}, pid.integral_maximum)",
        "-10.0",
        "it closed_loop::integral_clamp closed_loop::anti_windup",
    ),
    Mutation(
        "no anti-windup",
        "{{constants.integral_gain * error + constants.tracking * (realised - output)}},",
        "constants.integral_gain * error",
        "it closed_loop::integral_clamp closed_loop::anti_windup",
    ),
    Mutation(
        "the derivative acts with the wrong sign",
        "corrected + around - {{constants.derivative_over_filter * lag}};",
        "-(constants.derivative_over_filter * lag)",
        "it closed_loop::",
    ),
    Mutation(
        "the limiter has no range",
        "let end_mps = vehicle.limiter_speed_mps + {{vehicle.limiter_range_mps}};",
        "0.0",
        "it forces::",
    ),
    Mutation(
        "a held brake is not released",
        "error.simd_lt(0.0).select(held, {{held.at_least(constants.lowest_held)}});",
        "held",
        "it closed_loop::held_throttle",
    ),
    Mutation(
        "fuel is not cut in overrun",
        "map.at_least(0.0) * {{overrun.at_least(0.0)}}",
        "overrun.at_least(0.5)",
        "core engine::tests",
    ),
    Mutation(
        "an idling engine without auxiliaries",
        "let torque_nm = {{power_w / speed_radps}};",
        "0.0 * power_w",
        "it forces::",
    ),
    Mutation(
        "a kick-down is asked for while the torque is still coming back",
        "kick_left[lane.number] = {{shift.duration_s + shift.kickdown_s}};",
        "shift.kickdown_s",
        "it shift_strategy::",
    ),
    Mutation(
        "an upshift needs no reserve of power",
        "power_w(speed(g)) >= {{self.power_reserve}} * inputs.road_power_w;",
        "1.0",
        "it shift_strategy::",
    ),
    Mutation(
        "the battery's current as of half its resistance",
        "let under = voltage * voltage - power_w * (limits.resistance * {{4.0}});",
        "2.0",
        "core battery::tests",
    ),
    Mutation(
        "braking by the motor does not fade out",
        "let fade = {{clip(vehicle_mps * (1.0 / self.brake_fade_mps), 0.0, 1.0)}};",
        "Lanes::splat(vehicle_mps.simd, 1.0)",
        "core motor::tests",
    ),
    Mutation(
        "the motor brakes with all axles",
        "force_n * ({{self.motor.brake_share}} * self.gear_efficiency) / per_m",
        "1.0",
        "core battery_electric::; it electric::",
    ),
]

PLANNING = [
    Mutation(
        "traffic of the section before where the road type changes",
        "let density_per_m = density_at({{section}}, block);"
        " cycle.traffic.push(TrafficStretch { start_m: position_m, density_per_m }); }"
        " speed_mps = *v;",
        "section.saturating_sub(1)",
        "it free_flow_clock::",
    ),
    Mutation(
        "weather at a block's start",
        "let weather = weather_at({{middle_s(block)}});",
        "block * step_s",
        "it free_flow_clock::",
    ),
    Mutation(
        "the clock that traffic and weather go by does not wait at stops",
        "match change { Change::Standstill(wait_s) => time_s += {{wait_s}}, "
        "Change::Speed { section: s",
        "&0.0",
        "it free_flow_clock::",
    ),
    Mutation(
        "the clock goes by the sign alone",
        "let speed_mps = {{sign.speed_mps.min(legal_mps)}};",
        "sign.speed_mps",
        "it free_flow_clock:: tactical::",
    ),
    Mutation(
        "the daily profile of traffic at a block's start",
        "let middle_s = departure_s + (step as f64 + {{0.5}}) * self.step_s;",
        "0.0",
        "core traffic::tests; it free_flow_clock::",
    ),
    Mutation(
        "traffic goes by the truck's limit",
        "model.traffic().speed_mps(density, {{sign_mps}})",
        "sign_mps.min(truck_limit)",
        "it tactical::",
    ),
    Mutation(
        "the accelerating branch starts at the segment's limit, whatever the branch before",
        "let level = {{lower(branch.backward_end, branch.limit)}};",
        "branch.limit",
        "it tactical::",
    ),
    Mutation(
        "left curves are those that are driven slower",
        "let direction = if {{left}} { self.direction_effect }",
        "!left",
        "core curve_speed::tests; it tactical::",
    ),
    Mutation(
        "no guard at tight curves",
        "if {{radius_m < self.guard_radius_m}} { speed.min",
        "false",
        "core curve_speed::tests; it tactical::",
    ),
    Mutation(
        "a bump's speed as if its height were half",
        "length_m * (self.bump_acceleration_mps2 / ({{8.0}} * height_m)).sqrt()",
        "4.0",
        "core speed_limit::tests",
    ),
    Mutation(
        "compliance with the sign holds for the truck's limit not",
        "({{self.compliance * sign_mps.min(legal_mps)}}).min(self.maximum_speed_mps)",
        "(self.compliance * sign_mps).min(legal_mps)",
        "core speed_limit::tests; it tactical::",
    ),
    Mutation(
        "creeping trucks are captured as late as others",
        "let reach = if slow { {{simulation.creep_distance_m}} } else",
        "simulation.capture_distance_m",
        "it closed_loop::stop_capture",
    ),
]

SAMPLING = [
    Mutation(
        "K_P is clipped at its bounds",
        "if !inside && redraws < MOST_REDRAWS && {{spread}} {",
        "false",
        "core-it sampled::driver",
    ),
    Mutation(
        "innovations of traffic as large as the stationary spread",
        "let innovation = {{(1.0 - self.step_correlation * self.step_correlation).sqrt()}};",
        "1.0",
        "core traffic::tests",
    ),
    Mutation(
        "warm air is as humid as cold",
        "+ {{self.humidity.temperature_slope_per_k * deviation_k}} + self.humidity.sd",
        "0.0 * deviation_k",
        "core-it sampled::weather",
    ),
    Mutation(
        "curves may overlap",
        "curves.last().map_or(position, |last| {{position.max(last.end_m)}});",
        "position.max(0.0 * last.end_m)",
        "core curvature::tests; core-it sampled::road",
    ),
    Mutation(
        "any speed sign follows any other",
        "0.0 } else { c * share[j] * {{affinity(i, j)}} }",
        "affinity(i, i)",
        "core speed_sign::tests",
    ),
    Mutation(
        "slopes beyond the limit are kept",
        "while {{next.abs() > limit}} {",
        "false",
        "core topography::tests; core-it sampled::road",
    ),
    Mutation(
        "roughness with the shape's inverse as its shape",
        "let shape = {{1.0 / self.shape}};",
        "self.shape",
        "core surface::tests",
    ),
    Mutation(
        "all curves of a road have one residual",
        "draws.at({{c.start_m as u64}}).normal()",
        "0 * c.start_m as u64",
        "core-it sampled::driver",
    ),
    Mutation(
        "Sobol points without digital shift",
        "(f64::from(x) * scale) as u32 ^ {{shift}}",
        "0 * shift",
        "core sampling::; it sampling::",
    ),
    Mutation(
        "speed of a bivariate driver independent of its exponent",
        "self.mean[1] + {{b * x}} + c * y",
        "b * y",
        "core curve_speed::tests",
    ),
    Mutation(
        "junction turns of at least nothing",
        "draws.uniform_between({{self.minimum_share}}, 1.0)",
        "0.0",
        "core-it sampled::",
    ),
    Mutation(
        "stretches of road are longer by their smallest length",
        "let sojourn = minimum + "
        "{{(self.mean_length_m[road_type] - minimum)}} * draws.exponential();",
        "(self.mean_length_m[road_type])",
        "core road_type::tests; core-it sampled::road",
    ),
    Mutation(
        "the day of the weather begins with the departure",
        "let hour = {{time_s / 3600.0}};",
        "h as f64",
        "core-it sampled::weather",
    ),
]

STATISTICS = [
    Mutation(
        "the drivers' levels of the clustered error without n/(n-1)",
        "(levels[group] - mean_level) / count * {{libm::sqrt(count / (count - 1.0))}};",
        "(count / count)",
        "estimation-it fit::clustered_error",
    ),
    Mutation(
        "the upper rank of batches one lower",
        "let high = libm::ceil(n * (level + half_width)) + {{1.0}};",
        "0.0",
        "core quantile::tests",
    ),
    Mutation(
        "the lower rank of batches rounded inwards",
        "let low = {{libm::floor(n * (level - half_width))}};",
        "libm::ceil(n * (level - half_width))",
        "core quantile::tests",
    ),
    Mutation(
        "a ratio's variance with n in place of n - 1",
        "let standard_error = libm::sqrt({{n / (n - 1.0)}} * squares) / sum_x;",
        "n / n",
        "core ratio::tests",
    ),
    Mutation(
        "Student's t with one degree of freedom too many",
        "let half_width = student_975({{n - 1.0}}) * standard_error;",
        "n",
        "core ratio::tests",
    ),
    Mutation(
        "quantiles of Hazen's type",
        "let place = {{last as f64 * level}};",
        "((last as f64 + 1.0) * level - 0.5).clamp(0.0, last as f64)",
        "core quantile::tests",
    ),
    Mutation(
        "differences of pairs as if they were independent",
        "errors.iter().map(|(a, b)| {{(b - a) * (b - a)}}).sum();",
        "(a * a + b * b)",
        "core comparison::tests",
    ),
    Mutation(
        "residuals of a comparison as if all distances were one metre",
        "(contribution.y - ratio * contribution.x) / {{(x / n)}}",
        "(n / n)",
        "core comparison::tests",
    ),
    Mutation(
        "total shares of variance twice as large",
        "(first, square / ({{2.0}} * n * variance))",
        "1.0",
        "core variance_share::tests",
    ),
    Mutation(
        "uncertain parameters: errors of one estimation as if they were independent",
        "let together = {{&self.correlation * &e}};",
        "e.clone()",
        "it uncertainty::",
    ),
    Mutation(
        "two-way analysis: the driver's part with the rest in it",
        "let driver = squares(&column_means) / (j - 1.0) - {{both / i}};",
        "0.0 * i",
        "core random_effects::tests",
    ),
    Mutation(
        "the worst case without the energy that stranded cycles did need",
        "self.failed.iter().map(|shown| {{own(shown).max(worst)}}).sum();",
        "(0.0 * own(shown) + worst)",
        "core summary::tests",
    ),
    Mutation(
        "Tobit: the curvature of a censored row without its second term",
        "hazard, ({{hazard * (hazard - z)}}).clamp(0.0, 1.0)]",
        "hazard * hazard",
        "estimation tobit::tests",
    ),
    Mutation(
        "Anderson-Darling without the correction for a small sample",
        "let a = a2 * ({{1.0 + 0.75 / n + 2.25 / (n * n)}});",
        "n / n",
        "estimation anderson_darling::tests",
    ),
    Mutation(
        "maximum likelihood in place of REML",
        "profile.sum_sq / {{(self.n - p) as f64}}",
        "self.n as f64",
        "estimation-it fit::sleepstudy; estimation mixed_model::tests",
    ),
    Mutation(
        "the mean absolute deviation as a standard deviation",
        "left(at(k)).abs() * {{FRAC_PI_2.sqrt()}}",
        "(FRAC_PI_2 / FRAC_PI_2)",
        "estimation-it fit::weather",
    ),
    Mutation(
        "traffic's correlation over the counts' interval, not over the study's step",
        "let power = {{step_s / interval}};",
        "step_s / step_s",
        "estimation-it fit::traffic",
    ),
    Mutation(
        "radius of a detected curve from all of its cells",
        "{{grid.curvature_per_m[first..end].iter().sum::<f64>()}}; "
        "(turn > 0.0).then(|| inner / turn)",
        "grid.curvature_per_m[run.first..run.end].iter().sum::<f64>()",
        "estimation-it curve_detection::",
    ),
]

MUTATIONS = PHYSICS + PLANNING + SAMPLING + STATISTICS


# --------------------------------------------------------------------------------- what is drawn
# from
@dataclasses.dataclass
class Subject:
    """An answer: files, the word that its functions hold, and its tests, as in `Mutation`."""

    files: str
    tests: str
    word: str = ""


CORE, FLEET, ESTIMATION, IO, API = (
    f"crates/ocmc-{name}/src" for name in ("core", "fleet", "estimation", "io", "api")
)
SUBJECTS = {
    "charging": Subject(
        f"{CORE}/charging/*.rs {CORE}/kernel/trip/charging_*.rs"
        f" {FLEET}/charging.rs {FLEET}/load.rs {FLEET}/truck_arrivals.rs",
        "core charging:: kernel::trip::; fleet charging:: load:: truck_arrivals::;"
        " it charging:: charging_decision:: charging_limits:: loads::",
    ),
    "rest": Subject(
        f"{CORE}/rest/*.rs {CORE}/kernel/trip/rest_*.rs",
        "core-it rest::; core kernel::trip::; it rest:: chain::",
    ),
    "chain": Subject(
        f"{CORE}/kernel/**/*.rs {CORE}/study/*.rs {FLEET}/run.rs",
        "core kernel::; it chain:: rest:: charging::",
        r"\b[Hh]andover\b|\bchained?_|_chained?\b|\bchains\b",
    ),
    "cost": Subject(
        f"{CORE}/cost/*.rs {FLEET}/cost.rs {FLEET}/cost_difference.rs {API}/cost.rs",
        "fleet-it cost::; it cost:: mixed_fleet::",
    ),
    "range": Subject(
        f"{FLEET}/range.rs {FLEET}/kaplan_meier.rs {API}/range.rs",
        "fleet range:: kaplan_meier::; it range::",
    ),
    "truck-years": Subject(
        f"{FLEET}/truck_year.rs {FLEET}/truck_column.rs",
        "fleet truck_year::; it fleet_nesting:: fleet_answers:: cost:: mixed_fleet::",
    ),
    "calibration": Subject(
        f"{ESTIMATION}/calibration/**/*.rs {API}/calibrate_totals/*.rs {API}/totals_rows.rs"
        f" {API}/fit/calibrate.rs",
        "estimation calibration::; api calibrate_totals::; "
        "it calibration:: calibrate_totals:: learn::",
    ),
    "carriers": Subject(
        f"{CORE}/**/*.rs {FLEET}/*.rs {IO}/fleet_total.rs {IO}/part_table.rs {IO}/trip_totals.rs"
        f" {API}/totals_rows.rs",
        "core powertrain::; fleet quantity:: truck_year::;"
        " it fuel_cell:: parts:: energy_balance:: electric:: fleet_answers::",
        r"(?i)carrier",
    ),
    "intake": Subject(
        f"{IO}/intake/**/*.rs",
        "io intake::; io-it table; "
        "it intake:: logs:: small_faults:: signals:: given_cycles:: stop_plans::"
        " workbook:: mistakes:: odd_inputs:: bad_input::",
    ),
    "adjusted means": Subject(
        f"{FLEET}/adjustment.rs {FLEET}/outline_sample.rs {CORE}/study/outline.rs",
        "it adjusted_means:: sweep:: fleet_answers::",
    ),
}
# files that print, say or name
SAYING = {"text.rs", "page.rs", "error.rs", "files.rs", "finding.rs", "words.rs"}


# ----------------------------------------------------------------------------------------- the
# script package and target of cargo, in the order in which all tests of a change run
EXECUTABLES = {
    "core": ("ocmc-core", "lib"),
    "core-it": ("ocmc-core", "test"),
    "fleet": ("ocmc-fleet", "lib"),
    "fleet-it": ("ocmc-fleet", "test"),
    "estimation": ("ocmc-estimation", "lib"),
    "estimation-it": ("ocmc-estimation", "test"),
    "io": ("ocmc-io", "lib"),
    "io-it": ("ocmc-io", "test"),
    "vecto": ("ocmc-vecto", "lib"),
    "api": ("ocmc-api", "lib"),
    "it": ("ocmc", "test"),
}

SWITCH = f"""
/// Whether this change is turned on: only in a copy made by `scripts/mutations.py`.
#[inline(always)]
pub fn mutant(number: u32) -> bool {{
    use std::sync::atomic::{{AtomicU32, Ordering}};
    static ON: AtomicU32 = AtomicU32::new(u32::MAX);
    #[cold]
    #[inline(never)]
    fn read() -> u32 {{
        let text = std::env::var("{VARIABLE}").unwrap_or_default();
        let on = text.parse().unwrap_or(0);
        ON.store(on, Ordering::Relaxed);
        on
    }}
    let on = ON.load(Ordering::Relaxed);
    (if on == u32::MAX {{ read() }} else {{ on }}) == number
}}
"""


def sources(root):
    """List the Rust sources of the libraries, without the tests beside the code."""
    for path in sorted(root.glob("crates/*/src/**/*.rs")):
        text = path.read_text()
        tests = text.find("#[cfg(test)]\nmod tests")
        if tests < 0:
            tests = text.find("#[cfg(test)]\npub(crate) mod tests")
        yield path, text[:tests] if tests >= 0 else text


def pattern(code):
    """Make a regular expression of code, white space aside; its group is what is replaced."""
    before, rest = code.split("{{")
    old, after = rest.split("}}")
    parts = []
    for part in (before, old, after):
        tokens = re.findall(r"\w+|[^\w\s]", part)
        parts.append(r"\s*".join(re.escape(token) for token in tokens))
    before, old, after = parts
    return re.compile(rf"{before}\s*({old})\s*{after}" if before else rf"({old})\s*{after}")


def locate(root):
    """Where each change stands: (file, start, end), or the script stops."""
    texts = list(sources(root))
    places, faults = [], []
    for number, mutation in enumerate(MUTATIONS, 1):
        found = [
            (path, match.span(1))
            for path, text in texts
            for match in pattern(mutation.code).finditer(text)
        ]
        if len(found) != 1:
            where = ", ".join(str(path.relative_to(root)) for path, _ in found) or "nowhere"
            faults.append(f"{number} ({mutation.what}): {len(found)} times, {where}")
        places.append(found[0] if found else None)
    if faults:
        sys.exit("the code of these rows has to occur exactly once:\n  " + "\n  ".join(faults))
    return places


def write(root, changes):
    """Write all changes (file, place, new text) into the sources, each behind its number."""
    by_file = {}
    for number, (path, span, new) in enumerate(changes, 1):
        by_file.setdefault(path, []).append((span, number, new))
    for path, here in by_file.items():
        text = path.read_text()
        # inner changes of an expression before the outer one: from the back, the shorter one first
        here.sort(key=lambda change: (-change[0][0], change[0][1]))
        for k, ((start, end), number, new) in enumerate(here):
            crate = "crate" if "ocmc-core" in path.parts else "ocmc_core"
            old = text[start:end]
            both = f"(if {crate}::mutant({number}) {{ {new} }} else {{ {old} }})"
            text = text[:start] + both + text[end:]
            grown = len(both) - len(old)
            here[k + 1 :] = [
                ((a, b + grown if b >= end else b), *other) for (a, b), *other in here[k + 1 :]
            ]
        path.write_text(text)
    lib = root / "crates/ocmc-core/src/lib.rs"
    lib.write_text(lib.read_text() + SWITCH)


@dataclasses.dataclass
class Drawn:
    """One change that was drawn."""

    subject: str
    file: str
    line: int
    what: str
    span: tuple
    new: str

    def executables(self):
        """Name the executables of its crate's tests, that of the library first."""
        crate = Path(self.file).parts[1]
        return [name for name, (package, _) in EXECUTABLES.items() if package == crate]

    def beside(self):
        """Yield the tests beside its code, then those of its subject in the crates."""
        library, *_ = self.executables()
        inside = Path(self.file).relative_to(Path(*Path(self.file).parts[:3])).with_suffix("")
        module = "::".join(part for part in inside.parts if part != "mod") + "::"
        yield library, [module]
        yield from (stage for stage in self.named() if stage[0] != "it")

    def of_subject(self):
        """List those of its subject in the root, which take longer."""
        return [stage for stage in self.named() if stage[0] == "it"]

    def named(self):
        """Yield the tests that are named for its subject: (executable, filters)."""
        for part in SUBJECTS[self.subject].tests.split(";"):
            name, *filters = part.split()
            yield name, filters

    def others(self):
        """Name all tests of its crate, and those of the root."""
        return [(name, []) for name in (*self.executables(), "it")]


def stream(root, name, seed):
    """Draw changes of a subject, one a site, until all of its sites are used up."""
    subject = SUBJECTS[name]
    texts = dict(sources(root))
    files = {path for pattern in subject.files.split() for path in root.glob(pattern)}
    found = [
        (path, site)
        for path in sorted(files)
        if path.name not in SAYING
        for site in sites(texts[path], subject.word)
    ]
    draws = random.Random(f"{seed} {name}")  # noqa: S311 (nothing secret)
    draws.shuffle(found)
    for path, site in found:
        what, span, new = draws.choice(site.changes)
        yield Drawn(name, str(path.relative_to(root)), site.line, what, span, new)


def draw(root, target, count, seed):
    """Draw changes that compile, and write them into a copy of the tree."""
    streams = [stream(root, name, seed) for name in SUBJECTS]
    drawn = [next(streams[k % len(streams)]) for k in range(count)]
    originals = {path: path.read_text() for path in root.glob("crates/*/src/**/*.rs")}
    while True:
        for path, text in originals.items():
            if path.read_text() != text:
                path.write_text(text)
        write(root, [(root / one.file, one.span, one.new) for one in drawn])
        faulty = do_not_compile(root, target)
        if not faulty:
            return drawn
        for number in sorted(faulty):
            print(
                f"{number} does not compile: {drawn[number - 1].what}", file=sys.stderr, flush=True
            )
            drawn[number - 1] = next(streams[(number - 1) % len(streams)])


def do_not_compile(root, target):
    """Numbers of the changes in which the compiler finds an error."""
    environment = os.environ | {"CARGO_TARGET_DIR": str(target)}
    command = ["cargo", "check", "--release", "--workspace", "--lib", "--locked", "--keep-going"]
    command += ["--exclude", "ocmc-py", "--exclude", "ocmc-tab", "--message-format=json"]
    checked = subprocess.run(command, cwd=root, env=environment, capture_output=True, check=False)
    if checked.returncode == 0:
        return set()
    faulty, rendered = set(), []
    for line in checked.stdout.decode().splitlines():
        message = json.loads(line).get("message") or {}
        if message.get("level") == "error":
            rendered.append(message["rendered"])
            at = [
                (root / s["file_name"], s["line_start"], s["column_start"])
                for s in message["spans"]
            ]
            faulty |= {number for place in at if (number := innermost(*place))}
    return faulty or sys.exit("\n".join(rendered) or checked.stderr.decode())


def innermost(path, line, column):
    """Find the number of the innermost change around a place."""
    if "crates" not in path.parts:
        return None
    text = path.read_text()
    place = sum(len(row) for row in text.splitlines(keepends=True)[: line - 1]) + column - 1
    code = code_only(text)
    around = [
        (match.start(), int(match[1]))
        for match in re.finditer(r"\(if \w+::mutant\((\d+)\)", code)
        if match.start() <= place < closing(code, match.start())
    ]
    return max(around)[1] if around else None


def build(root, target):
    """Compiles the tests; their executables by name."""
    environment = os.environ | {"CARGO_TARGET_DIR": str(target)}
    command = [
        "cargo",
        "test",
        "--no-run",
        "--release",
        "--workspace",
        "--lib",
        "--test",
        "it",
        "--locked",
    ]
    command += ["--message-format=json-render-diagnostics"]
    built = subprocess.run(command, cwd=root, env=environment, stdout=subprocess.PIPE, check=True)
    lines = built.stdout.decode().splitlines()
    found = {}
    for line in lines:
        message = json.loads(line)
        if message.get("executable") and message["profile"]["test"]:
            folder = Path(message["manifest_path"]).parent
            package = "ocmc" if folder == root else folder.name
            kind = "test" if message["target"]["kind"] == ["test"] else "lib"
            for name, wanted in EXECUTABLES.items():
                if wanted == (package, kind):
                    found[name] = (message["executable"], folder)
    missing = EXECUTABLES.keys() - found.keys()
    return found if not missing else sys.exit(f"no executable of {sorted(missing)}")


def bound_memory():
    """Let no test take the machine's memory."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))


def run(executable, filters, number, limit_s=LIMIT_S):
    """Name of the first test that fails with a change turned on, as a list."""
    program, folder = executable
    command = [program, "--skip", SKIPPED, *filters]
    environment = os.environ | {VARIABLE: str(number)}
    tests = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        preexec_fn=bound_memory,  # noqa: PLW1509 (before any thread starts)
    )

    def end():
        # the programs that the tests have started, too
        with contextlib.suppress(ProcessLookupError):
            os.killpg(tests.pid, signal.SIGKILL)

    clock = threading.Timer(limit_s, end)
    clock.start()
    try:
        for line in tests.stdout:
            text = line.decode(errors="replace")
            if failed := re.match(r"^test (\S+)(?: - should panic)? \.\.\. FAILED$", text):
                return [failed[1]]
        status = tests.wait()
        return [] if status == 0 else ["(aborted)" if clock.is_alive() else "(no end)"]
    finally:
        clock.cancel()
        end()
        tests.wait()


def check_names(executables, rows):
    """Stop where a row, or a subject, names tests that are not there."""
    lists = {}
    for name, (program, folder) in executables.items():
        listed = subprocess.run([program, "--list"], cwd=folder, capture_output=True, check=True)
        lists[name] = re.findall(r"^(\S+): test$", listed.stdout.decode(), re.MULTILINE)
    faults = []
    for row, tests in rows.items():
        for part in tests.split(";"):
            name, *filters = part.split()
            missing = [
                wanted for wanted in filters if not any(wanted in test for test in lists[name])
            ]
            faults += [f"{row}: no test {wanted} in {name}" for wanted in missing]
    if faults:
        sys.exit("these rows name tests that are not there:\n  " + "\n  ".join(faults))


def notice(executables, number, mutation):
    """(whether the named tests notice it, name of the first that does)."""
    for part in mutation.tests.split(";"):
        name, *filters = part.split()
        if failed := run(executables[name], filters, number):
            return True, failed
    for executable in executables.values():
        if failed := run(executable, [], number):
            return False, failed
    return False, []


def main():
    """Read the arguments, build, run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("numbers", type=int, nargs="*", help="only these changes")
    parser.add_argument("--list", action="store_true", help="only say where they stand")
    parser.add_argument(
        "--draw", type=int, metavar="N", help="draw so many changes in place of the list"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the drawing; default: 1")
    parser.add_argument(
        "--progress", type=Path, help="file of what was found, from which a run goes on"
    )
    parser.add_argument("--target", type=Path, help="where cargo builds; default: in the copy")
    parser.add_argument(
        "--copy", type=Path, help="where the tree is copied to; one that is there is used as it is"
    )
    arguments = parser.parse_args()
    here = Path(__file__).resolve().parents[1]
    if arguments.list and not arguments.draw:
        for number, (mutation, (path, _)) in enumerate(
            zip(MUTATIONS, locate(here), strict=True), 1
        ):
            print(f"{number:3} {path.relative_to(here)}: {mutation.what}")
        return
    with tempfile.TemporaryDirectory() as folder:
        root = (arguments.copy or Path(folder) / "ocmc").resolve()
        target = (arguments.target or root / "target").resolve()
        os.environ.setdefault("OCMC_DATA", str(here.parent / "shared" / "data"))
        is_new = not (arguments.copy and root.exists())
        if is_new:
            shutil.copytree(here, root, ignore=shutil.ignore_patterns("target", ".git"))
        if arguments.draw:
            draw_and_report(arguments, root, target)
            return
        if is_new:
            news = [mutation.new for mutation in MUTATIONS]
            write(root, [(*place, new) for place, new in zip(locate(root), news, strict=True)])
        executables = build(root, target)
        check_names(executables, {number: row.tests for number, row in enumerate(MUTATIONS, 1)})
        if not arguments.numbers:
            for name, executable in executables.items():
                if failed := run(executable, [], 0):
                    sys.exit(f"without a change these fail in {name}: {failed}")
        report(executables, arguments.numbers or range(1, len(MUTATIONS) + 1))


class Search:
    """Tests that notice drawn changes; what is found is kept in a file, from which it goes on."""

    def __init__(self, executables, file):
        """Read what is known from the file, if there is one."""
        self.executables, self.file, self.known = executables, file, {}
        if file and file.exists():
            self.known = dict(json.loads(line) for line in file.read_text().splitlines())

    def once(self, key, find):
        """Return what is known under a key, or find it and keep it."""
        if key not in self.known:
            self.known[key] = find()
            if self.file:
                with self.file.open("a") as file:
                    file.write(json.dumps([key, self.known[key]]) + "\n")
        return self.known[key]

    def takes_s(self, name, filters):
        """How long tests take without a change."""
        begin = time.monotonic()
        if failed := run(self.executables[name], filters, 0):
            sys.exit(f"without a change these fail in {name} {filters}: {failed}")
        return time.monotonic() - begin

    def noticed_by(self, number, stages):
        """Find the first test that notices a change, with its executable; none where none is."""
        for name, filters in stages:
            key = " ".join([name, *filters])
            takes_s = self.once(key, lambda name=name, filters=filters: self.takes_s(name, filters))
            limit_s = LEAST_LIMIT_S + 5 * takes_s
            if failed := run(self.executables[name], filters, number, limit_s):
                return f"{name} {failed[0]}"
        return ""


def draw_and_report(arguments, root, target):
    """Draw changes, or take those of the copy; run them, and print the table and the share."""
    kept = root / "drawn.json"
    if kept.exists():
        drawn = [Drawn(**row) for row in json.loads(kept.read_text())]
    else:
        drawn = draw(root, target, arguments.draw, arguments.seed)
        kept.write_text(json.dumps([dataclasses.asdict(one) for one in drawn]))
    if arguments.list:
        for number, one in enumerate(drawn, 1):
            print(f"{number:3} {one.subject}: {one.file}:{one.line}: {one.what}")
        return
    executables = build(root, target)
    check_names(executables, {name: subject.tests for name, subject in SUBJECTS.items()})
    search = Search(executables, arguments.progress)
    numbers = arguments.numbers or range(1, len(drawn) + 1)
    found = {}
    print("| # | subject | place | change | noticed by |\n|---|---|---|---|---|", flush=True)
    for stages in (Drawn.beside, Drawn.of_subject, Drawn.others):
        for number in [number for number in numbers if not found.get(number)]:
            one = drawn[number - 1]
            find = functools.partial(search.noticed_by, number, stages(one))
            found[number] = search.once(f"{number} {stages.__name__}", find)
            if found[number] or stages is Drawn.others:
                by = f"`{found[number]}`" if found[number] else "UNNOTICED"
                place = f"{one.file}:{one.line}"
                print(f"| {number} | {one.subject} | {place} | {one.what} | {by} |", flush=True)
    noticed = sum(map(bool, found.values()))
    print(f"\n{noticed} of {len(numbers)} noticed ({noticed / len(numbers):.0%}).")


def report(executables, numbers):
    """Run the changes and print the table and the shares."""
    print("| # | change | noticed by |\n|---|---|---|", flush=True)
    principled = noticed = 0
    for number in numbers:
        begin = time.monotonic()
        mutation = MUTATIONS[number - 1]
        named, failed = notice(executables, number, mutation)
        principled += named
        noticed += bool(failed)
        by = f"`{failed[0]}`" if failed else "UNNOTICED"
        chance = "" if named or not failed else " (not named)"
        print(f"| {number} | {mutation.what} | {by}{chance} |", flush=True)
        print(f"{number}: {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    count = len(numbers)
    print(
        f"\n{noticed} of {count} noticed ({noticed / count:.0%}), "
        f"{principled} by the tests named for them ({principled / count:.0%})."
    )


if __name__ == "__main__":
    main()
