//! Road types of a road whose signs are known: drawn from their law given all the signs.
//!
//! The types are the hidden states of a semi-Markov chain (`road_type.rs`), the signs are what is
//! seen of them (`speed_sign.rs`). A stretch of one sign has, under a type, the likelihood
//! exp(-q L), q the rate at which the sign changes; a change of the sign has that of its rate where
//! the type stays, and where it changes that of the type's end times the share of the new sign.
//! Between signs a type may end, too, unseen: at places up to 250 m apart. A stretch of a type is
//! at least as long as its shortest one.
//!
//! The weights of all beginnings up to a place are summed forward, and types are drawn backward
//! from the end of the road: draws from the exact law, but for the places between signs.
//!
//! Method: forward filtering and backward sampling (L. Rabiner, Proc. IEEE 77 (1989); S.-Z. Yu,
//! Artificial Intelligence 174 (2010), for states with durations).
//!
//! Checked: of signs that roads of a chain have, the types that are drawn have the shares of the
//! roads' own, by sign, for seeds 1, 2 and 3; and two types without a sign in common are found.

use super::road_type::{RoadTypeChain, Section};
use super::speed_sign::SpeedSignChain;
use crate::random::Draws;

/// Places at which a type may end unseen are so far apart, in m, or as many on a long road.
const APART_M: f64 = 250.0;
const MOST_PLACES: f64 = 4000.0;
/// Share of a sign on a type that has none such: where a file's signs leave no type, the likeliest
/// is still drawn.
const FOREIGN: f64 = 1.0e-12;
/// Faces that differ by less are one, in m/s.
const SAME_FACE_MPS: f64 = 0.1;
/// Rounding of lengths, in m.
const ROUNDING_M: f64 = 1.0e-6;

/// The law of the road types of one road with known signs.
#[derive(Clone, Debug)]
pub struct TypesOfSigns {
    places: Vec<Place>,
    length_m: f64,
    next: Vec<Vec<f64>>,
}

/// A place at which a type may begin, and the weights of what leads to it.
#[derive(Clone, Debug)]
struct Place {
    at_m: f64,
    /// Weight of each type that has had its shortest length at the place before, too.
    carried: Vec<f64>,
    /// Stretches that have their shortest length here, or end with the road before they have.
    matured: Vec<Begun>,
    /// Weight of each type's end here.
    ends: Vec<f64>,
}

/// A stretch of a type that began at a place.
#[derive(Clone, Copy, Debug)]
struct Begun {
    road_type: usize,
    place: usize,
    weight: f64,
}

/// Rates of the changes of a type at a place.
#[derive(Clone, Copy)]
struct Rates {
    /// It ends, by probability, or per m where a sign stands.
    ends: f64,
    /// It does not.
    stays: f64,
    /// The sign changes within it, per m; 1 where no sign stands.
    changes: f64,
}

/// Evidence of the signs of one type on a sign.
struct Seen {
    share: f64,
    /// Rate of its change to any other, per m.
    exit_per_m: f64,
}

impl TypesOfSigns {
    /// Prepares the law; `limits` are signs from their places on, in m and m/s, the first one at 0.
    pub fn new(
        chain: &RoadTypeChain,
        signs: &[SpeedSignChain],
        limits: &[(f64, f64)],
        length_m: f64,
    ) -> Self {
        let types = signs.len();
        let next: Vec<Vec<f64>> = (0..types)
            .map(|r| {
                let total: f64 = chain.next(r).iter().sum();
                chain.next(r).iter().map(|w| if total > 0.0 { w / total } else { 0.0 }).collect()
            })
            .collect();
        let stretches = stretches(signs, limits, length_m);
        let apart_m = APART_M.max(length_m / MOST_PLACES);
        let mut law = Self { places: Vec::new(), length_m, next };
        let mut young: Vec<Begun> = Vec::new();
        let mut carried = vec![0.0; types];
        for (k, &(start_m, end_m, speed_mps)) in stretches.iter().enumerate() {
            let seen = seen(signs, speed_mps);
            let before = k.checked_sub(1).map(|before| stretches[before].2);
            let parts = libm::ceil((end_m - start_m) / apart_m).max(1.0);
            let part_m = (end_m - start_m) / parts;
            let mut from_m = start_m;
            for part in 0..=parts as usize {
                // the sign's own place, then the middles of its parts
                let of_type = |r: usize| {
                    let ends_per_m = chain.ends_per_m(r);
                    match before {
                        Some(before) if part == 0 => {
                            let changes = changes_per_m(&signs[r], before, speed_mps);
                            Rates { ends: ends_per_m, stays: 1.0, changes }
                        }
                        None if part == 0 => Rates { ends: 0.0, stays: 1.0, changes: 1.0 },
                        _ => {
                            let stays = libm::exp(-ends_per_m * part_m);
                            Rates { ends: 1.0 - stays, stays, changes: 1.0 }
                        }
                    }
                };
                let rates: Vec<Rates> = (0..types).map(of_type).collect();
                let is_start = k == 0 && part == 0;
                let shortest_m = |r: usize| chain.minimum_length_m(r);
                law.arrive(from_m, &mut carried, &mut young, shortest_m, &rates);
                law.begin(&seen, is_start.then_some(chain.share_by_length()), &mut young);
                for (r, carried) in carried.iter_mut().enumerate() {
                    *carried *= rates[r].stays * rates[r].changes;
                }
                let place = law.places.len() - 1;
                for begun in young.iter_mut().filter(|begun| begun.place < place) {
                    begun.weight *= rates[begun.road_type].changes;
                }
                let to_m = if part as f64 == parts {
                    end_m
                } else {
                    start_m + (part as f64 + 0.5) * part_m
                };
                let keep: Vec<f64> =
                    seen.iter().map(|s| libm::exp(-s.exit_per_m * (to_m - from_m))).collect();
                let mut total = 0.0;
                for (r, carried) in carried.iter_mut().enumerate() {
                    *carried *= keep[r];
                    total += *carried;
                }
                for begun in &mut young {
                    begun.weight *= keep[begun.road_type];
                    total += begun.weight;
                }
                if total > 0.0 {
                    let of_begun = young.iter_mut().map(|begun| &mut begun.weight);
                    for weight in carried.iter_mut().chain(of_begun) {
                        *weight /= total;
                    }
                }
                from_m = to_m;
            }
        }
        let ends = vec![Rates { ends: 1.0, stays: 0.0, changes: 1.0 }; types];
        // the road ends whatever there is
        law.arrive(length_m, &mut carried, &mut young, |_| 0.0, &ends);
        law
    }

    /// Comes to a place: what has its shortest length there can end there, at these rates.
    fn arrive(
        &mut self,
        at_m: f64,
        carried: &mut [f64],
        young: &mut Vec<Begun>,
        shortest_m: impl Fn(usize) -> f64,
        rates: &[Rates],
    ) {
        let places = &self.places;
        let is_old = |begun: &Begun| {
            places[begun.place].at_m + shortest_m(begun.road_type) <= at_m + ROUNDING_M
        };
        let matured: Vec<Begun> = young.iter().copied().filter(is_old).collect();
        young.retain(|begun| !is_old(begun));
        let before = carried.to_vec();
        for begun in &matured {
            carried[begun.road_type] += begun.weight;
        }
        let ends = carried.iter().zip(rates).map(|(weight, rates)| weight * rates.ends).collect();
        self.places.push(Place { at_m, carried: before, matured, ends });
    }

    /// Begins a stretch of each type at the last place: from what ends there, or, with the shares
    /// of the types, the road.
    fn begin(&self, seen: &[Seen], of_road: Option<&[f64]>, young: &mut Vec<Begun>) {
        let place = self.places.len() - 1;
        let ends = &self.places[place].ends;
        for (road_type, seen) in seen.iter().enumerate() {
            let comes = match of_road {
                Some(share) => share[road_type],
                None => ends.iter().zip(&self.next).map(|(end, next)| end * next[road_type]).sum(),
            };
            let weight = comes * seen.share;
            if weight > 0.0 {
                young.push(Begun { road_type, place, weight });
            }
        }
    }

    /// Draws the stretches of road types, in order and without gaps.
    pub fn sample(&self, draws: &mut Draws) -> Vec<Section> {
        let mut sections = Vec::new();
        let mut end_m = self.length_m;
        let last = self.places.len() - 1;
        let mut road_type = draws.index(&self.places[last].ends);
        let mut at = last;
        loop {
            // back to where the stretch had its shortest length, then to where it began
            let begun = loop {
                let place = &self.places[at];
                let of_type = || place.matured.iter().filter(|b| b.road_type == road_type);
                let carried = if at == 0 { 0.0 } else { place.carried[road_type] };
                if of_type().next().is_some() || at == 0 {
                    let weights: Vec<f64> =
                        [carried].into_iter().chain(of_type().map(|b| b.weight)).collect();
                    let chosen = draws.index(&weights);
                    if let Some(begun) = chosen.checked_sub(1).and_then(|k| of_type().nth(k)) {
                        break begun.place;
                    }
                }
                if at == 0 {
                    break 0;
                }
                at -= 1;
            };
            let start_m = self.places[begun].at_m;
            sections.push(Section { start_m, end_m, road_type });
            if begun == 0 {
                sections.reverse();
                return sections;
            }
            let place = &self.places[begun];
            let from: Vec<f64> = place
                .ends
                .iter()
                .zip(&self.next)
                .map(|(end, next)| end * next[road_type])
                .collect();
            road_type = draws.index(&from);
            (end_m, at) = (start_m, begun);
        }
    }
}

/// Stretches of one face: from, to, both in m, and the face, in m/s: of all types' the nearest one.
fn stretches(
    signs: &[SpeedSignChain],
    limits: &[(f64, f64)],
    length_m: f64,
) -> Vec<(f64, f64, f64)> {
    let faces = || {
        let pairs = signs.iter().flat_map(|signs| signs.speed_mps().iter().zip(signs.share()));
        pairs.filter(|(_, share)| **share > 0.0).map(|(speed_mps, _)| *speed_mps)
    };
    let nearest = |limit_mps: f64| {
        let apart = |face: &f64| (face - limit_mps).abs();
        faces().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(limit_mps)
    };
    let mut stretches: Vec<(f64, f64, f64)> = Vec::new();
    for &(at_m, limit_mps) in limits.iter().filter(|limit| limit.0 < length_m) {
        let face_mps = nearest(limit_mps);
        match stretches.last_mut() {
            None => stretches.push((0.0, length_m, face_mps)),
            Some(last) if (last.2 - face_mps).abs() > SAME_FACE_MPS => {
                last.1 = at_m;
                stretches.push((at_m, length_m, face_mps));
            }
            Some(_) => {}
        }
    }
    stretches
}

/// Evidence of the signs of each type on one. A type without it never holds it for longer than one
/// that has it would.
fn seen(signs: &[SpeedSignChain], speed_mps: f64) -> Vec<Seen> {
    let exit_per_m = |signs: &SpeedSignChain| {
        face_of(signs, speed_mps).map(|face| signs.rate_per_m()[face].iter().sum::<f64>())
    };
    let soonest_per_m = signs.iter().filter_map(exit_per_m).fold(0.0, f64::max);
    let of_type = |signs: &SpeedSignChain| match (face_of(signs, speed_mps), exit_per_m(signs)) {
        (Some(face), Some(exit_per_m)) => {
            Seen { share: signs.share()[face].max(FOREIGN), exit_per_m }
        }
        _ => Seen { share: FOREIGN, exit_per_m: soonest_per_m },
    };
    signs.iter().map(of_type).collect()
}

fn face_of(signs: &SpeedSignChain, speed_mps: f64) -> Option<usize> {
    signs.speed_mps().iter().position(|face| (face - speed_mps).abs() < SAME_FACE_MPS)
}

/// Rate of a change from one sign to another within a type, per m.
fn changes_per_m(signs: &SpeedSignChain, from_mps: f64, to_mps: f64) -> f64 {
    let least = FOREIGN * signs.flux_per_m().max(FOREIGN);
    let known = face_of(signs, from_mps).zip(face_of(signs, to_mps));
    known.map_or(0.0, |(from, to)| signs.rate_per_m()[from][to]).max(least)
}
