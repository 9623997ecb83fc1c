//! Tables of measured curves, one row a curve, as `ocmc curves` writes them.

use crate::intake::table::formats::CURVES;
use crate::intake::table::given::RowPlace;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use crate::intake::{FileAccount, curve};
use ocmc_estimation::fit::curve_speed::CurveTable;
use ocmc_estimation::log::surroundings::Surroundings;

/// Reads a table of curves.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read(source: Source, mappings: &[Mapping]) -> Result<(CurveTable, FileAccount), TableError> {
    let file = Table::open(source, &CURVES, mappings)?;
    file.refuse_other_units()?;
    file.need(&[Quantity::Driver, Quantity::Radius, Quantity::Speed])?;
    let both_gaps =
        [Quantity::GapBefore, Quantity::GapAfter].iter().all(|gap| file.column(*gap).is_some());
    let mut table = CurveTable {
        left: file.column(Quantity::Direction).map(|_| Vec::new()),
        route_m: file.column(Quantity::RouteLength).map(|_| Vec::new()),
        limit_mps: file.column(Quantity::Limit).map(|_| Vec::new()),
        acceleration_mps2: file.column(Quantity::Acceleration).map(|_| Vec::new()),
        around: both_gaps.then(Vec::new),
        ..CurveTable::default()
    };
    let mut impossible: Vec<(RowPlace, f64)> = Vec::new();
    let mut account = file.for_each(|row| {
        table.driver.push(row.text(Quantity::Driver).to_owned());
        let mut radius_m = row.number(Quantity::Radius)?;
        let speed_mps = row.number(Quantity::Speed)?;
        if let Some(lateral_mps2) = curve::impossible_mps2(speed_mps, radius_m) {
            impossible.push((row.place(), lateral_mps2));
            radius_m = f64::NAN;
        }
        table.speed_mps.push(speed_mps);
        if let Some(left) = &mut table.left {
            left.push(match row.text(Quantity::Direction).to_ascii_lowercase().as_str() {
                "left" => true,
                "right" => false,
                // a missing value like any other, which leaves the row out
                "" => {
                    radius_m = f64::NAN;
                    false
                }
                _ => return Err(row.refuse(Quantity::Direction, "`left` or `right`")),
            });
        }
        if let Some(route_m) = &mut table.route_m {
            route_m.push(row.number(Quantity::RouteLength)?);
        }
        if let Some(limit_mps) = &mut table.limit_mps {
            limit_mps.push(row.number(Quantity::Limit)?);
        }
        if let Some(acceleration_mps2) = &mut table.acceleration_mps2 {
            acceleration_mps2.push(row.number(Quantity::Acceleration)?);
        }
        if let Some(around) = &mut table.around {
            let stop_near_m = row.number(Quantity::StopNear)?;
            around.push(Surroundings {
                gap_before_m: row.number(Quantity::GapBefore)?,
                gap_after_m: row.number(Quantity::GapAfter)?,
                slowest_near_mps: row.number(Quantity::SlowestNear)?,
                stop_near_m: (!stop_near_m.is_nan()).then_some(stop_near_m),
            });
        }
        table.radius_m.push(radius_m);
        Ok(())
    })?;
    account.findings.extend(curve::impossible(&impossible));
    Ok((table, account))
}
