//! Rows of a table that are enough for a picture of it.

/// At most `most` of some rows, evenly apart; the first and the last are among them.
pub(super) fn thinned<T: Copy>(rows: &[T], most: usize) -> Vec<T> {
    if rows.len() <= most {
        return rows.to_vec();
    }
    (0..most).map(|k| rows[k * (rows.len() - 1) / (most - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_stay_and_few_rows_are_all_of_them() {
        let rows: Vec<usize> = (0..1001).collect();
        assert_eq!(thinned(&rows, 5), [0, 250, 500, 750, 1000]);
        assert_eq!(thinned(&rows[..3], 5), [0, 1, 2]);
        assert!(thinned(&[0; 0], 5).is_empty());
    }
}
