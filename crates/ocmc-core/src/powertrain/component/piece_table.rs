//! Finds the piece of a piecewise function by one look-up: a table of bytes over equal cells.
//!
//! The cell that holds a knot belongs to the piece at its centre, so the function differs from the
//! exact one by at most half a cell times the change of slope, next to a knot only.

use crate::lanes::{Lanes, clip};
use fearless_simd::prelude::*;

/// Cells of a table.
const CELLS: usize = 1024;

/// The pieces over equal cells from zero on.
#[derive(Clone, Debug)]
pub(super) struct PieceTable {
    cells_per_unit: f64,
    piece: Box<[u8; CELLS]>,
}

impl PieceTable {
    /// `knots` are the inner ends of pieces, increasing; the table reaches to `span`. The pieces
    /// are counted in steps of `stride`: so the pieces in two directions are row and column of a
    /// matrix whose rows are so long.
    pub(super) fn new(knots: &[f64], span: f64, stride: u8) -> Self {
        let cell = span / CELLS as f64;
        let mut piece = Box::new([0; CELLS]);
        for (k, entry) in piece.iter_mut().enumerate() {
            let centre = (k as f64 + 0.5) * cell;
            *entry = knots.iter().filter(|knot| **knot <= centre).count() as u8 * stride;
        }
        Self { cells_per_unit: 1.0 / cell, piece }
    }

    /// The cells of numbers, each as an integer in the low bits of its double; those beyond an end
    /// are in the cell there.
    #[inline(always)]
    pub(super) fn cells<S: Simd>(&self, x: Lanes<S>) -> Lanes<S> {
        // a double of 2^52 has ulps of 1: adding it rounds, without a slow cast; less a half it is
        // the floor
        const SHIFT: f64 = 4503599627370496.0;
        clip(x * self.cells_per_unit - 0.5, 0.0, (CELLS - 1) as f64) + SHIFT
    }

    /// The piece at the middle of such a cell.
    #[inline(always)]
    pub(super) fn piece_of(&self, cell: f64) -> u8 {
        self.piece[cell.to_bits() as usize & (CELLS - 1)]
    }

    /// The piece at the middle of a number's cell; that of the first cell for NaN.
    #[inline(always)]
    pub(super) fn piece_of_number(&self, x: f64) -> u8 {
        self.piece[((x * self.cells_per_unit) as usize).min(CELLS - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn pieces_are_those_between_the_knots_but_for_half_a_cell() {
        let knots = [3.0, 10.0, 10.3, 200.0];
        let table = PieceTable::new(&knots, 256.0, 16);
        let half_cell = 0.5 * 256.0 / CELLS as f64;
        for k in -100..3000 {
            let x = 0.1 * f64::from(k) + 0.013;
            let cell = dispatch!(Level::baseline(), simd => table.cells(Lanes::splat(simd, x))[0]);
            let piece = table.piece_of(cell);
            assert_eq!(piece, table.piece_of_number(x), "{x}");
            let below = |x: f64| 16 * knots.iter().filter(|knot| **knot <= x).count();
            let allowed = below(x - half_cell)..=below(x + half_cell);
            assert!(allowed.contains(&(piece as usize)), "{x}: {piece}");
        }
        assert_eq!(table.piece_of_number(f64::NAN), 0);
    }
}
