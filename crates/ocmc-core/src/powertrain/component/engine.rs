//! Diesel engine: full-load and drag curves, and fuel map.
//!
//! Curves are linear between the given points, the map is bilinear in its cells; beyond their ends
//! they continue the last slope, but drag stays below zero and full load does not fall below drag.
//! An empty cell of the map continues the last slope in torque. Below zero torque, fuel falls
//! linearly from the map's value at 0 Nm to zero at the drag torque, and is zero below (fuel below
//! zero torque).
//!
//! In the hot loop the pieces of the curves and the cells of the map are found by tables of bytes
//! (`piece_table.rs`).
//!
//! Checked: the map returns its own points, and agrees with a fitted polynomial (rms 4.8 kW) within
//! its largest error of 9.4 kW. Nothing breaks beyond the map, whatever the map and the truck, and
//! the time there is that of the trace (`tests/it/map_corners.rs`). The fuel of whole traces is
//! evaluated again from the map (`tests/it/energy_balance.rs`).

use crate::validation::{Problems, rises};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bilinear::{Cells, cells};
use super::piece_table::PieceTable;
use crate::distribution::Quantity;
use crate::energy::Carrier;
use crate::lanes::{Bounded, Lanes, WIDTH, columns, one};
use fearless_simd::prelude::*;

/// A diesel engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineModel {
    /// Moment of inertia, in kg m².
    #[schemars(range(min = 0.01, max = 100.0))]
    pub inertia_kgm2: f64,
    /// Idle speed, in rad/s.
    #[schemars(range(min = 20.0, max = 150.0))]
    pub idle_speed_radps: f64,
    /// Time constant of the torque, in s.
    #[schemars(range(min = 0.2, max = 5.0))]
    pub torque_lag_s: f64,
    /// Engine speeds of the full-load curve, in rad/s.
    #[schemars(inner(range(min = 10.0, max = 1024.0)))]
    pub full_load_speed_radps: Vec<f64>,
    /// Full-load torque, in Nm.
    #[schemars(inner(range(min = 1.0, max = 4096.0)))]
    pub full_load_torque_nm: Vec<f64>,
    /// Engine speeds of the map and the drag curve, in rad/s.
    #[schemars(inner(range(min = 10.0, max = 1024.0)))]
    pub map_speed_radps: Vec<f64>,
    /// Drag torque (negative), in Nm, at the map's speeds.
    #[schemars(inner(range(min = -4096.0, max = -0.1)))]
    pub drag_torque_nm: Vec<f64>,
    /// Torques of the map from 0 up, in Nm.
    #[schemars(inner(range(min = 0.0, max = 4096.0)))]
    pub map_torque_nm: Vec<f64>,
    /// Fuel, in kg/s: a row for each speed, a column for each torque; rows may end early.
    #[schemars(inner(inner(range(min = 0.0, max = 1.0))))]
    pub map_fuel_kgps: Vec<Vec<f64>>,
    /// Speed of the engine while the body takes power at a stop (`mission.stops.power_take_off`),
    /// in rad/s; absent: that of idling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 20.0, max = 400.0))]
    pub power_take_off_speed_radps: Option<f64>,
    /// Factor on the fuel map.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub fuel_factor: Quantity,
    /// The fuel.
    pub fuel: FuelModel,
}

impl EngineModel {
    /// Curves and a map of rising speeds and torques, each with as many values as it needs.
    pub fn validate(&self, problems: &mut Problems) {
        for (key, knots) in [
            ("full_load_speed_radps", &self.full_load_speed_radps),
            ("map_speed_radps", &self.map_speed_radps),
            ("map_torque_nm", &self.map_torque_nm),
        ] {
            let fits = rises(knots) && (2..=MOST_KNOTS).contains(&knots.len());
            problems.require(fits, key, format!("{knots:?}"), "2 to 16 rising numbers");
        }
        let (curve, rows) = (self.full_load_speed_radps.len(), self.map_speed_radps.len());
        let map_rows = "a row for each of map_speed_radps";
        for (key, have, want, allowed) in [
            (
                "full_load_torque_nm",
                self.full_load_torque_nm.len(),
                curve,
                "as many as full_load_speed_radps",
            ),
            ("drag_torque_nm", self.drag_torque_nm.len(), rows, "as many as map_speed_radps"),
            ("map_fuel_kgps", self.map_fuel_kgps.len(), rows, map_rows),
        ] {
            problems.require(have == want, key, format!("{have} entries"), allowed);
        }
        problems.require(
            self.map_torque_nm.first() == Some(&0.0),
            "map_torque_nm",
            format!("{:?}", self.map_torque_nm),
            "torques that begin with 0",
        );
        let columns = 2..=self.map_torque_nm.len();
        problems.require(
            self.map_fuel_kgps.iter().all(|row| columns.contains(&row.len())),
            "map_fuel_kgps",
            "a row of another length",
            "2 to as many columns as map_torque_nm in each row",
        );
        problems.part("fuel", |problems| self.fuel.validate(problems));
    }

    /// Largest power at the points of the full load, in W.
    pub fn peak_power_w(&self) -> f64 {
        let points = self.full_load_speed_radps.iter().zip(&self.full_load_torque_nm);
        points.fold(0.0, |most, (speed, torque)| libm::fmax(most, speed * torque))
    }

    /// Speed while the body takes power, in rad/s.
    pub fn working_radps(&self) -> f64 {
        let idle_radps = self.idle_speed_radps;
        self.power_take_off_speed_radps.map_or(idle_radps, |wanted| wanted.max(idle_radps))
    }

    /// Whether a speed in rad/s and a torque in Nm lie within the points of the map; below zero
    /// torque there is nothing to know.
    pub fn map_covers(&self, speed_radps: f64, torque_nm: f64) -> bool {
        torque_nm <= self.map_reach_nm(speed_radps)
    }

    /// Torque up to which the map has points at a speed in rad/s, in Nm; without end below zero
    /// where it has none.
    fn map_reach_nm(&self, speed_radps: f64) -> f64 {
        let [at_rest_nm, slope_nms] = self.map_reach(speed_radps);
        at_rest_nm + slope_nms * speed_radps
    }

    /// The same as a line over the speed that holds from the row before a speed to the one behind
    /// it: from the last point of the one to the last point of the other. At rest, in Nm, and its
    /// slope, in Nm s.
    fn map_reach(&self, speed_radps: f64) -> [f64; 2] {
        let speeds = &self.map_speed_radps;
        let above = speeds.partition_point(|knot| *knot < speed_radps);
        if speed_radps < speeds[0] || above == speeds.len() {
            return [f64::NEG_INFINITY, 0.0];
        }
        let last_nm = |row: usize| self.map_torque_nm[self.map_fuel_kgps[row].len() - 1];
        if speeds[above] <= speed_radps {
            return [last_nm(above), 0.0];
        }
        let slope_nms = (last_nm(above) - last_nm(above - 1)) / (speeds[above] - speeds[above - 1]);
        [last_nm(above) - slope_nms * speeds[above], slope_nms]
    }
}

/// A fuel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FuelModel {
    /// Carrier: `liquid_fuel`, `methane` or `hydrogen`.
    pub carrier: Carrier,
    /// Density, in kg/m³.
    #[schemars(range(min = 50.0, max = 2000.0))]
    pub density_kgpm3: f64,
    /// Lower heating value, in J/kg.
    #[schemars(range(min = 1.0e6, max = 2.0e8))]
    pub heating_value_jpkg: f64,
    /// Carbon dioxide for each kg of fuel, in kg.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub co2_kg_per_kg: f64,
}

impl FuelModel {
    /// A carrier that burns, with a heating value that it can have.
    fn validate(&self, problems: &mut Problems) {
        let declared = self.carrier.declaration();
        let Some([least, most]) = declared.heating_value_jpkg else {
            return problems.require(false, "carrier", declared.name, "what an engine can burn");
        };
        let is_known = (least..=most).contains(&self.heating_value_jpkg);
        let allowed = format!("{least:e} to {most:e} for {}", declared.name);
        problems.require(is_known, "heating_value_jpkg", self.heating_value_jpkg, &allowed);
    }
}

/// Torques that differ by this share are the same: full load often ends where the map does.
const ROUNDING: f64 = 1e-9;

/// Speed covered by the byte table, in rad/s: 0.25 rad/s a cell. Faster engines have it twice or
/// four times as wide.
const SPEED_SPAN_RADPS: f64 = 256.0;
/// Torque covered by the byte table, in Nm: 4 Nm a cell.
const TORQUE_SPAN_NM: f64 = 4096.0;

/// Most pieces of the full-load and drag curves: what a byte can tell apart.
const MOST_PIECES: usize = 256;
/// Most knots of the map in speed and in torque.
pub const MOST_KNOTS: usize = 16;

/// Full load and drag at one engine speed: value at zero speed and slope of the piece.
pub type CurveRow = [f64; 4];

/// A piece of the full-load and drag curves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(128))]
struct CurvePiece {
    /// The lines of full load and drag.
    row: CurveRow,
    /// The lines of full load below and above the piece where they end it, as its own otherwise:
    /// [`Curves::full_load_nm`].
    bounds: CurveRow,
    /// Where the piece begins and ends, in rad/s, and the torque up to which the map has points, a
    /// line over the speed: at rest, in Nm, without end below zero where it has none, and its
    /// slope.
    reach: [f64; 4],
}

/// Full load, drag and the reach of the map of some engines.
#[derive(Clone, Copy, Debug)]
pub struct Curves<S: Simd> {
    /// Full-load torque at zero speed, in Nm, and its slope; the same of drag.
    pub lines: [Lanes<S>; 4],
    /// The same of the full-load lines that it must not exceed beside its own.
    pub bounds: [Lanes<S>; 4],
    /// Torque up to which the map has points, in Nm.
    pub map_torque: Lanes<S>,
}

impl<S: Simd> Curves<S> {
    /// Full load at speeds that have left the piece, in rad/s, by a piece at most: the least of the
    /// piece's line and of the next ones, where the curve bends down. Never above the curve.
    #[inline(always)]
    pub fn full_load_nm(&self, speed_radps: Lanes<S>) -> Lanes<S> {
        let [full_0, full_1, _, _] = self.lines;
        let [below_0, below_1, above_0, above_1] = self.bounds;
        let own = full_0 + full_1 * speed_radps;
        let below = below_0 + below_1 * speed_radps;
        own.at_most(below).at_most(above_0 + above_1 * speed_radps)
    }
}

/// An engine prepared for the hot loop.
#[derive(Clone, Debug)]
pub struct Engine {
    /// The pieces of the full-load and drag curves, of which there are less than bytes.
    curves: Box<[CurvePiece; MOST_PIECES]>,
    curve_pieces: PieceTable,
    peak_torque_nm: f64,
    map_speed_pieces: PieceTable,
    map_torque_pieces: PieceTable,
    /// The map's cells; those of one speed lie together.
    cells: Cells,
}

impl Engine {
    /// Prepares a checked model.
    pub fn new(model: &EngineModel) -> Self {
        let (curve_knots, rows) = saturated_curves(model);
        let empty = CurvePiece { row: [0.0; 4], bounds: [0.0; 4], reach: [0.0; 4] };
        #[expect(
            clippy::large_stack_arrays,
            reason = "32 KiB, once a study, on their way to the heap"
        )]
        let mut curves = Box::new([empty; MOST_PIECES]);
        for (k, (piece, row)) in curves.iter_mut().zip(&rows).enumerate() {
            let from_radps = k.checked_sub(1).map_or(f64::NEG_INFINITY, |k| curve_knots[k]);
            let to_radps = curve_knots.get(k).copied().unwrap_or(f64::INFINITY);
            let [map_nm, map_nms] =
                model.map_reach(middle(&curve_knots, k)).map(|part| part * (1.0 + ROUNDING));
            let bounds = full_load_bounds(&rows, k);
            let reach = [from_radps, to_radps, map_nm, map_nms];
            *piece = CurvePiece { row: *row, bounds, reach };
        }
        let map = filled_map(&model.map_torque_nm, &model.map_fuel_kgps);
        let (speeds, torques) = (&model.map_speed_radps, &model.map_torque_nm);
        let cells = cells(speeds, torques, &map);
        let fastest = speeds[speeds.len() - 1];
        let mut span = SPEED_SPAN_RADPS;
        while span < fastest {
            span *= 2.0;
        }
        Self {
            curves,
            curve_pieces: PieceTable::new(&curve_knots, span, 1),
            peak_torque_nm: model.full_load_torque_nm.iter().copied().fold(0.0, f64::max),
            map_speed_pieces: PieceTable::new(inner(speeds), span, MOST_KNOTS as u8),
            map_torque_pieces: PieceTable::new(inner(torques), TORQUE_SPAN_NM, 1),
            cells,
        }
    }

    /// The lines of full load and drag that hold at a speed.
    fn curve_row(&self, speed_radps: f64) -> &CurveRow {
        self.curve_rows(speed_radps)[0]
    }

    /// The same, and the lines of full load below and above them.
    pub fn curve_rows(&self, speed_radps: f64) -> [&CurveRow; 2] {
        // the table knows the piece but for the width of a cell
        let mut k = self.curve_pieces.piece_of_number(speed_radps) as usize;
        while speed_radps < self.curves[k].reach[0] {
            k -= 1;
        }
        while speed_radps >= self.curves[k].reach[1] {
            k += 1;
        }
        [&self.curves[k].row, &self.curves[k].bounds]
    }

    /// Full load and drag at some speeds, in rad/s: within a cell of the table the line of the
    /// piece that it mostly belongs to.
    #[inline(always)]
    pub fn curves_at<S: Simd>(&self, speed_radps: Lanes<S>) -> Curves<S> {
        let simd = speed_radps.simd;
        let cells = self.curve_pieces.cells(speed_radps);
        let pieces: [&CurvePiece; WIDTH] = std::array::from_fn(
            #[inline(always)]
            |lane| &self.curves[self.curve_pieces.piece_of(cells[lane]) as usize],
        );
        let lines = columns(
            simd,
            #[inline(always)]
            |lane| &pieces[lane].row,
        );
        let bounds = columns(
            simd,
            #[inline(always)]
            |lane| &pieces[lane].bounds,
        );
        let [_, _, map_0, map_1] = columns(
            simd,
            #[inline(always)]
            |lane| &pieces[lane].reach,
        );
        Curves { lines, bounds, map_torque: map_0 + map_1 * speed_radps }
    }

    /// Highest full-load torque, in Nm.
    pub fn peak_torque_nm(&self) -> f64 {
        self.peak_torque_nm
    }

    /// Torques of full load and of drag, in Nm.
    pub fn full_and_drag_nm(&self, speed_radps: f64) -> [f64; 2] {
        let [full_nm, full_nms, drag_nm, drag_nms] = *self.curve_row(speed_radps);
        [full_nm + full_nms * speed_radps, drag_nm + drag_nms * speed_radps]
    }

    /// Full-load torque, in Nm.
    pub fn full_load_nm(&self, speed_radps: f64) -> f64 {
        self.full_and_drag_nm(speed_radps)[0]
    }

    /// Drag torque (negative), in Nm.
    pub fn drag_nm(&self, speed_radps: f64) -> f64 {
        self.full_and_drag_nm(speed_radps)[1]
    }

    /// Fuel of some engines, in kg/s, before the vehicles' factors; the drag torque is that at the
    /// speed.
    #[inline(always)]
    pub fn fuel_rates<S: Simd>(
        &self,
        speed_radps: Lanes<S>,
        torque_nm: Lanes<S>,
        drag_torque_nm: Lanes<S>,
    ) -> Lanes<S> {
        let powered = torque_nm.at_least(0.0);
        let speed_cells = self.map_speed_pieces.cells(speed_radps);
        let torque_cells = self.map_torque_pieces.cells(powered);
        let [a, b, c, d] = columns(
            speed_radps.simd,
            #[inline(always)]
            |l| {
                let row = self.map_speed_pieces.piece_of(speed_cells[l]);
                let column = self.map_torque_pieces.piece_of(torque_cells[l]);
                &self.cells[(row | column) as usize]
            },
        );
        let map = a + b * speed_radps + powered * (c + d * speed_radps);
        let overrun = 1.0 - torque_nm.at_most(0.0) / drag_torque_nm;
        map.at_least(0.0) * overrun.at_least(0.0)
    }

    /// Fuel of one engine, in kg/s, before the vehicle's factor.
    pub fn fuel_kgps(&self, speed_radps: f64, torque_nm: f64) -> f64 {
        self.fuel_of_kgps(speed_radps, torque_nm, self.drag_nm(speed_radps))
    }

    /// The same where the drag torque at the speed is known, in Nm.
    pub fn fuel_of_kgps(&self, speed_radps: f64, torque_nm: f64, drag_nm: f64) -> f64 {
        self.fuel_rates(one(speed_radps), one(torque_nm), one(drag_nm))[0]
    }
}

/// Least drag torque, without sign, in Nm: what the bounds of a study allow at a point.
const LEAST_DRAG_NM: f64 = 0.1;

/// The lines of full load and drag by pieces of engine speed, and the speeds in rad/s at which the
/// pieces meet; the ends of the map are among them. Drag stays below zero, and full load does not
/// fall below drag.
fn saturated_curves(model: &EngineModel) -> (Vec<f64>, Vec<CurveRow>) {
    let full = (&model.full_load_speed_radps, &model.full_load_torque_nm);
    let drag = (&model.map_speed_radps, &model.drag_torque_nm);
    let least = (-LEAST_DRAG_NM, 0.0);
    let lines =
        |speed_radps| (line_at(full.0, full.1, speed_radps), line_at(drag.0, drag.1, speed_radps));
    let mut knots: Vec<f64> = inner(full.0).iter().chain(drag.0).copied().collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    // where a line begins to be held
    let mut crossings = Vec::new();
    for piece in 0..=knots.len() {
        let (f, d) = lines(middle(&knots, piece));
        let within = |speed: &f64| knots.partition_point(|knot| knot < speed) == piece;
        let meet = [(f, d), (f, least), (d, least)].map(|(a, b)| (b.0 - a.0) / (a.1 - b.1));
        crossings.extend(meet.into_iter().filter(|speed| speed.is_finite()).filter(within));
    }
    knots.extend(crossings);
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    let row = |piece| {
        let inside = middle(&knots, piece);
        let at = |line: (f64, f64)| line.0 + line.1 * inside;
        let (f, d) = lines(inside);
        let d = if at(d) > at(least) { least } else { d };
        let f = if at(f) < at(d) { d } else { f };
        [f.0, f.1, d.0, d.1]
    };
    let rows = (0..=knots.len()).map(row).collect();
    (knots, rows)
}

/// The full-load lines of the pieces below and above number `piece`, where the curve bends down
/// between them; its own where it bends up, so that the least of all is never above the curve.
fn full_load_bounds(rows: &[CurveRow], piece: usize) -> CurveRow {
    let own = rows[piece];
    // a corner of the drag's curve alone parts pieces with one line of full load
    let other = |row: &&CurveRow| row[..2] != own[..2];
    let bends_down = |lower: &CurveRow, upper: &CurveRow| upper[1] < lower[1];
    let below = rows[..piece].iter().rev().find(other).filter(|below| bends_down(below, &own));
    let above = rows[piece..].iter().find(other).filter(|above| bends_down(&own, above));
    let (below, above) = (below.unwrap_or(&own), above.unwrap_or(&own));
    [below[0], below[1], above[0], above[1]]
}

fn inner(points: &[f64]) -> &[f64] {
    &points[1..points.len() - 1]
}

/// A place inside piece number `piece` of the pieces that `knots` part.
fn middle(knots: &[f64], piece: usize) -> f64 {
    match (piece.checked_sub(1).map(|k| knots[k]), knots.get(piece)) {
        (Some(a), Some(b)) => 0.5 * (a + b),
        (Some(a), None) => a + 1.0,
        (None, Some(b)) => b - 1.0,
        (None, None) => 0.0,
    }
}

/// Value at zero and slope of the piece of a polygon that holds at `x`.
fn line_at(xs: &[f64], ys: &[f64], x: f64) -> (f64, f64) {
    let k = xs[1..xs.len() - 1].iter().filter(|knot| **knot <= x).count();
    let slope = (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k]);
    (ys[k] - slope * xs[k], slope)
}

/// The map with its empty cells filled: each continues the row's last slope in torque.
fn filled_map(torques: &[f64], rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    rows.iter()
        .map(|row| {
            let mut full = row.clone();
            while full.len() < torques.len() {
                let k = full.len();
                let slope = (full[k - 1] - full[k - 2]) / (torques[k - 1] - torques[k - 2]);
                full.push(full[k - 1] + slope * (torques[k] - torques[k - 1]));
            }
            full
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine_b::engine_b;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn the_map_returns_its_own_points() {
        let model = engine_b();
        let engine = Engine::new(&model);
        for (w, row) in model.map_speed_radps.iter().zip(&model.map_fuel_kgps) {
            for (t, fuel) in model.map_torque_nm.iter().zip(row) {
                let got = engine.fuel_kgps(*w, *t);
                assert!((got / fuel - 1.0).abs() < 1e-9, "{w} {t}: {got} {fuel}");
            }
        }
        for (w, t) in model.full_load_speed_radps.iter().zip(&model.full_load_torque_nm) {
            assert!((engine.full_load_nm(*w) / t - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn an_empty_cell_continues_the_last_slope_of_its_row() {
        // rows at 100 and 200 rad/s over 0, 100, 200, 400 and 800 Nm, in mg/s. The first one is
        // convex and ends at 200 Nm: its slopes are 10 and 30, the mean of both is 20
        let fuel_kgps = |row: &[f64]| row.iter().map(|mgps| mgps * 1e-6).collect();
        let model = EngineModel {
            map_speed_radps: vec![100.0, 200.0],
            drag_torque_nm: vec![-100.0, -100.0],
            map_torque_nm: vec![0.0, 100.0, 200.0, 400.0, 800.0],
            map_fuel_kgps: vec![
                fuel_kgps(&[1000.0, 2000.0, 5000.0]),
                fuel_kgps(&[3000.0, 6000.0, 9000.0, 19_000.0]),
            ],
            ..engine_b()
        };
        let engine = Engine::new(&model);
        for (w, t, mgps) in [
            (100.0, 150.0, 3500.0),
            (100.0, 200.0, 5000.0),
            (100.0, 300.0, 8000.0),
            (100.0, 400.0, 11_000.0),
            (100.0, 800.0, 23_000.0),
            (100.0, 900.0, 26_000.0),
            // the second row has slopes of 30, 30 and 50
            (200.0, 600.0, 29_000.0),
            (200.0, 800.0, 39_000.0),
            (150.0, 600.0, 0.5 * (17_000.0 + 29_000.0)),
        ] {
            let got = engine.fuel_kgps(w, t) * 1e6;
            assert!((got / mgps - 1.0).abs() < 1e-9, "{w} {t}: {got} {mgps}");
        }
    }

    #[test]
    fn the_map_agrees_with_the_fitted_polynomial() {
        // a polynomial fitted to the map: P = 203.79 w + .8413 w^2 + 1.7072 w T + 1.988e-4 w T^2,
        // rms 4.8, max 9.4 kW
        let engine = Engine::new(&engine_b());
        for rpm in [900.0, 1100.0, 1300.0, 1500.0] {
            for t in [200.0, 700.0, 1200.0, 1600.0] {
                let w: f64 = rpm * std::f64::consts::PI / 30.0;
                let fit = 203.79 * w + 0.8413 * w * w + 1.7072 * w * t + 1.988e-4 * w * t * t;
                let power = engine.fuel_kgps(w, t) * 42.7e6;
                assert!((power - fit).abs() < 9.4e3, "{rpm} {t}: {power} {fit}");
            }
        }
    }

    #[test]
    fn the_map_knows_its_edges() {
        let model = engine_b();
        let rpm = |n: f64| n * std::f64::consts::PI / 30.0;
        assert!(model.map_covers(rpm(1053.0), 2134.0) && model.map_covers(rpm(1200.0), -300.0));
        // the rows of 1367 and 1490 rpm end at 2134 and 1707 Nm: a line between them
        assert!(!model.map_covers(rpm(1450.0), 1900.0) && model.map_covers(rpm(1450.0), 1800.0));
        assert!(!model.map_covers(rpm(1490.0), 1750.0) && model.map_covers(rpm(1300.0), 2000.0));
        assert!(!model.map_covers(rpm(1900.0), 100.0) && !model.map_covers(rpm(590.0), 100.0));
    }

    #[test]
    fn overrun_cuts_the_fuel() {
        let engine = Engine::new(&engine_b());
        let (w, idle) = (110.0, engine.fuel_kgps(110.0, 0.0));
        let drag = engine.drag_nm(w);
        assert!(engine.fuel_kgps(w, drag) == 0.0 && engine.fuel_kgps(w, 2.0 * drag) == 0.0);
        assert!((engine.fuel_kgps(w, 0.5 * drag) / idle - 0.5).abs() < 1e-12);
    }

    #[test]
    fn beyond_the_map_nothing_breaks() {
        // drag that falls with speed, and a full-load curve that ends long before the map
        let falling = EngineModel {
            drag_torque_nm: (0..10).map(|k| f64::from(10 * k) - 100.0).collect(),
            full_load_speed_radps: vec![62.8, 90.0],
            full_load_torque_nm: vec![900.0, 500.0],
            ..engine_b()
        };
        for model in [engine_b(), falling] {
            let engine = Engine::new(&model);
            for w in [0.0, 10.0, 100.0, 150.0, 240.0, 400.0, 1e6] {
                let (full, drag) = (engine.full_load_nm(w), engine.drag_nm(w));
                assert!(drag <= -0.09 && full >= drag, "{w}: {drag} {full}");
                for t in [-1e5, drag, 0.0, 3000.0, 1e5] {
                    let fuel = engine.fuel_kgps(w, t);
                    assert!(fuel >= 0.0 && fuel.is_finite(), "{w} {t}: {fuel}");
                }
            }
        }
    }

    #[test]
    fn a_piece_knows_how_far_the_map_reaches() {
        let model = engine_b();
        let engine = Engine::new(&model);
        for rpm in
            [500.0, 590.0, 610.0, 760.0, 1100.0, 1300.0, 1400.0, 1500.0, 1700.0, 1850.0, 1900.0]
        {
            let w = rpm * std::f64::consts::PI / 30.0;
            let map_torque_nm = dispatch!(Level::baseline(), simd => {
                engine.curves_at(Lanes::splat(simd, w)).map_torque[0]
            });
            for t in [-100.0, 0.0, 800.0, 1200.0, 1500.0, 1900.0, 2200.0] {
                let covers = model.map_covers(w, t);
                assert_eq!(covers, t <= map_torque_nm, "{rpm} {t}");
            }
        }
    }

    #[test]
    fn full_load_is_never_above_the_curve() {
        // a curve that bends up at 100 and down at 147 and 188 rad/s, seen from each piece's end
        let model = engine_b();
        let engine = Engine::new(&model);
        for k in 600..2200 {
            let from = 0.1 * f64::from(k);
            for step in [-3.0, -1.0, -0.1, 0.0, 0.1, 1.0, 3.0, 8.0] {
                let w = from + step;
                let seen = dispatch!(Level::baseline(), simd => {
                    let curves = engine.curves_at(Lanes::splat(simd, from));
                    curves.full_load_nm(Lanes::splat(simd, w))[0]
                });
                let curve = engine.full_load_nm(w);
                assert!(seen <= curve + 1e-9, "{from} {w}: {seen} {curve}");
                // within the piece it is the curve, but for the width of a cell
                assert!(step != 0.0 || seen > curve - 3.0, "{from}: {seen} {curve}");
            }
        }
    }

    #[test]
    fn curves_from_the_table_are_the_lines() {
        let engine = Engine::new(&engine_b());
        // half a cell beyond its end a line of some 23 Nm s is 3 Nm away from the next one
        let (mut most_nm, mut exact) = (0.0_f64, 0);
        for k in 0..2600 {
            let w = 0.1 * f64::from(k);
            let lines: [f64; 4] = dispatch!(Level::baseline(), simd => {
                engine.curves_at(Lanes::splat(simd, w)).lines.map(|line| line[0])
            });
            let full = (lines[0] + lines[1] * w - engine.full_load_nm(w)).abs();
            let drag = (lines[2] + lines[3] * w - engine.drag_nm(w)).abs();
            most_nm = most_nm.max(full).max(drag);
            exact += usize::from(full == 0.0 && drag == 0.0);
        }
        assert!(most_nm < 3.0, "{most_nm}");
        assert!(exact > 2560, "{exact}");
    }
}
