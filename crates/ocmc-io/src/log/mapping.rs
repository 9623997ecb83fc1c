//! Which column of a log is what: by its name, or as a user says with `--map speed_mph=gps_speed`.

use super::error::LogFileError;
use super::quantity::{Label, Quantity, Word};

/// One assignment of a user.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    target: Target,
    column: String,
    /// −1 where the column counts the other way round, written as `yaw_rate_degps=-gyro`.
    sign: f64,
}

/// What a column is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Quantity(Quantity, f64),
    Label(Label),
    Word(Word),
}

/// Where a quantity stands: its column, and what its numbers are multiplied with.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityColumn {
    /// The quantity.
    pub quantity: Quantity,
    /// Index of the column.
    pub index: usize,
    /// Name of the column.
    pub name: String,
    /// SI units of its unit, negative where it counts the other way round.
    pub factor: f64,
}

/// Where everything stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// The quantities.
    pub quantities: Vec<QuantityColumn>,
    /// The labels, with the index of their columns.
    pub labels: Vec<(Label, usize)>,
    /// The words, with the index of their columns.
    pub words: Vec<(Word, usize)>,
}

impl Mapping {
    /// Reads `NAME=COLUMN`.
    ///
    /// # Errors
    /// [`LogFileError::Mapping`], [`LogFileError::UnknownUnit`] or [`LogFileError::UnknownName`].
    pub fn parse(text: &str) -> Result<Self, LogFileError> {
        let wrong = || LogFileError::Mapping { text: text.to_owned() };
        let (name, column) = text.split_once('=').ok_or_else(wrong)?;
        let (name, column) = (name.trim(), column.trim());
        let (sign, column) = match column.strip_prefix('-') {
            Some(rest) => (-1.0, rest),
            None => (1.0, column),
        };
        if name.is_empty() || column.is_empty() {
            return Err(wrong());
        }
        let target = if let Some((quantity, size)) = Quantity::parse(name) {
            Target::Quantity(quantity, size)
        } else if let Some(label) = Label::parse(name) {
            Target::Label(label)
        } else if let Some(word) = Word::parse(name) {
            Target::Word(word)
        } else if let Some(quantity) = Quantity::with_wrong_unit(name) {
            let allowed = quantity.names().collect();
            return Err(LogFileError::UnknownUnit { name: name.to_owned(), allowed });
        } else {
            return Err(LogFileError::unknown_name(name));
        };
        Ok(Self { target, column: column.to_owned(), sign })
    }
}

impl Columns {
    /// Finds the columns of a header: those that a user assigns, then those whose names say what they are.
    ///
    /// # Errors
    /// [`LogFileError::NoSuchColumn`] for an assigned column that is not there, [`LogFileError::Ambiguous`] where two
    /// columns are the same.
    pub fn find(header: &[String], mappings: &[Mapping]) -> Result<Self, LogFileError> {
        let mut columns = Self::default();
        for mapping in mappings {
            let index = header.iter().position(|name| *name == mapping.column);
            let index =
                index.ok_or_else(|| LogFileError::no_such_column(&mapping.column, header))?;
            match mapping.target {
                Target::Quantity(quantity, size) => {
                    columns.add(quantity, index, header, mapping.sign * size)?;
                }
                Target::Label(label) => {
                    add_named(&mut columns.labels, label, label.name(), index, header)?;
                }
                Target::Word(word) => {
                    add_named(&mut columns.words, word, word.name(), index, header)?;
                }
            }
        }
        let assigned = columns.clone();
        for (index, name) in header.iter().enumerate() {
            if let Some((quantity, size)) = Quantity::parse(name) {
                if assigned.quantity(quantity).is_none() {
                    columns.add(quantity, index, header, size)?;
                }
            } else if let Some(label) = Label::parse(name)
                && assigned.label(label).is_none()
            {
                add_named(&mut columns.labels, label, label.name(), index, header)?;
            } else if let Some(word) = Word::parse(name)
                && assigned.word(word).is_none()
            {
                add_named(&mut columns.words, word, word.name(), index, header)?;
            }
        }
        Ok(columns)
    }

    /// The column of a quantity.
    pub fn quantity(&self, quantity: Quantity) -> Option<&QuantityColumn> {
        self.quantities.iter().find(|column| column.quantity == quantity)
    }

    /// The column of a label.
    pub fn label(&self, label: Label) -> Option<usize> {
        self.labels.iter().find(|(known, _)| *known == label).map(|(_, index)| *index)
    }

    /// The column of a word.
    pub fn word(&self, word: Word) -> Option<usize> {
        self.words.iter().find(|(known, _)| *known == word).map(|(_, index)| *index)
    }

    fn add(
        &mut self,
        quantity: Quantity,
        index: usize,
        header: &[String],
        factor: f64,
    ) -> Result<(), LogFileError> {
        if let Some(other) = self.quantity(quantity) {
            return Err(LogFileError::Ambiguous {
                name: quantity.name(),
                columns: [header[other.index].clone(), header[index].clone()],
            });
        }
        self.quantities.push(QuantityColumn {
            quantity,
            index,
            name: header[index].clone(),
            factor,
        });
        Ok(())
    }
}

/// Adds a column that is told by its name alone.
fn add_named<T: PartialEq>(
    columns: &mut Vec<(T, usize)>,
    which: T,
    name: &'static str,
    index: usize,
    header: &[String],
) -> Result<(), LogFileError> {
    if let Some((_, other)) = columns.iter().find(|(known, _)| *known == which) {
        return Err(LogFileError::Ambiguous {
            name,
            columns: [header[*other].clone(), header[index].clone()],
        });
    }
    columns.push((which, index));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn assigned_columns_come_before_named_ones() {
        let header = header(&["time_s", "speed_mps", "gps_speed", "gyro", "who"]);
        let mappings = ["speed_mph=gps_speed", "yaw_rate_degps=-gyro", "driver=who"]
            .map(|text| Mapping::parse(text).expect("valid"));
        let columns = Columns::find(&header, &mappings).expect("valid");
        assert_eq!(columns.quantity(Quantity::Speed).map(|column| column.index), Some(2));
        let yaw = columns.quantity(Quantity::YawRate).expect("assigned");
        assert!(yaw.index == 3 && yaw.factor < 0.0);
        assert_eq!(columns.label(Label::Driver), Some(4));
        assert_eq!(columns.quantity(Quantity::Time).map(|column| column.factor), Some(1.0));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let text = |text: &str| Mapping::parse(text).expect_err("wrong").to_string();
        assert!(text("speed_furlongs=v").contains("speed_mps, speed_kmh, speed_mph"));
        assert!(text("sped_mps=v").contains("speed_mps"));
        assert!(text("speed_mps").contains("NAME=COLUMN"));
        let header = header(&["time_s", "speed_mps", "speed_kmh"]);
        let error = Columns::find(&header, &[]).expect_err("ambiguous").to_string();
        assert!(error.contains("speed_mps") && error.contains("--map"), "{error}");
        let mapping = Mapping::parse("yaw_rate_degps=speed_mp").expect("valid");
        let error = Columns::find(&header, &[mapping]).expect_err("absent").to_string();
        assert!(error.contains("speed_mps"), "{error}");
    }
}
