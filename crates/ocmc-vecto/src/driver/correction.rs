//! The distance that is driven against that of the mission.

/// Correction of the next second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Correction {
    /// It is driven.
    None,
    /// It is driven twice.
    Repeat,
    /// It is left out.
    Drop,
}

/// Compares the way that was driven with the mission's nodes: the next second is repeated where one
/// more of it comes nearer to the node, and left out where the node after it is as near.
pub(super) fn correction(way_m: &[f64], node: usize, driven_m: f64, target_mps: f64) -> Correction {
    let Some(&here_m) = way_m.get(node) else {
        return Correction::None;
    };
    let off_m = (driven_m - here_m).abs();
    if way_m.len() > node + 2 && (driven_m + target_mps - here_m).abs() < off_m {
        return Correction::Repeat;
    }
    match way_m.get(node + 1) {
        Some(&next_m) if (driven_m - next_m).abs() <= off_m => Correction::Drop,
        _ => Correction::None,
    }
}
