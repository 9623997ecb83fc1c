//! VECTO's cycles over distance: `<s>` in m, `<v>` target speed in km/h, `<grad>` in %, `<stop>` in
//! s.
//!
//! A row holds up to the next one. A row with a stop time is a stop line; behind it the next row's
//! target speed holds. The gradient is rise over run, tan θ; the road's slope is sin θ. The first
//! and the last stop are the start and the end of the trip: a truck stands there anyway, their
//! times are not counted. A unit in brackets, as in `<s> [m]`, has to be that one. Other columns
//! (auxiliaries, wind) are not used.

use super::in_file;
use crate::intake::FileAccount;
use crate::intake::table::error::Fault;
use crate::intake::table::formats::VECTO_CYCLE;
use crate::intake::table::unit::KMH;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use ocmc_core::operating_cycle::given::GivenCycle;
use ocmc_core::operating_cycle::tracks::{Rule, Track};

/// Reads a cycle.
pub(super) fn read(
    source: Source,
    mappings: &[Mapping],
) -> Result<(GivenCycle, FileAccount), TableError> {
    let table = Table::open(source, &VECTO_CYCLE, mappings)?;
    super::refuse_over_time(&table, &[Quantity::Position])?;
    table.need(&[Quantity::Position, Quantity::Speed])?;
    let (mut position_m, mut speed_mps) = (Vec::new(), Vec::new());
    let (mut gradient, mut stop_s) = (Vec::new(), Vec::<f64>::new());
    let account = table.for_each(|row| {
        position_m.push(row.number(Quantity::Position)?);
        speed_mps.extend(row.divided(Quantity::Speed, KMH, 3.6)?);
        gradient.push(row.divided(Quantity::Gradient, "percent", 100.0)?.unwrap_or(0.0));
        // at a stop line two rows may share a place: the second one says how fast the road goes on
        if let [.., a, b] = position_m[..]
            && (b < a || b == a && stop_s.last().is_none_or(|stop_s| *stop_s <= 0.0))
        {
            return Err(TableError::of(source.path(), Fault::Order(row.place(), b)));
        }
        stop_s.push(row.optional(Quantity::Stop)?.unwrap_or(0.0));
        Ok(())
    })?;
    let mut limits = Track::empty("speed_limit_mps", Rule::Constant);
    let mut grades = Track::empty("grade", Rule::Constant);
    let mut stops = Track::empty("stop_sign_s", Rule::Event);
    for k in 0..position_m.len() {
        let here_m = position_m[k] - position_m[0];
        let same_place = k > 0 && position_m[k] == position_m[k - 1];
        if stop_s[k] > 0.0 {
            stops.push(here_m, stop_s[k]);
        }
        if same_place {
            continue;
        }
        let moving = speed_mps[k..].iter().find(|speed| **speed > 0.0);
        // behind the last stop there is no road
        if let Some(speed_mps) = moving {
            limits.push(here_m, *speed_mps);
        }
        let tangent = gradient[k];
        grades.push(here_m, tangent / (1.0 + tangent * tangent).sqrt());
    }
    let length_m = position_m.last().map_or(0.0, |last| last - position_m[0]);
    for track in [&mut limits, &mut grades] {
        track.merge_equal();
    }
    let cycle = GivenCycle::from_tracks(&[limits, grades, stops], Some(length_m))
        .map_err(in_file(source.path()))?;
    Ok((cycle, account))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(text: &str) -> Result<GivenCycle, TableError> {
        read(Source::Text(Path::new("a.vdri"), text), &[]).map(|(cycle, _)| cycle)
    }

    #[test]
    fn rows_become_limits_slopes_and_stops() {
        let text = "<s>,<v>,<grad>,<stop>\n0,0,3,2\n9,60,3,0\n100,60,0,0\n150,0,0,25\n155,30,-3,0\n\
                    400,0,0,2\n";
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
                "`a.vdri`, line 3, column `<stop>`: `-5`; allowed is 0 to 172800",
            ),
            (
                "<s>,<v>,<grad>,<stop>",
                "9,-60,0,0",
                "`a.vdri`, line 3, column `<v>`: `-60`; allowed is 0 to 252",
            ),
            ("<s> [s],<v>,<grad>,<stop>", "9,60,0,0", "`<s> [s]` is read in m, not in s"),
            (
                "<t>,<v>,<grad>,<stop>",
                "9,60,0,0",
                "it has a column `<t>`, and none for the position",
            ),
            ("<s>,<v>,<v>,<stop>", "9,60,50,0", "the columns `<v>` and `<v>`"),
        ] {
            let fault = parse(&format!("{header}\n0,0,0,2\n{row}\n400,0,0,2\n"));
            let fault = fault.unwrap_err().to_string();
            assert!(fault.contains(words), "{fault}");
        }
        let units = "<s> [m],<v> [km/h],<grad> [%],<stop> [s]\n0,0,0,2\n9,60,0,0\n400,0,0,2\n";
        assert_eq!(parse(units).unwrap().length_m, 400.0);
        let units = "<s> [km],<v> [m/s],<grad> [%],<stop> [s]\n0,0,0,2\n0.009,20,0,0\n0.4,0,0,2\n";
        let cycle = parse(units).unwrap();
        assert_eq!((cycle.length_m, cycle.limits[0].1), (400.0, 20.0));
    }

    #[test]
    fn positions_have_to_grow() {
        let text = "<s>,<v>,<grad>,<stop>\n0,0,0,2\n9,60,0,0\n8,60,0,0\n400,0,0,2\n";
        assert!(parse(text).unwrap_err().to_string().starts_with("`a.vdri`, line 4: position 8 m"));
    }
}
