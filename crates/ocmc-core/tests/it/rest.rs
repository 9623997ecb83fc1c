//! The clock of duty against timelines that were written by hand from the laws' articles.

use ocmc_core::rest::{Activity, DutyClock, Rest, RestLaw};

/// A timeline and what the clock says at its end. D, W, R: driving, other work, rest of the truck,
/// in h:mm; `driven` and `left`: since the last break and until all have to rest (none where the
/// limit is passed); then the next rest and its length.
#[derive(Clone, Copy)]
struct Timeline {
    drivers: u32,
    before: &'static str,
    days: &'static str,
    driven: &'static str,
    left: &'static str,
    next: (Rest, &'static str),
    article: &'static str,
}

const fn one(
    days: &'static str,
    driven: &'static str,
    left: &'static str,
    next: (Rest, &'static str),
    article: &'static str,
) -> Timeline {
    Timeline { drivers: 1, before: "0:00", days, driven, left, next, article }
}

const fn crew(timeline: Timeline) -> Timeline {
    Timeline { drivers: 2, ..timeline }
}

const fn after(before: &'static str, timeline: Timeline) -> Timeline {
    Timeline { before, ..timeline }
}

use Rest::{Break, Daily};

/// Two days of ten hours, 45 h together, and three of nine.
const EXTENDED: &str = "D4:30 R0:45 D4:30 R0:45 D1:00 R11:00 D4:30 R0:45 D4:30 R0:45 D1:00 R11:00 ";
const REGULAR: &str = "D4:30 R0:45 D4:30 R11:00 D4:30 R0:45 D4:30 R11:00 D4:30 R0:45 D4:30 R11:00 ";

const EU: &[Timeline] = &[
    one("", "0:00", "4:30", (Break, "0:45"), "7(1)"),
    one("D2:00", "2:00", "2:30", (Break, "0:45"), "7(1)"),
    one("D4:30", "4:30", "0:00", (Break, "0:45"), "7(1)"),
    one("D4:30 R0:44", "4:30", "0:00", (Break, "0:01"), "7(1)"),
    one("D4:30 R0:45", "0:00", "4:30", (Break, "0:45"), "7(1)"),
    one("D3:00 R0:45 D1:00", "1:00", "3:30", (Break, "0:45"), "7(1)"),
    one("D2:00 R0:15 D2:30", "4:30", "0:00", (Break, "0:30"), "7(2)"),
    one("D2:00 R0:15 D2:30 R0:30", "0:00", "4:30", (Break, "0:45"), "7(2)"),
    one("D2:00 R0:30 D2:30 R0:15", "4:30", "0:00", (Break, "0:15"), "7(2): 30 before 15 is none"),
    one("D2:00 R0:14 D2:30", "4:30", "0:00", (Break, "0:45"), "7(2): at least 15"),
    one("D2:00 R0:10 R0:05 D2:30", "4:30", "0:00", (Break, "0:30"), "7(2): one rest of 15"),
    one("D2:00 R0:10 W0:01 R0:05 D2:30", "4:30", "0:00", (Break, "0:45"), "7(2): not in one"),
    one("D1:00 R0:15 D1:00 R0:15 D1:00 R0:15 D1:30", "4:30", "0:00", (Break, "0:30"), "7(2)"),
    one("D2:00 R0:15 D1:00 R0:45 D2:00", "2:00", "2:30", (Break, "0:45"), "7(2): a new period"),
    one("D2:00 R0:15 D1:00 R0:30 D1:00 R0:30 D1:00", "2:00", "2:30", (Break, "0:30"), "7(2)"),
    one("W0:30 R0:15 D4:30", "4:30", "0:00", (Break, "0:45"), "7(2): parts lie in the period"),
    one("D2:00 W0:45 D2:00", "4:00", "0:30", (Break, "0:45"), "4(d): work is no break"),
    one("W2:00 D4:30", "4:30", "0:00", (Break, "0:45"), "7(1): of driving"),
    after("3:00", one("D1:00", "4:00", "0:30", (Break, "0:45"), "7(1)")),
    one("D4:30 R11:00 D2:00", "2:00", "2:30", (Break, "0:45"), "7(1): unless he takes a rest"),
    one("D4:30 R0:45 D4:30", "4:30", "0:00", (Break, "0:45"), "6(1): may be ten hours"),
    one("D4:30 R0:45 D4:30 R0:45 D1:00", "1:00", "0:00", (Daily, "11:00"), "6(1)"),
    one("D4:30 R0:45 D4:30 R0:45 D1:00 R10:59", "0:00", "0:00", (Daily, "0:01"), "8(2), 4(g)"),
    one("D4:30 R0:45 D4:30 R0:45 D1:00 R11:00", "0:00", "4:30", (Break, "0:45"), "8(2), 4(g)"),
    one(
        "D4:30 R0:45 D4:30 R9:00",
        "0:00",
        "0:00",
        (Daily, "2:00"),
        "4(g): a reduced one is not taken",
    ),
    one("W8:30 D4:30", "4:30", "0:00", (Daily, "11:00"), "8(2): 24 h less 11 h"),
    one("W11:00 D1:00", "1:00", "1:00", (Daily, "11:00"), "8(2)"),
    one("W8:00 D4:00", "4:00", "0:30", (Daily, "11:00"), "8(2): no break is worth it"),
    one("R5:00 W4:00 D4:30", "4:30", "0:00", (Break, "0:45"), "8(2): from the end of the rest"),
    crew(one("", "0:00", "20:00", (Daily, "9:00"), "6(1), 8(5)")),
    crew(one("D4:30", "4:30", "15:30", (Daily, "9:00"), "7(3): the break is beside the driver")),
    crew(one("D9:00", "4:30", "11:00", (Daily, "9:00"), "7(3)")),
    crew(one("D20:00", "1:00", "0:00", (Daily, "9:00"), "6(1) for each")),
    crew(one("D20:00 R9:00", "0:00", "20:00", (Daily, "9:00"), "8(5): 9 h within 30 h")),
    crew(one("D20:00 R8:59", "0:00", "0:00", (Daily, "0:01"), "8(5)")),
    crew(one("W2:00 D19:00", "1:00", "0:00", (Daily, "9:00"), "8(5): 30 h less 9 h")),
    crew(after("4:00", one("D1:00", "0:30", "15:00", (Daily, "9:00"), "7(3)"))),
];

const US: &[Timeline] = &[
    one("", "0:00", "8:00", (Break, "0:30"), "395.3(a)(3)(ii)"),
    one("D8:00", "8:00", "0:00", (Break, "0:30"), "395.3(a)(3)(ii)"),
    one("D8:00 R0:29", "8:00", "0:00", (Break, "0:01"), "395.3(a)(3)(ii)"),
    one("D8:00 W0:30", "0:00", "3:00", (Daily, "10:00"), "395.3(a)(3)(ii): on duty, not driving"),
    one("D5:00 W0:15 R0:15 D3:00", "3:00", "3:00", (Daily, "10:00"), "395.3(a)(3)(ii)"),
    one("D4:00 R0:15 D2:00 R0:15 D2:00", "8:00", "0:00", (Break, "0:30"), "395.3: consecutive"),
    one("D8:00 R0:30 D3:00", "3:00", "0:00", (Daily, "10:00"), "395.3(a)(3)(i)"),
    one("D8:00 R0:30 D3:00 R9:59", "0:00", "0:00", (Daily, "0:01"), "395.3(a)(1)"),
    one("D8:00 R0:30 D3:00 R10:00", "0:00", "8:00", (Break, "0:30"), "395.3(a)(1)"),
    one("W6:00 D8:00", "8:00", "0:00", (Daily, "10:00"), "395.3(a)(2)"),
    one("W13:00 D0:30", "0:30", "0:30", (Daily, "10:00"), "395.3(a)(2)"),
    one("W3:00 R9:00 D2:00", "2:00", "0:00", (Daily, "10:00"), "395.3(a)(2): rest is in the 14 h"),
    after("7:00", one("D0:30", "7:30", "0:30", (Break, "0:30"), "395.3(a)(3)(ii)")),
    crew(one("D8:00", "8:00", "8:00", (Break, "0:30"), "395.1(g)(1)")),
    crew(one("D16:00 R0:30 D3:00", "3:00", "8:00", (Break, "0:30"), "395.1(g)(1)")),
];

fn seconds(h_mm: &str) -> f64 {
    let (hours, minutes) = h_mm.split_once(':').unwrap();
    hours.parse::<f64>().unwrap() * 3600.0 + minutes.parse::<f64>().unwrap() * 60.0
}

fn clock_after(law: RestLaw, timeline: &Timeline, days: &str, part_s: f64) -> DutyClock {
    let mut clock = DutyClock::new(law, timeline.drivers, seconds(timeline.before));
    for (kind, time) in days.split_whitespace().map(|part| part.split_at(1)) {
        let activity = match kind {
            "D" => Activity::Driving,
            "W" => Activity::Work,
            _ => Activity::Rest,
        };
        let mut left_s = seconds(time);
        while left_s > 0.0 {
            clock.pass(activity, left_s.min(part_s));
            left_s -= part_s;
        }
    }
    clock
}

fn check(law: RestLaw, timeline: &Timeline, days: &str) {
    // at once, and piece by piece
    for part_s in [f64::INFINITY, 420.0] {
        let clock = clock_after(law, timeline, days, part_s);
        let (rest, length_s) = clock.next_rest();
        let said = format!("{} ({} drivers) {}", days, timeline.drivers, timeline.article);
        let close = |a: f64, b: &str| (a - seconds(b)).abs() < 1e-3;
        assert!(close(clock.driven_s(), timeline.driven), "{said}: driven {}", clock.driven_s());
        assert!(close(clock.left_s().max(0.0), timeline.left), "{said}: left {}", clock.left_s());
        assert_eq!(rest, timeline.next.0, "{said}");
        assert!(close(length_s, timeline.next.1), "{said}: {length_s}");
    }
}

#[test]
fn the_clock_follows_the_articles() {
    assert!(EU.len() + US.len() >= 30);
    for timeline in EU {
        check(RestLaw::Eu561, timeline, timeline.days);
    }
    for timeline in US {
        check(RestLaw::Us395, timeline, timeline.days);
    }
}

#[test]
fn a_week_has_two_days_of_ten_hours() {
    let day = "D4:30 R0:45 D4:30";
    let third = one("", "4:30", "0:00", (Daily, "11:00"), "6(1): twice a week");
    check(RestLaw::Eu561, &third, &format!("{EXTENDED}{day}"));
    let fourth = one("", "0:30", "0:30", (Daily, "11:00"), "6(1): a day of nine hours is none");
    check(RestLaw::Eu561, &fourth, &format!("{REGULAR}{day} R0:45 D0:30"));
    let next = one("", "4:30", "0:00", (Break, "0:45"), "6(1), 4(i): of the next week");
    check(RestLaw::Eu561, &next, &format!("{EXTENDED}R123:00 {day}"));
}

#[test]
fn who_rests_when_he_has_to_never_passes_a_limit() {
    for (law, drivers, most_s) in [
        (RestLaw::Eu561, 1, 16_200.0),
        (RestLaw::Eu561, 2, 16_200.0),
        (RestLaw::Us395, 1, 28_800.0),
        (RestLaw::Us395, 2, 28_800.0),
    ] {
        let mut clock = DutyClock::new(law, drivers, 0.0);
        let (mut driven_s, mut rested_s) = (0.0, 0.0);
        for k in 0..200 {
            let part_s = (f64::from(k % 7) * 1800.0 + 600.0).min(clock.left_s());
            clock.pass(Activity::Driving, part_s);
            driven_s += part_s;
            assert!(clock.driven_s() <= most_s + 1e-3, "{law:?} {drivers}: {}", clock.driven_s());
            if clock.left_s() < 1.0 {
                let (_, length_s) = clock.next_rest();
                assert!(length_s > 0.0, "{law:?} {drivers}");
                clock.pass(Activity::Rest, length_s);
                rested_s += length_s;
                assert!(clock.left_s() > 60.0, "{law:?} {drivers}: {}", clock.left_s());
            }
        }
        // in the long run no more than the law's day allows
        let share = driven_s / (driven_s + rested_s);
        let (least, most) = if drivers == 1 { (0.38, 0.55) } else { (0.6, 1.0) };
        assert!(share > least && share < most, "{law:?} {drivers}: {share}");
    }
}
