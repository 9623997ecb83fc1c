//! Results of VECTO: time series by the second, and sums.

use super::error::VectoError;
use ocmc_io::table::source::read_text;
use std::path::{Path, PathBuf};

/// A table of VECTO by the names of its columns, without their units and brackets.
pub(super) struct Columns {
    path: PathBuf,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Columns {
    pub(super) fn read(path: &Path) -> Result<Self, VectoError> {
        let text = read_text(path)?;
        let row_error = |line, problem| VectoError::Row { path: path.to_owned(), line, problem };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut records = reader.records();
        let header = match records.next() {
            Some(Ok(header)) => header,
            Some(Err(error)) => return Err(row_error(1, error.to_string())),
            None => return Err(row_error(1, "it is empty".to_owned())),
        };
        let names = header.iter().map(|name| plain(name).to_owned()).collect();
        let mut rows = Vec::new();
        for (k, record) in records.enumerate() {
            let record = record.map_err(|error| row_error(k as u64 + 2, error.to_string()))?;
            rows.push(record.iter().map(str::to_owned).collect());
        }
        Ok(Self { path: path.to_owned(), names, rows })
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|have| have.eq_ignore_ascii_case(name))
    }

    /// A column as texts.
    fn texts(&self, name: &'static str) -> Result<Vec<&str>, VectoError> {
        let Some(place) = self.place(name) else {
            let names = self.names.join(", ");
            return Err(VectoError::Column { path: self.path.clone(), column: name, found: names });
        };
        Ok(self.rows.iter().map(|row| row.get(place).map_or("", String::as_str)).collect())
    }

    /// A column of numbers; `-` and an empty cell are no number.
    pub(super) fn numbers(&self, name: &'static str) -> Result<Vec<f64>, VectoError> {
        self.texts(name)?.into_iter().enumerate().map(|row| self.number(name, row)).collect()
    }

    fn number(&self, name: &str, (k, text): (usize, &str)) -> Result<f64, VectoError> {
        if ["", "-"].contains(&text) {
            return Ok(f64::NAN);
        }
        text.parse().map_err(|_| VectoError::Row {
            path: self.path.clone(),
            line: k as u64 + 2,
            problem: format!("column `{name}`: `{text}` is no number"),
        })
    }

    /// The first of these columns that is there, as numbers.
    pub(super) fn numbers_of(&self, names: &[&'static str]) -> Result<Vec<f64>, VectoError> {
        let there = names.iter().find(|name| self.place(name).is_some());
        self.numbers(there.unwrap_or(&names[0]))
    }

    /// The same; without one of these names the column at a place, where there is one.
    pub(super) fn numbers_of_or_at(
        &self,
        names: &[&'static str],
        place: usize,
    ) -> Result<Vec<f64>, VectoError> {
        if names.iter().any(|name| self.place(name).is_some()) || self.names.len() <= place {
            return self.numbers_of(names);
        }
        let cells = self.rows.iter().map(|row| row.get(place).map_or("", String::as_str));
        cells.enumerate().map(|row| self.number(&self.names[place], row)).collect()
    }

    /// A column of numbers, or this number where there is no such column.
    pub(super) fn numbers_or(
        &self,
        name: &'static str,
        otherwise: f64,
    ) -> Result<Vec<f64>, VectoError> {
        match self.place(name) {
            Some(_) => self.numbers(name),
            None => Ok(vec![otherwise; self.rows.len()]),
        }
    }
}

/// A name without its unit, in brackets or behind `in`, and without angle brackets.
fn plain(name: &str) -> &str {
    let name = name.trim().trim_start_matches('\u{feff}');
    let name = name.split('[').next().unwrap_or(name).trim();
    let name = name.split(" in ").next().unwrap_or(name).trim();
    name.trim_start_matches('<').trim_end_matches('>')
}

/// One second of a time series: means over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Second {
    /// Speed, in m/s.
    pub speed_mps: f64,
    /// Distance at its end, in m.
    pub end_m: f64,
    /// Acceleration, in m/s².
    pub acceleration_mps2: f64,
    /// Gradient, rise over run: that at its end.
    pub gradient: f64,
    /// Gear, from 1; 0 where none is engaged.
    pub gear: usize,
    /// Speed of the engine, in rad/s.
    pub engine_radps: f64,
    /// Power of the auxiliaries, in W.
    pub auxiliary_w: f64,
    /// Power of the engine, in W.
    pub engine_w: f64,
    /// Loss of gearbox, axle and retarder, in W.
    pub lost_w: f64,
    /// Part of the retarder in it, in W.
    pub retarder_w: f64,
    /// Against the air, the tyres and gravity, in W.
    pub drag_w: f64,
    /// Rolling.
    pub rolling_w: f64,
    /// Grade.
    pub grade_w: f64,
    /// At the wheels, in W.
    pub wheel_w: f64,
    /// Power of the brakes, in W; negative.
    pub brake_w: f64,
    /// Fuel, in kg/s.
    pub fuel_kgps: f64,
}

/// A time series (`.vmod`).
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its seconds.
    pub seconds: Vec<Second>,
}

/// Reads a time series of VECTO 2.2.
///
/// # Errors
/// [`VectoError`] names the file, the place and what is allowed.
pub fn read_series(path: &Path) -> Result<Series, VectoError> {
    let columns = Columns::read(path)?;
    let kw = |name| Ok::<_, VectoError>(scaled(columns.numbers(name)?, 1000.0));
    let speed = scaled(columns.numbers("v_act")?, 1.0 / 3.6);
    let (end_m, acceleration) = (columns.numbers("dist")?, columns.numbers("acc")?);
    let (gradient, gear) = (columns.numbers("grad")?, columns.numbers("Gear")?);
    let engine = scaled(columns.numbers("n")?, std::f64::consts::PI / 30.0);
    let (auxiliary, engine_w) = (kw("Paux")?, kw("Pe_eng")?);
    let lost = [kw("Ploss GB")?, kw("Ploss Diff")?, kw("Ploss Retarder")?];
    let (drag, rolling, grade) = (kw("Pair")?, kw("Proll")?, kw("Pgrad")?);
    let (wheel, brake) = (kw("Pwheel")?, kw("Pbrake")?);
    let fuel = scaled(columns.numbers("FC-Map")?, 1e-3 / 3600.0);
    let second = |k: usize| Second {
        speed_mps: speed[k],
        end_m: end_m[k],
        acceleration_mps2: acceleration[k],
        gradient: gradient[k] / 100.0,
        gear: gear[k].max(0.0) as usize,
        engine_radps: engine[k],
        auxiliary_w: auxiliary[k],
        engine_w: engine_w[k],
        // a retarder that there is not loses no number
        lost_w: lost.iter().map(|part| part[k]).filter(|lost| lost.is_finite()).sum(),
        retarder_w: if lost[2][k].is_finite() { lost[2][k] } else { 0.0 },
        drag_w: drag[k],
        rolling_w: rolling[k],
        grade_w: grade[k],
        wheel_w: wheel[k],
        brake_w: brake[k],
        fuel_kgps: fuel[k],
    };
    let seconds: Vec<Second> = (0..speed.len()).map(second).collect();
    let whole = |second: &Second| second.speed_mps.is_finite() && second.gradient.is_finite();
    let (row, problem) = match seconds.iter().position(|second| !whole(second)) {
        Some(row) => (row, "no speed or no gradient".to_owned()),
        None if seconds.is_empty() => (0, "it has no rows".to_owned()),
        None => return Ok(Series { seconds }),
    };
    Err(VectoError::Row { path: path.to_owned(), line: row as u64 + 2, problem })
}

fn scaled(values: Vec<f64>, factor: f64) -> Vec<f64> {
    values.into_iter().map(|value| factor * value).collect()
}

/// A row of sums (`.vsum`): energies in J.
#[derive(Clone, Debug, PartialEq)]
pub struct Sum {
    /// Name of the row.
    pub name: String,
    /// File of the mission.
    pub mission: String,
    /// Mass with its load, in kg.
    pub gross_mass_kg: f64,
    /// Duration, in s.
    pub time_s: f64,
    /// Distance, in m.
    pub distance_m: f64,
    /// Fuel, in kg.
    pub fuel_kg: f64,
    /// Against the air.
    pub air_j: f64,
    /// Against the tyres.
    pub rolling_j: f64,
    /// Energy of the brakes, in J.
    pub brake_j: f64,
    /// Energy of the auxiliaries, in J.
    pub auxiliary_j: f64,
    /// Lost in gearbox and axle.
    pub gearbox_axle_j: f64,
    /// Lost in the retarder.
    pub retarder_j: f64,
    /// Energy of the engine, where it is positive, in J.
    pub engine_j: f64,
}

/// Reads sums of VECTO 2.2 or 3.
///
/// # Errors
/// [`VectoError`] names the file, the place and what is allowed.
pub fn read_sums(path: &Path) -> Result<Vec<Sum>, VectoError> {
    let columns = Columns::read(path)?;
    // VECTO 3 has `E_air` where 2.2 has `Eair`
    let kwh = |name: [&'static str; 2]| {
        Ok::<_, VectoError>(scaled(columns.numbers_of(&name)?, 3.6e6).into_iter().map(f64::abs))
    };
    let (names, missions) = (columns.texts("Job")?, columns.texts("Cycle")?);
    let (mass, loading) = (columns.numbers("Mass")?, columns.numbers("Loading")?);
    let (time, distance) = (columns.numbers("time")?, columns.numbers("distance")?);
    let fuel_gph = columns.numbers("FC-Map")?;
    let energy = |name: [&'static str; 2]| Ok::<_, VectoError>(kwh(name)?.collect::<Vec<f64>>());
    let (air, rolling) = (energy(["E_air", "Eair"])?, energy(["E_roll", "Eroll"])?);
    let (brake, auxiliary) = (energy(["E_brake", "Ebrake"])?, energy(["E_aux_sum", "Eaux"])?);
    let gears = energy(["E_gbx_axl_loss", "Etransm"])?;
    let (retarder, engine) =
        (energy(["E_ret_loss", "Eretarder"])?, energy(["E_fcmap_pos", "EposICE"])?);
    let sum = |k: usize| Sum {
        name: names[k].to_owned(),
        mission: missions[k].to_owned(),
        gross_mass_kg: mass[k] + loading[k],
        time_s: time[k],
        distance_m: 1000.0 * distance[k],
        fuel_kg: fuel_gph[k] * time[k] / 3.6e6,
        air_j: air[k],
        rolling_j: rolling[k],
        brake_j: brake[k],
        auxiliary_j: auxiliary[k],
        gearbox_axle_j: gears[k],
        retarder_j: retarder[k],
        engine_j: engine[k],
    };
    Ok((0..names.len()).map(sum).collect())
}
