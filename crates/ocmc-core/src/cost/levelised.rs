//! Prices in one state of the world: cost of a charge and of a truck over the life.

use super::costing::{Costing, Trip};
use super::item::Item;
use super::state::State;

/// The life of a truck in a state of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Life {
    /// Parts of each year that belong to the life, and the same times the present worth of a unit
    /// of money.
    pub years: Vec<[f64; 2]>,
    /// Years.
    pub years_a: f64,
    /// Years, discounted: D.
    pub discounted_a: f64,
    /// Worth at the start of a unit of money at the end of the life.
    pub at_end: f64,
    /// Distance in a year, in km.
    pub km_per_a: f64,
}

impl Life {
    /// A life of so many years.
    pub fn new(life_a: f64, rate_per_a: f64, km_per_a: f64) -> Self {
        let mut years = Vec::new();
        let (mut left, mut worth) = (life_a, 1.0);
        while left > 0.0 {
            let part = libm::fmin(left, 1.0);
            years.push([part, part * worth]);
            worth /= 1.0 + rate_per_a;
            left -= 1.0;
        }
        let sum = |k: usize| years.iter().map(|year| year[k]).sum();
        let at_end = libm::pow(1.0 + rate_per_a, -life_a);
        Self { years_a: sum(0), discounted_a: sum(1), years, at_end, km_per_a }
    }

    /// Sum of yearly payments, discounted or not, over the whole life.
    fn sum(&self, in_year: impl Fn(usize) -> f64) -> Money {
        let mut sum = Money::default();
        for (year, [part, discounted]) in self.years.iter().enumerate() {
            sum.paid += part * in_year(year);
            sum.discounted += discounted * in_year(year);
        }
        sum
    }
}

/// Money over a life.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Money {
    /// As it is paid.
    pub paid: f64,
    /// Worth at the start.
    pub discounted: f64,
}

/// Prices in one state of the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Levelised {
    /// The life, where there is one.
    pub life: Option<Life>,
    /// Price of each charge in the mean of the years, discounted and as paid.
    pub prices: Vec<Money>,
    /// Costs of a truck over its life, item by item.
    pub truck: Vec<(Item, Money)>,
}

impl Levelised {
    /// Evaluates the prices in a state.
    pub fn of(costing: &Costing, state: &State) -> Self {
        let life = costing.life.map(|inputs| {
            let [life, rate, distance] =
                [inputs.life, inputs.rate, inputs.distance].map(|input| state.constant(input));
            Life::new(life, rate, distance)
        });
        let prices = costing.charges.iter().map(|charge| {
            let price = &state.0[charge.input];
            let Some(life) = &life else {
                let price = price.first();
                return Money { paid: price, discounted: price };
            };
            let sum = life.sum(|year| price.in_year(year));
            Money { paid: sum.paid / life.years_a, discounted: sum.discounted / life.discounted_a }
        });
        let prices = prices.collect();
        let truck = life.as_ref().map_or(Vec::new(), |life| truck(costing, state, life));
        Self { life, prices, truck }
    }

    /// Cost of the truck in a year, levelised; 0 where nothing is paid by it.
    pub fn truck_per_a(&self) -> f64 {
        let sum: f64 = self.truck.iter().map(|(_, money)| money.discounted).sum();
        self.life.as_ref().map_or(0.0, |life| sum / life.discounted_a)
    }

    /// Cost of the truck over a km, levelised.
    pub fn truck_per_km(&self) -> f64 {
        self.life.as_ref().map_or(0.0, |life| self.truck_per_a() / life.km_per_a)
    }

    /// Charges that trips pay for what they use.
    pub fn charged(&self, trip: &Trip) -> f64 {
        self.prices.iter().zip(&trip.amounts).map(|(price, amount)| price.discounted * amount).sum()
    }

    /// Cost of trips, the truck included.
    pub fn cost(&self, trip: &Trip) -> f64 {
        self.charged(trip) + self.truck_per_km() * trip.km
    }

    /// Cost of trips over a km.
    pub fn per_km(&self, trips: &Trip) -> f64 {
        self.cost(trips) / trips.km
    }
}

fn truck(costing: &Costing, state: &State, life: &Life) -> Vec<(Item, Money)> {
    let mut items: Vec<(Item, Money)> = costing
        .parts
        .iter()
        .map(|part| {
            let price = part.amount * state.constant(part.input);
            (part.item, Money { paid: price, discounted: price })
        })
        .collect();
    if let Some(residual) = costing.residual {
        let bought: f64 = items.iter().map(|(_, money)| money.paid).sum();
        let left = -state.constant(residual) * bought;
        items.push((Item::Residual, Money { paid: left, discounted: left * life.at_end }));
    }
    if let Some(insurance) = costing.insurance {
        let price = &state.0[insurance];
        items.push((Item::Insurance, life.sum(|year| price.in_year(year))));
    }
    items
}
