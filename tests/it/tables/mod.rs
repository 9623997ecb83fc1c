//! Tables that a command can use, and what can be wrong with them.

/// A table as rows of cells, the first one its names.
#[derive(Clone)]
pub(crate) struct Table(Vec<Vec<String>>);

impl Table {
    pub(crate) fn new(names: &str, rows: usize, cell: impl Fn(usize, usize) -> String) -> Self {
        let names: Vec<String> = names.split(',').map(str::to_owned).collect();
        let row = |k| (0..names.len()).map(|column| cell(k, column)).collect();
        Self([vec![names.clone()], (0..rows).map(row).collect()].concat())
    }

    fn column(&self, name: &str) -> usize {
        self.0[0].iter().position(|found| found == name).expect("a column")
    }

    /// Without a column.
    pub(crate) fn without(mut self, name: &str) -> Self {
        let column = self.column(name);
        self.0.iter_mut().for_each(|row| _ = row.remove(column));
        self
    }

    pub(crate) fn renamed(mut self, name: &str, new: &str) -> Self {
        let column = self.column(name);
        new.clone_into(&mut self.0[0][column]);
        self
    }

    /// With something else in the rows from `first` on, from 0, before `end`.
    pub(crate) fn with(mut self, name: &str, first: usize, end: usize, cell: &str) -> Self {
        let column = self.column(name);
        let end = end.min(self.0.len() - 1);
        self.0[first + 1..=end].iter_mut().for_each(|row| cell.clone_into(&mut row[column]));
        self
    }

    pub(crate) fn swapped(mut self, a: usize, b: usize) -> Self {
        self.0.swap(a + 1, b + 1);
        self
    }

    pub(crate) fn rows(mut self, rows: usize) -> Self {
        self.0.truncate(rows + 1);
        self
    }

    pub(crate) fn text(&self) -> String {
        self.0.iter().map(|row| row.join(",") + "\n").collect()
    }
}

/// 400 s of driving ten times a second: ten seconds of rest, 20 m/s, a slope, a lower limit, a
/// curve.
pub(crate) fn log() -> Table {
    Table::new(
        "time_s,speed_mps,yaw_rate_radps,limit_mps,accelerator,brake,grade",
        4000,
        |k, column| {
            let t = k as f64 / 10.0;
            let up = (t - 10.0).clamp(0.0, 20.0);
            let speed = if t < 200.0 { up } else { (20.0 - 0.8 * (t - 200.0)).max(11.0) };
            let turns = (300.0..320.0).contains(&t);
            let climbs = (100.0..130.0).contains(&t);
            let value = match column {
                0 => t,
                1 => speed,
                2 => {
                    if turns {
                        speed / 100.0
                    } else {
                        0.0
                    }
                }
                3 => {
                    if t < 205.0 {
                        20.0
                    } else {
                        11.0
                    }
                }
                4 => {
                    if climbs {
                        0.5
                    } else {
                        0.3
                    }
                }
                5 => 0.0,
                _ => {
                    if climbs {
                        0.03
                    } else {
                        0.0
                    }
                }
            };
            value.to_string()
        },
    )
}

/// 100 curves of five drivers.
pub(crate) fn curves() -> Table {
    Table::new("driver,radius_m,direction,speed_mps", 100, |k, column| {
        let radius = 30.0 + (37 * k % 400) as f64;
        let noise = 1.0 + 0.02 * (k * k % 7) as f64;
        match column {
            0 => format!("d{}", k % 5),
            1 => radius.to_string(),
            2 => if k % 2 == 0 { "left" } else { "right" }.to_owned(),
            _ => (8.0 * (radius / 100.0).powf(0.4) * noise).to_string(),
        }
    })
}

pub(crate) fn speed_changes() -> Table {
    Table::new("driver,category,acceleration_mps2", 60, |k, column| match column {
        0 => format!("d{}", k % 5),
        1 => "70-to-40".to_owned(),
        _ => (-0.7 - 0.05 * (k * k % 13) as f64).to_string(),
    })
}

/// 400 days by the hour.
pub(crate) fn hours() -> Table {
    let names = "time_s,temperature_c,pressure_hpa,relative_humidity_percent,wind_speed_mps";
    Table::new(names, 9600, |hour, column| {
        let h = hour as f64;
        let wave = |period: f64| (std::f64::consts::TAU * h / period).sin();
        let cold = |period: f64, at: f64| (std::f64::consts::TAU * (h - at) / period).cos();
        let value = match column {
            0 => 3600.0 * h,
            1 => 10.0 - 9.0 * cold(8760.0, 480.0) - 2.0 * cold(24.0, 3.0) + 3.0 * wave(131.0),
            2 => 1010.0 + 10.0 * wave(173.0),
            3 => 75.0 + 15.0 * wave(59.0),
            _ => 4.0 + 3.0 * wave(91.0),
        };
        value.to_string()
    })
}

/// Ten days of densities, every quarter of an hour.
pub(crate) fn densities() -> Table {
    Table::new("time_s,road_type,density_share", 960, |k, column| {
        let hour = (k % 96) as f64 / 4.0;
        let peak = (-0.5 * (hour - 7.5) * (hour - 7.5)).exp();
        match column {
            0 => (900 * k).to_string(),
            1 => "rural".to_owned(),
            _ => ((0.1 + 0.15 * peak) * (1.0 + 0.01 * (k * k % 17) as f64)).to_string(),
        }
    })
}

/// Each driver has a radius of his own.
pub(crate) fn own_radius() -> Table {
    let mut table = curves();
    let column = table.column("radius_m");
    for (k, row) in table.0.iter_mut().skip(1).enumerate() {
        row[column] = (100 + 10 * (k % 5)).to_string();
    }
    table
}

/// Each driver turned one way only.
pub(crate) fn own_direction() -> Table {
    let mut table = curves();
    let column = table.column("direction");
    for (k, row) in table.0.iter_mut().skip(1).enumerate() {
        if k % 5 < 2 { "left" } else { "right" }.clone_into(&mut row[column]);
    }
    table
}

/// Densities of one hour of the day alone.
pub(crate) fn one_hour() -> Table {
    let mut table = densities();
    let column = table.column("time_s");
    for (k, row) in table.0.iter_mut().skip(1).enumerate() {
        row[column] = (86_400 * k).to_string();
    }
    table
}
