//! One trip of a run, driven again: speed, slope, what brakes, and the charge of a battery.

use super::Reported;
use super::panel::Panel;
use super::repeat::{Repeat, trace_command};
use super::svg::{begin, escaped, rounded_short};
use crate::label::label;
use crate::number_text::rounded;
use crate::study::load_text;
use ocmc_core::kernel::drive::trace::{TableColumn, trace};
use ocmc_fleet::quantity::RecordQuantity;

/// Places along the way: more cannot be told apart.
const PLACES: usize = 480;
/// Metres a second in kilometres an hour.
const KMH: f64 = 3.6;

/// The signals of a trip at even places along its way.
#[derive(Debug, Default)]
struct Series {
    end_m: f64,
    /// Lowest and highest speed between a place and the next, in m/s.
    speed_mps: Vec<[f64; 2]>,
    desired_mps: Vec<f64>,
    limit_mps: Vec<f64>,
    /// Slope, a mean over the rows.
    grade: Vec<f64>,
    /// Mean power of the service brakes, in W.
    service_w: Vec<f64>,
    /// Mean power of the engine brake, or of what the motor brings back, in W.
    own_w: Vec<f64>,
    /// State of charge; empty without a battery.
    charge: Vec<f64>,
}

/// The trip in the middle of a run by a quantity; nothing where it cannot be driven again as it
/// was: on given roads or at a given speed, and by another version of the program.
pub(super) fn trip(run: &Reported, quantity: &RecordQuantity, repeat: &Repeat) -> String {
    let manifest = &run.manifest;
    let Some((cycle_id, value)) = run.gathered.middle(quantity, manifest.first_cycle) else {
        return String::new();
    };
    if manifest.followed.is_some() || !manifest.routes().is_empty() {
        return String::new();
    }
    let no_sets: &[&str] = &[];
    let Ok(loaded) = load_text(&manifest.study, &manifest.resolved_study, no_sets) else {
        return String::new();
    };
    let driven = trace(&loaded.study, manifest.seed, cycle_id);
    if quantity.of_cycle(&driven.record) != Some(value) {
        return String::new();
    }
    let Some(series) = Series::of(&driven.columns) else { return String::new() };
    let (unit, factor) = label(quantity.column);
    let electric = !series.charge.is_empty();
    let own = if electric {
        "what the motor brings back to the battery (blue)"
    } else {
        "the engine brake, or retarder (blue)"
    };
    let charge = if electric { ", and the state of charge" } else { "" };
    format!(
        "<h2>A trip in the middle</h2>\n\
         <p>Cycle {cycle_id} takes {} {}: as many trips take less as take more. Step by step: \
         {}</p>\n<figure>{}<figcaption>Limit (dashed), what the driver wants (red) and speed \
         (blue); slope; power of the service brakes (red) and of {own}{charge}. Where much happens \
         within {:.0} m the lowest and the highest speed are drawn, and the mean power.\
         </figcaption></figure>\n",
        rounded(factor * value),
        escaped(unit),
        trace_command(run, repeat, cycle_id),
        series.svg(cycle_id),
        series.end_m / PLACES as f64,
    )
}

impl Series {
    /// None where nothing moves.
    fn of(columns: &[TableColumn]) -> Option<Self> {
        let column = |name: &str| {
            columns.iter().find(|column| column.name == name).map(|column| column.values.as_slice())
        };
        let position_m = column("position_m")?;
        let end_m = position_m.last().copied().filter(|end_m| *end_m > 0.0)?;
        let [speed, desired, limit, grade, step, service] = [
            column("speed_mps")?,
            column("desired_speed_mps")?,
            column("limit_mps")?,
            column("grade")?,
            column("step_s")?,
            column("service_brake_energy_added_j")?,
        ];
        let charge = column("state_of_charge");
        let own = match charge {
            Some(_) => column("regenerated_energy_added_j")?,
            None => column("engine_brake_energy_added_j")?,
        };
        let mut series = Self { end_m, ..Self::default() };
        let mut first = 0;
        for place in 0..PLACES {
            let to_m = end_m * (place + 1) as f64 / PLACES as f64;
            let count = position_m[first..].iter().take_while(|at_m| **at_m <= to_m).count();
            // a place without a row is as the row before
            let rows = match count {
                0 => first.saturating_sub(1)..first.max(1),
                _ => first..first + count,
            };
            first += count;
            let folded = |values: &[f64], start: f64, both: fn(f64, f64) -> f64| {
                values[rows.clone()].iter().copied().fold(start, both)
            };
            let sum = |values: &[f64]| folded(values, 0.0, |sum, value| sum + value);
            let mean = |values: &[f64]| sum(values) / rows.len() as f64;
            let power = |values: &[f64]| {
                let time_s = sum(step);
                if time_s > 0.0 { (sum(values) / time_s).max(0.0) } else { 0.0 }
            };
            let last = rows.end - 1;
            let low = folded(speed, f64::INFINITY, f64::min);
            series.speed_mps.push([low, folded(speed, 0.0, f64::max)]);
            series.desired_mps.push(folded(desired, 0.0, f64::max));
            series.limit_mps.push(limit[last]);
            series.grade.push(mean(grade));
            series.service_w.push(power(service));
            series.own_w.push(power(own));
            series.charge.extend(charge.map(|charge| charge[last]));
        }
        Some(series)
    }

    /// The panels, one below the other.
    fn svg(&self, cycle_id: u64) -> String {
        let electric = !self.charge.is_empty();
        let height = if electric { 572.0 } else { 472.0 };
        let mut svg = begin(720.0, height, &format!("Cycle {cycle_id} over its way"));
        let end_km = self.end_m / 1000.0;
        let panel = |y: [f64; 2], top: f64, height: f64| {
            Panel::new([0.0, end_km], y, [50.0, top, 660.0, height])
        };
        let at_km = |place: usize| end_km * (place as f64 + 0.5) / PLACES as f64;
        let over = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            (0..PLACES).map(|place| (at_km(place), values(place))).collect()
        };
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);

        let fastest = KMH * most(&self.desired_mps).max(most(&self.limit_mps));
        let top = 20.0 * (fastest / 20.0).ceil().max(1.0);
        let speeds = panel([0.0, top], 24.0, 170.0);
        speeds.across(&mut svg, &[0.0, 0.5 * top, top], "speed, km/h");
        speeds.line(&mut svg, over(&|k| KMH * self.limit_mps[k]), "class=\"mean\"");
        speeds.line(&mut svg, over(&|k| KMH * self.desired_mps[k]), "class=\"mark\"");
        let ends = |k: usize| self.speed_mps[k].map(|speed| (at_km(k), KMH * speed));
        speeds.line(&mut svg, (0..PLACES).flat_map(ends), "class=\"line\"");

        let steep = 100.0 * most(&self.grade.iter().map(|g| g.abs()).collect::<Vec<_>>());
        let steep = steep.ceil().max(1.0);
        let slopes = panel([-steep, steep], 234.0, 60.0);
        slopes.across(&mut svg, &[-steep, 0.0, steep], "slope, %");
        slopes.area(&mut svg, over(&|k| 100.0 * self.grade[k]), "class=\"band\"");

        let strongest = most(&self.service_w).max(most(&self.own_w)) / 1000.0;
        let strongest = 50.0 * (strongest / 50.0).ceil().max(1.0);
        let brakes = panel([0.0, strongest], 334.0, 80.0);
        brakes.across(&mut svg, &[0.0, strongest], "braking, kW");
        brakes.area(&mut svg, over(&|k| self.service_w[k] / 1000.0), "class=\"brake\"");
        brakes.area(&mut svg, over(&|k| self.own_w[k] / 1000.0), "class=\"bar\"");

        let mut last = brakes;
        if electric {
            let fullest = most(&self.charge);
            let emptiest = self.charge.iter().copied().fold(fullest, f64::min);
            let range = [(10.0 * emptiest).floor() * 10.0, (10.0 * fullest).ceil() * 10.0];
            last = panel(range, 444.0, 70.0);
            last.across(&mut svg, &range, "state of charge, %");
            last.line(&mut svg, over(&|k| 100.0 * self.charge[k]), "class=\"line\"");
        }
        let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * end_km);
        let ticks = ticks.map(|km| (km, rounded_short(km)));
        last.along_with_room(&mut svg, &ticks, "km");
        svg + "</svg>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::study::Study;

    fn series(name: &str) -> (Series, Vec<TableColumn>) {
        let loaded = crate::study::load(name, &["mission.length_m=6000"]).unwrap();
        let driven = trace(&Study::new(loaded.model).unwrap(), 1, 3);
        (Series::of(&driven.columns).unwrap(), driven.columns)
    }

    #[test]
    fn places_hold_the_extremes_and_the_energy_of_the_rows() {
        for name in ["field-truck", "battery-truck"] {
            let (series, columns) = series(name);
            let column = |name: &str| {
                &columns.iter().find(|column| column.name == name).expect("a column").values
            };
            let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
            let fastest = series.speed_mps.iter().fold(0.0, |most: f64, ends| most.max(ends[1]));
            assert_eq!(fastest, most(column("speed_mps")));
            assert!(series.speed_mps.iter().any(|[low, _]| *low < 1.0), "it starts and stops");
            assert!(most(&series.service_w) > 0.0 && most(&series.own_w) > 0.0, "{name}");
            assert_eq!(series.charge.len(), if name == "battery-truck" { PLACES } else { 0 });
            let svg = series.svg(3);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            assert_eq!(svg.contains("state of charge"), name == "battery-truck");
        }
    }

    #[test]
    fn what_does_not_move_has_no_picture() {
        assert!(Series::of(&[]).is_none());
        let (_, mut columns) = series("field-truck");
        for column in &mut columns {
            column.values.clear();
        }
        assert!(Series::of(&columns).is_none());
    }
}
