//! A downhill simplex in the plane (Nelder and Mead 1965): two parameters, no derivatives, deterministic.

type Point = [f64; 2];

/// Evaluations after which the best point so far has to do.
const MOST: usize = 200;

/// A local minimum of `cost` downhill from `start`, first simplex of side `step`; stops when the simplex is
/// smaller than `tolerance`.
pub(super) fn minimise(cost: impl Fn(&Point) -> f64, start: Point, step: f64, tolerance: f64) -> Point {
    let value = |point: Point| {
        let cost = cost(&point);
        (point, if cost.is_nan() { f64::INFINITY } else { cost })
    };
    let mut simplex = [start, [start[0] + step, start[1]], [start[0], start[1] + step]].map(value);
    let mut evaluations = 3;
    while evaluations < MOST {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [best, middle, worst] = simplex;
        let size = (0..2).map(|k| (worst.0[k] - best.0[k]).abs().max((middle.0[k] - best.0[k]).abs()));
        if size.fold(0.0, f64::max) < tolerance {
            break;
        }
        // From the worst corner through the middle of the other two, `share` times as far again.
        let along = |share: f64| {
            let centre = |k: usize| 0.5 * (best.0[k] + middle.0[k]);
            value(std::array::from_fn(|k| centre(k) + share * (centre(k) - worst.0[k])))
        };
        let reflected = along(1.0);
        evaluations += 1;
        simplex[2] = if reflected.1 < best.1 {
            evaluations += 1;
            let expanded = along(2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < middle.1 {
            reflected
        } else {
            evaluations += 1;
            let contracted = along(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            if contracted.1 < worst.1.min(reflected.1) {
                contracted
            } else {
                evaluations += 2;
                let halfway = |p: Point| value(std::array::from_fn(|k| 0.5 * (p[k] + best.0[k])));
                simplex[1] = halfway(middle.0);
                halfway(worst.0)
            }
        };
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_end_of_rosenbrocks_valley() {
        let found =
            minimise(|[x, y]| (1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2), [-1.0, 1.0], 1.0, 1e-6);
        assert!((found[0] - 1.0).abs() < 1e-3 && (found[1] - 1.0).abs() < 1e-3, "{found:?}");
    }
}
