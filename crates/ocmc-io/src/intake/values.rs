//! Values of a column: codes that stand for a missing one, and values that the quantity does not
//! usually have.

use super::Finding;
use crate::intake::table::given::RowPlace;
use crate::intake::table::{Column, Style};
use crate::number_text::{grouped, rounded};

/// Largest magnitude of the other values, over that of a code.
const APART: f64 = 0.5;
/// Codes that machines write and that are not all nines.
const OTHER_CODES: [f64; 4] = [32_767.0, 65_535.0, 16_777_215.0, 1e20];
/// Share of the values of a log from which on unusual ones are named: a receiver may jump.
const OF_LOG: f64 = 0.01;

/// Values of a column, as far as they are remembered.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    values: usize,
    /// Largest and second largest magnitude as written, and how often the largest is there.
    largest: f64,
    second: f64,
    times: usize,
    unusual: usize,
    /// The first unusual value: where it is, the number as it is written, and in SI.
    first: Option<(RowPlace, f64, f64)>,
}

impl Watched {
    /// Looks at a value as it is written, and in SI.
    pub fn look(&mut self, place: RowPlace, column: &Column, written: f64, si: f64) {
        if !written.is_finite() {
            return;
        }
        self.values += 1;
        if written.abs() > self.largest.abs() {
            (self.second, self.largest, self.times) = (self.largest, written, 1);
        } else if written == self.largest {
            self.times += 1;
        } else if written.abs() > self.second.abs() {
            self.second = written;
        }
        let usual = column.quantity.entry().usual;
        if usual.is_some_and(|[low, high]| si < low || si > high) {
            self.unusual += 1;
            self.first.get_or_insert((place, written, si));
        }
    }

    /// Judges the column that is called `name`.
    pub fn judge(&self, name: &str, column: &Column, style: Style) -> Option<Finding> {
        self.missing_code(name, style).or_else(|| self.unusual(name, column, style))
    }

    /// A code for missing: all nines, or one of [`OTHER_CODES`], far above all other values.
    fn missing_code(&self, name: &str, style: Style) -> Option<Finding> {
        let is_apart = self.values > self.times && self.second.abs() < APART * self.largest.abs();
        if !(is_apart && is_code(self.largest)) {
            return None;
        }
        let text = format!(
            "column `{name}` has {} in {} of {} rows, and {} at most otherwise",
            self.largest,
            grouped(self.times as u64),
            grouped(self.values as u64),
            rounded(self.second)
        );
        let figures = [self.largest, self.second];
        let remedy = "if it stands for a missing value, leave such cells empty";
        Some(if style == Style::Log {
            Finding::warned("missing-code", figures, text, remedy)
        } else {
            Finding::refused("missing-code", figures, text, remedy)
        })
    }

    fn unusual(&self, name: &str, column: &Column, style: Style) -> Option<Finding> {
        let [low, high] = column.quantity.entry().usual?;
        let (place, written, _) = self.first?;
        if style == Style::Log && (self.unusual as f64) < OF_LOG * self.values as f64 {
            return None;
        }
        let [from, to] = [low, high].map(|bound| rounded(column.written(bound)));
        let text = format!(
            "column `{name}` has {} of {} values outside {from} to {to}, which are usual, first \
             {written} in {place}",
            grouped(self.unusual as u64),
            grouped(self.values as u64),
        );
        let fits = |si: f64| si >= low && si <= high;
        let units = column.quantity.units().iter();
        let mut others = units.filter(|unit| **unit != *column.unit && fits(unit.si(written)));
        let remedy = others.next().map_or_else(
            || "is the unit right?".to_owned(),
            |unit| {
                let name = column.quantity.name();
                let suffix = if unit.suffix.is_empty() { "" } else { "_" };
                format!("is the unit right? `{name}{suffix}{}` would be usual", unit.suffix)
            },
        );
        let bound = if written > column.written(high) { high } else { low };
        Some(Finding::warned("unusual-value", [written, column.written(bound)], text, &remedy))
    }
}

/// Whether a number looks like a code: 99, 999.9, -9999.
fn is_code(number: f64) -> bool {
    let digits = number.abs().to_string();
    let nines = digits.trim_end_matches(".0").bytes().filter(|byte| *byte != b'.');
    let all_nines = digits.len() >= 2 && nines.clone().all(|byte| byte == b'9');
    all_nines && nines.count() >= 2 || OTHER_CODES.contains(&number.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intake::End;
    use crate::intake::table::Quantity;

    fn judged(quantity: Quantity, unit: &str, values: &[f64], style: Style) -> Option<Finding> {
        let unit = crate::intake::table::unit::with_suffix(quantity.units(), unit).unwrap();
        let column = Column { quantity, place: 0, unit, sign: 1.0, bounds: None };
        let mut watched = Watched::default();
        for (k, value) in values.iter().enumerate() {
            watched.look(RowPlace::Line(k as u64 + 2), &column, *value, column.si(*value));
        }
        watched.judge("x", &column, style)
    }

    #[test]
    fn codes_for_missing_values_are_named() {
        let of_wind = |values: &[f64]| {
            judged(Quantity::WindSpeed, "mps", values, Style::Measurements)
                .map(|finding| finding.end)
        };
        assert_eq!(of_wind(&[3.0, 99.0, 5.0, 99.0]), Some(End::Refused));
        assert_eq!(of_wind(&[3.0, 9.9, 12.0, 5.0]), None);
        assert_eq!(of_wind(&[-999.0, 2.0, 3.0]), Some(End::Refused));
        // all the same, or no gap
        assert_eq!(of_wind(&[9.9, 9.9]), None);
        let humid = judged(Quantity::RelativeHumidity, "percent", &[99.0, 98.0, 40.0], Style::Log);
        assert!(humid.is_none());
    }

    #[test]
    fn unusual_values_are_named_with_the_unit_that_would_do() {
        let finding = judged(Quantity::Accelerator, "", &[0.0, 40.0, 100.0], Style::Log).unwrap();
        assert!(finding.remedy.contains("`accelerator_percent`"), "{finding}");
        assert_eq!((finding.check, finding.end), ("unusual-value", End::Warned));
        let some = |share: usize| {
            let values: Vec<f64> = (0..1000).map(|k| if k < share { 3.0 } else { 0.3 }).collect();
            judged(Quantity::Brake, "", &values, Style::Log)
        };
        assert!(some(9).is_none() && some(10).is_some());
    }
}
