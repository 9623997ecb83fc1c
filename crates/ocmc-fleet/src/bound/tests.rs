//! The search against the whole grid and against brute force.

use super::driven::{DrivenLeg, Heights};
use super::grid::{Fineness, Place};
use super::moves::Truck;
use super::solve::{Answer, FROM_NOTHING, FROM_TRACKS, PRICES, Problem, Question, Stage, Track};
use ocmc_core::powertrain::combustion::CombustionPowertrain;
use ocmc_core::powertrain::component::engine::EngineModel;
use ocmc_core::powertrain::component::gearbox::GearboxModel;
use ocmc_core::powertrain::efficiency::{EfficiencyCurve, EfficiencyDriveline};
use ocmc_core::powertrain::{GearOrder, Powertrain, TruckInputs};
use ocmc_core::prescribed::Body;
use ocmc_core::vehicle::resistance::DragBySpeed;
use std::sync::atomic::AtomicBool;

const RIGID: &str = include_str!("../../../../configs/vehicles/rigid-12t.toml");
const DRIVEN_MPS: f64 = 15.0;
const MOST_MPS: f64 = 20.0;
/// Error that the search may have: how it rounds speeds between its grid's.
const SHARE: f64 = 5e-4;

fn body() -> Body {
    Body {
        mass_kg: 11_000.0,
        wheel_mass_kg: 150.0,
        drag_area_m2: 5.5,
        drag_by_speed: DragBySpeed::NONE,
        rolling_coefficient: 0.006,
        air_density_kgpm3: 1.2,
    }
}

fn diesel() -> CombustionPowertrain {
    let table: toml::Table = toml::from_str(RIGID).unwrap();
    let combustion = &table["powertrain"]["combustion"];
    let engine: EngineModel = combustion["engine"].clone().try_into().unwrap();
    let gearbox: GearboxModel = combustion["gearbox"].clone().try_into().unwrap();
    CombustionPowertrain::new(&engine, &gearbox, 0.42, 3.0)
}

/// A leg at constant speed over hills, and its places.
struct Road {
    leg: DrivenLeg,
    places: Vec<Place>,
    heights: Heights,
}

impl Road {
    fn new(pieces: usize, piece_m: f64, slopes: Vec<f64>) -> Self {
        let length_m = pieces as f64 * piece_m;
        let heights = Heights::new(length_m / slopes.len() as f64, slopes);
        let mut leg = DrivenLeg::begin();
        leg.speed_mps[0] = DRIVEN_MPS;
        leg.push(length_m / DRIVEN_MPS, DRIVEN_MPS, GearOrder::Free);
        leg.road_m = [0.0, length_m];
        let place = |k: usize| Place {
            way_m: k as f64 * piece_m,
            height_m: heights.at(k as f64 * piece_m),
            most_mps: MOST_MPS,
            driven_mps: DRIVEN_MPS,
            planned_mps: MOST_MPS,
            limit_mps: MOST_MPS,
            in_curve: false,
            section: 0,
        };
        let places = (0..=pieces).map(place).collect();
        Self { leg, places, heights }
    }

    fn hills() -> Self {
        Self::new(40, 50.0, vec![0.0, 0.04, -0.03, 0.0, 0.05, -0.06, 0.02, 0.0])
    }

    fn answer<const N: usize>(
        &self,
        truck: &Truck,
        [most_s, price_w]: [f64; 2],
        free: bool,
        stages: &[Stage],
        around: Option<Vec<[Track; 2]>>,
    ) -> Answer {
        let Self { leg, places, heights } = self;
        let legs = vec![Problem { leg, places, free: vec![free; places.len()] }];
        let prices_w = if most_s.is_finite() { [0.05, 20.0] } else { [1.0; 2] };
        let prices_w = prices_w.map(|share| share * price_w);
        let (stop, fineness) = (&AtomicBool::new(false), Fineness::default());
        Question { truck, heights, legs, most_s, prices_w, stages, fineness, stop }
            .answer::<N>(around)
            .unwrap()
    }
}

const TRUCK: TruckInputs =
    TruckInputs { auxiliary_power_w: 2000.0, map_factor: 1.0, initial_charge: None };

#[test]
fn the_corridor_has_the_optimum_of_the_whole_grid() {
    let (powertrain, road) = (diesel(), Road::hills());
    let inverse = powertrain.inverse(&TRUCK);
    let truck = Truck::new(body(), &*inverse, 2.5);
    let whole = FROM_NOTHING.map(|stage| Stage { reach: 1e3, gears: 99, ..stage });
    for price_w in [20e3, 40e3, 60e3, 90e3] {
        let limits = [f64::INFINITY, price_w];
        let [all, near] = [&whole, &FROM_NOTHING].map(|stages| {
            let answer = road.answer::<1>(&truck, limits, true, stages, None);
            answer.energy_j() + price_w * answer.time_s()
        });
        assert!(near <= all * (1.0 + SHARE), "{price_w}: {}", near / all);
    }
    let most_s = road.leg.duration_s();
    let in_time = road.answer::<PRICES>(&truck, [most_s, 60e3], true, &FROM_NOTHING, None);
    assert!(in_time.time_s() <= most_s * (1.0 + 1e-9));
}

#[test]
fn a_search_around_tracks_has_the_optimum_of_one_from_nothing() {
    let (powertrain, road) = (diesel(), Road::hills());
    let inverse = powertrain.inverse(&TRUCK);
    let truck = Truck::new(body(), &*inverse, 2.5);
    for price_w in [20e3, 40e3, 90e3] {
        let limits = [f64::INFINITY, price_w];
        let at =
            |free, stages: &[Stage], around| road.answer::<1>(&truck, limits, free, stages, around);
        let cost = |answer: &Answer| answer.energy_j() + price_w * answer.time_s();
        let nothing = at(true, &FROM_NOTHING, None);
        let driven = at(false, &FROM_NOTHING, None);
        // the gears at constant speed, and the optimum of another price
        let other =
            road.answer::<1>(&truck, [f64::INFINITY, 1.1 * price_w], true, &FROM_NOTHING, None);
        let places = std::slice::from_ref(&road.places);
        let around = driven.tracks(places).into_iter().zip(other.tracks(places));
        let near = at(true, &FROM_TRACKS, Some(around.map(<[_; 2]>::from).collect()));
        let ratio = cost(&near) / cost(&nothing);
        assert!(ratio <= 1.0 + SHARE, "{price_w}: {ratio}");
        assert!(cost(&nothing) < cost(&driven) * (1.0 - SHARE), "{price_w}");
    }
}

#[test]
fn nothing_on_a_fine_grid_is_better_than_what_is_found() {
    let powertrain = EfficiencyDriveline {
        transmission_efficiency: 0.92,
        engine: EfficiencyCurve {
            rated_power_w: 200e3,
            power_share: vec![0.0, 1.0],
            efficiency: vec![0.4, 0.4],
        },
        auxiliary_power_w: 2e3,
    };
    let truck = Truck::new(body(), &powertrain, 2.5);
    let road = Road::new(4, 150.0, vec![0.03, -0.04, -0.03, 0.04]);
    let speeds: Vec<f64> = (0..=76).map(|k| 1.0 + 0.25 * f64::from(k)).collect();
    for price_w in [30e3, 80e3] {
        let cost = |k: usize, from_mps: f64, to_mps: f64| {
            let (a, b) = (&road.places[k], &road.places[k + 1]);
            let piece = [b.way_m - a.way_m, b.height_m - a.height_m];
            truck.piece_j([from_mps, to_mps], piece, price_w)
        };
        let mut least = f64::INFINITY;
        for one in &speeds {
            for two in &speeds {
                let before = cost(0, DRIVEN_MPS, *one) + cost(1, *one, *two);
                for three in &speeds {
                    let behind = cost(2, *two, *three) + cost(3, *three, DRIVEN_MPS);
                    least = least.min(before + behind);
                }
            }
        }
        let limits = [f64::INFINITY, price_w];
        let answer = road.answer::<1>(&truck, limits, true, &FROM_NOTHING, None);
        let cost_j = answer.energy_j() + price_w * answer.time_s();
        assert!(cost_j <= least * (1.0 + SHARE), "{price_w}: {cost_j} {least}");
        assert!(cost_j >= least * (1.0 - 2e-3), "{price_w}: {cost_j} {least}");
    }
}
