//! Decimal commas: a table whose cells are separated by semicolons or tabulators may write 2,5.
//!
//! A table has one kind of decimals. Where both are there, `1.234` or `1,234` has thousands in it,
//! and nothing tells which: the second kind counts as no number.

use crate::intake::Finding;
use crate::number_text::has_decimal_comma;
use std::cell::Cell;

/// Decimal marks that the numbers of a table have had so far.
#[derive(Debug, Default)]
pub(super) struct Decimals {
    /// Whether a comma separates no cells.
    allowed: bool,
    point: Cell<bool>,
    comma: Cell<bool>,
    /// Whether a number with a comma cannot have thousands in it.
    is_certain: Cell<bool>,
}

impl Decimals {
    /// None yet; `allowed`: whether a comma may be a decimal one.
    pub(super) fn new(allowed: bool) -> Self {
        Self { allowed, ..Self::default() }
    }

    /// The number that a text is; none where it is something else.
    pub(super) fn number(&self, text: &str) -> Option<f64> {
        let number: Option<f64> = text.parse().ok();
        if !self.allowed {
            return number;
        }
        if number.is_some() {
            if text.contains('.') {
                if self.comma.get() {
                    return None;
                }
                self.point.set(true);
            }
            return number;
        }
        if self.point.get() || !has_decimal_comma(text) {
            return None;
        }
        self.comma.set(true);
        let (whole, part) = text.split_once(',').unwrap_or((text, ""));
        let whole = whole.trim_start_matches(['-', '+']);
        if part.len() != 3 || whole.len() > 3 || whole.starts_with('0') {
            self.is_certain.set(true);
        }
        text.replace(',', ".").parse().ok()
    }

    /// Says that there were decimal commas, and whether they may have been something else.
    pub(super) fn finding(&self) -> Option<Finding> {
        if !self.comma.get() {
            return None;
        }
        if self.is_certain.get() {
            let text = "numbers have decimal commas: 2,5 is 2.5".to_owned();
            return Some(Finding::mended("decimal-commas", [1.0, 0.0], text));
        }
        let text = "numbers with a comma all have three digits behind it: 1,234 was read as 1.234";
        let remedy = "where it separates thousands write 1234";
        Some(Finding::warned("decimal-commas", [1.0, 0.0], text.to_owned(), remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_kind_of_decimals_is_read() {
        let comma = Decimals::new(true);
        assert_eq!([comma.number("2,5"), comma.number("-0,018")], [Some(2.5), Some(-0.018)]);
        assert_eq!([comma.number("7"), comma.number("1.5")], [Some(7.0), None]);
        assert!(comma.finding().unwrap().text.contains("decimal commas"));
        let point = Decimals::new(true);
        assert_eq!([point.number("2.5"), point.number("2,5")], [Some(2.5), None]);
        assert_eq!(point.finding(), None);
        let unclear = Decimals::new(true);
        assert_eq!(unclear.number("12,500"), Some(12.5));
        assert!(unclear.finding().unwrap().remedy.contains("thousands"));
        assert_eq!(Decimals::new(false).number("2,5"), None);
        assert_eq!(unclear.number("1,2,3"), None);
    }
}
