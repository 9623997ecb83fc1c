//! Curves by speed limit, as the facts state them.

/// Classes of the speed limit.
pub(crate) const CLASSES: [&str; 4] = ["<= 50", "60-80", ">= 100", "other"];
/// Wider curves are left out, in m: they do not limit a truck's speed.
const WIDEST_M: f64 = 500.0;
/// Tighter curves are left out of the field's statistics, in m: parking.
const TIGHTEST_M: f64 = 20.0;

/// Lengths and curves by class of the speed limit.
#[derive(Clone, Default)]
pub(crate) struct CurveTable {
    length_m: [f64; 4],
    curves: [usize; 4],
    log_radii: Vec<f64>,
}

/// Class of a limit in km/h.
fn class(limit_kmh: f64) -> usize {
    match limit_kmh {
        v if v <= 50.5 => 0,
        v if (59.5..80.5).contains(&v) => 1,
        v if v >= 99.5 => 2,
        _ => 3,
    }
}

impl CurveTable {
    pub(crate) fn add_length(&mut self, limit_kmh: f64, length_m: f64) {
        self.length_m[class(limit_kmh)] += length_m;
    }

    pub(crate) fn add_curve(&mut self, limit_kmh: f64, radius_m: f64) {
        if radius_m < WIDEST_M {
            self.curves[class(limit_kmh)] += 1;
            self.log_radii.push(radius_m.ln());
        }
    }

    /// Length, in km.
    pub(crate) fn km(&self) -> f64 {
        self.length_m.iter().sum::<f64>() / 1000.0
    }

    /// Curves per km.
    pub(crate) fn per_km(&self) -> f64 {
        self.curves.iter().sum::<usize>() as f64 / self.km()
    }

    /// Curves per km of one class.
    pub(crate) fn per_km_of(&self, class: usize) -> f64 {
        1000.0 * self.curves[class] as f64 / self.length_m[class]
    }

    /// Curves per km with the lengths of another table.
    pub(crate) fn per_km_on(&self, other: &Self) -> f64 {
        let curves = |class: usize| self.per_km_of(class) * other.length_m[class];
        (0..3).map(curves).sum::<f64>() / other.length_m[..3].iter().sum::<f64>()
    }

    /// Geometric mean of the radii, in m.
    pub(crate) fn geometric_mean_m(&self) -> f64 {
        (self.log_radii.iter().sum::<f64>() / self.log_radii.len() as f64).exp()
    }

    /// Geometric mean, in m, and standard deviation of ln R, of the radii that the field's fit
    /// uses.
    pub(crate) fn field_moments(&self) -> (f64, f64) {
        let logs: Vec<f64> =
            self.log_radii.iter().copied().filter(|log| *log >= TIGHTEST_M.ln()).collect();
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean.exp(), variance.sqrt())
    }

    /// One row of the table of the guide.
    pub(crate) fn row(&self, what: &str) -> String {
        let (mean_m, sd) = self.field_moments();
        let [slow, middle, fast] = [0, 1, 2].map(|class| {
            let rate = self.per_km_of(class);
            if rate.is_nan() { "-".to_owned() } else { format!("{rate:.2}") }
        });
        format!(
            "| {what} | {:.0} | {:.2} | {slow} | {middle} | {fast} | {:.0} | {mean_m:.0} | {sd:.2} \
             |",
            self.km(),
            self.per_km(),
            self.geometric_mean_m(),
        )
    }
}

/// Head of the table.
pub(crate) fn head() -> String {
    format!(
        "| | km | R < 500 m per km | {} | {} | {} | geometric mean R, m | of 20-500 m | SD(ln R) \
         of 20-500 m |\n|---|---|---|---|---|---|---|---|---|",
        CLASSES[0], CLASSES[1], CLASSES[2]
    )
}
