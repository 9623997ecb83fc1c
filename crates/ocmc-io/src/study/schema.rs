//! The JSON schema of a study file, for editors.
//!
//! It is the schema of the core's types with the keys that only files have (`base`, `drop`) and the range of every
//! number. No key is required in it, because any key may be inherited; `ocmc study check` tells what is missing.

use ocmc_core::study::{StudyModel, bound_of};
use serde_json::{Map, Value, json};

/// The schema of a study file.
pub fn schema() -> Value {
    let root = schemars::schema_for!(StudyModel).to_value();
    let none = Map::new();
    let definitions = root.get("$defs").and_then(Value::as_object).unwrap_or(&none);
    let mut schema = expand(&root, "", definitions);
    let laws: Map<String, Value> = definitions
        .iter()
        .filter(|(name, _)| is_shared(name))
        .map(|(name, definition)| (name.clone(), definition.clone()))
        .collect();
    add_key(
        &mut schema,
        "study",
        "base",
        &json!({
            "type": "string",
            "description": "A built-in study or a file beside this one, whose keys hold where this study does not say otherwise."
        }),
    );
    add_key(
        &mut schema,
        "study",
        "drop",
        &json!({
            "type": "array", "items": { "type": "string" },
            "description": "Inherited paths that are left out, such as \"road.types.rural\"."
        }),
    );
    add_key(
        &mut schema,
        "vehicle",
        "base",
        &json!({
            "type": "string",
            "description": "A built-in vehicle or a file, whose keys hold where this study does not say otherwise."
        }),
    );
    schema["title"] = json!("ocmc study");
    schema["$defs"] = Value::Object(laws);
    schema
}

/// Quantities and laws stay definitions: laws contain quantities.
fn is_shared(name: &str) -> bool {
    matches!(name, "Quantity" | "Law")
}

fn add_key(schema: &mut Value, table: &str, key: &str, value: &Value) {
    schema["properties"][table]["properties"][key] = value.clone();
}

/// Puts definitions in place of references, without `required`, with the range of the numbers at a path.
fn expand(schema: &Value, path: &str, definitions: &Map<String, Value>) -> Value {
    let Value::Object(keywords) = schema else { return schema.clone() };
    let name =
        keywords.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix("#/$defs/"));
    if let Some(name) = name {
        let mut expanded = if name == "Quantity" {
            let mut number = json!({ "type": "number" });
            limit(&mut number, path);
            json!({ "anyOf": [number, { "$ref": "#/$defs/Law" }] })
        } else {
            definitions
                .get(name)
                .map_or(Value::Null, |definition| expand(definition, path, definitions))
        };
        // what stands beside the reference, such as the key's own description
        for (keyword, value) in keywords.iter().filter(|(keyword, _)| *keyword != "$ref") {
            expanded[keyword] = value.clone();
        }
        return expanded;
    }
    // what may be absent is described as what it is where it is there
    if let Some([there, _]) = keywords.get("anyOf").and_then(Value::as_array).and_then(either_null)
    {
        let mut expanded = expand(there, path, definitions);
        for (keyword, value) in keywords.iter().filter(|(keyword, _)| *keyword != "anyOf") {
            expanded[keyword] = value.clone();
        }
        return expanded;
    }
    let mut expanded = Map::new();
    for (keyword, value) in keywords {
        let value = match (keyword.as_str(), value) {
            ("required" | "$defs", _) => continue,
            ("properties", Value::Object(properties)) => {
                let below = properties.iter().map(|(key, property)| {
                    let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                    (key.clone(), expand(property, &path, definitions))
                });
                Value::Object(below.collect())
            }
            ("additionalProperties", Value::Object(_)) => {
                expand(value, &format!("{path}.*"), definitions)
            }
            ("items", _) => expand(value, path, definitions),
            ("anyOf" | "prefixItems", Value::Array(items)) => {
                items.iter().map(|item| expand(item, path, definitions)).collect()
            }
            _ => value.clone(),
        };
        expanded.insert(keyword.clone(), value);
    }
    let mut expanded = Value::Object(expanded);
    limit(&mut expanded, path);
    expanded
}

/// Two items of which the second one is null.
fn either_null(items: &Vec<Value>) -> Option<&[Value; 2]> {
    let pair: &[Value; 2] = items.as_slice().try_into().ok()?;
    (pair[1]["type"] == "null").then_some(pair)
}

/// Adds the range of a number's path.
fn limit(schema: &mut Value, path: &str) {
    let is_number = match &schema["type"] {
        Value::String(kind) => kind == "number" || kind == "integer",
        Value::Array(kinds) => kinds.iter().any(|kind| kind == "number" || kind == "integer"),
        _ => false,
    };
    if let Some(bound) = bound_of(path).filter(|_| is_number) {
        schema["minimum"] = json!(bound.minimum);
        schema["maximum"] = json!(bound.maximum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_range_and_files_their_own_keys() {
        let schema = schema();
        let vehicle = &schema["properties"]["vehicle"]["properties"];
        assert_eq!(vehicle["curb_mass_kg"]["minimum"], 500.0);
        assert_eq!(vehicle["drag_area_m2"]["anyOf"][0]["maximum"], 20.0);
        assert_eq!(vehicle["axles"]["items"]["properties"]["tyres"]["maximum"], 16.0);
        assert_eq!(
            vehicle["engine"]["properties"]["map_fuel_kgps"]["items"]["items"]["maximum"],
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
