//! The numbers of the laws on driving times and rests.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Seconds of an hour and of a minute.
const H: f64 = 3600.0;
const MIN: f64 = 60.0;

/// A law on driving times and rests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RestLaw {
    /// Regulation (EC) No 561/2006 of the European Union.
    #[serde(rename = "eu_561")]
    Eu561,
    /// 49 CFR 395.3 of the United States, for trucks that carry property.
    #[serde(rename = "us_395_3")]
    Us395,
}

/// Requirements of a law on one driver, in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Driving after which a break is due.
    pub driving_s: f64,
    /// Length of that break, in s.
    pub break_s: f64,
    /// First and second part that may replace it, in this order.
    pub split_s: Option<[f64; 2]>,
    /// Whether other work interrupts the driving as a break does.
    pub work_is_break: bool,
    /// Driving of a day.
    pub day_s: f64,
    /// Driving of a day that is extended.
    pub extended_day_s: f64,
    /// Extended days in a week.
    pub extended_days: u32,
    /// Time after the last daily rest in which may be driven.
    pub window_s: f64,
    /// Daily rest.
    pub daily_rest_s: f64,
    /// Whether the time beside the driver at the wheel counts to the daily rest: in a sleeper
    /// berth.
    pub rests_on_the_way: bool,
}

/// Art. 6(1), 7 and 8(2): a new daily rest within 24 h, which leaves 13 h before it.
const EU_561: Rules = Rules {
    driving_s: 4.5 * H,
    break_s: 45.0 * MIN,
    split_s: Some([15.0 * MIN, 30.0 * MIN]),
    work_is_break: false,
    day_s: 9.0 * H,
    extended_day_s: 10.0 * H,
    extended_days: 2,
    window_s: 13.0 * H,
    daily_rest_s: 11.0 * H,
    rests_on_the_way: false,
};

/// Art. 8(5): of a crew each a daily rest of 9 h within 30 h.
const EU_561_CREW: Rules = Rules { window_s: 21.0 * H, daily_rest_s: 9.0 * H, ..EU_561 };

/// § 395.3(a)(1) to (3); of a crew who sleeps on the way is off duty, § 395.1(g)(1).
const US_395_3: Rules = Rules {
    driving_s: 8.0 * H,
    break_s: 30.0 * MIN,
    split_s: None,
    work_is_break: true,
    day_s: 11.0 * H,
    extended_day_s: 11.0 * H,
    extended_days: 0,
    window_s: 14.0 * H,
    daily_rest_s: 10.0 * H,
    rests_on_the_way: true,
};

impl RestLaw {
    /// Rules for each driver of a crew of that size.
    pub fn rules(self, drivers: u32) -> &'static Rules {
        match self {
            Self::Eu561 if drivers > 1 => &EU_561_CREW,
            Self::Eu561 => &EU_561,
            Self::Us395 => &US_395_3,
        }
    }
}
