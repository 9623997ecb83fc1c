//! The keys in which two resolved studies differ.

use crate::number_text::rounded;
use ocmc_core::study::StudyModel;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;

/// Tables that say what a study is, not what it does.
const NOT_DRIVEN: [&str; 1] = ["study"];
/// Longest value that is printed, and longest line, in characters.
const SHOWN: usize = 24;
const WIDTH: usize = 80;
/// Longest list of numbers that is printed as it is.
const FEW: usize = 3;

/// A key that differs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct KeyDifference {
    /// Its path, or that of a table which one of the two lacks.
    pub key: String,
    /// Its value in A; none where A lacks it.
    pub a: Option<Value>,
    /// Its value in B; none where B lacks it.
    pub b: Option<Value>,
    /// B over A, of numbers, and of the means of lists of numbers; none where A is 0.
    pub ratio: Option<f64>,
}

impl KeyDifference {
    /// The values in A and in B, in a few words.
    pub fn values(&self) -> [String; 2] {
        [&self.a, &self.b].map(|value| value.as_ref().map_or("none".to_owned(), brief))
    }

    /// How far B lies from A, where that is a ratio: as a share, or as a factor where it is large.
    pub fn change(&self) -> Option<String> {
        let ratio = self.ratio?;
        Some(if (ratio - 1.0).abs() < 0.5 {
            format!("{:+.1} %", 100.0 * (ratio - 1.0))
        } else {
            format!("times {}", rounded(ratio))
        })
    }
}

/// The keys in which B differs from A: what one of them lacks and words first, then numbers by how
/// far their ratio is from 1.
pub fn differences(a: &StudyModel, b: &StudyModel) -> Vec<KeyDifference> {
    let [a, b] = [a, b].map(|model| serde_json::to_value(model).expect("numbers and words"));
    let mut differences = Vec::new();
    compare("", Some(&a), Some(&b), &mut differences);
    let far = |difference: &KeyDifference| match difference.ratio {
        Some(ratio) if ratio > 0.0 => libm::log(ratio).abs(),
        _ => f64::INFINITY,
    };
    // of equal distances the order of the study stays
    differences.sort_by(|a, b| far(b).total_cmp(&far(a)));
    differences
}

fn compare(key: &str, a: Option<&Value>, b: Option<&Value>, differences: &mut Vec<KeyDifference>) {
    let path = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match (a, b) {
        (Some(Value::Object(a)), Some(Value::Object(b))) if same_kind(a, b) => {
            let only_b = b.keys().filter(|name| !a.contains_key(*name));
            for name in a.keys().chain(only_b) {
                if key.is_empty() && NOT_DRIVEN.contains(&name.as_str()) {
                    continue;
                }
                compare(&path(name), a.get(name), b.get(name), differences);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b)))
            if a.len() == b.len() && a.iter().chain(b).any(Value::is_object) =>
        {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&path(&k.to_string()), Some(a), Some(b), differences);
            }
        }
        _ => {
            let [a, b] = [a, b].map(|value| value.filter(|value| !value.is_null()));
            if a != b {
                let ratio = a.and_then(mean).zip(b.and_then(mean));
                // lists of one mean differ otherwise
                let ratio = ratio.and_then(|(a, b)| (a != 0.0 && a != b).then(|| b / a));
                let (a, b) = (a.cloned(), b.cloned());
                differences.push(KeyDifference { key: key.to_owned(), a, b, ratio });
            }
        }
    }
}

/// Whether two tables have the same keys to compare: laws of two kinds have not.
fn same_kind(a: &Map<String, Value>, b: &Map<String, Value>) -> bool {
    a.get("distribution") == b.get("distribution")
}

/// A number, or the mean of a list of them, of lists, too.
fn mean(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::Array(values) if !values.is_empty() => {
            let means: Option<Vec<f64>> = values.iter().map(mean).collect();
            means.map(|means| means.iter().sum::<f64>() / means.len() as f64)
        }
        _ => None,
    }
}

/// At most `most` of the differences, one below the other.
pub fn differences_text(differences: &[KeyDifference], most: usize) -> String {
    let shown = &differences[..differences.len().min(most)];
    let mut text = String::new();
    for difference in shown {
        let (key, [a, b]) = (&difference.key, difference.values());
        let change = difference.change().map_or(String::new(), |change| format!(" ({change})"));
        let values = format!("{a} -> {b}{change}");
        let one_line = key.len() + 2 + values.chars().count() <= WIDTH;
        let between = if one_line { "  " } else { "\n    " };
        let _ = writeln!(text, "{key}{between}{values}");
    }
    let more = differences.len() - shown.len();
    if more > 0 {
        let _ = writeln!(text, "and {more} more");
    }
    text
}

/// A value in a few words.
fn brief(value: &Value) -> String {
    match value {
        Value::Object(table) => match table.get("distribution") {
            Some(law) => format!("a {} law", law.as_str().unwrap_or_default()),
            None => format!("a table of {} keys", table.len()),
        },
        Value::Array(values) if values.len() <= FEW && values.iter().all(Value::is_number) => {
            let numbers: Vec<String> = values.iter().map(Value::to_string).collect();
            format!("[{}]", numbers.join(", "))
        }
        Value::Array(values) => match mean(value) {
            Some(mean) => format!("{} numbers, mean {}", values.len(), rounded(mean)),
            None => format!("{} entries", values.len()),
        },
        Value::String(word) => word.chars().take(SHOWN).collect(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::load;

    const NONE: &[&str] = &[];

    #[test]
    fn exactly_what_was_set_differs() {
        let base = load("field-truck", NONE).expect("built in");
        assert_eq!(differences(&base.model, &base.model), []);
        let sets = [
            "vehicle.drag_area_m2=4.24",
            "vehicle.axles.1.iso_rolling_coefficient=0.007",
            "driver.curve_speed.form=table",
            "mission.payload_kg=12000",
        ];
        let changed = base.set(&sets).expect("allowed");
        let changes = differences(&base.model, &changed.model);
        let keys: Vec<&str> = changes.iter().map(|difference| difference.key.as_str()).collect();
        for key in ["driver.curve_speed.form", "mission.payload_kg", "vehicle.drag_area_m2"] {
            assert!(keys.contains(&key), "{keys:?}");
        }
        assert!(keys.contains(&"vehicle.axles.1.iso_rolling_coefficient"), "{keys:?}");
        assert_eq!(keys.len(), 4, "{keys:?}");
        // what has no ratio stands first
        assert!(changes[0].ratio.is_none() && changes[3].ratio.is_some());
        let text = differences_text(&changes, 3);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(text.contains("table") && text.ends_with("and 1 more\n"), "{text}");
        // back again
        let back = differences(&changed.model, &base.model);
        assert_eq!(back.len(), changes.len());
    }

    #[test]
    fn parts_of_lists_are_named_by_their_places() {
        let base = load("field-truck", NONE).expect("built in");
        let law = "mission.payload_kg={distribution='mixture', weights=[0.3, 0.7], \
                   components=[0.0, {distribution='uniform', lower=1.0, upper=9000.0}]}";
        let a = base.set(&[law]).expect("allowed");
        let b = a.set(&["mission.payload_kg.components.1.upper=8000.0"]).expect("allowed");
        let changes = differences(&a.model, &b.model);
        assert_eq!(changes.len(), 1, "{changes:?}");
        assert_eq!(changes[0].key, "mission.payload_kg.components.1.upper");
        let c = a.set(&["mission.payload_kg.weights=[0.7, 0.3]"]).expect("allowed");
        let text = differences_text(&differences(&a.model, &c.model), 9);
        assert_eq!(text, "mission.payload_kg.weights  [0.3, 0.7] -> [0.7, 0.3]\n");
    }

    #[test]
    fn a_table_that_one_lacks_is_one_line() {
        let [a, b] =
            ["field-truck", "battery-truck"].map(|name| load(name, NONE).expect("built in"));
        let changes = differences(&a.model, &b.model);
        let lacking = |key: &str| {
            changes.iter().any(|difference| difference.key == key && difference.b.is_none())
        };
        assert!(lacking("vehicle.powertrain.combustion"), "{changes:?}");
        assert!(!changes.iter().any(|difference| difference.key.contains("combustion.")));
    }
}
