//! The clock of drivers' duty: what has been driven since the last break and since the last daily
//! rest, how long may still be driven, and which rest is due.

use super::law::{RestLaw, Rules};

/// Activity of a truck with its crew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// It is driven.
    Driving,
    /// It stands, and its drivers work.
    Work,
    /// It stands, and its drivers rest.
    Rest,
}

/// A rest that a law asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// A break in the driving.
    Break,
    /// The rest between two days.
    Daily,
}

/// Less driving than this before the end of a day is not worth a break, in s: the daily rest is
/// taken instead (judgement).
const WORTH_A_BREAK_S: f64 = 900.0;
/// Shortest driving time with which a driver takes the wheel, in s.
const SHORTEST_DRIVING_S: f64 = 1.0;
/// Beyond what a sum of durations is off by, in s.
const ROUNDING_S: f64 = 1e-6;
const WEEK_S: f64 = 7.0 * 86_400.0;

/// Duty of one driver.
#[derive(Clone, Copy, PartialEq)]
enum Duty {
    Driving,
    Work,
    Rest,
    /// Beside the driver at the wheel.
    Beside,
}

/// The clock of one driver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct DriverClock {
    /// Driven since the last break, and since the last daily rest.
    driven_s: f64,
    driven_today_s: f64,
    /// Time since the end of the last daily rest, and since the start of the week.
    day_s: f64,
    week_s: f64,
    /// Whether the first part of a break has been taken.
    first_part: bool,
    extended_days: u32,
    /// Rest without interruption; the same with what counts for a break, but not as rest.
    rest_s: f64,
    break_s: f64,
}

impl DriverClock {
    fn pass(&mut self, rules: &Rules, duty: Duty, time_s: f64) {
        self.day_s += time_s;
        self.week_s += time_s;
        if self.week_s >= WEEK_S {
            self.week_s -= WEEK_S;
            self.extended_days = 0;
        }
        let rests = duty == Duty::Rest || duty == Duty::Beside && rules.rests_on_the_way;
        let pauses = duty != Duty::Driving && (duty != Duty::Work || rules.work_is_break);
        if !rests {
            // a part of a break has ended
            let is_part = |[first_s, _]: [f64; 2]| self.rest_s + ROUNDING_S >= first_s;
            self.first_part |= self.driven_s > 0.0 && rules.split_s.is_some_and(is_part);
        }
        self.rest_s = if rests { self.rest_s + time_s } else { 0.0 };
        self.break_s = if pauses { self.break_s + time_s } else { 0.0 };
        if duty == Duty::Driving {
            self.driven_s += time_s;
            self.driven_today_s += time_s;
        }
        let taken = |taken_s: f64, needed_s: f64| taken_s + ROUNDING_S >= needed_s;
        if taken(self.break_s, rules.break_s) || taken(self.rest_s, self.break_length_s(rules)) {
            (self.driven_s, self.first_part) = (0.0, false);
        }
        if taken(self.rest_s, rules.daily_rest_s) {
            let extended = self.driven_today_s > rules.day_s + ROUNDING_S;
            self.extended_days += u32::from(extended);
            (self.driven_today_s, self.day_s) = (0.0, 0.0);
        }
    }

    /// How long a break has to be now, in s.
    fn break_length_s(&self, rules: &Rules) -> f64 {
        rules.split_s.filter(|_| self.first_part).map_or(rules.break_s, |[_, second_s]| second_s)
    }

    fn left_to_break_s(&self, rules: &Rules) -> f64 {
        rules.driving_s - self.driven_s
    }

    /// How long may be driven today, if `paused_s` are not.
    fn left_today_s(&self, rules: &Rules, paused_s: f64) -> f64 {
        let extends = self.extended_days < rules.extended_days;
        let most_s = if extends { rules.extended_day_s } else { rules.day_s };
        (most_s - self.driven_today_s).min(rules.window_s - self.day_s - paused_s)
    }

    fn left_s(&self, rules: &Rules) -> f64 {
        self.left_to_break_s(rules).min(self.left_today_s(rules, 0.0))
    }

    fn due(&self, rules: &Rules) -> Rest {
        let (now_s, break_s) = (self.left_s(rules).max(0.0), self.break_length_s(rules));
        let after_s = self.left_today_s(rules, break_s) - now_s;
        if after_s > WORTH_A_BREAK_S { Rest::Break } else { Rest::Daily }
    }

    /// How much longer a rest of that kind has to be, in s.
    fn missing_s(&self, rules: &Rules, rest: Rest) -> f64 {
        match rest {
            Rest::Break => self.break_length_s(rules) - self.rest_s,
            Rest::Daily => rules.daily_rest_s - self.rest_s,
        }
    }
}

/// The clock of a truck's one or two drivers under a law. While one of two drives the other sits
/// beside him; they change places when the one at the wheel may not go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DutyClock {
    rules: &'static Rules,
    clocks: [DriverClock; 2],
    drivers: usize,
    at_wheel: usize,
}

impl DutyClock {
    /// After a daily rest; the first driver has driven so long since then, in s.
    pub fn new(law: RestLaw, drivers: u32, driven_before_s: f64) -> Self {
        let drivers = drivers.clamp(1, 2);
        let rules = law.rules(drivers);
        // rest at the start makes the daily rest longer
        let rested = DriverClock { rest_s: rules.daily_rest_s, ..DriverClock::default() };
        let mut clock = Self { rules, clocks: [rested; 2], drivers: drivers as usize, at_wheel: 0 };
        clock.pass(Activity::Driving, driven_before_s);
        clock
    }

    /// Time goes on.
    pub fn pass(&mut self, activity: Activity, time_s: f64) {
        let duty = match activity {
            Activity::Work => Duty::Work,
            Activity::Rest => Duty::Rest,
            Activity::Driving => return self.drive(time_s),
        };
        for clock in &mut self.clocks {
            clock.pass(self.rules, duty, time_s);
        }
    }

    fn drive(&mut self, time_s: f64) {
        let mut left_s = time_s;
        while left_s > 0.0 {
            self.change_places();
            let may_s = self.clocks[self.at_wheel].left_s(self.rules);
            let changes = self.drivers > 1 && may_s > SHORTEST_DRIVING_S;
            let part_s = if changes { left_s.min(may_s) } else { left_s };
            for (driver, clock) in self.clocks.iter_mut().enumerate() {
                let duty = if driver == self.at_wheel { Duty::Driving } else { Duty::Beside };
                clock.pass(self.rules, duty, part_s);
            }
            left_s -= part_s;
        }
    }

    /// The other one takes the wheel where the one who has it may not go on.
    fn change_places(&mut self) {
        let may = |clock: &DriverClock| clock.left_s(self.rules) > SHORTEST_DRIVING_S;
        let other = self.drivers - 1 - self.at_wheel.min(self.drivers - 1);
        if !may(&self.clocks[self.at_wheel]) && may(&self.clocks[other]) {
            self.at_wheel = other;
        }
    }

    /// Driving time of the driver at the wheel since his last break, in s.
    pub fn driven_s(&self) -> f64 {
        self.clocks[self.at_wheel].driven_s
    }

    /// How long may be driven before all have to rest, in s; below zero where the limit is passed.
    pub fn left_s(&self) -> f64 {
        let mut ahead = *self;
        let mut sum_s = 0.0;
        loop {
            ahead.change_places();
            let left_s = ahead.clocks[ahead.at_wheel].left_s(self.rules);
            if self.drivers == 1 || left_s <= SHORTEST_DRIVING_S {
                return sum_s + left_s;
            }
            ahead.drive(left_s);
            sum_s += left_s;
        }
    }

    /// The rest that is due where all that may be driven has been driven, and how long it has to
    /// be, in s; where the limit has been reached, how much longer. Of a crew it is that of the one
    /// who may drive on the soonest.
    pub fn next_rest(&self) -> (Rest, f64) {
        let mut then = *self;
        then.drive(self.left_s());
        let is_break = |clock: &DriverClock| clock.due(then.rules) == Rest::Break;
        let rest = if then.crew().any(is_break) { Rest::Break } else { Rest::Daily };
        (rest, then.length_s(rest))
    }

    /// How long a rest of that kind has to be from now on, in s.
    pub fn length_s(&self, rest: Rest) -> f64 {
        let due = self.crew().filter(|clock| clock.due(self.rules) == rest);
        let lengths_s = due.map(|clock| clock.missing_s(self.rules, rest));
        let own_s = self.clocks[self.at_wheel].missing_s(self.rules, rest);
        lengths_s.reduce(f64::min).unwrap_or(own_s).max(0.0)
    }

    fn crew(&self) -> impl Iterator<Item = &DriverClock> {
        self.clocks[..self.drivers].iter()
    }
}
