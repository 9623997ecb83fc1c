//! The schema of questions and messages.

use super::{Ask, Message, VERSION};
use schemars::generate::SchemaSettings;

/// JSON schema (draft 2020-12) of [`Ask`] and [`Message`], under `$defs`; it stands in the guide as
/// `reference/ask.schema.json`.
pub fn ask_schema() -> serde_json::Value {
    let mut generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let message = generator.subschema_for::<Message>();
    let mut questions = SchemaSettings::draft2020_12().for_deserialize().into_generator();
    let question = questions.subschema_for::<Ask>();
    let mut definitions = generator.take_definitions(true);
    definitions.extend(questions.take_definitions(true));
    serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Questions and messages of `ocmc ask`",
        "version": VERSION,
        "oneOf": [question, message],
        "$defs": definitions,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_schema_of_the_guide_is_that_of_the_program() {
        let file =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/src/reference/ask.schema.json");
        let text = serde_json::to_string_pretty(&ask_schema()).expect("JSON") + "\n";
        if std::env::var_os("OCMC_WRITE_DOCS").is_some() {
            std::fs::write(&file, &text).expect("space");
        }
        let written = std::fs::read_to_string(&file).expect("written");
        assert!(
            written == text,
            "`OCMC_WRITE_DOCS=1 cargo test -p ocmc-api --lib schema` writes it anew"
        );
    }
}
