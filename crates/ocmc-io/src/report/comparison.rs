//! The page of a comparison: how cycles differ between two studies, pair by pair.

use super::gathered::explaining;
use super::opening::{lead, three_digits};
use super::svg::{self, Mark, escaped};
use super::tables::{cells, repeated, table};
use super::{EXPLAINING, Explaining, FOOT, STYLE, folded, page_head, panels, strongest};
use crate::label::label;
use crate::number_text::{count_of, percent, rounded};
use crate::study::KeyDifference;
use ocmc_core::record::Record;
use ocmc_fleet::association::association;
use ocmc_fleet::comparison::{Comparison, PairOfValues};
use ocmc_fleet::cost_difference::{CostDifference, Side};
use ocmc_fleet::dependence::Dependence;
use ocmc_fleet::quantity::quantity;
use ocmc_fleet::statistic::Statistic;
use std::fmt::Write;

/// Shares of the variance of the differences below which nothing is shown.
const LEAST_SHARE: f64 = 0.01;

/// Keys that are listed.
const MOST_KEYS: usize = 40;

/// A comparison, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonPage<'a> {
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
    /// One for each study but the baseline.
    pub pictures: &'a [PairPicture<'a>],
    /// The command that repeats it, in the directory of the page.
    pub command: &'a str,
}

/// How study B differs from study A.
#[derive(Clone, Copy, Debug)]
pub struct PairPicture<'a> {
    /// Names of A and B.
    pub names: [&'a str; 2],
    /// The difference.
    pub comparison: &'a Comparison,
    /// Difference in cost; none where they have not both prices in one currency.
    pub cost: Option<&'a CostDifference>,
    /// The keys in which they differ.
    pub keys: &'a [KeyDifference],
    /// The values of the pairs.
    pub pairs: &'a [PairOfValues],
    /// The records of A, in the order of their ids.
    pub baseline: &'a [Record],
}

/// The page: HTML that opens offline.
pub fn comparison_html(page: &ComparisonPage) -> String {
    let names = page.pictures.iter().map(|picture| escaped(picture.names[1]));
    let names = names.collect::<Vec<_>>().join(", ");
    let baseline = page.pictures.first().map_or("", |picture| picture.names[0]);
    let title = format!("{names} against {}", escaped(baseline));
    let mut text =
        "<p class=\"soft\">The same cycles in each study: what they do not differ in is the same, \
                    cycle by cycle, and falls out of the difference.</p>\n"
            .to_owned();
    for picture in page.pictures {
        text.push_str(&picture.html(page.pictures.len() > 1));
    }
    text.push_str(&repeated("comparison", "the studies", page.command, page.facts));
    text.push_str(
        "<p class=\"soft\">The intervals are those of sampling from the studies. They do not hold \
         the error of the models, nor that of numbers that were judged.</p>\n",
    );
    let top = page_head(&format!("{title}: a comparison by ocmc"), STYLE);
    format!("{top}<h1>{title}</h1>\n{}{FOOT}", folded(&text))
}

impl PairPicture<'_> {
    fn html(&self, is_one_of_many: bool) -> String {
        let name = escaped(self.names[1]);
        let mut text = if is_one_of_many { format!("<h2>B: {name}</h2>\n") } else { String::new() };
        text.push_str(&self.sentences());
        text.push_str(&self.costs());
        text.push_str(&self.differing_keys());
        text.push_str(&self.differences());
        text
    }

    /// The answer in plain sentences.
    fn sentences(&self) -> String {
        let comparison = self.comparison;
        let (unit, factor) = label(&comparison.column);
        let (Some(a), Some(difference)) = (comparison.a, comparison.difference) else {
            let column = escaped(&comparison.column);
            return format!(
                "<p class=\"lead\">No cycle has <code>{column}</code> in both studies.</p>\n"
            );
        };
        let change = three_digits(factor * difference.abs());
        let interval = comparison.ci95.map_or_else(String::new, |[low, high]| {
            format!(" ± {}", three_digits(factor * (high - low) / 2.0))
        });
        let word = if difference < 0.0 { "less" } else { "more" };
        let share =
            if a == 0.0 { String::new() } else { format!(" ({} %)", percent(difference / a)) };
        let [in_b, in_a] = [a + difference, a].map(|mean| rounded(factor * mean));
        let mut said = if quantity(&comparison.column).is_some() {
            format!(
                "B takes {change}{interval} {unit} {word} than A{share}, in the mean of the fleet: \
                 {in_b} against {in_a}."
            )
        } else {
            format!(
                "{unit} is {change}{interval} {word} in B than in A{share}, in the mean of the \
                 cycles: {in_b} against {in_a}."
            )
        };
        if let (Some(lower), Some(equal)) = (comparison.share_a_lower, comparison.share_equal) {
            let pairs = count_of(comparison.pairs - comparison.pairs_without_value, "pair");
            let [in_a, in_b] = [lower, 1.0 - lower - equal].map(percent);
            let _ = write!(said, " Of {pairs} B is lower in {in_b} %, A in {in_a} %");
            let _ = match percent(equal).as_str() {
                "0.0" => write!(said, "."),
                same => write!(said, ", and {same} % are equal."),
            };
        }
        if comparison.ci95.is_some_and(|[low, high]| low <= 0.0 && high >= 0.0) {
            said.push_str(" The interval holds 0: so many cycles do not tell which is lower.");
        }
        if let Some(uncertain) = &comparison.parameter_uncertainty {
            let [low, high] = uncertain.ci95;
            let half = three_digits(factor * (high - low) / 2.0);
            let _ = write!(
                said,
                " With the errors of the uncertain numbers of the studies it is ± {half}."
            );
        }
        let failed = comparison.a_failed + comparison.b_failed;
        if failed > 0 {
            let _ = write!(
                said,
                " {} of A and {} of B were not completed and are left out.",
                comparison.a_failed, comparison.b_failed
            );
        }
        let [a, b] = self.names.map(escaped);
        format!("<p class=\"soft\">A: {a}<br>B: {b}</p>\n{}", lead(&said))
    }

    /// Costs of both over the distance and the work of transport.
    fn costs(&self) -> String {
        let Some(cost) = self.cost else { return String::new() };
        let line = |unit: &str, side: &Side| {
            let range = |[low, high]: [f64; 2]| format!("{} to {}", rounded(low), rounded(high));
            cells(&[
                escaped(&format!("{}/{unit}", cost.currency)),
                rounded(side.a),
                rounded(side.b),
                rounded(side.difference),
                side.difference_ci95.map_or("–".to_owned(), range),
                format!("{} %", percent(side.probability_a_cheaper)),
            ])
        };
        let per_tkm = cost.per_tkm.iter().map(|side| line("tkm", side));
        let rows = std::iter::once(line("km", &cost.per_km)).chain(per_tkm);
        let head = ["cost", "A", "B", "B - A", "95 %", "P(A cheaper)"];
        format!("<h2>Cost</h2>\n{}", table(&head, rows))
    }

    /// Keys in which B differs.
    fn differing_keys(&self) -> String {
        let rows = self.keys.iter().take(MOST_KEYS).map(|key| {
            let [a, b] = key.values().map(|value| escaped(&value));
            let change = key.change().unwrap_or_default();
            cells(&[format!("<code>{}</code>", escaped(&key.key)), a, b, change])
        });
        let more = match self.keys.len().saturating_sub(MOST_KEYS) {
            0 => String::new(),
            more => format!("<p class=\"soft\">And {}.</p>\n", count_of(more as u64, "more key")),
        };
        match self.keys {
            [] => String::new(),
            _ => format!(
                "<h2>What differs in the studies</h2>\n{}{more}",
                table(&["key", "A", "B", "change"], rows)
            ),
        }
    }

    /// How the differences are spread, and what they go with.
    fn differences(&self) -> String {
        let (unit, factor) = label(&self.comparison.column);
        let cycles = self.pairs.iter().map(|pair| (pair.cycle_id, factor * (pair.b - pair.a)));
        let statistic = Statistic::new("difference", None, &cycles, &Dependence::default().into());
        let Some(histogram) = &statistic.histogram else { return String::new() };
        let mean =
            self.comparison.difference.map(|mean| Mark::mean(factor * mean, "mean".to_owned()));
        let marks: Vec<Mark> =
            [Mark::quantile(0.0, "same".to_owned())].into_iter().chain(mean).collect();
        let outside = match histogram.below + histogram.above {
            0 => String::new(),
            n => format!(" {} lie outside the picture.", count_of(n, "pair")),
        };
        let edges = &histogram.edges;
        let same = if edges.iter().any(|edge| *edge <= 0.0) && edges.iter().any(|edge| *edge >= 0.0)
        {
            "a line where both take the same, and "
        } else {
            "zero, where both take the same, lies outside; "
        };
        let what = format!("B less A, {unit}");
        let quantiles = statistic.quantiles.iter().filter_map(|quantile| {
            let name = quantile.name.to_uppercase();
            Some((name, quantile.value?))
        });
        let (head, cells): (String, String) = quantiles
            .map(|(name, value)| {
                (format!("<th>{name}</th>"), format!("<td>{}</td>", rounded(value)))
            })
            .unzip();
        let sd = statistic.sd.map_or_else(|| "–".to_owned(), rounded);
        format!(
            "<h2>Differences, pair by pair</h2>\n\
             <figure>{}<figcaption>Number of cycles by how much more they take in B than in A; \
             {same}a dashed line at the difference of the fleets' \
             means.{outside}</figcaption></figure>\n\
             <div class=\"wide\" tabindex=\"0\"><table>\n\
             <thead><tr><th>over the pairs</th><th>SD</th>{head}</tr></thead>\n<tbody><tr>\
             <td>{}</td><td>{sd}</td>{cells}</tr></tbody></table></div>\n{}",
            svg::histogram(histogram, &marks, &what, "cycles"),
            escaped(&what),
            self.explained(unit, factor)
        )
    }

    /// Inputs that go with the differences.
    fn explained(&self, unit: &str, factor: f64) -> String {
        let first = self.baseline.first().map_or(0, |record| record.cycle_id);
        let record = |pair: &PairOfValues| self.baseline.get((pair.cycle_id - first) as usize);
        let change = |pair: &PairOfValues| factor * (pair.b - pair.a);
        let mut quantities = Vec::new();
        let mut look = |name: String, factor: f64, x: &dyn Fn(&PairOfValues) -> Option<f64>| {
            let pairs = self.pairs.iter().filter_map(|pair| Some((x(pair)?, change(pair))));
            let pairs: Vec<(f64, f64)> = pairs.filter(|(x, y)| (x + y).is_finite()).collect();
            let association = association(&pairs).filter(|known| known.share >= LEAST_SHARE);
            quantities.extend(association.map(|association| Explaining {
                name,
                factor,
                association,
            }));
        };
        // of both: what is high in A by chance is lower in B
        look(format!("mean of A and B, {unit}"), factor, &|pair| {
            Some(f64::midpoint(pair.a, pair.b))
        });
        for (column, name, factor, per_distance) in EXPLAINING {
            let name = if per_distance { format!("{name} per km") } else { name.to_owned() };
            look(name, factor, &|pair| explaining(record(pair)?, column));
        }
        if quantities.is_empty() {
            return String::new();
        }
        format!(
            "<h2>What goes with the difference</h2>\n\
             <p>B less A, {} over tenths of the pairs, sorted by each quantity of A, whose values \
             stand below the first, the middle and the last of them: the line is the median, the \
             band holds 80 % of the pairs. The percentage is the share of the variance of the \
             differences between the tenths. It says what goes together, not what causes \
             what.</p>\n{}",
            escaped(unit),
            panels(&strongest(quantities), "Difference")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ocmc_core::energy::Carrier;
    use ocmc_fleet::comparison::paired_values;
    use ocmc_fleet::quantity::quantity;

    fn fleet(more: impl Fn(u64) -> f64) -> Vec<Record> {
        let record = |id: u64| Record {
            cycle_id: 7 + id,
            distance_m: 10_000.0,
            payload_kg: 100.0 * id as f64,
            ..Record::default().with(
                Carrier::LiquidFuel,
                [None, Some(30.0 + (id * 37 % 11) as f64 + more(id)), None],
            )
        };
        (0..200).map(record).collect()
    }

    fn page(a: &[Record], b: &[Record]) -> String {
        let litres = quantity("consumption_l_per_100km").expect("known");
        let comparison = &Comparison::of(litres, Dependence::default(), a, b);
        let pairs = &paired_values(litres, a, b);
        let names = ["plain <b>", "other"];
        let [one, other] = [1.0, 3.0].map(|value| Some(serde_json::json!(value)));
        let keys =
            [KeyDifference { key: "road.<k>".to_owned(), a: one, b: other, ratio: Some(3.0) }];
        let picture =
            PairPicture { names, comparison, cost: None, keys: &keys, pairs, baseline: a };
        comparison_html(&ComparisonPage {
            facts: &[("seed", "1".to_owned())],
            pictures: &[picture],
            command: "ocmc compare a.toml b.toml",
        })
    }

    #[test]
    fn the_answer_stands_first_and_the_picture_is_of_the_differences() {
        // heavier trucks lose more
        let page = page(&fleet(|_| 0.0), &fleet(|id| -0.01 * id as f64));
        assert!(page.contains("L/100 km less than A"), "{page}");
        assert!(
            page.replace('\u{a0}', " ")
                .contains("Of 200 pairs B is lower in 99.5 %, A in 0.0 %, and 0.5 % are equal.")
        );
        assert!(page.contains("Histogram of B less A, L/100 km over the cycles"));
        assert!(
            page.contains("<h3>payload, t: 99 %</h3>") && page.contains("Difference over payload")
        );
        assert!(page.contains("road.&lt;k&gt;") && page.contains("<td>times 3.000</td>"), "{page}");
        assert!(page.contains("a line where both take the same"), "{page}");
        assert!(page.contains("plain &lt;b&gt;") && !page.contains("plain <b>"));
        assert!(page.contains("ocmc compare a.toml b.toml") && !page.contains("NaN"));
        let bars = page.matches("class=\"bar\"").count();
        assert!(bars > 5, "{bars}");
    }

    #[test]
    fn studies_that_do_not_differ_have_a_page() {
        let page = page(&fleet(|_| 0.0), &fleet(|_| 0.0));
        assert!(
            page.replace('\u{a0}', " ").contains("100.0 % are equal") && !page.contains("NaN"),
            "{page}"
        );
        assert!(!page.contains("What goes with the difference"));
    }
}
