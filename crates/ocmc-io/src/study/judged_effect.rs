//! Effect of the judged numbers of a study on its mean consumption, without driving: the stored
//! effects of the built-in study that it derives from, each a share of that study's mean.
//!
//! `configs/judged-effects.csv` has them, as `ocmc doubt` finds them. A study whose own numbers are
//! others has the effects of those that are still judged, rescaled to its own mean. Nothing is
//! known of a study with other entries, with another vehicle, on given roads, and of one that
//! derives from no built-in one.

use super::judged::{Judged, JudgedNumbers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

const STORED: &str = include_str!("../../../../configs/judged-effects.csv");

/// Entries that are named.
const NAMED: usize = 5;

/// Effect of judged numbers on the mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgedDoubt {
    /// Entries of numbers that are judged; 0 where the study says nothing of its numbers.
    pub entries: usize,
    /// Their effect; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stored: Option<StoredDoubt>,
}

/// Effects of a built-in study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StoredDoubt {
    /// The built-in study.
    pub effects_of: String,
    /// Whether the study is this one, with nothing changed.
    pub is_same: bool,
    /// The consumption.
    pub column: String,
    /// Root of the sum of squares of the effects on its mean, as a share of the mean.
    pub share_of_mean: f64,
    /// The entries that do most, the largest first.
    pub largest: Vec<NumbersShare>,
}

/// Share of one entry in the sum of squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumbersShare {
    /// Name of the entry.
    pub name: String,
    /// Its share.
    pub share: f64,
}

impl NumbersShare {
    /// The entry and its share, in words.
    pub fn words(&self) -> String {
        share_words(&self.name, self.share)
    }
}

/// An entry of judged numbers and its share, in words.
pub(crate) fn share_words(name: &str, share: f64) -> String {
    format!("{} {:.0} %", name.replace('_', " "), 100.0 * share)
}

/// A row of the stored effects.
#[derive(Debug, Deserialize)]
struct Stored {
    study: String,
    /// Its first digits.
    study_hash: String,
    vehicle: String,
    column: String,
    name: String,
    /// Mean square of the changes of the mean, less what sampling adds, over the square of the
    /// mean.
    square: f64,
}

fn stored() -> impl Iterator<Item = Stored> {
    let reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(STORED.as_bytes());
    reader.into_deserialize().map(|row| row.expect("a table of the program"))
}

/// Effect of the judged numbers of a study with this hash; none where all of them have been
/// replaced. Of a study that says nothing of its numbers nothing is known.
pub(super) fn of(judged: &Judged, study_hash: &str, on_routes: bool) -> Option<JudgedDoubt> {
    let entries = judged.numbers.len();
    let replaced = entries == 0 && judged.study.is_some();
    let stored = known(judged, study_hash).filter(|stored| stored.is_same || !on_routes);
    (!replaced).then_some(JudgedDoubt { entries, stored })
}

/// Entries, the largest stored effect first: that of the study and the vehicle that they are from,
/// else the largest that any study has of an entry of that name. In the order of the file where
/// nothing is stored.
pub(super) fn sorted(judged: &Judged) -> Vec<&JudgedNumbers> {
    let rows: Vec<Stored> = stored().collect();
    let own = |row: &&Stored| {
        judged.study.as_ref() == Some(&row.study) && judged.vehicle.as_ref() == Some(&row.vehicle)
    };
    let has_own = rows.iter().any(|row| own(&row));
    let square = |name: &str| {
        let of_name = rows.iter().filter(|row| row.name == name).filter(|row| !has_own || own(row));
        of_name.map(|row| row.square).fold(0.0, f64::max)
    };
    let mut entries: Vec<(&JudgedNumbers, f64)> =
        judged.numbers.iter().map(|numbers| (numbers, square(&numbers.name))).collect();
    entries.sort_by(|a, b| b.1.total_cmp(&a.1));
    entries.into_iter().map(|(numbers, _)| numbers).collect()
}

fn known(judged: &Judged, study_hash: &str) -> Option<StoredDoubt> {
    let (study, vehicle) = (judged.study.as_ref()?, judged.vehicle.as_ref()?);
    let rows: Vec<Stored> =
        stored().filter(|row| row.study == *study && row.vehicle == *vehicle).collect();
    let column = rows.first()?.column.clone();
    let is_same = study_hash.starts_with(&rows[0].study_hash);
    let square = |name: &str| Some(rows.iter().find(|row| row.name == name)?.square);
    let squares: Option<Vec<(&str, f64)>> = judged
        .numbers
        .iter()
        .map(|numbers| Some((numbers.name.as_str(), square(&numbers.name)?)))
        .collect();
    let mut squares = squares?;
    squares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let sum: f64 = squares.iter().map(|(_, square)| square).sum();
    if sum <= 0.0 {
        return None;
    }
    let largest = squares
        .iter()
        .take(NAMED)
        .map(|(name, square)| NumbersShare { name: (*name).to_owned(), share: square / sum });
    Some(StoredDoubt {
        effects_of: study.clone(),
        is_same,
        column,
        share_of_mean: libm::sqrt(sum),
        largest: largest.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::builtin::STUDIES;
    use crate::study::{load, study_hash};

    fn doubt(study: &str, sets: &[&str]) -> Option<JudgedDoubt> {
        load(study, sets).unwrap().judged_doubt()
    }

    #[test]
    fn every_built_in_study_has_its_effects() {
        for study in STUDIES {
            let loaded = load(study.name, &[] as &[&str]).unwrap();
            let doubt = loaded.judged_doubt().unwrap_or_else(|| panic!("{}", study.name));
            let stored = doubt.stored.unwrap_or_else(|| panic!("{} has none", study.name));
            assert_eq!(stored.effects_of, study.name);
            // `scripts/judged_effects.py` reckons them again
            assert!(stored.is_same, "{} has changed: {}", study.name, study_hash(&loaded.model));
            assert!((0.001..0.6).contains(&stored.share_of_mean), "{} {stored:?}", study.name);
        }
    }

    #[test]
    fn what_is_typed_is_left_out_and_what_is_unknown_is_not_told() {
        let whole = doubt("field-truck", &[]).and_then(|doubt| doubt.stored).unwrap();
        assert_eq!(whole.largest[0].name, "payload");
        let typed = doubt("field-truck", &["mission.payload_kg=12000"]).unwrap();
        let rest = typed.stored.unwrap();
        assert!(!rest.is_same && rest.largest[0].name != "payload");
        let square = |doubt: &StoredDoubt| doubt.share_of_mean * doubt.share_of_mean;
        let payload = whole.largest[0].share * square(&whole);
        assert!((square(&whole) - payload - square(&rest)).abs() < 1e-12);
        // another truck, or a study that says nothing of where it comes from
        let other = doubt("field-truck", &["vehicle.base=tractor-electric-40t"]).unwrap();
        assert!(other.stored.is_none() && other.entries > 50);
    }
}
