//! Tables of traffic, one row a site and interval.
//!
//! `site` says which rows follow each other; without it each road type is one site. Rows of a site
//! are in order of time.

use crate::intake::FileAccount;
use crate::intake::table::clock::{ClockColumn, PlaceClock};
use crate::intake::table::formats::TRAFFIC;
use crate::intake::table::{Mapping, Quantity, Source, Table, TableError};
use ocmc_core::operating_cycle::traffic::TrafficModel;
use ocmc_estimation::fit::traffic::TrafficRecord;
use std::collections::BTreeMap;

/// A table of traffic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrafficTable {
    /// Its rows.
    pub records: Vec<TrafficRecord>,
    /// Where speeds were measured: of each row the speed over that of the empty road, NaN where it
    /// is missing.
    pub speed_ratios: Option<Vec<f64>>,
    /// Account of the file.
    pub read: FileAccount,
}

/// Reads the records of a table of traffic, as [`read_table`].
///
/// # Errors
/// As [`read_table`].
pub fn read(
    source: Source,
    mappings: &[Mapping],
    model: &TrafficModel,
    place: Option<&PlaceClock>,
) -> Result<Vec<TrafficRecord>, TableError> {
    read_table(source, mappings, model, place).map(|table| table.records)
}

/// Reads a table of traffic; `model` knows the jam density and the law of speeds, `place`
/// is the clock of the place, where that is known.
///
/// # Errors
/// [`TableError`] names the file, the place in it and what is allowed.
pub fn read_table(
    source: Source,
    mappings: &[Mapping],
    model: &TrafficModel,
    place: Option<&PlaceClock>,
) -> Result<TrafficTable, TableError> {
    let file = Table::open(source, &TRAFFIC, mappings)?;
    file.refuse_other_units()?;
    let mut clock = ClockColumn::find(&file, place)?;
    file.need(&[Quantity::RoadType])?;
    let kinds = [Quantity::DensityShare, Quantity::Density, Quantity::SpeedRatio];
    let measured = file.one_of(&kinds)?.ok_or_else(|| file.missing("traffic", &kinds))?;
    let measured = measured.quantity;
    let has_sites = file.column(Quantity::Site).is_some();
    let mut last: BTreeMap<String, f64> = BTreeMap::new();
    let mut records = Vec::new();
    let mut speed_ratios = (measured == Quantity::SpeedRatio).then(Vec::new);
    let mut read = file.for_each(|row| {
        let road_type = row.text(Quantity::RoadType).to_owned();
        let site = if has_sites { row.text(Quantity::Site).to_owned() } else { road_type.clone() };
        let (time_s, _) = clock.after(row, last.get(&site).copied())?;
        last.insert(site.clone(), time_s);
        let value = row.number(measured)?;
        if let Some(speed_ratios) = &mut speed_ratios {
            speed_ratios.push(value);
        }
        let share = match measured {
            Quantity::Density => value / model.jam_density_per_m,
            Quantity::SpeedRatio => model.share_at(value),
            _ => value,
        };
        if share > 1.0 && measured != Quantity::SpeedRatio {
            return Err(row.refuse(measured, "a density up to that of standing traffic"));
        }
        records.push(TrafficRecord { site, road_type, time_s, share });
        Ok(())
    })?;
    read.findings.extend(clock.findings());
    Ok(TrafficTable { records, speed_ratios, read })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study;
    use std::path::Path;

    fn table(text: &str) -> Result<Vec<TrafficRecord>, TableError> {
        let study = study::load("field-truck", &[] as &[&str]).expect("a built-in study");
        read(Source::Text(Path::new("traffic.csv"), text), &[], &study.model.traffic, None)
    }

    #[test]
    fn densities_and_speeds_are_understood() {
        let by_share = table("time_s,road_type,density_share\n0,urban,0.2\n300,urban,\n").unwrap();
        assert!((by_share[0].share - 0.2).abs() < 1e-15 && by_share[1].share.is_nan());
        let by_density = table("time_s,road_type,density_per_m\n0,urban,0.026\n").unwrap();
        assert!((by_density[0].share - 0.2).abs() < 1e-12);
        let speed = "time,road_type,speed_ratio,site\n2024-03-01T00:00,rural,0.8,a\n\
                     2024-03-01T00:00,rural,1.1,b\n\
                     2024-03-01T00:05,rural,0,a\n2024-03-01T00:05,rural,0.01,b\n\
                     2024-03-01T00:10,rural,,a\n";
        let by_speed = table(speed).unwrap();
        // standing traffic, traffic slower than the law at the jam density, and a missing value
        assert!(by_speed[2].share == 1.0 && by_speed[3].share == 1.0 && by_speed[4].share.is_nan());
        assert!((by_speed[0].share - 0.35 * (-2.0 * 0.8_f64.ln()).sqrt()).abs() < 1e-12);
        assert!(by_speed[1].share == 0.0 && by_speed[1].site == "b");
    }

    #[test]
    fn what_is_no_traffic_is_refused_with_its_place() {
        for (text, words) in [
            ("time_s,road_type,cars\n0,urban,3\n", "speed_ratio"),
            ("time_s,density_share\n0,0.1\n", "road_type"),
            (
                "time_s,road_type,density_share,speed_ratio\n0,urban,0.1,0.9\n",
                "`density_share` and `speed_ratio`, which are both the density",
            ),
            ("time_s,road_type,density_share\n300,urban,0.1\n300,urban,0.1\n", "line 3"),
            ("time_s,road_type,density_share\n0,urban,20\n", "standing traffic"),
            ("time_s,road_type,speed_ratio\n0,urban,-1\n", "from 0 on"),
        ] {
            let message = table(text).unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}
