//! Weather files of EnergyPlus (`.epw`): eight lines of heading, then an hour a row without names.
//!
//! Source: Auxiliary Programs of EnergyPlus, "EnergyPlus Weather File (EPW) Data Dictionary":
//! places of the columns, hours from 1 to 24 that end at their number, and the codes for missing
//! values. The months of a typical year come from different years, which are not read.

use super::{Content, Format, text_of};
use jiff::civil::date;
use std::fmt::Write;

/// The format.
pub(super) const EPW: Format = Format {
    name: "a weather file of EnergyPlus",
    is_track: false,
    is_one: |start| {
        let text = text_of(start);
        let mut lines = text.lines();
        let mut begins = |name| lines.next().is_some_and(|line| line.starts_with(name));
        begins("LOCATION,") && begins("DESIGN CONDITIONS")
    },
    read: |_, bytes| Ok(Content::Cells(as_table(&text_of(bytes)), Vec::new())),
};

const HEADING_LINES: usize = 8;

/// Places of month, day and hour.
const CLOCK: [usize; 3] = [1, 2, 3];

/// Place, name in our vocabulary, and the number from which on a value is missing.
const COLUMNS: [(usize, &str, f64); 6] = [
    (6, "temperature_c", 99.9),
    (8, "relative_humidity_percent", 999.0),
    (9, "pressure_pa", 999_999.0),
    (20, "wind_direction_deg", 999.0),
    (21, "wind_speed_mps", 999.0),
    (33, "precipitation_mm_per_h", 999.0),
];

/// The file as a table of weather, a line for each of its lines; cells that are no numbers stay as
/// they are, and are refused with their line.
pub(super) fn as_table(text: &str) -> String {
    let names = COLUMNS.map(|(_, name, _)| name).join(",");
    let mut table = format!("{}time_h,{names}\n", "#\n".repeat(HEADING_LINES - 1));
    let rows = text.lines().skip(HEADING_LINES).filter(|line| !line.trim().is_empty());
    for line in rows {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let cell = |place: usize| cells.get(place).copied().unwrap_or_default();
        match hour_of_year(CLOCK.map(cell)) {
            Some(hour) => _ = write!(table, "{hour}"),
            None => table.push_str(cell(CLOCK[2])),
        }
        for (place, _, missing) in COLUMNS {
            let cell = cell(place);
            let is_missing = cell.parse::<f64>().is_ok_and(|number| number >= missing);
            _ = write!(table, ",{}", if is_missing { "" } else { cell });
        }
        table.push('\n');
    }
    table
}

/// The hour of a year without a leap day, counted from 0, at which an hour begins.
fn hour_of_year([month, day, hour]: [&str; 3]) -> Option<u32> {
    let [month, day] = [month, day].map(|text| text.parse::<i8>().ok());
    let (month, day, hour) = (month?, day?, hour.parse::<u32>().ok()?);
    let is_date =
        (1..=12).contains(&month) && day >= 1 && day <= date(2001, month, 1).days_in_month();
    let days = is_date.then(|| date(2001, month, day).day_of_year() as u32 - 1)?;
    (1..=24).contains(&hour).then(|| 24 * days + hour - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_and_codes_for_missing_values() {
        let mut text = "LOCATION,x\nDESIGN CONDITIONS,0\n".to_owned() + &"y\n".repeat(6);
        let cells = |hour: &str, temperature: &str, wind: &str| {
            let mut cells = vec!["0"; 35];
            (cells[1], cells[2], cells[3], cells[6], cells[21]) =
                ("2", "1", hour, temperature, wind);
            cells.join(",")
        };
        writeln!(text, "{}\n{}", cells("1", "-5.9", "999"), cells("24", "99.9", "1.8")).unwrap();
        assert!((EPW.is_one)(text.as_bytes()) && !(EPW.is_one)(b"LOCATION,time\nx,0\n"));
        let table = as_table(&text);
        let rows: Vec<&str> = table.lines().skip(8).collect();
        assert!(rows[0].starts_with("744,-5.9,0,0,0,,0"), "{}", rows[0]);
        assert!(rows[1].starts_with("767,,0,0,0,1.8,0"), "{}", rows[1]);
    }
}
