//! Remarks on a log that was read: where a drive stands, and what is odd.

use super::{LogFile, LoggedTrip};
use crate::intake::Finding;
use crate::number_text::{count_of, grouped, has_decimal_comma};
use ocmc_estimation::log::signal::LogCounts;

/// Counts of something at a place, each with its number, its noun in the singular and what becomes
/// of it.
pub(crate) fn counted<'a>(
    place: &str,
    counts: impl IntoIterator<Item = (usize, &'a str, &'a str)>,
) -> Vec<String> {
    let some = counts.into_iter().filter(|(count, ..)| *count > 0);
    some.map(|(count, thing, what)| format!("{place}: {} {what}", count_of(count as u64, thing)))
        .collect()
}

/// Rows that are not used, or doubtful.
pub(crate) fn row_notes(place: &str, rows: &LogCounts) -> Vec<String> {
    let reversing = if rows.reversing > rows.used {
        "in reverse: not used; is the sign of the speed right?"
    } else {
        "in reverse: not used"
    };
    counted(
        place,
        [
            (rows.missing_time, "row", "without time: not used"),
            (rows.missing_speed, "row", "without speed: not used"),
            (rows.repeated_time, "row", "with the time of the row before: not used"),
            (rows.reversing, "row", reversing),
            (rows.implausible_speed, "row", "faster than 70 m/s: is the unit right?"),
        ],
    )
}

impl LogFile {
    /// Where a drive stands.
    pub fn place(&self, drive: &LoggedTrip) -> String {
        let path = self.path.display();
        if self.drives.len() == 1 && !self.is_part {
            return format!("`{path}`");
        }
        match &drive.event {
            Some(event) => format!("drive `{}`, event `{event}` of `{path}`", drive.drive),
            None => format!("drive `{}` of `{path}`", drive.drive),
        }
    }
}

/// Finding on the ambient temperature, where there is one.
pub(super) fn ambient_temperature(means_k: &[f64]) -> Option<Finding> {
    let means_k = means_k.iter().copied();
    let (low_k, high_k) = (means_k.clone().reduce(f64::min)?, means_k.reduce(f64::max)?);
    let [low, high] = [low_k, high_k].map(|k| format!("{:.1}", k - 273.15));
    let range = if low == high { low } else { format!("{low} to {high}") };
    let text = format!(
        "the ambient temperature, {range} °C in the mean of a drive, is that of the air in \
         `identify`; other commands do not use it"
    );
    Some(Finding::noted("ambient-temperature", [low_k, high_k], text, ""))
}

/// Rows with too few or too many cells, and cells that are no numbers.
pub(super) fn cells_left_out(file: &LogFile) -> Vec<Finding> {
    let rows = grouped(file.rows as u64);
    let ragged = (file.ragged_rows > 0).then(|| {
        let text = format!(
            "{} of {rows} rows have too few or too many cells: what is there is used",
            grouped(file.ragged_rows as u64)
        );
        Finding::warned("ragged-rows", [file.ragged_rows as f64, 0.0], text, "")
    });
    let unreadable = file.unreadable.iter().map(|cells| {
        let text = format!(
            "{} cells of `{}` are no numbers, first `{}` in {}: they count as missing{}",
            grouped(cells.cells as u64),
            cells.column,
            cells.text,
            cells.place,
            how_numbers_are_written(&cells.column, &cells.text)
        );
        Finding::warned("unreadable-cells", [cells.cells as f64, 0.0], text, "")
    });
    ragged.into_iter().chain(unreadable).collect()
}

/// Remedy for a cell that is no number and looks like one, or like a time.
pub(super) fn how_numbers_are_written(column: &str, text: &str) -> &'static str {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if has_decimal_comma(text) {
        return "; numbers take a decimal point: write 0.5, not 0,5 (commas are read where all \
                numbers have them and semicolons separate the cells)";
    }
    if column == "time" && text.parse::<f64>().is_ok() {
        return "; a time in numbers has its unit in the name, as in time_s: --map time_s=time";
    }
    let date = text.get(..4).is_some_and(digits) && text[4..].starts_with(['-', '/']);
    if date || (column.starts_with("time") && text.contains(':')) {
        return "; times are numbers, seconds from any origin, as in time_s, or dates under the \
                name time";
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_commas_and_dates_get_a_hint() {
        for (column, text, hint) in [
            ("speed_kmh", "0,0", "decimal point"),
            ("speed_kmh", "-12,5", "decimal point"),
            ("speed_kmh", "fast", ""),
            ("speed_kmh", "ä,5", ""),
            ("zeit", "2024-03-01T12:00:00Z", "seconds from any origin"),
            ("time", "0.5", "--map time_s=time"),
            ("time_s", "12:00:01", "seconds from any origin"),
            ("time_s", "", ""),
        ] {
            let message = how_numbers_are_written(column, text);
            assert!(
                message.contains(hint) && message.is_empty() == hint.is_empty(),
                "{text}: {message}"
            );
        }
    }
}
