//! Schema of a format's tables, and the assignment of columns to quantities: by its name, or as a
//! user says with `--map`.

use super::dwd;
use super::error::{Fault, TableError};
use super::mapping::Mapping;
use super::quantity::{Quantity, with_unit};
use super::unit::{Scale, Unit, is_written, with_suffix, written};
use super::word;
use std::path::Path;

/// A format.
#[derive(Debug)]
pub struct Schema {
    /// One table of it, in messages.
    pub what: &'static str,
    /// How its tables are written.
    pub style: Style,
    /// Fields that a table may hold.
    pub fields: &'static [Field],
}

/// How the tables of a format are written, and how much is taken from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// By machines, over hours: rows may lack cells, and a cell that is no number counts as
    /// missing. Other columns are not looked at.
    Log,
    /// By people, from measurements: a number may be missing. Other columns are not looked at, but
    /// for a quantity in another unit.
    Measurements,
    /// As the description of one thing: every cell is a finite number. Names are compared without
    /// case; old files are Latin-1.
    Description,
}

/// The suffix of a unit, and names with which a format means it.
pub type OwnNames = (&'static str, &'static [&'static str]);

/// Field of a format.
#[derive(Debug)]
pub struct Field {
    /// Quantity of the field.
    pub quantity: Quantity,
    /// Names of the format's own, behind the suffix of their unit. They come before those of the
    /// vocabulary.
    pub own: &'static [OwnNames],
    /// Bounds of its numbers.
    pub bounds: Option<Bounds>,
}

/// Bounds of a number, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest number.
    pub minimum: f64,
    /// Largest number.
    pub maximum: f64,
    /// How that reads.
    pub allowed: &'static str,
}

impl Field {
    /// With the names of the vocabulary.
    pub const fn of(quantity: Quantity) -> Self {
        Self { quantity, own: &[], bounds: None }
    }

    /// With names of the format's own.
    pub const fn named(quantity: Quantity, own: &'static [OwnNames]) -> Self {
        Self { quantity, own, bounds: None }
    }

    /// Bounded, in SI; `allowed` says so.
    #[must_use]
    pub const fn within(self, minimum: f64, maximum: f64, allowed: &'static str) -> Self {
        Self { bounds: Some(Bounds { minimum, maximum, allowed }), ..self }
    }

    /// The names with which its column can be written.
    pub fn names(&self) -> Vec<String> {
        let own = self.own.iter().flat_map(|(_, names)| *names);
        let mut names: Vec<String> = own.map(|name| (*name).to_owned()).collect();
        let usual: Vec<String> = self.quantity.names().filter(|n| !names.contains(n)).collect();
        names.extend(usual);
        names
    }

    /// The unit of a name of the format's own, and how far it stands behind the first one.
    fn own_unit(&self, name: &str) -> Option<(&'static Unit, usize)> {
        self.own.iter().find_map(|(suffix, names)| {
            let place = names.iter().position(|own| *own == name)?;
            Some((with_suffix(self.quantity.units(), suffix)?, place))
        })
    }
}

/// A column of a table that is understood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Quantity that it holds.
    pub quantity: Quantity,
    /// Its place in the table.
    pub place: usize,
    /// Its unit.
    pub unit: &'static Unit,
    /// -1 where it counts the other way round.
    pub sign: f64,
    /// Bounds of its numbers.
    pub bounds: Option<Bounds>,
}

impl Column {
    /// A number of it in SI.
    pub fn si(&self, number: f64) -> f64 {
        self.sign * self.unit.si(number)
    }

    /// A number in SI as it would be written; of an angle that of a small one.
    pub fn written(&self, si: f64) -> f64 {
        self.sign * (si - self.unit.offset) / self.unit.factor
    }

    /// Whether its numbers are in SI as they stand.
    pub fn is_si(&self) -> bool {
        let Unit { factor, offset, scale, .. } = *self.unit;
        self.sign == 1.0 && factor == 1.0 && offset == 0.0 && scale == Scale::Linear
    }
}

/// A column's name as it is compared: without case, and with what stands in brackets apart.
struct Name<'a> {
    text: String,
    bracket: Option<&'a str>,
}

/// The name and the unit of a header: `speed [km/h]`, `speed (km/h)`, `speed / km/h`,
/// `speed, km/h`, `speed in km/h` or `grade%`.
fn split_unit(header: &str) -> (&str, Option<&str>) {
    if let Some((text, rest)) = header.split_once('[') {
        return (text, Some(rest.split(']').next().unwrap_or_default().trim()));
    }
    let header = header.trim();
    let in_parentheses = header.strip_suffix(')').and_then(|text| text.rsplit_once('('));
    let others = [" / ", ", ", " in "].into_iter().filter_map(|by| header.rsplit_once(by));
    let mut all = in_parentheses.into_iter().chain(others);
    if let Some((text, unit)) = all.find(|(_, unit)| is_written(unit.trim())) {
        return (text, Some(unit.trim()));
    }
    for unit in ["%", "‰"] {
        if let Some(text) = header.strip_suffix(unit) {
            return (text.trim_end_matches(['_', ' ']), Some(unit));
        }
    }
    (header, None)
}

impl<'a> Name<'a> {
    fn of(header: &'a str) -> Self {
        let (text, bracket) = split_unit(header);
        let text = text.trim().trim_matches(|c| c == '<' || c == '>').trim();
        let words: Vec<&str> = text.split_whitespace().collect();
        let text = words.join("_").to_lowercase();
        Self { text, bracket: bracket.filter(|bracket| !bracket.is_empty()) }
    }
}

/// Error that two columns are the same quantity.
pub(super) fn ambiguous(path: &Path, header: &[String], columns: [Column; 2]) -> TableError {
    let quantity = columns[0].quantity.noun();
    let columns = columns.map(|column| header[column.place].clone());
    TableError::of(path, Fault::Ambiguous { quantity, columns })
}

/// How well a name fits: of several columns for one quantity the one with the smallest number is
/// meant.
type Rank = usize;
const OTHER_SPELLING: Rank = 100;
const OTHER_NAME: Rank = 200;
const OTHER_WORD: Rank = 400;

/// Whether a name ends with a unit.
fn ends_with_unit(name: &str, unit: &Unit) -> bool {
    let suffix = unit.suffix;
    !suffix.is_empty()
        && name
            .strip_suffix(suffix)
            .is_some_and(|rest| rest.is_empty() || rest.ends_with('_') || suffix.len() > 1)
}

impl Schema {
    /// The columns of a table, first those that a user assigns, then those whose names say what
    /// they are.
    ///
    /// # Errors
    /// [`TableError`] for an assigned column that is not there or that the format does not have,
    /// for two columns of one quantity, and for a quantity in a unit that is not read.
    pub(super) fn find(
        &self,
        path: &Path,
        header: &[String],
        mappings: &[Mapping],
    ) -> Result<Vec<Column>, TableError> {
        let mut columns: Vec<Column> = Vec::new();
        let has_pause = self.of(Quantity::Pause).is_some();
        for mapping in mappings.iter().filter(|mapping| !(has_pause && mapping.is_pause())) {
            let column = mapping.column(self, path, header)?;
            if let Some(other) = columns.iter().find(|other| other.quantity == column.quantity) {
                return Err(ambiguous(path, header, [*other, column]));
            }
            columns.push(column);
        }
        let mut named: Vec<(Column, Rank)> = Vec::new();
        for (place, name) in dwd::names(header).enumerate() {
            if let Some((field, unit, rank)) = self.understand(path, name)? {
                let (quantity, bounds) = (field.quantity, field.bounds);
                named.push((Column { quantity, place, unit, sign: 1.0, bounds }, rank));
            }
        }
        for (column, _) in &named {
            if columns.iter().any(|other| other.quantity == column.quantity) {
                continue;
            }
            let same = named.iter().filter(|(other, _)| other.quantity == column.quantity);
            let best = same.clone().map(|(_, rank)| rank).min();
            let mut fitting =
                same.filter(|(_, rank)| Some(rank) == best).map(|(column, _)| *column);
            match (fitting.next(), fitting.next()) {
                (Some(one), Some(other)) => return Err(ambiguous(path, header, [one, other])),
                (one, _) => columns.extend(one),
            }
        }
        Ok(columns)
    }

    /// Quantity and unit by the name of a column.
    fn understand(
        &self,
        path: &Path,
        header: &str,
    ) -> Result<Option<(&Field, &'static Unit, Rank)>, TableError> {
        let name = Name::of(header);
        let Some((field, mut unit, rank, said)) = self.field_in_words(&name) else {
            return Ok(None);
        };
        let text = field.quantity.is_text();
        if let Some(bracket) = name.bracket
            && !(text && self.style == Style::Description)
        {
            match written(field.quantity.units(), bracket) {
                Some(written) if written.is_same(unit) => {}
                // a name that has no unit has that of the brackets
                Some(written) if !ends_with_unit(&said, unit) => unit = written,
                _ if self.style != Style::Description => return Ok(None),
                _ => {
                    let fault = Fault::Bracket {
                        column: header.to_owned(),
                        unit: bracket.to_owned(),
                        allowed: unit.written.first().copied().unwrap_or(unit.suffix),
                    };
                    return Err(TableError::of(path, fault));
                }
            }
        }
        let same = self.style == Style::Description || header == name.text;
        Ok(Some((field, unit, if same { rank } else { rank + OTHER_SPELLING })))
    }

    /// As [`Schema::field`], of a name that may be a synonym or of another language, with the name
    /// that is known.
    fn field_in_words(&self, name: &Name) -> Option<(&Field, &'static Unit, Rank, String)> {
        if let Some((field, unit, rank)) = self.field(&name.text, name.bracket) {
            return Some((field, unit, rank, name.text.clone()));
        }
        // the unit of a row below may have been put behind a name that has one
        let known = word::known_as(&name.text)?;
        let (field, unit, rank) = self.field(&known, name.bracket)?;
        Some((field, unit, rank + OTHER_WORD, known))
    }

    /// The field that a name means, its unit, and how well it fits.
    pub(super) fn field(
        &self,
        name: &str,
        bracket: Option<&str>,
    ) -> Option<(&Field, &'static Unit, Rank)> {
        let own = self.fields.iter().find_map(|field| {
            let (unit, place) = field.own_unit(name)?;
            Some((field, unit, if field.quantity.is_text() { place } else { 0 }))
        });
        own.or_else(|| self.fields.iter().find_map(|field| field.of_vocabulary(name, bracket)))
            .or_else(|| self.fields.iter().find_map(|field| field.own_with_bracket(name, bracket?)))
    }

    /// Quantity by the name of a column.
    pub(crate) fn quantity_of(&self, header: &str) -> Option<Quantity> {
        self.field_in_words(&Name::of(header)).map(|(field, ..)| field.quantity)
    }

    /// Quantity by the name of a column, be it without a unit that is read.
    pub(crate) fn means(&self, header: &str) -> Option<Quantity> {
        let lacking = || self.lacking_unit(header).map(|field| field.quantity);
        self.quantity_of(header).or_else(lacking)
    }

    /// The quantity that a name is but for its unit.
    pub(super) fn lacking_unit(&self, name: &str) -> Option<&Field> {
        let name = Name::of(name);
        let known = word::known_as(&name.text).unwrap_or(name.text);
        self.fields.iter().find(|field| field.quantity.lacks_unit(&known))
    }

    /// The field of a quantity.
    pub(super) fn of(&self, quantity: Quantity) -> Option<&Field> {
        self.fields.iter().find(|field| field.quantity == quantity)
    }
}

impl Field {
    /// As a name of its own with the unit that stands in brackets: `Strecke (km)` is `strecke_km`.
    fn own_with_bracket(&self, name: &str, bracket: &str) -> Option<(&Self, &'static Unit, Rank)> {
        let unit = written(self.quantity.units(), bracket)?;
        let (own, _) = self.own_unit(&with_unit(name, unit.suffix))?;
        own.is_same(unit).then_some((self, own, OTHER_NAME))
    }

    /// The unit in which a name means its quantity, and how well it fits.
    fn of_vocabulary(
        &self,
        name: &str,
        bracket: Option<&str>,
    ) -> Option<(&Self, &'static Unit, Rank)> {
        let entry = self.quantity.entry();
        if let Some(unit) = self.quantity.unit_of(name) {
            // where the name has no unit the brackets have it
            let bracket = bracket.filter(|_| unit.suffix.is_empty());
            let unit = bracket.and_then(|text| written(entry.units, text)).unwrap_or(unit);
            let usual = self.own.is_empty() && with_unit(entry.names[0], unit.suffix) == name;
            return Some((self, unit, if usual { 0 } else { OTHER_NAME }));
        }
        let unit = written(entry.units, bracket?)?;
        entry.names.contains(&name).then_some((self, unit, OTHER_NAME))
    }
}

#[cfg(test)]
mod tests {
    use super::super::formats::TRIP_TOTALS;
    use super::super::quantity::VOCABULARY;
    use super::*;

    #[test]
    fn units_in_brackets_are_those_of_own_names() {
        let understood = |header: &str| {
            let column = TRIP_TOTALS.understand(Path::new("trips.csv"), header).expect("a name");
            column.map(|(field, unit, _)| (field.quantity, unit.suffix))
        };
        for header in ["strecke_km", "Strecke km", "Strecke (km)", "Strecke [km]", "Distancia (km)"]
        {
            assert_eq!(understood(header), Some((Quantity::Distance, "km")), "{header}");
        }
        for header in ["Verbrauch (l)", "Verbrauch in Liter", "Consommation (L)"] {
            assert_eq!(understood(header), Some((Quantity::FuelAmount, "l")), "{header}");
        }
        // consumption may be per distance or time: no amount unless its unit says so
        for header in ["Verbrauch", "Verbrauch (l/100km)", "Verbrauch (l/h)", "Kilometerstand (l)"]
        {
            assert_eq!(understood(header), None, "{header}");
        }
    }

    #[test]
    fn numbers_in_si_are_those_that_stay_what_they_are() {
        for entry in VOCABULARY {
            let quantity = entry.quantity;
            for (unit, sign) in quantity.units().iter().flat_map(|unit| [(unit, 1.0), (unit, -1.0)])
            {
                let column = Column { quantity, place: 0, unit, sign, bounds: None };
                let stay = [0.1, 0.5, 3.0].iter().all(|number| column.si(*number) == *number);
                assert_eq!(column.is_si(), stay, "{quantity:?} {unit:?} {sign}");
            }
        }
    }
}
