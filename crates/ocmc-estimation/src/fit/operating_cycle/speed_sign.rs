//! Signs of a road type: shares, mean length and similarity.
//!
//! Limits of a log may be those of trucks, as a trace's are: on a motorway then every sign from
//! the truck limit on reads as the truck limit. Such faces are grouped: the group's share is
//! observed, its division is the base study's, and mean length and similarity follow from the
//! changes that are seen.

use super::TypeRoads;
use super::stretch::face;
use crate::fit::nelder_mead::minimise;
use crate::fit::study_parameter::Estimates;
use ocmc_core::operating_cycle::road::RoadModel;
use ocmc_core::operating_cycle::road::speed_sign::SpeedSignModel;
use std::collections::BTreeMap;

/// Changes of signs from which on their similarity is estimated.
const FEWEST_CHANGES: usize = 30;
/// Distance between a limit and the truck limit at which they are one, in tenths of km/h.
const AT_TRUCK_LIMIT: i64 = 5;

/// Highest face that is seen of a type, and its truck limit; none without a truck limit.
fn top_and_truck_limit(roads: &TypeRoads, truck_limit_mps: Option<f64>) -> Option<(i64, i64)> {
    roads.sign_length_m.keys().next_back().copied().zip(truck_limit_mps.map(face))
}

/// Whether the limits are those of trucks: none lies above the truck limit of its type, and one
/// that is the truck limit hides signs of the base study.
pub(super) fn are_of_trucks(of_type: &BTreeMap<String, TypeRoads>, base: &RoadModel) -> bool {
    let tops = || {
        of_type.iter().filter_map(|(name, roads)| {
            let base = base.types.get(name)?;
            let (top, limit) = top_and_truck_limit(roads, base.truck_limit_mps)?;
            Some((top, limit, &base.speed_signs))
        })
    };
    tops().all(|(top, limit, _)| top <= limit + AT_TRUCK_LIMIT)
        && tops().any(|(top, limit, signs)| {
            top >= limit - AT_TRUCK_LIMIT && hidden_faces(top, signs).any(|(face, _)| face > top)
        })
}

/// Faces of the base study, and their shares, that read as the truck limit.
fn hidden_faces(top: i64, base: &SpeedSignModel) -> impl Iterator<Item = (i64, f64)> + '_ {
    let faces = base.speed_kmh.iter().map(|kmh| libm::round(10.0 * kmh) as i64);
    faces.zip(base.share.iter().copied()).filter(move |(face, _)| *face >= top - AT_TRUCK_LIMIT)
}

/// Faces that are seen, in tenths of km/h, with their lengths, each divided into the faces behind
/// it: that face with all its share, but for the truck limit.
struct SeenFace {
    face: i64,
    length_m: f64,
    /// Faces in tenths of km/h, and their parts of the length.
    behind: Vec<(i64, f64)>,
}

fn seen_faces(
    roads: &TypeRoads,
    truck_limit_mps: Option<f64>,
    base: &SpeedSignModel,
) -> Vec<SeenFace> {
    let group = top_and_truck_limit(roads, truck_limit_mps)
        .filter(|(top, limit)| (top - limit).abs() <= AT_TRUCK_LIMIT)
        .map(|(top, _)| (top, hidden_faces(top, base).collect::<Vec<_>>()))
        .filter(|(top, faces)| faces.iter().any(|(face, share)| face > top && *share > 0.0));
    let behind = |face: i64| match &group {
        Some((top, faces)) if *top == face => {
            let total: f64 = faces.iter().map(|(_, share)| share).sum();
            faces.iter().map(|(face, share)| (*face, share / total)).collect()
        }
        _ => vec![(face, 1.0)],
    };
    let seen = roads.sign_length_m.iter();
    seen.map(|(&face, &length_m)| SeenFace { face, length_m, behind: behind(face) }).collect()
}

/// Shares, mean length and similarity of signs; `truck_limit_mps` is that of the type where the
/// limits are those of trucks.
pub(super) fn fit_signs(
    roads: &TypeRoads,
    truck_limit_mps: Option<f64>,
    model: &mut SpeedSignModel,
    estimates: &mut Estimates,
) {
    let seen = seen_faces(roads, truck_limit_mps, model);
    let length_m: f64 = seen.iter().map(|face| face.length_m).sum();
    if seen.is_empty() {
        estimates.warn(
            "no speed limit is known on any of its roads: its signs stay those of the base study",
        );
        return;
    }
    if let Some(group) = seen.iter().find(|seen| seen.behind != [(seen.face, 1.0)]) {
        estimates.warn(format_args!(
            "its limits end at the {:.0} km/h of trucks: the shares of signs from there on are \
             divided as in the base study, since traffic and curves follow the sign",
            group.face as f64 / 10.0
        ));
    }
    model.speed_kmh.clear();
    model.share.clear();
    let mut group_of = Vec::new();
    for (k, face) in seen.iter().enumerate() {
        for (behind, part) in &face.behind {
            model.speed_kmh.push(*behind as f64 / 10.0);
            model.share.push(part * face.length_m / length_m);
            group_of.push(k);
        }
        let share = face.length_m / length_m;
        let name = format!("speed_signs.share of {}", face.face as f64 / 10.0);
        estimates.push(&name, share, None, seen.len());
    }
    let changes = roads.sign_changes.len();
    if changes == 0 {
        estimates.warn(
            "its signs never change within a stretch: their mean length stays that of \
            the base study",
        );
        return;
    }
    // the next sign: P(j | i) in proportion to s_j exp(-|v_i - v_j| / V)
    let place = |face: i64| seen.binary_search_by_key(&face, |seen| seen.face).unwrap_or(0);
    let mut counts = vec![vec![0.0; seen.len()]; seen.len()];
    for &(from, to) in &roads.sign_changes {
        counts[place(from)][place(to)] += 1.0;
    }
    let with = |similarity_kmh: f64| {
        SpeedSignModel { similarity_kmh, ..model.clone() }.chain().grouped(&group_of)
    };
    let mut similarity = None;
    if changes >= FEWEST_CHANGES && seen.len() >= 3 {
        let minus_log_likelihood =
            |theta: &[f64; 1]| with(libm::exp(theta[0])).minus_log_likelihood(&counts);
        let start = [libm::log(model.similarity_kmh)];
        let (theta, value) = minimise(minus_log_likelihood, start, 0.3);
        // curvature of the likelihood, by differences
        let h = 0.05;
        let bend = minus_log_likelihood(&[theta[0] + h]) + minus_log_likelihood(&[theta[0] - h])
            - 2.0 * value;
        let similarity_kmh = libm::exp(theta[0]);
        if (1.0..=300.0).contains(&similarity_kmh) {
            similarity =
                Some((similarity_kmh, (bend > 0.0).then(|| similarity_kmh * h / libm::sqrt(bend))));
        } else {
            estimates.warn(
                "its changes of signs do not tell their similarity, which stays that of the base \
                 study",
            );
        }
    }
    // of all changes those are seen that lead to another group
    let similarity_kmh = similarity.map_or(model.similarity_kmh, |(kmh, _)| kmh);
    let share_seen = model.mean_length_m * with(similarity_kmh).flux_per_m();
    let mean_m = share_seen * length_m / changes as f64;
    let error = Some(mean_m / libm::sqrt(changes as f64));
    let into = &mut model.mean_length_m;
    estimates.set("speed_signs.mean_length_m", into, mean_m, error, changes);
    if let Some((kmh, error)) = similarity {
        let into = &mut model.similarity_kmh;
        estimates.set("speed_signs.similarity_kmh", into, kmh, error, changes);
    }
}
