//! VECTO's cycles over distance: `<s>` in m, `<v>` target speed in km/h, `<grad>` in %, `<stop>` in s.
//!
//! A row holds up to the next one. A row with a stop time is a stop line; behind it the next row's target speed holds. The gradient
//! is rise over run, tan θ; the road's slope is sin θ. The first and the last stop are the start and the end of the trip: a truck
//! stands there anyway, their times are not counted. A unit in brackets, as in `<s> [m]`, has to be that one. Other columns (auxiliaries, wind) are not used.

use super::{GivenCycleFileError, in_file};
use crate::delimited::{DelimitedTable, KMH, METRES, PERCENT, SECONDS, Unit};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::tracks::{Rule, Track};

/// Allowed target speeds, in km/h: those of any track; 0 where a truck stops.
const SPEEDS_KMH: [f64; 2] = [0.0, 252.0];
/// Allowed stop times, in s; 0 is none.
const STOPS_S: [f64; 2] = [0.0, 172_800.0];

/// Reads a cycle.
pub(super) fn read(table: &DelimitedTable) -> Result<GivenCycle, GivenCycleFileError> {
    let needed = |name: &str, unit: Unit| {
        let column = table.column(&[name])?;
        table.check_unit(column, unit).map(|()| column)
    };
    super::refuse_over_time(table, &["s"])?;
    let position_m = table.numbers(needed("s", METRES)?)?;
    needed("v", KMH)?;
    let speed_kmh = super::within(table, &["v"], SPEEDS_KMH)?.unwrap_or_default();
    let zero = || vec![0.0; position_m.len()];
    let gradient = table.numbers_in(&["grad"], PERCENT)?.unwrap_or_else(zero);
    if let Some(column) = table.one_of(&["stop"])? {
        table.check_unit(column, SECONDS)?;
    }
    let stop_s = super::within(table, &["stop"], STOPS_S)?.unwrap_or_else(zero);
    let lines: Vec<u64> = table.lines().collect();
    let mut limits = Track::empty("speed_limit_mps", Rule::Constant);
    let mut grades = Track::empty("grade", Rule::Constant);
    let mut stops = Track::empty("stop_sign_s", Rule::Event);
    for k in 0..position_m.len() {
        let here_m = position_m[k] - position_m[0];
        // at a stop line two rows may share a place: the second one says how fast the road goes on
        let same_place = k > 0 && position_m[k] == position_m[k - 1] && stop_s[k - 1] > 0.0;
        if k > 0 && position_m[k] <= position_m[k - 1] && !same_place {
            let (path, line) = (table.path().to_owned(), lines[k]);
            return Err(GivenCycleFileError::Order { path, line, position_m: position_m[k] });
        }
        if stop_s[k] > 0.0 {
            stops.push(here_m, stop_s[k]);
        }
        if same_place {
            continue;
        }
        let moving = speed_kmh[k..].iter().find(|speed| **speed > 0.0);
        // behind the last stop there is no road
        if let Some(speed_kmh) = moving {
            limits.push(here_m, speed_kmh / 3.6);
        }
        let tangent = gradient[k] / 100.0;
        grades.push(here_m, tangent / (1.0 + tangent * tangent).sqrt());
    }
    let length_m = position_m.last().map_or(0.0, |last| last - position_m[0]);
    for track in [&mut limits, &mut grades] {
        track.merge_equal();
    }
    GivenCycle::from_tracks(&[limits, grades, stops], Some(length_m)).map_err(in_file(table.path()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(text: &str) -> Result<GivenCycle, GivenCycleFileError> {
        read(&DelimitedTable::parse(Path::new("a.vdri"), text).unwrap())
    }

    #[test]
    fn rows_become_limits_slopes_and_stops() {
        let text = "<s>,<v>,<grad>,<stop>\n0,0,3,2\n9,60,3,0\n100,60,0,0\n150,0,0,25\n155,30,-3,0\n400,0,0,2\n";
        let cycle = parse(text).unwrap();
        assert_eq!(cycle.length_m, 400.0);
        assert_eq!(cycle.limits, [(0.0, 60.0 / 3.6), (150.0, 30.0 / 3.6)]);
        assert_eq!(cycle.events.len(), 1);
        assert_eq!(cycle.events[0].position_m, 150.0);
        assert_eq!(cycle.events[0].kind.standstill_s(), Some(25.0));
        // 100 m up 3 % of the run
        let climb = 100.0 * 0.03 / (1.0f64 + 0.03 * 0.03).sqrt();
        assert!((cycle.altitude_m(120.0) - climb).abs() < 1e-9);
    }

    #[test]
    fn what_no_cycle_has_is_refused_with_its_place() {
        for (header, row, words) in [
            (
                "<s>,<v>,<grad>,<stop>",
                "9,60,0,-5",
                "a.vdri:3: `stop` is -5, allowed is 0 to 172800",
            ),
            ("<s>,<v>,<grad>,<stop>", "9,-60,0,0", "a.vdri:3: `v` is -60, allowed is 0 to 252"),
            ("<s> [km],<v>,<grad>,<stop>", "9,60,0,0", "`<s> [km]` is read in m, not in km"),
            ("<s>,<v> [m/s],<grad>,<stop>", "9,60,0,0", "`<v> [m/s]` is read in km/h"),
            ("<t>,<v>,<grad>,<stop>", "9,60,0,0", "it has a column `t`, and none for the position"),
            ("<s>,<v>,<v>,<stop>", "9,60,50,0", "the columns `<v>` and `<v>`"),
        ] {
            let fault = DelimitedTable::parse(
                Path::new("a.vdri"),
                &format!("{header}\n0,0,0,2\n{row}\n400,0,0,2\n"),
            );
            let fault = read(&fault.unwrap()).unwrap_err().to_string();
            assert!(fault.contains(words), "{fault}");
        }
        let units = "<s> [m],<v> [km/h],<grad> [%],<stop> [s]\n0,0,0,2\n9,60,0,0\n400,0,0,2\n";
        assert_eq!(parse(units).unwrap().length_m, 400.0);
    }

    #[test]
    fn positions_have_to_grow() {
        let text = "<s>,<v>,<grad>,<stop>\n0,0,0,2\n9,60,0,0\n8,60,0,0\n400,0,0,2\n";
        assert!(parse(text).unwrap_err().to_string().starts_with("a.vdri:4: position 8 m"));
    }
}
