//! Judged numbers between and beyond the ends of their ranges, several entries at a time.
//!
//! A place of 0 is what was judged, −1 and 1 are the ends; beyond an end a number goes on as before
//! it. Positive numbers move by a factor, as those do that are judged as a half to twice as much;
//! shares and what reaches zero move by an amount. Numbers that are nowhere below zero in the range
//! stay so, whole numbers stay whole.

use super::error::StudyFileError;
use super::judged::{JudgedKey, JudgedNumbers};
use super::node::Node;
use super::{LoadedStudy, finish};
use serde_json::{Number, Value};

/// Keys of shares, whose sum stays the same.
const SHARES: [&str; 4] = ["next", "ground", "share", "weights"];

/// A number below a judged key, and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedNumber {
    /// Path of the number, such as `vehicle.drag_area_m2.median`.
    pub path: String,
    /// The number at the place.
    pub value: f64,
    /// Its change by one of the place.
    pub slope: f64,
}

impl JudgedKey {
    /// The value at a place of the range.
    pub fn at(&self, place: f64) -> Value {
        let is_share = SHARES.iter().any(|word| self.path.split('.').any(|key| key == *word));
        between([&self.low, &self.judged, &self.high], place, is_share)
    }
}

impl JudgedNumbers {
    /// The values of its keys at a place of the range.
    pub fn at(&self, place: f64) -> impl Iterator<Item = (String, Value)> + '_ {
        self.keys.iter().map(move |key| (key.path.clone(), key.at(place)))
    }

    /// The numbers that move, at a place of the range.
    pub fn moving(&self, place: f64) -> Vec<MovedNumber> {
        /// Half the way over which slopes are taken.
        const STEP: f64 = 0.05;
        let mut moved = Vec::new();
        for key in &self.keys {
            let sides = [key.at(place - STEP), key.at(place), key.at(place + STEP)];
            collect(&key.path, [&sides[0], &sides[1], &sides[2]], 2.0 * STEP, &mut moved);
        }
        moved
    }
}

impl LoadedStudy {
    /// The study with entries of its judged numbers at places of their ranges, and then with other
    /// values under their keys.
    ///
    /// # Errors
    /// Where the rest of the study does not go with them.
    pub fn at_places(
        &self,
        entries: &[(&JudgedNumbers, f64)],
        values: &[(String, Value)],
    ) -> Result<Self, StudyFileError> {
        let moved = entries.iter().flat_map(|(numbers, place)| numbers.at(*place));
        self.with_values(moved.chain(values.iter().cloned()))
    }

    /// The study with other values under their keys.
    ///
    /// # Errors
    /// Where the rest of the study does not go with them.
    pub fn with_values(
        &self,
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Self, StudyFileError> {
        let mut own = self.own.clone();
        for (path, value) in values {
            let nested = |value: Value, name: &str| {
                Value::Object([(name.into(), value)].into_iter().collect())
            };
            own.overlay(Node::from_json(&path.split('.').rev().fold(value, nested))?)?;
        }
        finish(own, self.files.clone(), &[] as &[&str], self.origin.clone())
    }
}

fn between(range: [&Value; 3], place: f64, is_share: bool) -> Value {
    let [low, judged, high] = range;
    match (low, judged, high) {
        (Value::Number(a), Value::Number(b), Value::Number(c)) => {
            number([a, b, c], place, is_share)
        }
        (Value::Array(a), Value::Array(b), Value::Array(c))
            if a.len() == b.len() && b.len() == c.len() =>
        {
            let each = a.iter().zip(b).zip(c);
            Value::Array(each.map(|((a, b), c)| between([a, b, c], place, is_share)).collect())
        }
        (Value::Object(a), Value::Object(b), Value::Object(c))
            if b.keys().all(|key| a.contains_key(key) && c.contains_key(key))
                && a.len() == b.len()
                && b.len() == c.len() =>
        {
            let each = b.iter().map(|(key, b)| {
                let is_share = is_share || SHARES.contains(&key.as_str());
                (key.clone(), between([&a[key], b, &c[key]], place, is_share))
            });
            Value::Object(each.collect())
        }
        // words and laws of other forms: the nearest
        _ if place < -0.5 => low.clone(),
        _ if place > 0.5 => high.clone(),
        _ => judged.clone(),
    }
}

fn number(range: [&Number; 3], place: f64, is_share: bool) -> Value {
    let [low, judged, high] = range.map(|number| number.as_f64().unwrap_or(f64::NAN));
    let least = low.min(judged).min(high);
    let end = if place < 0.0 { low } else { high };
    let value = if least > 0.0 && !is_share {
        judged * libm::pow(end / judged, place.abs())
    } else {
        judged + place.abs() * (end - judged)
    };
    let value = if least >= 0.0 { value.max(0.0) } else { value };
    let is_whole = range.iter().all(|number| number.is_i64() || number.is_u64());
    if is_whole {
        return Value::from(libm::round(value) as i64);
    }
    Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// The numbers that differ between the two sides.
fn collect(path: &str, [a, b, c]: [&Value; 3], apart: f64, moved: &mut Vec<MovedNumber>) {
    let below = |name: &str| format!("{path}.{name}");
    match (a, b, c) {
        (Value::Number(a), Value::Number(b), Value::Number(c)) => {
            let [a, b, c] = [a, b, c].map(|number| number.as_f64().unwrap_or(f64::NAN));
            if a != c {
                let slope = (c - a) / apart;
                moved.push(MovedNumber { path: path.to_owned(), value: b, slope });
            }
        }
        (Value::Array(a), Value::Array(b), Value::Array(c)) => {
            for (k, ((a, b), c)) in a.iter().zip(b).zip(c).enumerate() {
                collect(&below(&k.to_string()), [a, b, c], apart, moved);
            }
        }
        (Value::Object(a), Value::Object(b), Value::Object(c)) => {
            for (key, b) in b {
                if let (Some(a), Some(c)) = (a.get(key), c.get(key)) {
                    collect(&below(key), [a, b, c], apart, moved);
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use crate::study::{End, LoadedStudy, load};
    use serde_json::json;

    #[test]
    fn places_of_a_range_are_its_ends_and_what_lies_between() {
        let study = load("field-truck", &[] as &[&str]).unwrap();
        let entry = |name: &str| study.judged().iter().find(|e| e.name == name).unwrap();
        let drag = entry("drag_area");
        for (place, end) in [(-1.0, End::Low), (1.0, End::High)] {
            let moved = study.at_places(&[(drag, place)], &[]).unwrap();
            let ends = study.at_end(drag, end).unwrap();
            let drag = |study: &LoadedStudy| study.model.vehicle.drag_area_m2.centre();
            assert!((drag(&moved) - drag(&ends)).abs() < 1e-12);
        }
        assert_eq!(study.at_places(&[(drag, 0.0)], &[]).unwrap().model, study.model);
        let wide = drag.keys[0].at(1.5)["median"].as_f64().unwrap();
        assert!((wide - 4.9 * (5.4_f64 / 4.9).powf(1.5)).abs() < 1e-12, "{wide}");
        let bumps = entry("speed_bumps").keys[0].at(-2.0);
        assert_eq!(bumps, json!(0.0));
        let moving = drag.moving(0.3);
        assert_eq!(moving.len(), 1);
        assert_eq!(moving[0].path, "vehicle.drag_area_m2.median");
        let ratio = 5.4_f64 / 4.9;
        let value = 4.9 * ratio.powf(0.3);
        assert!((moving[0].value - value).abs() < 1e-12);
        assert!((moving[0].slope / (value * ratio.ln()) - 1.0).abs() < 1e-4);
        // whole numbers, shares whose sum stays 1, and values beside them
        let gears = entry("start_gears").at(0.4).map(|(_, value)| value);
        assert!(gears.take(2).all(|gear| gear.is_i64()));
        let values = [("mission.length_m".to_owned(), json!(4e4))];
        let both = [(entry("road_sequence"), 0.7), (entry("rural_signs"), -0.6)];
        let moved = study.at_places(&both, &values).unwrap();
        let next = &moved.model.road.types["urban"].next;
        assert!((next["rural"] - 0.66).abs() < 1e-12 && (next["motorway"] - 0.34).abs() < 1e-12);
        assert!(study.at_places(&[(entry("road_sequence"), 9.0)], &[]).is_err());
    }
}
