//! Gaussian-weighted running slerp over orientations.

use nalgebra::UnitQuaternion;

/// Standard deviation of the weights, frames of the 15 Hz timeline.
const SIGMA: f64 = 10.0;
/// Frames to each side: a kernel of 21.
const HALF: usize = 10;

/// Every orientation replaced by the running slerp of its neighbours: they are taken in one by one, each with
/// its share of the weight so far.
///
/// The kernel stays centred: near the ends it is cut and normalised anew for that frame alone. The published
/// program normalises it in place, so that the cut of the first frames stays and its centroid lies 0.84 frames
/// ahead for the rest of the clip; that is not followed.
pub(super) fn smooth(rotations: &[UnitQuaternion<f64>]) -> Vec<UnitQuaternion<f64>> {
    (0..rotations.len())
        .map(|centre| {
            let window = centre.saturating_sub(HALF)..(centre + HALF + 1).min(rotations.len());
            let mut mean = rotations[window.start];
            let mut total = 0.0;
            for other in window {
                let distance = other.abs_diff(centre) as f64;
                let weight = (-0.5 * (distance / SIGMA).powi(2)).exp();
                total += weight;
                mean = slerp(&mean, &rotations[other], weight / total);
            }
            mean
        })
        .collect()
}

/// Along the shorter way; half a turn has none, and stays where it is.
pub(super) fn slerp(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    from.try_slerp(to, share, 1e-9).unwrap_or(*from)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    fn about_z(angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
    }

    #[test]
    fn a_steady_turn_passes_and_does_not_lead_or_lag() {
        let turning: Vec<_> = (0..60).map(|t| about_z(0.02 * f64::from(t))).collect();
        let smoothed = smooth(&turning);
        for t in HALF..60 - HALF {
            assert!(smoothed[t].angle_to(&turning[t]) < 1e-9);
        }
    }

    #[test]
    fn quaternions_of_either_sign_mean_the_same() {
        let turning: Vec<_> = (0..40).map(|t| about_z(0.05 * f64::from(t))).collect();
        let flipped: Vec<_> = turning
            .iter()
            .enumerate()
            .map(|(t, q)| if t % 3 == 0 { UnitQuaternion::new_unchecked(-q.into_inner()) } else { *q })
            .collect();
        for (a, b) in smooth(&turning).iter().zip(smooth(&flipped)) {
            assert!(a.angle_to(&b) < 1e-9);
        }
    }
}
