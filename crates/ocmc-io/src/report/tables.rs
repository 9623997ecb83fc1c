//! The report's tables: statistics, road, outliers, failures, study, provenance.

use super::gathered::Sums;
use super::repeat::{Repeat, trace_command};
use super::svg::escaped;
use super::{Reported, shown};
use crate::given_drive::Followed;
use crate::label::label;
use crate::number_text::{grouped, rounded};
use crate::study::{commented, in_words};
use ocmc_core::operating_cycle::route::RouteModel;
use ocmc_core::record::{Outcome, Record};
use ocmc_fleet::quantity::RecordQuantity;
use ocmc_fleet::statistic::Statistic;
use std::borrow::Borrow;
use std::fmt::Write;

/// A row of two columns, the second one in words.
pub(super) fn row(name: &str, value: &str) -> String {
    format!("<tr><td>{name}</td><td class=\"words\">{}</td></tr>\n", escaped(value))
}

/// The rows of facts, by their names.
pub(super) fn rows(facts: &[(&'static str, String)]) -> String {
    facts.iter().map(|(name, value)| row(name, value)).collect()
}

/// A row of cells.
pub(super) fn cells<S: Borrow<str>>(cells: &[S]) -> String {
    format!("<tr><td>{}</td></tr>\n", cells.join("</td><td>"))
}

/// A table that is moved sideways where it is broader than the page.
pub(super) fn table<S: Borrow<str>>(head: &[S], rows: impl Iterator<Item = String>) -> String {
    format!(
        "<div class=\"wide\" tabindex=\"0\"><table>\n<thead><tr><th>{}</th></tr></thead>\n\
         <tbody>\n{}</tbody></table></div>\n",
        head.join("</th><th>"),
        rows.collect::<String>()
    )
}

/// How the answer of a page is repeated in its folder, and where it comes from.
pub(super) fn repeated(
    what: &str,
    has: &str,
    command: &str,
    facts: &[(&'static str, String)],
) -> String {
    format!(
        "<h2>Repeat this {what}</h2>\n<p>In the folder of this page, which has {has} whole:</p>\n\
         <pre class=\"command\" tabindex=\"0\">{}</pre>\n<h2>Provenance</h2>\n<div class=\"wide\" \
         tabindex=\"0\"><table><tbody>\n{}</tbody></table></div>\n",
        escaped(command),
        rows(facts)
    )
}

/// Explanation of a table over cycles.
pub(super) const OVER_CYCLES: &str = "Mean: of the fleet, total over total, with its 95 % \
                                      interval. The other columns count each cycle once.";

/// Every quantity, with intervals, under a caption.
pub(super) fn statistics(statistics: &[Statistic], caption: &str, note: Option<&str>) -> String {
    let note =
        note.map_or_else(String::new, |note| format!("<p class=\"soft\">Intervals: {note}.</p>\n"));
    let quantiles = statistics.first().into_iter().flat_map(|statistic| &statistic.quantiles);
    let mut head = ["over the cycles", "mean", "95 % interval", "SD"].map(str::to_owned).to_vec();
    head.extend(quantiles.map(|quantile| quantile.name.to_uppercase()));
    let rows = statistics.iter().filter(|statistic| statistic.n > 0).map(|statistic| {
        let (name, factor) = label(statistic.column);
        let range = |[low, high]: [f64; 2]| {
            format!("{} to {}", rounded(factor * low), rounded(factor * high))
        };
        let interval = statistic.ci95.map_or("–".to_owned(), range);
        let [mean, sd] = [statistic.mean, statistic.sd].map(|value| shown(value, factor));
        let quantiles = statistic.quantiles.iter().map(|quantile| {
            let tip = |ci95| format!(" title=\"95 % interval {}\"", range(ci95));
            let tip = quantile.ci95.map_or(String::new(), tip);
            format!("<td{tip}>{}</td>", shown(quantile.value, factor))
        });
        format!(
            "<tr><td>{}</td><td>{mean}</td><td>{interval}</td><td>{sd}</td>{}</tr>\n",
            escaped(name),
            quantiles.collect::<String>()
        )
    });
    format!("{note}<p class=\"soft\">{caption}</p>\n{}", table(&head, rows))
}

/// Shares of the road and of time.
pub(super) fn road_shares(sums: &Sums) -> String {
    let [distance, duration, standstill] =
        [sums.distance_m, sums.duration_s, sums.standstill_s].map(Option::unwrap_or_default);
    if !(distance > 0.0 && duration > 0.0) {
        return String::new();
    }
    let shares = sums.on_m.into_iter().zip(["urban", "rural", "motorway"]);
    // a study need not have all of these road types, and what is driven exactly has none
    let shares = shares.filter_map(|(metres, name)| Some((100.0 * metres? / distance, name)));
    let shares = shares.enumerate().map(|(k, (share, name))| match k {
        0 => format!("{share:.1} % is {name}"),
        _ => format!("{share:.1} % {name}"),
    });
    let types = match shares.collect::<Vec<_>>().as_slice() {
        [] => String::new(),
        [only] => format!("Of the distance {only}. "),
        [others @ .., last] => format!("Of the distance {} and {last}. ", others.join(", ")),
    };
    let standing = standstill / duration;
    format!(
        "<h2>Road</h2>\n<p>{types}The trucks stand for {:.1} % of the time.</p>\n",
        100.0 * standing
    )
}

/// The cycles with the lowest and the highest consumption.
pub(super) fn outliers(run: &Reported, quantity: &RecordQuantity, repeat: &Repeat) -> String {
    let ends = run.gathered.ends(quantity);
    let (unit, factor) = label(quantity.column);
    let mut text = format!(
        "<h2>Lowest and highest</h2>\n<div class=\"wide commands\" tabindex=\"0\" \
         style=\"--columns: 7\"><table>\n<thead><tr><th>cycle</th><th>{}</th><th>payload, \
         t</th><th>km</th><th>km/h</th><th>climb, m/km</th><th>stops</th><td class=\"words\">step \
         by step</td></tr></thead>\n<tbody>\n",
        escaped(unit)
    );
    for (value, record) in ends {
        let Record { cycle_id, n_stops, .. } = record;
        let km = record.distance_m / 1000.0;
        let (payload_t, climb_m_per_km) = (record.payload_kg / 1000.0, record.climb_m / km);
        let numbers = [factor * value, km, 3.6 * record.mean_speed_mps];
        let [value, km, speed_kmh] = numbers.map(rounded);
        let command = trace_command(run, repeat, cycle_id);
        let _ = writeln!(
            text,
            "<tr><td>{cycle_id}</td><td>{value}</td><td>{payload_t:.1}</td><td>{km}</td>\
             <td>{speed_kmh}</td><td>{climb_m_per_km:.1}</td><td>{n_stops}</td>\
             <td class=\"words\">{command}</td></tr>"
        );
    }
    text.push_str("</tbody></table></div>\n");
    if repeat.takes_file() && run.manifest.followed.is_none() {
        text.push_str(&Repeat::first(&run.manifest));
    }
    text
}

/// Cycles that were not completed, by reason.
pub(super) fn failures(run: &Reported, repeat: &Repeat) -> String {
    let summary = &run.summary.summary;
    let failed = summary.outcomes.failed();
    if failed == 0 {
        return "<h2>Cycles that failed</h2>\n<p>None: every cycle was completed.</p>\n".to_owned();
    }
    let was = if failed == 1 { "was" } else { "were" };
    let mut text = format!(
        "<h2>Cycles that failed</h2>\n<p>{} of {} cycles {was} not completed. Those that stalled \
         or timed out are in the records, but in no mean and no quantile. A trip whose battery \
         ran empty counts with the kilometres that it drove: as heavy consumers drive fewer, the \
         figure for the trips asked for is that of the whole trips, driven to their end with a \
         battery that never empties.</p>\n<div class=\"wide commands\" tabindex=\"0\" \
         style=\"--columns: 2\"><table>\n<thead><tr><th>why</th><th>cycles</th><td \
         class=\"words\">the first ones, step by step</td></tr></thead>\n<tbody>\n",
        grouped(failed),
        grouped(summary.cycles)
    );
    for outcome in Outcome::ALL.into_iter().filter(|outcome| *outcome != Outcome::Completed) {
        let count = summary.outcomes.of(outcome);
        if count == 0 {
            continue;
        }
        let first = run.gathered.first(outcome).iter();
        let commands: Vec<String> = first.map(|id| trace_command(run, repeat, *id)).collect();
        let (name, count, commands) = (outcome.name(), grouped(count), commands.join("<br>"));
        let _ = writeln!(
            text,
            "<tr><td>{name}</td><td>{count}</td><td class=\"words\">{commands}</td></tr>"
        );
    }
    text.push_str("</tbody></table></div>\n");
    if let Some(worst) = summary.worst_case {
        let (unit, factor) = label(worst.column);
        let (mean, unit) = (rounded(factor * worst.mean), escaped(unit));
        let _ = writeln!(
            text,
            "<p>Had each that stalled or timed out been as long as the mean completed cycle and \
             consumed like the worst one, or like its own record where that is more, the fleet's \
             mean would be {mean} {unit}.</p>"
        );
    }
    text
}

/// Where the text of the study is to be found.
pub(super) const THE_WHOLE_STUDY: &str = "“The whole study” below";

/// The key of what routes and drive cycles have a length of their own for.
const LENGTH: &str = "mission.length_m";

/// Keys of the study that say what kind of fleet it is.
const STUDY_KEYS: [(&str, &str); 13] = [
    ("length of a mission, m", LENGTH),
    ("payload, kg", "mission.payload_kg"),
    ("departure, s of the day", "mission.departure_s_of_day"),
    ("vehicle: own mass, kg", "vehicle.curb_mass_kg"),
    ("vehicle: drag area, m²", "vehicle.drag_area_m2"),
    ("curve speed: form", "driver.curve_speed.form"),
    ("curve speed: exponent", "driver.curve_speed.exponent"),
    ("curve speed at the reference radius, m/s", "driver.curve_speed.reference_speed_mps"),
    ("curve speed: spread between drivers, log", "driver.curve_speed.driver_sd"),
    ("pedals: share of PID drivers", "driver.pedals.pid_share"),
    ("parts turned off", "simulation.without"),
    ("factors frozen", "simulation.frozen"),
    ("sampling", "simulation.sampling"),
];

/// The study in words and numbers, and whole.
pub(super) fn study(run: &Reported) -> String {
    let manifest = &run.manifest;
    let mut text = "<h2>Study</h2>\n<div class=\"wide\" tabindex=\"0\"><table><tbody>\n".to_owned();
    let driven = driven_instead(&manifest.routes(), manifest.followed.as_ref());
    text.extend(driven.iter().map(|(name, value)| row(name, value)));
    let keys = STUDY_KEYS.iter().filter(|(_, path)| *path != LENGTH || driven.is_empty());
    text.extend(keys.filter_map(|(name, path)| Some(row(name, &in_words(&manifest.value(path)?)))));
    text.push_str("</tbody></table></div>\n");
    let sources = manifest.value("study.sources");
    let sources = sources.as_ref().and_then(|sources| sources.as_array()).into_iter().flatten();
    let sources: Vec<String> = sources
        .filter_map(|source| Some(format!("<li>{}</li>", escaped(source.as_str()?))))
        .collect();
    if !sources.is_empty() {
        let _ = writeln!(text, "<p>Sources:</p>\n<ul>{}</ul>", sources.join("\n"));
    }
    let _ = writeln!(
        text,
        "<details><summary>The whole study, as a file that {}</summary>\n<pre \
         tabindex=\"0\">{}</pre></details>",
        escaped(&what_it_repeats(manifest.followed.as_ref())),
        escaped(&commented(&manifest.resolved_study))
    );
    text
}

/// Drives that replaced the study's own roads: routes, with what is kept of them, and a speed that
/// was followed.
fn driven_instead(
    routes: &[RouteModel],
    followed: Option<&Followed>,
) -> Vec<(&'static str, String)> {
    let whole: f64 = routes.iter().map(|route| route.weight).sum();
    let route = |route: &RouteModel| {
        let mut text = route.file.clone();
        let keep: Vec<&str> = route.keep.iter().map(|keep| keep.name()).collect();
        if !keep.is_empty() {
            let _ = write!(text, ", with its own {}", keep.join(" and "));
        }
        let draw: Vec<&str> = route.draw.iter().map(|draw| draw.name()).collect();
        if !draw.is_empty() {
            let _ = write!(text, ", where it lacks them with drawn {}", draw.join(" and "));
        }
        if let Some(plan) = &route.stop_plan {
            let _ = write!(text, ", with the stop plan {plan}");
        }
        if routes.len() > 1 {
            let _ = write!(text, ", {:.1} % of the cycles", 100.0 * route.weight / whole);
        }
        text
    };
    let mut rows = Vec::new();
    if !routes.is_empty() {
        let named: Vec<String> = routes.iter().map(route).collect();
        rows.push(("routes", named.join("; ")));
    }
    if let Some(Followed { how, file, .. }) = followed {
        rows.push(("speed that is followed", format!("{file} ({})", how.name())));
    }
    rows
}

/// Note on the parts of a run that the file of the study repeats, and the further files that it
/// takes.
fn what_it_repeats(followed: Option<&Followed>) -> String {
    match followed {
        None => "repeats this run".to_owned(),
        Some(followed) => format!(
            "repeats this run together with {}, whose speed is followed ({})",
            followed.file,
            followed.how.name()
        ),
    }
}

/// Where the numbers come from.
pub(super) fn provenance(run: &Reported) -> String {
    let manifest = &run.manifest;
    let last = manifest.first_cycle + manifest.completed.saturating_sub(1);
    let (status, completed) = (manifest.status.name(), grouped(manifest.completed));
    let wall_s = rounded(run.summary.wall_s);
    let rows = [
        ("program", format!("ocmc {}", manifest.program_version)),
        ("study", manifest.study.clone()),
        ("hash of the study", manifest.study_hash.clone()),
        ("seed", manifest.seed.to_string()),
        ("cycle ids", format!("{} to {last}", manifest.first_cycle)),
        ("status", format!("{status}: {completed} of {} cycles", grouped(manifest.cycles))),
        ("ended", run.summary.ended_at.clone()),
        ("took", format!("{wall_s} s on {} threads", run.summary.threads)),
    ];
    format!(
        "<h2>Provenance</h2>\n<div class=\"wide\" \
         tabindex=\"0\"><table><tbody>\n{}</tbody></table></div>\n<p class=\"soft\">The intervals \
         are those of sampling from the study. They do not hold the error of the models, nor that \
         of numbers that were judged.</p>\n",
        self::rows(&rows)
    )
}

#[cfg(test)]
mod tests {
    use super::super::gathered::Gathered;
    use super::*;
    use crate::given_drive::Follow;
    use crate::records::examples;
    use ocmc_core::operating_cycle::drawn_part::Draw;
    use ocmc_core::operating_cycle::route::Keep;

    fn sums(records: &[Record]) -> Sums {
        let mut gathered = Gathered::default();
        gathered.add(records);
        gathered.sums
    }

    #[test]
    fn shares_that_nobody_knows_are_not_told() {
        let mut records = examples::records(5);
        for record in &mut records {
            record.outcome = Outcome::Completed;
            (record.distance_m, record.duration_s, record.standstill_s) = (1000.0, 100.0, 5.0);
            record.urban_share = Some(0.25);
            record.rural_share = Some(0.75);
            record.motorway_share = Some(0.0);
        }
        let message = road_shares(&sums(&records));
        assert!(message.contains("25.0 % is urban, 75.0 % rural and 0.0 % motorway"), "{message}");
        for (urban, rural, words) in [
            (Some(0.25), None, "Of the distance 25.0 % is urban and 0.0 % motorway. "),
            (None, None, "Of the distance 0.0 % is motorway. "),
        ] {
            for record in &mut records {
                (record.urban_share, record.rural_share) = (urban, rural);
            }
            let message = road_shares(&sums(&records));
            assert!(message.contains(words), "{message}");
        }
        for record in &mut records {
            record.urban_share = None;
            record.rural_share = None;
            record.motorway_share = None;
        }
        let message = road_shares(&sums(&records));
        assert!(!message.contains("urban") && message.contains("stand for 5.0 %"), "{message}");
    }

    #[test]
    fn what_was_driven_instead_of_the_studys_roads_is_named() {
        assert!(driven_instead(&[], None).is_empty());
        let route = |file: &str, weight: f64, keep: &[Keep]| RouteModel {
            file: file.to_owned(),
            weight,
            keep: keep.to_vec(),
            draw: Vec::new(),
            columns: std::collections::BTreeMap::new(),
            sha256: None,
            stop_plan: None,
            stop_plan_sha256: None,
            table: None,
        };
        let bare = RouteModel { draw: vec![Draw::Stops, Draw::Hills], ..route("a.csv", 1.0, &[]) };
        let message = "a.csv, where it lacks them with drawn stops and hills".to_owned();
        assert_eq!(driven_instead(&[bare], None), [("routes", message)]);
        let one = route("a.csv", 3.0, &[Keep::Weather, Keep::Traffic]);
        let rows = driven_instead(std::slice::from_ref(&one), None);
        let message = "a.csv, with its own weather and traffic".to_owned();
        assert_eq!(rows, [("routes", message.clone())]);
        let message = format!("{message}, 75.0 % of the cycles; b.csv, 25.0 % of the cycles");
        assert_eq!(driven_instead(&[one, route("b.csv", 1.0, &[])], None), [("routes", message)]);
        let followed = Followed { how: Follow::Exact, file: "dc.csv".to_owned(), cycle: None };
        let rows = driven_instead(&[], Some(&followed));
        assert_eq!(rows, [("speed that is followed", "dc.csv (exact)".to_owned())]);
    }

    #[test]
    fn a_run_that_follows_a_speed_takes_its_file_too() {
        assert_eq!(what_it_repeats(None), "repeats this run");
        let file = "city.csv".to_owned();
        let followed = Followed { how: Follow::Exact, file, cycle: None };
        let message = what_it_repeats(Some(&followed));
        assert!(message.contains("together with city.csv"), "{message}");
    }
}
