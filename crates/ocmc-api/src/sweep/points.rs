//! The points of a sweep: keys of a study, and what each point sets them to.

use super::MOST_POINTS;
use crate::error::Error;
use crate::source::Source;
use ocmc_io::study::alternatives;
use ocmc_io::table::words;

/// Keys of a study, and what each point sets them to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepPoints {
    keys: Vec<String>,
    /// Values of each point in the order of the keys, as `--set` takes them; none where the point
    /// leaves a key as the study has it.
    rows: Vec<Vec<Option<String>>>,
}

impl SweepPoints {
    /// Each point by itself: of each the values in the order of the keys.
    ///
    /// # Errors
    /// [`Error::SweptTwice`] and [`Error::ManyPoints`].
    pub fn new(keys: Vec<String>, rows: Vec<Vec<Option<String>>>) -> Result<Self, Error> {
        let twice = keys.iter().enumerate().find(|(k, key)| keys[..*k].contains(key));
        if let Some((_, key)) = twice {
            return Err(Error::SweptTwice(key.clone()));
        }
        if rows.len() > MOST_POINTS {
            return Err(Error::ManyPoints { points: rows.len(), most: MOST_POINTS });
        }
        Ok(Self { keys, rows })
    }

    /// The grid of the values of some keys, each combination a point: the last key goes through all
    /// of its values before the one in front of it takes its next. A key with one value is no part
    /// of it: its setting stands in front, for the study itself and so for all points.
    ///
    /// ```
    /// use ocmc_api::SweepPoints;
    /// let key = |name: &str, values: &[&str]| {
    ///     (name.to_owned(), values.iter().map(|value| (*value).to_owned()).collect())
    /// };
    /// let keys = vec![key("a", &["1", "2"]), key("b", &["x", "y"]), key("c", &["5"])];
    /// let (fixed, grid) = SweepPoints::grid(keys)?;
    /// let names: Vec<String> = (0..grid.len()).map(|k| grid.name(k)).collect();
    /// assert_eq!(names, ["a=1, b=x", "a=1, b=y", "a=2, b=x", "a=2, b=y"]);
    /// assert_eq!(fixed, ["c=5"]);
    /// # Ok::<(), ocmc_api::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SweepPoints::new`].
    pub fn grid(keys: Vec<(String, Vec<String>)>) -> Result<(Vec<String>, Self), Error> {
        let is_fixed = |(_, values): &(String, Vec<String>)| values.len() == 1;
        let (fixed, swept): (Vec<_>, Vec<_>) = keys.into_iter().partition(is_fixed);
        let fixed = fixed.into_iter().map(|(key, values)| format!("{key}={}", values[0]));
        let points =
            swept.iter().fold(1, |points: usize, (_, values)| points.saturating_mul(values.len()));
        if points > MOST_POINTS {
            return Err(Error::ManyPoints { points, most: MOST_POINTS });
        }
        let mut rows = vec![Vec::new()];
        for (_, values) in &swept {
            let with = |row: &Vec<Option<String>>, value: &String| {
                [row.as_slice(), &[Some(value.clone())]].concat()
            };
            rows = rows.iter().flat_map(|row| values.iter().map(|v| with(row, v))).collect();
        }
        let keys = swept.into_iter().map(|(key, _)| key).collect();
        Ok((fixed.collect(), Self::new(keys, rows)?))
    }

    /// The grid of texts such as `KEY=A,B,C`, and what holds for all of its points.
    ///
    /// # Errors
    /// As [`SweepPoints::new`], and [`Error::Study`] of what is no such text.
    pub fn of_settings(settings: &[String]) -> Result<(Vec<String>, Self), Error> {
        let keys = settings.iter().map(|setting| alternatives(setting));
        Self::grid(keys.collect::<Result<_, _>>()?)
    }

    /// A table whose columns are keys and whose rows are points; an empty cell leaves a key as the
    /// study has it.
    ///
    /// # Errors
    /// As [`SweepPoints::new`], and [`Error::Table`] of what cannot be read.
    pub fn list(source: &Source) -> Result<Self, Error> {
        let (keys, rows) = words(source.lent())?;
        let value = |cell: String| (!cell.is_empty()).then_some(cell);
        let rows = rows.into_iter().map(|row| row.into_iter().map(value).collect());
        Self::new(keys, rows.collect())
    }

    /// The keys.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether no point sets anything.
    pub(super) fn set_nothing(&self) -> bool {
        self.rows.iter().flatten().all(Option::is_none)
    }

    /// The values of a point, as they are written, in the order of the keys.
    pub(super) fn written(&self, point: usize) -> impl Iterator<Item = (&str, Option<&str>)> {
        let values = self.rows[point].iter().map(Option::as_deref);
        self.keys.iter().map(String::as_str).zip(values)
    }

    /// The settings of a point.
    pub(super) fn settings(&self, point: usize) -> Vec<String> {
        let set = self.written(point).filter_map(|(key, value)| Some(format!("{key}={}", value?)));
        set.collect()
    }

    /// Name of a point.
    pub fn name(&self, point: usize) -> String {
        let settings = self.settings(point);
        if settings.is_empty() { "nothing set".to_owned() } else { settings.join(", ") }
    }
}
