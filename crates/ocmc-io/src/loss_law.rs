//! The law of a loss map: what gears, axles and retarders lose, by least squares over the
//! points of a file.

/// Loss torque as a sum of terms of which none gives energy, over the points of a map.
///
/// `terms`: each term at each point; the answer has a factor for each, at least 0.
fn fit<const N: usize>(terms: &[Vec<f64>; N], losses: &[f64]) -> [f64; N] {
    let mut used: Vec<usize> = (0..N).filter(|k| terms[*k].iter().any(|x| *x != 0.0)).collect();
    loop {
        let factors = solve(&used, terms, losses);
        // a term that would give energy is none
        let least = used.iter().zip(&factors).min_by(|a, b| a.1.total_cmp(b.1));
        match least {
            Some((term, factor)) if *factor < 0.0 => {
                let term = *term;
                used.retain(|k| *k != term);
            }
            _ => {
                let mut all = [0.0; N];
                for (k, factor) in used.iter().zip(factors) {
                    all[*k] = factor;
                }
                return all;
            }
        }
    }
}

/// The normal equations of these terms, by elimination; a term that says nothing new has none.
fn solve<const N: usize>(used: &[usize], terms: &[Vec<f64>; N], losses: &[f64]) -> Vec<f64> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    // terms of about the same size, so that a pivot can be compared with 1
    let size = |k: usize| product(&terms[k], &terms[k]).sqrt();
    let mut rows: Vec<Vec<f64>> = used
        .iter()
        .map(|&a| {
            let matrix = used.iter().map(|&b| product(&terms[a], &terms[b]) / (size(a) * size(b)));
            matrix.chain([product(&terms[a], losses) / size(a)]).collect()
        })
        .collect();
    let n = used.len();
    for k in 0..n {
        let pivot = rows[k][k];
        if pivot < 1e-9 {
            rows[k].fill(0.0);
            continue;
        }
        let row: Vec<f64> = rows[k].iter().map(|x| x / pivot).collect();
        for (other, target) in rows.iter_mut().enumerate() {
            if other != k {
                let factor = target[k];
                target.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
            }
        }
        rows[k] = row;
    }
    rows.iter().zip(used).map(|(row, &k)| row[n] / size(k)).collect()
}

/// Constant in Nm, growth with speed in Nm s, and share of the torque: the law of a gear.
pub fn of_gear([speed, torque, loss]: &[Vec<f64>; 3]) -> [f64; 3] {
    let ones = vec![1.0; loss.len()];
    // one speed says nothing of growth
    let varies = speed.iter().any(|w| *w != speed[0]);
    let turning = if varies { speed.clone() } else { vec![0.0; speed.len()] };
    fit(&[ones, turning, torque.iter().map(|t| t.abs()).collect()], loss)
}

/// Constant in Nm, and growth with the square of speed in Nm s²: the law of a retarder.
pub fn of_retarder([speed, loss]: &[Vec<f64>; 2]) -> [f64; 2] {
    fit(&[vec![1.0; loss.len()], speed.iter().map(|w| w * w).collect()], loss)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_comes_back_and_nothing_gives_energy() {
        let (mut points, mut wrong) = ([vec![], vec![], vec![]], vec![]);
        for (k, w) in [60.0, 120.0, 200.0].into_iter().enumerate() {
            for torque in [-350.0, 50.0, 800.0, 2250.0] {
                points[0].push(w);
                points[1].push(torque);
                points[2].push(5.0 + 0.05 * w + 0.02 * f64::abs(torque));
                wrong.push(40.0 - 10.0 * k as f64 + 0.02 * f64::abs(torque));
            }
        }
        let [constant, growth, share] = of_gear(&points);
        assert!((constant - 5.0).abs() < 1e-9 && (growth - 0.05).abs() < 1e-11);
        assert!((share - 0.02).abs() < 1e-12);
        // a loss that falls with speed is taken without it
        let [constant, growth, share] = of_gear(&[points[0].clone(), points[1].clone(), wrong]);
        assert!(growth == 0.0 && (constant - 30.0).abs() < 1e-9 && (share - 0.02).abs() < 1e-12);
        let even = [vec![100.0; 3], vec![0.0, 100.0, 200.0], vec![1.0, 2.0, 3.0]];
        let [constant, growth, share] = of_gear(&even);
        assert!((constant - 1.0).abs() < 1e-9 && growth == 0.0 && (share - 0.01).abs() < 1e-12);
        let speed: Vec<f64> = (0..8).map(|k| 30.0 * f64::from(k)).collect();
        let loss: Vec<f64> = speed.iter().map(|w| 10.0 + 2e-4 * w * w).collect();
        let [constant, growth] = of_retarder(&[speed, loss]);
        assert!((constant - 10.0).abs() < 1e-9 && (growth - 2e-4).abs() < 1e-12);
    }
}
