//! A study as one text, all bases resolved, and the hash that names it.

use crate::given_cycle::hash;
use ocmc_core::study::StudyModel;

/// The fully resolved study as TOML; it loads to the same study.
pub fn resolved_toml(model: &StudyModel) -> String {
    toml::to_string(model).expect("a study is tables, lists, numbers and words")
}

/// SHA-256, in hexadecimal digits, of the resolved study: of its JSON without blanks, keys in the
/// order of their names.
///
/// Two studies with the same hash give the same records under the same seed and program version.
pub fn study_hash(model: &StudyModel) -> String {
    hash_of_tree(serde_json::to_value(model).expect("a study is tables, lists, numbers and words"))
}

/// The hash of a resolved study by its TOML, be it that of an earlier version with other keys; none
/// where it is no TOML.
pub fn hash_of_resolved(text: &str) -> Option<String> {
    let tree: toml::Table = text.parse().ok()?;
    Some(hash_of_tree(serde_json::to_value(tree).ok()?))
}

fn hash_of_tree(mut tree: serde_json::Value) -> String {
    tree.sort_all_objects();
    hash(tree.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{builtin, load, load_text};

    const NO_SETS: &[&str] = &[];

    #[test]
    fn a_resolved_study_loads_to_the_same_study() {
        for built_in in builtin::STUDIES {
            let model = load(built_in.name, NO_SETS).unwrap().model;
            let text = resolved_toml(&model);
            assert!(!text.contains("base ="), "{text}");
            assert_eq!(load_text("resolved.toml", &text, NO_SETS).unwrap().model, model);
            assert_eq!(hash_of_resolved(&text), Some(study_hash(&model)));
        }
    }

    #[test]
    fn the_hash_tells_studies_apart_and_nothing_else() {
        let hash = |set: &[&str]| study_hash(&load("field-truck", set).unwrap().model);
        let default = hash(&[]);
        assert_eq!(default.len(), 64);
        assert_eq!(default, hash(&["simulation.step_s=1.5"]));
        assert_ne!(default, hash(&["simulation.step_s=0.1"]));
        assert_ne!(default, hash(&["study.name=other"]));
    }
}
