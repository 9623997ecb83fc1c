//! The keys in which two studies differ.

use crate::answer::Answer;
use crate::study::{LoadedStudy, study_hash};
use crate::text::fact;
use ocmc_io::number_text::count_of;
use ocmc_io::study::{KeyDifference, differences, differences_text};
use serde::Serialize;

/// Keys that a comparison prints.
const MOST_BESIDE: usize = 8;

/// How a study B differs from a study A.
#[derive(Clone, Debug, Serialize)]
pub struct StudyDifferenceAnswer {
    /// Name of A.
    pub study_a: String,
    /// Hash of the resolved study A.
    pub study_hash_a: String,
    /// Name of B.
    pub study_b: String,
    /// Hash of the resolved study B.
    pub study_hash_b: String,
    /// The keys, what differs most first.
    pub differences: Vec<KeyDifference>,
}

/// Lists the keys in which two resolved studies differ.
///
/// ```
/// use ocmc_api::{Answer, study, study_difference};
/// let base = study::load("field-truck", &[] as &[&str])?;
/// let slippery = base.set(&["vehicle.drag_area_m2=4.5"])?;
/// let answer = study_difference(("base", &base), ("slippery", &slippery));
/// assert_eq!(answer.differences[0].key, "vehicle.drag_area_m2");
/// assert!(answer.text().contains("1 key differs"));
/// # Ok::<(), ocmc_api::Error>(())
/// ```
pub fn study_difference(
    (name_a, a): (&str, &LoadedStudy),
    (name_b, b): (&str, &LoadedStudy),
) -> StudyDifferenceAnswer {
    StudyDifferenceAnswer {
        study_a: name_a.to_owned(),
        study_hash_a: study_hash(&a.model),
        study_b: name_b.to_owned(),
        study_hash_b: study_hash(&b.model),
        differences: differences(&a.model, &b.model),
    }
}

impl Answer for StudyDifferenceAnswer {
    fn text(&self) -> String {
        let differ = differ(&self.differences);
        let keys = differences_text(&self.differences, usize::MAX);
        format!("{}{}\n{differ}\n{keys}", fact("A", &self.study_a), fact("B", &self.study_b))
    }
}

/// How many keys differ, in words.
fn differ(differences: &[KeyDifference]) -> String {
    match differences.len() {
        0 => "no key differs".to_owned(),
        1 => "1 key differs".to_owned(),
        n => format!("{} differ, in A and in B", count_of(n as u64, "key")),
    }
}

/// The largest differences, below a comparison.
pub(crate) fn beside_comparison(differences: &[KeyDifference]) -> String {
    let more =
        if differences.len() > MOST_BESIDE { ": all of them by ocmc study diff" } else { "" };
    format!("\n{}{more}\n{}", differ(differences), differences_text(differences, MOST_BESIDE))
}
