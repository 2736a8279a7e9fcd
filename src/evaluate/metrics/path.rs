//! Paths: speed, a common timeline, distance.

use nalgebra::Vector3;

/// Speed along `path`, one value fewer than points: the length of each forward difference times `fps`, m/s.
pub fn speed(path: &[Vector3<f64>], fps: f64) -> Vec<f64> {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm() * fps).collect()
}

/// `path` at `count` moments spread evenly from its first to its last point, by linear interpolation: paths of any
/// length come to one normalised timeline. As many points as there are come back unchanged; of no points none.
pub fn resampled(path: &[Vector3<f64>], count: usize) -> Vec<Vector3<f64>> {
    if path.is_empty() || path.len() == count {
        return path.to_vec();
    }
    let last = path.len() - 1;
    let at = |k: usize| {
        let place = if count > 1 { (k * last) as f64 / (count - 1) as f64 } else { 0.0 };
        let before = (place.floor() as usize).min(last);
        path[before].lerp(&path[(before + 1).min(last)], place - before as f64)
    };
    (0..count).map(at).collect()
}

/// Mean distance of corresponding points in metres, over those that `counts`; `None` where none does.
pub fn mean_distance(a: &[Vector3<f64>], b: &[Vector3<f64>], counts: &[bool]) -> Option<f64> {
    let pairs = a.iter().zip(b).zip(counts).filter(|(_, counts)| **counts);
    let (sum, count) =
        pairs.fold((0.0, 0_usize), |(sum, count), ((a, b), _)| (sum + (a - b).norm(), count + 1));
    (count > 0).then(|| sum / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(count: usize) -> Vec<Vector3<f64>> {
        (0..count).map(|k| Vector3::new(k as f64 / (count - 1) as f64, 0.0, 1.0)).collect()
    }

    #[test]
    fn a_timeline_of_another_length_keeps_both_ends_and_the_shape() {
        for count in [2, 7, 30, 31, 90] {
            let found = resampled(&line(31), count);
            assert_eq!(found.len(), count);
            for (found, expected) in found.iter().zip(line(count)) {
                assert!((found - expected).norm() < 1e-12);
            }
        }
        assert!(resampled(&[], 5).is_empty());
    }

    #[test]
    fn speed_is_distance_times_rate_and_only_what_counts_is_averaged() {
        assert!(speed(&line(31), 30.0).iter().all(|value| (value - 1.0).abs() < 1e-12));
        let (a, b) = (vec![Vector3::zeros(); 3], vec![Vector3::x(), Vector3::x() * 3.0, Vector3::x() * 9.0]);
        assert_eq!(mean_distance(&a, &b, &[true, true, false]), Some(2.0));
        assert_eq!(mean_distance(&a, &b, &[false; 3]), None);
    }
}
