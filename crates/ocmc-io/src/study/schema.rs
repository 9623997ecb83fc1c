//! The JSON schema of a study file, for editors: what the core declares of the keys, and the keys
//! that only files have (`base`, `drop`). `ocmc study check` tells what is missing.

use ocmc_core::study::keys::declarations;
use serde_json::{Value, json};

/// The schema of a study file.
pub fn schema() -> Value {
    let mut schema = declarations().clone();
    schema["title"] = json!("ocmc study");
    schema["properties"]["study"]["properties"]["base"] = json!({
        "type": "string",
        "description": "A built-in study or a file beside this one, whose keys hold where this \
            study does not say otherwise."
    });
    schema["properties"]["study"]["properties"]["drop"] = json!({
        "type": "array", "items": { "type": "string" },
        "description": "Inherited paths that are left out, such as \"road.types.rural\"."
    });
    schema["properties"]["vehicle"]["properties"]["base"] = json!({
        "type": "string",
        "description": "A built-in vehicle or a file, whose keys hold where this study does not \
            say otherwise."
    });
    schema["properties"]["fleet"]["properties"]["group"] = json!({
        "type": "array",
        "description": "Groups of a fleet, each a study of its own: the tables of a group are laid \
            over those of the file.",
        "items": {
            "type": "object",
            "description": "A group of trucks, with tables of a study that differ from those of \
                            the file.",
            "properties": {
                "name": { "type": "string", "description": "Name of the group." },
                "trucks": {
                    "type": "integer", "minimum": 1, "maximum": 1e6,
                    "description": "Number of its trucks."
                },
                "study": {
                    "type": "string",
                    "description": "A built-in study or a file, whose keys hold in place of those \
                                    of the file's base."
                }
            },
            "required": ["name", "trucks"]
        }
    });
    let judged = json!({
        "type": "object",
        "description": "Between which values judged numbers plausibly lie; those of an entry move \
            together.",
        "additionalProperties": {
            "type": ["object", "string"],
            "description": "A reason, and for each key one end of its range, what was judged, and \
                the other end. As `effects_of` the built-in study or vehicle whose stored effects \
                hold.",
            "additionalProperties": { "type": ["string", "array"] }
        }
    });
    schema["properties"]["judged"] = judged.clone();
    schema["properties"]["vehicle"]["properties"]["judged"] = judged;
    schema
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::study::keys::Key;

    #[test]
    fn numbers_have_their_range_and_files_their_own_keys() {
        let schema = schema();
        let vehicle = &schema["properties"]["vehicle"]["properties"];
        assert_eq!(vehicle["curb_mass_kg"]["minimum"], 500.0);
        assert_eq!(vehicle["drag_area_m2"]["anyOf"][0]["maximum"], 20.0);
        assert_eq!(vehicle["axles"]["items"]["properties"]["tyres"]["maximum"], 16.0);
        assert_eq!(
            vehicle["powertrain"]["properties"]["combustion"]["properties"]["engine"]["properties"]
                ["map_fuel_kgps"]["items"]["items"]["maximum"],
            1.0
        );
        assert_eq!(vehicle["base"]["type"], "string");
        let weather = &schema["properties"]["weather"]["properties"];
        assert_eq!(weather["pressure"]["properties"]["sd"]["maximum"], 5000.0);
        assert_eq!(weather["wind"]["properties"]["direction"]["properties"]["sd"]["maximum"], 10.0);
        let urban = &schema["properties"]["road"]["properties"]["types"]["additionalProperties"];
        assert_eq!(urban["properties"]["mean_length_m"]["minimum"], 50.0);
        assert_eq!(urban["properties"]["truck_limit_mps"]["maximum"], 70.0);
    }

    /// Keys whose number has no range, by their paths.
    fn without_range(path: &str, key: &Value, paths: &mut Vec<String>) {
        let entry = Key(key).entry().0;
        let number = entry.get("anyOf").is_some() || entry["type"] == "number";
        if number && Key(key).bounds().is_none() {
            paths.push(path.to_owned());
        }
        for (name, below) in entry["properties"].as_object().into_iter().flatten() {
            without_range(&format!("{path}.{name}"), below, paths);
        }
        if let Some(any) = Key(key).any_name() {
            without_range(&format!("{path}.*"), any.0, paths);
        }
    }

    #[test]
    fn every_number_has_a_range() {
        let mut paths = Vec::new();
        without_range("study", &schema(), &mut paths);
        assert_eq!(paths, Vec::<String>::new());
    }

    #[test]
    fn every_reference_leads_to_a_definition() {
        let schema = schema();
        let text = schema.to_string();
        for reference in text.split("\"$ref\":\"#/$defs/").skip(1) {
            let name = reference.split('"').next().unwrap();
            assert!(schema["$defs"].get(name).is_some(), "{name}");
        }
    }
}
