//! Known quantities of a trip beside its consumption, and a study's expectation by them.

use ocmc_core::record::Record;
use ocmc_estimation::fit::least_squares::LeastSquares;
use ocmc_fleet::quantity::NamedQuantity;
use ocmc_io::trip_totals::TripTotal;
use serde::Serialize;
use std::f64::consts::TAU;

/// Weight and length about which columns are centred, and their steps.
const WEIGHT_KG: [f64; 2] = [25_000.0, 10_000.0];
const LENGTH_M: f64 = 50_000.0;
/// Mean speed about which it is centred.
const SPEED_MPS: f64 = 20.0;
/// Climb of a hundredth of the way is one.
const CLIMB: f64 = 100.0;
const YEAR_S: f64 = 365.0 * 86_400.0;
/// Longest part of the year without a trip with which a table tells its own season.
const MOST_WITHOUT_TRIP: f64 = 1.0 / 3.0;
/// SD of ln length below which trips have one length.
const LEAST_LENGTH_SD: f64 = 0.01;

/// A quantity in which trips differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Covariate {
    /// Gross weight, and its square.
    Weight,
    /// Logarithm of the length.
    Length,
    /// Climb over length.
    Climb,
    /// Logarithm of the mean speed while driving, and its square: which roads a trip was on.
    Speed,
    /// Day of the year, as a first harmonic.
    Season,
    /// Route in the table, of which the study knows nothing.
    Route,
}

impl Covariate {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Weight => "weight",
            Self::Length => "length",
            Self::Climb => "climb",
            Self::Speed => "mean speed",
            Self::Season => "season",
            Self::Route => "route",
        }
    }

    fn columns(self) -> usize {
        match self {
            Self::Weight | Self::Speed | Self::Season => 2,
            Self::Length | Self::Climb => 1,
            Self::Route => 0,
        }
    }
}

/// The known quantities of one trip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) gross_kg: f64,
    pub(super) length_m: f64,
    pub(super) climb_m: f64,
    pub(super) driving_s: f64,
    pub(super) s_of_year: f64,
}

impl Known {
    pub(super) fn of_row(row: &TripTotal, gross_kg: f64) -> Self {
        Self {
            gross_kg,
            length_m: row.distance_m,
            climb_m: row.climb_m,
            driving_s: row.driving_s,
            s_of_year: row.s_of_year,
        }
    }

    fn of_record(record: &Record, curb_kg: f64) -> Self {
        Self {
            gross_kg: curb_kg + record.mean_payload_kg,
            length_m: record.distance_m,
            climb_m: record.climb_m,
            driving_s: record.duration_s - record.rest_s.unwrap_or(0.0),
            s_of_year: record.departure_s_of_year,
        }
    }

    /// The columns of what is known.
    pub(super) fn columns(&self, known: &[Covariate]) -> Vec<f64> {
        let mut columns = Vec::new();
        for covariate in known {
            match covariate {
                Covariate::Weight => {
                    let g = (self.gross_kg - WEIGHT_KG[0]) / WEIGHT_KG[1];
                    columns.extend([g, g * g]);
                }
                Covariate::Length => columns.push(libm::log(self.length_m / LENGTH_M)),
                Covariate::Climb => columns.push(CLIMB * self.climb_m / self.length_m),
                Covariate::Speed => {
                    let v = libm::log(self.length_m / self.driving_s / SPEED_MPS);
                    columns.extend([v, v * v]);
                }
                Covariate::Season => {
                    let phase = TAU * self.s_of_year / YEAR_S;
                    columns.extend([libm::cos(phase), libm::sin(phase)]);
                }
                Covariate::Route => {}
            }
        }
        columns
    }
}

/// The places of the columns of each covariate.
pub(super) fn places(known: &[Covariate]) -> Vec<(Covariate, std::ops::Range<usize>)> {
    let mut first = 0;
    let place = |covariate: &Covariate| {
        first += covariate.columns();
        (*covariate, first - covariate.columns()..first)
    };
    known.iter().map(place).collect()
}

/// Whether lengths differ at all.
pub(super) fn lengths_differ(lengths_m: &[f64]) -> bool {
    let n = lengths_m.len() as f64;
    let mean = lengths_m.iter().map(|m| libm::log(*m)).sum::<f64>() / n;
    let square = lengths_m.iter().map(|m| (libm::log(*m) - mean) * (libm::log(*m) - mean));
    libm::sqrt(square.sum::<f64>() / n) > LEAST_LENGTH_SD
}

/// Whether trips are spread over the year so that a table tells its own season.
pub(super) fn tells_season(s_of_year: impl Iterator<Item = f64>) -> bool {
    let mut shares: Vec<f64> = s_of_year.map(|s| s / YEAR_S).collect();
    shares.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (shares.first(), shares.last()) else { return false };
    let around = first + 1.0 - last;
    let between = shares.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    between <= MOST_WITHOUT_TRIP
}

/// The expectation of a study: ln consumption by the known quantities.
#[derive(Clone, Debug)]
pub(super) struct Expectation {
    known: Vec<Covariate>,
    level: f64,
    /// Slope of each column; 0 of those in which the study's trips do not differ.
    pub(super) slopes: Vec<f64>,
    /// SD of its trips beside that.
    pub(super) sd: f64,
    /// ln of their variance by what is known: its level, and of each column.
    ln_variance: (f64, Vec<f64>),
}

/// E ln χ²₁: what the logarithm of a squared residual is below that of its variance.
const LN_SQUARE_BIAS: f64 = -1.270_362_845_461_478;
/// Least squared residual of which a logarithm is taken, as a share of the mean square.
const LEAST_SQUARE: f64 = 1e-4;
/// How far an SD may be from that of all trips, as a factor.
const MOST_SPREAD: f64 = 2.0;

impl Expectation {
    /// Fits the trips of the study; none where hardly any arrived.
    pub(super) fn fit(
        trips: &[Record],
        quantity: &NamedQuantity,
        curb_kg: f64,
        known: &[Covariate],
    ) -> Option<Self> {
        let arrived = trips.iter().filter(|trip| trip.outcome.counts());
        let rows: Vec<(Vec<f64>, f64)> = arrived
            .filter_map(|trip| {
                let consumption = quantity.of_cycle(trip).filter(|c| *c > 0.0)?;
                let columns = Known::of_record(trip, curb_kg).columns(known);
                Some((columns, libm::log(consumption)))
            })
            .collect();
        let width = places(known).last().map_or(0, |(_, range)| range.end);
        let columns: Vec<Vec<f64>> = rows.iter().map(|row| row.0.clone()).collect();
        let ln: Vec<f64> = rows.iter().map(|row| row.1).collect();
        let (level, slopes, sd) = fitted(&columns, &ln, width)?;
        let at = |x: &[f64]| level + x.iter().zip(&slopes).map(|(x, s)| x * s).sum::<f64>();
        let ln_squares: Vec<f64> = (rows.iter())
            .map(|(x, y)| {
                let square = ((y - at(x)) * (y - at(x))).max(LEAST_SQUARE * sd * sd);
                libm::log(square.max(f64::MIN_POSITIVE)) - LN_SQUARE_BIAS
            })
            .collect();
        let (ln_variance, by, _) = fitted(&columns, &ln_squares, width)?;
        let known = known.to_vec();
        Some(Self { known, level, slopes, sd, ln_variance: (ln_variance, by) })
    }

    /// ln of the consumption that is expected of a trip.
    pub(super) fn of(&self, trip: &Known) -> f64 {
        let columns = trip.columns(&self.known);
        self.level + columns.iter().zip(&self.slopes).map(|(x, slope)| x * slope).sum::<f64>()
    }

    /// SD of ln consumption of such a trip.
    pub(super) fn sd_of(&self, trip: &Known) -> f64 {
        let (level, slopes) = &self.ln_variance;
        let columns = trip.columns(&self.known);
        let ln = level + columns.iter().zip(slopes).map(|(x, slope)| x * slope).sum::<f64>();
        libm::exp(0.5 * ln).clamp(self.sd / MOST_SPREAD, self.sd * MOST_SPREAD)
    }
}

/// Least squares: the level, the slope of each column, 0 of those that others determine, and the
/// SD; none of too few rows.
fn fitted(rows: &[Vec<f64>], y: &[f64], width: usize) -> Option<(f64, Vec<f64>, f64)> {
    let mut kept: Vec<usize> = (0..width).collect();
    loop {
        let row = |k: usize, x: &mut [f64]| {
            x[0] = 1.0;
            x[1..].iter_mut().zip(&kept).for_each(|(x, column)| *x = rows[k][*column]);
            y[k]
        };
        match LeastSquares::reduce(rows.len(), 1 + kept.len(), row) {
            Ok(fit) if fit.residual_df() > 0 => {
                let coefficients = fit.coefficients();
                let mut slopes = vec![0.0; width];
                for (place, column) in kept.iter().enumerate() {
                    slopes[*column] = coefficients[1 + place];
                }
                return Some((coefficients[0], slopes, fit.residual_sd()));
            }
            Err(collinear) if collinear.column > 0 => {
                kept.remove(collinear.column - 1);
            }
            _ => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_half_a_year_tells_no_season() {
        let days = |last: u32| (0..last).map(|day| f64::from(day) * 86_400.0);
        assert!(tells_season(days(360)) && !tells_season(days(180)) && !tells_season(days(0)));
        // a winter around the end of the year has the same gap
        let winter = days(60).chain(days(365).skip(300));
        assert!(!tells_season(winter));
    }

    #[test]
    fn columns_stand_where_their_places_say() {
        let trip = Known {
            gross_kg: 35e3,
            length_m: 5e4,
            climb_m: 500.0,
            driving_s: 2500.0,
            s_of_year: 0.0,
        };
        let known = [
            Covariate::Weight,
            Covariate::Length,
            Covariate::Climb,
            Covariate::Speed,
            Covariate::Season,
        ];
        assert_eq!(trip.columns(&known), [1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let ends: Vec<usize> = places(&known).into_iter().map(|(_, range)| range.end).collect();
        assert_eq!(ends, [2, 3, 4, 6, 8]);
    }
}
