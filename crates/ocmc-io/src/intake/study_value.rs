//! Numbers of a study that are allowed and unusual: slips of a unit.

use super::Finding;
use crate::number_text::rounded;
use ocmc_core::study::{StudyModel, Unusual, outside_usual};

/// Name of the check.
const NAME: &str = "unusual-number";

/// Ends of keys, the unit that is likely meant, and one of it in that of the key.
const SLIPS: [(&str, &str, f64); 14] = [
    ("length_m", "km", 1000.0),
    ("distance_km_per_a", "m", 1e-3),
    ("_kg", "t", 1000.0),
    ("_kg", "g", 1e-3),
    ("_mps", "km/h", 1.0 / 3.6),
    ("_w", "kW", 1000.0),
    ("_j", "kWh", 3.6e6),
    ("_j", "Wh", 3600.0),
    ("_s", "min", 60.0),
    ("_s", "h", 3600.0),
    ("_per_l", "hundredths of the currency", 0.01),
    ("_per_kg", "hundredths of the currency", 0.01),
    ("_per_kwh", "hundredths of the currency", 0.01),
    ("_m2", "cm²", 1e-4),
];

/// Looks at the numbers of a study.
pub fn judge(model: &StudyModel) -> Vec<Finding> {
    outside_usual(&model.to_tree()).iter().map(finding).collect()
}

fn finding(unusual: &Unusual) -> Finding {
    let Unusual { path, value, usual } = unusual;
    let (low, high) = (usual.minimum, usual.maximum);
    let bound = if *value > high { high } else { low };
    let text = format!(
        "`{path}` is {}, and {} to {} are usual",
        rounded(*value),
        rounded(low),
        rounded(high)
    );
    let would_do = |(end, _, factor): &&(&str, &str, f64)| {
        path.ends_with(end) && (low..=high).contains(&(factor * value))
    };
    let slip = SLIPS.iter().find(would_do);
    let remedy = slip.map_or_else(
        || "is it right?".to_owned(),
        |(_, unit, factor)| {
            format!("is it right? In {unit} it would be {}", rounded(factor * value))
        },
    );
    Finding::warned(NAME, [*value, bound], text, &remedy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{BuiltIn, list, load};

    fn judged(sets: &[&str]) -> Vec<String> {
        let loaded = load("field-truck", sets).unwrap();
        judge(&loaded.model).iter().map(Finding::to_string).collect()
    }

    #[test]
    fn slips_are_named_and_built_in_studies_have_none() {
        let texts = judged(&["mission.payload_kg=12"]);
        assert!(texts[0].contains("`mission.payload_kg` is 12") && texts[0].contains("In t it"));
        let texts = judged(&["mission.length_m=300"]);
        assert!(texts[0].contains("In km it would be 300,000"), "{texts:?}");
        assert!(judged(&["mission.payload_kg=0"]).is_empty());
        for BuiltIn { name, .. } in list() {
            let findings = judge(&load(name, &[] as &[&str]).unwrap().model);
            assert!(findings.is_empty(), "{name}: {findings:?}");
        }
    }
}
