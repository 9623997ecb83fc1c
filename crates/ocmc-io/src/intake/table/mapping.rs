//! Assignment of a table's columns to quantities, as a user says with `--map speed_mph=gps_speed`.

use super::error::{Fault, TableError, nearest};
use super::formats::SCHEMAS;
use super::quantity::{Quantity, VOCABULARY};
use super::schema::{Column, Schema};
use std::collections::BTreeMap;
use std::path::Path;

/// One assignment of a user.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// Name of a quantity with its unit.
    name: String,
    column: String,
    /// -1 where the column counts the other way round, written as `yaw_rate_degps=-gyro`.
    sign: f64,
}

impl Mapping {
    /// Reads `NAME=COLUMN`.
    ///
    /// # Errors
    /// [`Fault::Mapping`], [`Fault::UnknownUnit`] or [`Fault::UnknownName`].
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let wrong = || TableError::of_mapping(Fault::Mapping(text.to_owned()));
        let (name, column) = text.split_once('=').ok_or_else(wrong)?;
        let (name, column) = (name.trim(), column.trim());
        let (sign, column) = match column.strip_prefix('-') {
            Some(rest) => (-1.0, rest),
            None => (1.0, column),
        };
        if name.is_empty() || column.is_empty() {
            return Err(wrong());
        }
        let known = |entry: Quantity| entry.unit_of(name).is_some();
        if VOCABULARY.iter().any(|entry| known(entry.quantity))
            || SCHEMAS.iter().any(|schema| schema.field(name, None).is_some())
        {
            return Ok(Self { name: name.to_owned(), column: column.to_owned(), sign });
        }
        if let Some(entry) = VOCABULARY.iter().find(|entry| entry.quantity.lacks_unit(name)) {
            return Err(unknown_unit(name, &entry.quantity.names().collect::<Vec<_>>()));
        }
        let all: Vec<String> = VOCABULARY.iter().flat_map(|entry| entry.quantity.names()).collect();
        let (name, nearest) = (name.to_owned(), nearest(name, &all));
        let allowed = VOCABULARY.each_ref().map(|entry| entry.names[0]).join(", ");
        Err(TableError::of_mapping(Fault::UnknownName { name, nearest, allowed }))
    }

    /// The assignments of a table of names and columns.
    ///
    /// # Errors
    /// As [`Mapping::parse`].
    pub fn of_columns(columns: &BTreeMap<String, String>) -> Result<Vec<Self>, TableError> {
        columns.iter().map(|(name, column)| Self::parse(&format!("{name}={column}"))).collect()
    }

    /// Assignments as a table of names and columns.
    pub fn columns(mappings: &[Self]) -> BTreeMap<String, String> {
        let column = |mapping: &Self| {
            let sign = if mapping.sign < 0.0 { "-" } else { "" };
            (mapping.name.clone(), format!("{sign}{}", mapping.column))
        };
        mappings.iter().map(column).collect()
    }

    /// The column of a table that is assigned.
    pub(super) fn column(
        &self,
        schema: &Schema,
        path: &Path,
        header: &[String],
    ) -> Result<Column, TableError> {
        let Some((field, unit, _)) = schema.field(&self.name, None) else {
            if let Some(field) = schema.lacking_unit(&self.name) {
                return Err(unknown_unit(&self.name, &field.names()));
            }
            let names = schema.fields.iter().map(|field| field.quantity.name());
            let fault = Fault::NotOfFormat {
                name: self.name.clone(),
                what: schema.what,
                allowed: names.collect::<Vec<_>>().join(", "),
            };
            return Err(TableError::of(path, fault));
        };
        let place = header
            .iter()
            .position(|name| {
                // a row below the names may have put its units behind them
                *name == self.column
                    || name.split_once(" [").is_some_and(|(name, _)| name == self.column)
            })
            .ok_or_else(|| {
                let fault = Fault::NoSuchColumn {
                    column: self.column.clone(),
                    nearest: nearest(&self.column, header),
                    found: header.join(", "),
                };
                TableError::of(path, fault)
            })?;
        let sign = if field.quantity.is_text() { 1.0 } else { self.sign };
        Ok(Column { quantity: field.quantity, place, unit, sign, bounds: field.bounds })
    }

    /// The standstill that ends a trip, in s, where one is stated.
    ///
    /// # Errors
    /// [`Fault::Mapping`] where it is no time.
    pub(crate) fn pause_s(mappings: &[Self]) -> Result<Option<f64>, TableError> {
        let Some(own) = mappings.iter().find(|mapping| mapping.is_pause()) else {
            return Ok(None);
        };
        let unit = Quantity::Pause.unit_of(&own.name);
        let number: Option<f64> = own.column.parse().ok().filter(|_| own.sign > 0.0);
        let pause_s = unit.zip(number).map(|(unit, number)| unit.si(number));
        pause_s.filter(|pause_s| pause_s.is_finite() && *pause_s > 0.0).map(Some).ok_or_else(|| {
            TableError::of_mapping(Fault::Pause(format!("{}={}", own.name, own.column)))
        })
    }

    /// Whether it states a pause, and assigns no column.
    pub(super) fn is_pause(&self) -> bool {
        Quantity::Pause.unit_of(&self.name).is_some()
    }

    /// Whether this column is assigned.
    pub(crate) fn assigns(&self, column: &str) -> bool {
        self.column == column
    }

    /// Whether a format has what is assigned.
    pub(crate) fn is_of(&self, schema: &Schema) -> bool {
        schema.field(&self.name, None).is_some()
    }
}

fn unknown_unit(name: &str, allowed: &[String]) -> TableError {
    let (name, allowed) = (name.to_owned(), allowed.join(", "));
    TableError::of_mapping(Fault::UnknownUnit { name, allowed })
}
