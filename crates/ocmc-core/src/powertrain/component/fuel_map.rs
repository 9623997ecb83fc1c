//! Fuel maps as test benches give them, points of speed, torque and fuel, on the grid of the
//! engine's model.
//!
//! Points of one speed are a row. Speeds beyond the most that a model holds are thinned out evenly;
//! torques are those that rows share where they are few enough, otherwise evenly spaced. Within a
//! row fuel is linear in torque between its points; a row ends at its highest torque and then goes
//! on with its last slope, as everywhere in the engine.

use super::engine::MOST_KNOTS;

/// One point of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuelPoint {
    /// Engine speed, in rad/s.
    pub speed_radps: f64,
    /// Torque, in Nm; a negative one is the drag torque.
    pub torque_nm: f64,
    /// Fuel, in kg/s.
    pub fuel_kgps: f64,
}

/// A map on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct FuelGrid {
    /// Speeds, in rad/s.
    pub speed_radps: Vec<f64>,
    /// Torques from 0 up, in Nm.
    pub torque_nm: Vec<f64>,
    /// Fuel, in kg/s: a row for each speed; rows may end early.
    pub fuel_kgps: Vec<Vec<f64>>,
}

/// Puts points on a grid; none where they do not make one: fewer than two speeds with two torques
/// each.
pub fn on_grid(points: &[FuelPoint]) -> Option<FuelGrid> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| {
        a.speed_radps.total_cmp(&b.speed_radps).then(a.torque_nm.total_cmp(&b.torque_nm))
    });
    let mut rows: Vec<(f64, Vec<(f64, f64)>)> = Vec::new();
    for point in sorted {
        let same = rows.last().is_some_and(|row| point.speed_radps - row.0 < 0.1);
        if !same {
            rows.push((point.speed_radps, Vec::new()));
        }
        if let Some(row) = rows.last_mut() {
            row.1.push((point.torque_nm, point.fuel_kgps));
        }
    }
    for row in &mut rows {
        row.1.dedup_by(|next, before| next.0 - before.0 < 1e-6);
    }
    rows.retain(|row| row.1.iter().filter(|point| point.0 > 0.0).count() >= 2);
    let rows = thinned(&rows);
    if rows.len() < 2 {
        return None;
    }
    let highest =
        rows.iter().filter_map(|row| row.1.last()).map(|point| point.0).fold(0.0, f64::max);
    let torque_nm = torques(&rows, highest);
    let fuel = |row: &(f64, Vec<(f64, f64)>)| {
        let last = row.1.last().map_or(0.0, |point| point.0);
        let reached = torque_nm.iter().filter(|torque| **torque <= last + 1e-6).count();
        let count = reached.clamp(2, torque_nm.len());
        torque_nm[..count].iter().map(|torque| interpolate(&row.1, *torque).max(0.0)).collect()
    };
    Some(FuelGrid {
        speed_radps: rows.iter().map(|row| row.0).collect(),
        fuel_kgps: rows.iter().map(fuel).collect(),
        torque_nm,
    })
}

/// The torques of the grid.
fn torques(rows: &[(f64, Vec<(f64, f64)>)], highest: f64) -> Vec<f64> {
    let near = 0.002 * highest;
    let mut all: Vec<f64> = rows.iter().flat_map(|row| row.1.iter().map(|point| point.0)).collect();
    all.retain(|torque| *torque > near);
    all.sort_by(f64::total_cmp);
    let mut shared = vec![0.0];
    let mut k = 0;
    while k < all.len() {
        let group = all[k..].iter().take_while(|torque| **torque - all[k] < near).count();
        if 2 * group >= rows.len() {
            shared.push(all[k..k + group].iter().sum::<f64>() / group as f64);
        }
        k += group;
    }
    let spaced = |k: usize| highest * k as f64 / (MOST_KNOTS - 1) as f64;
    if shared.len() >= 4 && shared.len() < MOST_KNOTS {
        if shared.last().is_some_and(|last| highest - last > near) {
            shared.push(highest);
        }
        shared
    } else {
        (0..MOST_KNOTS).map(spaced).collect()
    }
}

/// At most as many rows as a model holds, the first and the last among them.
fn thinned<T: Clone>(rows: &[T]) -> Vec<T> {
    if rows.len() <= MOST_KNOTS {
        return rows.to_vec();
    }
    let last = (rows.len() - 1) as f64;
    let place = |k: usize| libm::round(last * k as f64 / (MOST_KNOTS - 1) as f64) as usize;
    (0..MOST_KNOTS).map(|k| rows[place(k)].clone()).collect()
}

/// Linear between points, continued beyond them.
fn interpolate(points: &[(f64, f64)], x: f64) -> f64 {
    let k = points.partition_point(|point| point.0 <= x).clamp(1, points.len() - 1);
    let ((x0, y0), (x1, y1)) = (points[k - 1], points[k]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bilinear_map_survives_the_grid() {
        let fuel = |w: f64, t: f64| 1e-4 + 2e-6 * w + t * (1e-6 + 1e-8 * w);
        let mut points = Vec::new();
        for i in 0..30 {
            let w = 60.0 + 5.0 * f64::from(i);
            for j in 0..25 {
                let t = 97.0 * f64::from(j);
                points.push(FuelPoint { speed_radps: w, torque_nm: t, fuel_kgps: fuel(w, t) });
            }
        }
        let grid = on_grid(&points).unwrap();
        assert!(grid.speed_radps.len() <= MOST_KNOTS && grid.torque_nm.len() <= MOST_KNOTS);
        assert_eq!((grid.speed_radps[0], grid.torque_nm[0]), (60.0, 0.0));
        for (w, row) in grid.speed_radps.iter().zip(&grid.fuel_kgps) {
            for (t, have) in grid.torque_nm.iter().zip(row) {
                assert!((have / fuel(*w, *t) - 1.0).abs() < 1e-9, "{w} {t}");
            }
        }
        assert!(on_grid(&points[..10]).is_none());
    }
}
