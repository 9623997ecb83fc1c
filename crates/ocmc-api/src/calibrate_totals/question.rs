//! Questions that a calibrated study answers and a table does not: what a change of truck, load or
//! speed would take.

use ocmc_core::study::{Study, StudyModel};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

/// A change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// A tenth less drag area.
    Drag,
    /// A tenth less rolling resistance.
    Rolling,
    /// A tonne more to carry, the legal gross mass raised with it.
    Weight,
    /// The speed limiter at 80 km/h.
    Limiter,
}

const LIMITER_MPS: f64 = 80.0 / 3.6;

impl Question {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Drag, Self::Rolling, Self::Weight, Self::Limiter];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Drag => "drag area -10 %",
            Self::Rolling => "rolling resistance -10 %",
            Self::Weight => "weight +1 t",
            Self::Limiter => "limiter at 80 km/h",
        }
    }

    /// A study with the change; none where it cannot have it.
    pub(super) fn study(self, study: &Study) -> Option<Study> {
        let mut tree = study.model().to_tree();
        match self {
            Self::Drag => scale(tree.pointer_mut("/vehicle/drag_area_m2")?, 0.9),
            Self::Rolling => scale(tree.pointer_mut("/vehicle/rolling_factor")?, 0.9),
            Self::Weight => {
                for key in ["curb_mass_kg", "gross_mass_limit_kg"] {
                    if let Some(mass) = tree["vehicle"].get_mut(key) {
                        *mass = json!(mass.as_f64()? + 1000.0);
                    }
                }
            }
            Self::Limiter => {
                let limiter = tree.pointer_mut("/vehicle/limiter_speed_mps")?;
                *limiter = json!(limiter.as_f64()?.min(LIMITER_MPS));
            }
        }
        study.with_model(StudyModel::from_tree(&tree).ok()?).ok()
    }
}

/// Multiplies a number, or the numbers of a law that have its unit.
pub(super) fn scale(value: &mut Value, factor: f64) {
    match value {
        Value::Number(number) => *value = json!(factor * number.as_f64().unwrap_or(f64::NAN)),
        Value::Array(values) => {
            for value in values {
                scale(value, factor);
            }
        }
        Value::Object(law) => {
            let no_unit = ["weights", "log_sd", "shape", "alpha", "beta", "truck_sd"];
            for (_, value) in law.iter_mut().filter(|(key, _)| !no_unit.contains(&key.as_str())) {
                scale(value, factor);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_are_scaled_in_what_has_their_unit() {
        let mut law = json!({ "distribution": "log_normal", "median": 5.0, "log_sd": 0.05 });
        scale(&mut law, 0.9);
        assert_eq!(law, json!({ "distribution": "log_normal", "median": 4.5, "log_sd": 0.05 }));
        let mut number = json!(4.0);
        scale(&mut number, 0.5);
        assert_eq!(number, json!(2.0));
        let mut mixture = json!({ "distribution": "mixture", "weights": [0.2, 0.8],
            "components": [3.0, { "distribution": "uniform", "lower": 1.0, "upper": 2.0 }] });
        scale(&mut mixture, 2.0);
        let uniform = json!({ "distribution": "uniform", "lower": 2.0, "upper": 4.0 });
        assert_eq!(mixture["components"], json!([6.0, uniform]));
        assert_eq!(mixture["weights"], json!([0.2, 0.8]));
    }

    #[test]
    fn every_question_changes_the_default_study() {
        let study = crate::study::load("field-truck", &[] as &[&str]).unwrap();
        for question in Question::ALL {
            let asked = question.study(&study.study).unwrap();
            assert_ne!(asked.model(), study.study.model(), "{question:?}");
        }
    }
}
