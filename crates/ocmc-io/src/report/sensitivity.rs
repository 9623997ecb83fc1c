//! The page of a sensitivity analysis: which factors the spread between cycles comes from.

use super::opening::lead;
use super::svg::{bars, escaped};
use super::tables::{self, cells, repeated};
use super::{FOOT, STYLE, folded, page_head};
use crate::label::label;
use crate::number_text::{grouped, percent, rounded, share_text};
use ocmc_fleet::random_effects::TwoWay;
use ocmc_fleet::sensitivity::{FactorShare, Over, Sensitivity};
use ocmc_fleet::shapley::ShapleyEffects;
/// Factors that the first sentence names.
const NAMED: usize = 3;

/// An analysis, as far as its page needs it.
#[derive(Clone, Copy, Debug)]
pub struct SensitivityPage<'a> {
    /// Name of the study.
    pub study: &'a str,
    /// The shares.
    pub sensitivity: &'a Sensitivity,
    /// The shares that add up to one, where they were asked for.
    pub shapley: Option<&'a ShapleyEffects>,
    /// The second opinion, where it was asked for.
    pub two_way: Option<&'a TwoWay>,
    /// Facts about it.
    pub facts: &'a [(&'static str, String)],
    /// The command that repeats it, in the directory of the page.
    pub command: &'a str,
}

/// The page: HTML that opens offline.
pub fn sensitivity_html(page: &SensitivityPage) -> String {
    let shares = page.sensitivity;
    let (unit, factor) = label(shares.column);
    let study = escaped(page.study);
    let mut text = format!(
        "{}<p class=\"soft\">{}: mean {}, standard deviation {}.</p>\n",
        lead(&sentence(shares)),
        escaped(unit),
        rounded(factor * shares.mean),
        rounded(factor * shares.variance.sqrt())
    );
    text.push_str(&picture(shares));
    text.push_str(&table(shares));
    text.push_str(&page.shapley.map_or_else(String::new, shapley));
    text.push_str(&page.two_way.map_or_else(String::new, two_way));
    text.push_str(&repeated("analysis", "the study", page.command, page.facts));
    let top = page_head(&format!("{study}: where the spread comes from, by ocmc"), STYLE);
    format!("{top}<h1>Where the spread of {study} comes from</h1>\n{}{FOOT}", folded(&text))
}

/// Units between which the variance is.
fn between(over: Over) -> &'static str {
    match over {
        Over::Trip => "trips",
        Over::Truck => "trucks",
    }
}

/// The answer: the factors with the largest total effects. Parts of factors are not named.
fn sentence(shares: &Sensitivity) -> String {
    let mut factors: Vec<&FactorShare> =
        shares.factors.iter().filter(|share| !share.factor.contains('.')).collect();
    factors.sort_by(|a, b| b.total.total_cmp(&a.total));
    let named = factors.iter().take(NAMED).enumerate().map(|(k, share)| {
        let verb = if k == 0 { " would go" } else { "" };
        format!("{} %{verb} with the {}", percent(share.total), share.factor)
    });
    let named = named.collect::<Vec<_>>().join(", ");
    if named.is_empty() {
        return format!("Shares of the variance between {}.", between(shares.over));
    }
    format!(
        "Of the variance between {}, {named}, were it the same in every trip.",
        between(shares.over)
    )
}

/// Total effects as bars, the largest first.
fn picture(shares: &Sensitivity) -> String {
    let mut rows: Vec<(String, f64, String)> = shares
        .factors
        .iter()
        .map(|share| {
            let words = share_text(share.total, share.total_ci95);
            (share.factor.replace('.', ": ").replace('_', " "), share.total.max(0.0), words)
        })
        .collect();
    rows.sort_by(|a, b| b.1.total_cmp(&a.1));
    format!(
        "<h2>Total effects</h2>\n<figure>{}<figcaption>Share of the variance, in %, that would be \
         gone if the factor were the same in every trip, with its 95 % interval. A part, named \
         behind a colon, is in its factor, too; joint effects are in each factor that has a part \
         in them, so that the bars may add up to more than 100 %.</figcaption></figure>\n",
        bars(&rows, "Total effects of the factors")
    )
}

fn table(shares: &Sensitivity) -> String {
    let rows = shares.factors.iter().map(|share| {
        let first = share_text(share.first, share.first_ci95);
        cells(&[share.factor.to_owned(), first, share_text(share.total, share.total_ci95)])
    });
    format!(
        "<h2>First-order and total effects</h2>\n<p class=\"soft\">First-order: share of the \
         variance, in %, that the factor explains alone. Total: with its joint effects.</p>\n{}",
        tables::table(&["factor", "first-order", "total"], rows)
    )
}

fn shapley(effects: &ShapleyEffects) -> String {
    let rows: Vec<(String, f64, String)> = effects
        .factors
        .iter()
        .map(|share| {
            let words = share_text(share.share, share.ci95);
            (share.factor.to_owned(), share.share.max(0.0), words)
        })
        .collect();
    format!(
        "<h2>Shapley effects</h2>\n<figure>{}<figcaption>Shares of the variance, in %, that add \
         up to 100: joint effects are shared out between the factors that have a part in them. \
         From {} rows.</figcaption></figure>\n",
        bars(&rows, "Shapley effects of the factors"),
        grouped(effects.rows)
    )
}

fn two_way(shares: &TwoWay) -> String {
    let [cycle, driver, both] = [shares.cycle, shares.driver, shares.both].map(percent);
    format!(
        "<h2>A second opinion</h2>\n<p>{} cycles by {} drivers, two-way random effects: {cycle} % \
         of the variance is the cycle's, {driver} % the driver's, {both} % of both \
         together.</p>\n",
        grouped(shares.cycles),
        shares.drivers
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(factor: &'static str, first: f64, total: f64) -> FactorShare {
        let total_ci95 = Some([total - 0.1, total + 0.1]);
        FactorShare { factor, first, first_ci95: None, total, total_ci95 }
    }

    #[test]
    fn the_largest_factors_are_named_first_and_all_have_a_bar() {
        let sensitivity = &Sensitivity {
            column: "consumption_l_per_100km",
            over: Over::Trip,
            rows: 100,
            dropped_rows: 0,
            failed_rows: 0,
            rows_without_value: 0,
            replicates: None,
            cycles: 600,
            mean: 38.0,
            variance: 49.0,
            factors: vec![
                share("road", 0.05, 0.1),
                share("mission", 0.7, 0.8),
                share("mission.payload", 0.69, 0.79),
                share("driver", 0.01, 0.02),
            ],
        };
        let page = sensitivity_html(&SensitivityPage {
            study: "a & b",
            sensitivity,
            shapley: None,
            two_way: None,
            facts: &[("seed", "1".to_owned())],
            command: "ocmc sensitivity --study study.toml",
        });
        let said = "Of the variance between trips, 80.0 % would go with the mission, 10.0 % with \
                    the road, 2.0 % with the driver, were it the same in every trip.";
        assert!(page.replace('\u{a0}', " ").contains(said), "{page}");
        assert!(page.contains("a &amp; b") && page.contains("mission: payload"));
        assert!(page.contains("80.0 (70.0 to 90.0)"));
        assert_eq!(page.matches("class=\"bar\"").count(), 4);
    }
}
