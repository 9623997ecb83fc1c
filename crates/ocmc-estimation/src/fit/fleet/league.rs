//! A league table of trucks, or of drivers, and how sure its order is.
//!
//! Members stand in the order of their best linear unbiased predictions, which are drawn to the
//! mean the more, the fewer trips a member has. How sure the order is follows from draws of all
//! effects at once, given the estimated SDs; for two neighbours it has the closed form Φ(d/s), d
//! the difference of their predictions and s the SD of its error.
//!
//! Sources: H. Goldstein, D. J. Spiegelhalter, League tables and their limitations, Journal of the
//! Royal Statistical Society A 159 (1996), 385-443 \[PK\]; N. M. Laird, T. A. Louis, Empirical
//! Bayes ranking methods, Journal of Educational Statistics 14 (1989), 29-46 (expected ranks)
//! \[PK\].

use super::components::Components;
use super::likelihood::Posterior;
use super::trips::{FleetDesign, Trips};
use super::{Best, FleetOptions};
use crate::fit::p_value::normal_probability;
use ocmc_core::random::{Draws, Stream};
use serde::Serialize;

/// A league table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct League {
    /// `truck`, `driver` or `truck_and_driver`.
    pub level: &'static str,
    /// End that stands first.
    pub best: Best,
    /// How likely the first one is truly the first.
    pub first_is_first: f64,
    /// How likely the first three are truly the first three, in any order; none of three or fewer.
    pub three_are_three: Option<f64>,
    /// How likely the whole order is the true one.
    pub order_is_right: f64,
    /// Draws that this was counted in.
    pub draws: u64,
    /// The members, the best one first.
    pub members: Vec<LeagueMember>,
}

/// A truck or a driver in a league table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeagueMember {
    /// Its name.
    pub label: String,
    /// Trips.
    pub trips: usize,
    /// Mean of its trips.
    pub mean: f64,
    /// Predicted difference from the mean member.
    pub effect: f64,
    /// Standard error of that: the root of the variance of its error.
    pub standard_error: f64,
    /// Mean that it would have with the trips of the fleet: mean of the fleet and effect.
    pub predicted: f64,
    /// 1 less the variance of the error over that between members: 0 nothing is known, 1 all.
    pub reliability: f64,
    /// Mean of its rank over the draws, from 1.
    pub expected_rank: f64,
    /// How likely it is truly better than the median of all.
    pub better_than_median: f64,
    /// How likely it is truly the first.
    pub is_first: f64,
    /// How likely it truly stands before the next one.
    pub before_next: Option<f64>,
}

/// The leagues of all levels whose members differ.
pub(crate) fn leagues(
    trips: &Trips,
    components: &Components,
    posterior: &Posterior,
    options: &FleetOptions,
) -> Vec<League> {
    let families: Vec<usize> =
        (0..2).filter(|f| trips.families[*f].len() > 1 && components.sd[*f] > 0.0).collect();
    let mut counts: Vec<Counts> = families
        .iter()
        .map(|family| Counts::new(&posterior.effects[*family], options.best))
        .collect();
    let mut effects = posterior.effects.clone();
    for number in 0..options.draws {
        let mut draws = Draws::new(options.seed, number, Stream::Bootstrap);
        posterior.draw(&mut draws, &mut effects);
        for (family, counts) in families.iter().zip(&mut counts) {
            counts.add(&effects[*family]);
        }
    }
    let league_of = |(family, counts): (&usize, Counts)| {
        league(trips, components.sd[*family], posterior, options, *family, &counts)
    };
    families.iter().zip(counts).map(league_of).collect()
}

/// Counts over the draws.
struct Counts {
    best: Best,
    /// Members in the order of their predictions.
    order: Vec<usize>,
    ranks: Vec<u64>,
    firsts: Vec<u64>,
    better: Vec<u64>,
    three: u64,
    whole: u64,
    sorted: Vec<usize>,
}

impl Counts {
    fn new(effects: &[f64], best: Best) -> Self {
        let mut order: Vec<usize> = (0..effects.len()).collect();
        order.sort_by(|a, b| best.key(effects[*a]).total_cmp(&best.key(effects[*b])));
        let none = vec![0; effects.len()];
        Self {
            best,
            sorted: order.clone(),
            order,
            ranks: none.clone(),
            firsts: none.clone(),
            better: none,
            three: 0,
            whole: 0,
        }
    }

    fn add(&mut self, effects: &[f64]) {
        let best = self.best;
        self.sorted.sort_by(|a, b| best.key(effects[*a]).total_cmp(&best.key(effects[*b])));
        for (rank, member) in self.sorted.iter().enumerate() {
            self.ranks[*member] += rank as u64 + 1;
            self.better[*member] += u64::from(2 * rank + 1 < self.order.len());
        }
        self.firsts[self.sorted[0]] += 1;
        if self.order.len() > 3 {
            let three = &self.sorted[..3];
            self.three += u64::from(self.order[..3].iter().all(|member| three.contains(member)));
        }
        self.whole += u64::from(self.sorted == self.order);
    }
}

fn league(
    trips: &Trips,
    sd: f64,
    posterior: &Posterior,
    options: &FleetOptions,
    family: usize,
    counts: &Counts,
) -> League {
    let none = vec![0.0; trips.width];
    let fleet = posterior.combine(&trips.mean_predictors(), &[]).mean;
    let share = |count: u64| count as f64 / options.draws as f64;
    let members = counts.order.iter().enumerate().map(|(place, member)| {
        let own = posterior.combine(&none, &[(family, *member, 1.0)]);
        let before_next = counts.order.get(place + 1).map(|next| {
            let terms = [(family, *next, 1.0), (family, *member, -1.0)];
            let ahead = posterior.combine(&none, &terms);
            options.best.key(1.0) * ahead.mean / libm::sqrt(ahead.variance)
        });
        LeagueMember {
            label: trips.families[family].labels[*member].clone(),
            trips: trips.families[family].trips[*member],
            mean: trips.mean_of(family, *member),
            effect: own.mean,
            standard_error: libm::sqrt(own.variance),
            predicted: fleet + own.mean,
            reliability: (1.0 - own.variance / (sd * sd)).max(0.0),
            expected_rank: share(counts.ranks[*member]),
            better_than_median: share(counts.better[*member]),
            is_first: share(counts.firsts[*member]),
            before_next: before_next.map(normal_probability),
        }
    });
    League {
        level: match (family, trips.design) {
            (0, FleetDesign::TruckAndDriver) => "truck_and_driver",
            (0, _) => "truck",
            _ => "driver",
        },
        best: options.best,
        first_is_first: share(counts.firsts[counts.order[0]]),
        three_are_three: (counts.order.len() > 3).then(|| share(counts.three)),
        order_is_right: share(counts.whole),
        draws: options.draws,
        members: members.collect(),
    }
}
