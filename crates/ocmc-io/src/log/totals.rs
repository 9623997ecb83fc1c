//! Totals of logged drives, as rows of a table of trips.

use super::LoggedTrip;
use crate::intake::table::Quantity;
use crate::intake::table::given::RowPlace;
use crate::trip_totals::{Amount, TripTotal};

const JOULE_PER_KWH: f64 = 3.6e6;
const SECONDS_PER_DAY: f64 = 86_400.0;
/// Share of a drive whose consumption has to be known: the rest is taken to have gone on as it.
const LEAST_KNOWN: f64 = 0.98;

/// Totals of a logged drive: fuel or energy by its rate, the way by its speed, the driving time
/// without the long standstills of a mission; none where it tells no amount.
pub fn of_drive(
    drive: &LoggedTrip,
    place: RowPlace,
    mission_stop_s: f64,
) -> Option<(Amount, TripTotal)> {
    let column = |quantity| drive.column(quantity);
    let time_s = column(Quantity::Time)?;
    let speed_mps = column(Quantity::Speed)?;
    let (amount_is, rate, unit) = match (column(Quantity::FuelRate), column(Quantity::BatteryPower))
    {
        (Some(rate), _) => (Amount::Kilograms, rate, 1.0),
        (None, Some(power)) => (Amount::KilowattHours, power, 1.0 / JOULE_PER_KWH),
        (None, None) => return None,
    };
    let (mut distance_m, mut amount, mut known_s, mut stood_s, mut rest_s) =
        (0.0, 0.0, 0.0, 0.0, 0.0);
    for row in 1..time_s.len() {
        let step_s = time_s[row] - time_s[row - 1];
        let way_m = step_s * 0.5 * (speed_mps[row] + speed_mps[row - 1]);
        if way_m.is_finite() {
            distance_m += way_m;
        }
        // a counter's rate is the mean since the row before
        if rate[row].is_finite() {
            amount += unit * rate[row] * step_s;
            known_s += step_s;
        }
        if speed_mps[row] == 0.0 && speed_mps[row - 1] == 0.0 {
            stood_s += step_s;
        } else {
            rest_s += if stood_s >= mission_stop_s { stood_s } else { 0.0 };
            stood_s = 0.0;
        }
    }
    let duration_s = time_s.last()? - time_s.first()?;
    let mean = |quantity| {
        let known = column(quantity).into_iter().flatten().copied().filter(|x: &f64| x.is_finite());
        let (count, sum) = known.fold((0.0, 0.0), |(count, sum), x| (count + 1.0, sum + x));
        if count > 0.0 { sum / count } else { f64::NAN }
    };
    let first =
        |quantity| column(quantity).and_then(|all| all.first()).copied().unwrap_or(f64::NAN);
    let is_whole = known_s >= LEAST_KNOWN * duration_s && distance_m > 0.0 && amount > 0.0;
    let total = TripTotal {
        place,
        distance_m,
        amount: amount * duration_s / known_s,
        gross_kg: mean(Quantity::GrossWeight),
        payload_kg: mean(Quantity::Payload),
        driving_s: duration_s - rest_s,
        duration_s,
        climb_m: f64::NAN,
        truck: drive.truck.clone().unwrap_or_default(),
        driver: String::new(),
        route: String::new(),
        group: String::new(),
        time_s: f64::NAN,
        s_of_year: SECONDS_PER_DAY * first(Quantity::DayOfYear) + first(Quantity::TimeOfDay),
    };
    is_whole.then_some((amount_is, total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_has_its_way_its_fuel_and_the_time_without_long_stops() {
        // 100 s at 10 m/s, 400 s of standstill, 100 s at 10 m/s; 2 g/s but while it stands
        let rows = 0..=600;
        let moves = |k: &u32| *k <= 100 || *k > 500;
        let time_s: Vec<f64> = rows.clone().map(f64::from).collect();
        let speed_mps: Vec<f64> =
            rows.clone().map(|k| if moves(&k) { 10.0 } else { 0.0 }).collect();
        let rate: Vec<f64> = rows.map(|k| if moves(&k) { 0.002 } else { 0.0 }).collect();
        let columns =
            [(Quantity::Time, time_s), (Quantity::Speed, speed_mps), (Quantity::FuelRate, rate)];
        let drive = LoggedTrip::new("a", "1", columns);
        let (amount, total) = of_drive(&drive, RowPlace::Row(1), 300.0).unwrap();
        // by hand: 100 s and 99 s at 10 m/s, and half a second at each end of the standstill
        assert_eq!((amount, total.distance_m), (Amount::Kilograms, 2000.0));
        assert!((total.amount - 0.4).abs() < 1e-12 && total.driving_s == 201.0, "{total:?}");
        let silent = LoggedTrip::new("a", "1", [(Quantity::Time, vec![0.0, 1.0])]);
        assert!(of_drive(&silent, RowPlace::Row(1), 300.0).is_none());
    }
}
