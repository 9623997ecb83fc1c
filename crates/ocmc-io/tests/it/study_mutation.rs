//! Whatever is done to the text of a study, it loads to a valid study or to an error, and never
//! panics.

use ocmc_core::study::Study;
use ocmc_io::study;
use proptest::prelude::*;

/// One change of a text.
#[derive(Clone, Debug)]
enum Change {
    Delete {
        at: usize,
        length: usize,
    },
    Repeat {
        at: usize,
        length: usize,
    },
    Replace {
        at: usize,
        with: String,
    },
    /// Puts another value behind the n-th `=`.
    Value {
        nth: usize,
        with: String,
    },
    /// Renames the n-th key.
    Key {
        nth: usize,
    },
}

/// Values of every type, allowed and not.
const VALUES: &str = "nan|inf|-inf|1e400|-1e308|1e-300|0|-1|0.0|1|2.5|1e9|99999999999999999999|0x7f\
    |true|\"word\"|\"table\"|\\[\\]|\\{\\}|\\[1, 2\\]|1979-05-27|\\[\\[1\\]\\]|\\[nan\\]";
/// Laws, right and wrong.
const LAWS: &str = "\\{ distribution = \
                    \"(normal|log_normal|uniform|beta|gamma|mixture|empirical|wrong)\", \
                    (mean|median|lower|alpha|values|components) = (1|-1|\\[\\]|\\[1, 2\\]|1e300), \
                    (sd|log_sd|upper|shape|weights) = (0.1|0|-1|\\[1\\]|5) \\}";

fn change() -> impl Strategy<Value = Change> {
    let at = 0_usize..40_000;
    let value = prop_oneof![VALUES, LAWS, any::<f64>().prop_map(|x| format!("{x:?}"))];
    let piece = "\\PC{1,4}|[\\x00-\\x7f]{1,4}|[\\[\\]{}=\"'.,#\n]";
    prop_oneof![
        1 => (at.clone(), 1_usize..400).prop_map(|(at, length)| Change::Delete { at, length }),
        1 => (at.clone(), 1_usize..400).prop_map(|(at, length)| Change::Repeat { at, length }),
        1 => (at, piece).prop_map(|(at, with)| Change::Replace { at, with }),
        4 => (0_usize..400, value).prop_map(|(nth, with)| Change::Value { nth, with }),
        1 => (0_usize..400).prop_map(|nth| Change::Key { nth }),
    ]
}

/// A range of whole characters.
fn range(text: &str, at: usize, length: usize) -> std::ops::Range<usize> {
    let boundary = |at: usize| (0..=at).rev().find(|k| text.is_char_boundary(*k)).unwrap_or(0);
    let start = boundary(at % (text.len() + 1));
    start..boundary((start + length).min(text.len())).max(start)
}

fn apply(text: &mut String, change: &Change) {
    let places: Vec<usize> = text.match_indices(" = ").map(|(k, _)| k).collect();
    match change {
        Change::Delete { at, length } => text.replace_range(range(text, *at, *length), ""),
        Change::Repeat { at, length } => {
            let range = range(text, *at, *length);
            let piece = text[range.clone()].to_owned();
            text.insert_str(range.start, &piece);
        }
        Change::Replace { at, with } => text.replace_range(range(text, *at, with.len()), with),
        Change::Value { nth, with } if !places.is_empty() => {
            let start = places[nth % places.len()] + 3;
            let end = text[start..].find(['\n', '#']).map_or(text.len(), |k| start + k);
            text.replace_range(start..end, with);
        }
        Change::Key { nth } if !places.is_empty() => text.insert(places[nth % places.len()], 's'),
        Change::Value { .. } | Change::Key { .. } => {}
    }
}

fn judge(text: &str) {
    match study::load_text::<&str>("mutant.toml", text, &[]) {
        Ok(loaded) => {
            Study::new(loaded.model.clone()).expect("a loaded study is valid").sample(1, 0);
            let written = study::resolved_toml(&loaded.model);
            let again = study::load_text::<&str>("again.toml", &written, &[]);
            assert_eq!(again.expect("a resolved study loads").model, loaded.model);
        }
        Err(error) => {
            assert!(!error.faults.is_empty());
            let message = error.to_string();
            assert!(!message.contains(|c: char| c.is_control() && c != '\n'), "{message:?}");
            assert!(error.faults.iter().all(|fault| fault.place.is_some()), "{message}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300, failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn a_changed_complete_study_never_panics(changes in prop::collection::vec(change(), 1..4)) {
        let mut text = study::init_text();
        for change in &changes {
            apply(&mut text, change);
        }
        judge(&text);
    }

    #[test]
    fn a_changed_deriving_study_never_panics(changes in prop::collection::vec(change(), 1..5)) {
        let mut text = study::show("urban-delivery").expect("built in").to_owned();
        for change in &changes {
            apply(&mut text, change);
        }
        judge(&text);
    }

    #[test]
    fn no_setting_panics(
        key in "[a-z_.]{1,30}|vehicle\\.axles\\.[0-9]\\.tyres|mission\\.length_m|\\PC{1,10}",
        value in "\\PC{0,20}|-?[0-9]{1,25}|nan|\\[[0-9,]{0,9}\\]",
    ) {
        let set = format!("{key}={value}");
        if let Err(error) = study::load("field-truck", &[set]) {
            assert!(!error.to_string().is_empty());
        }
    }
}
