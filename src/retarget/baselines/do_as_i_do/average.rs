//! The moving average over joint angles.

use crate::retarget::solver::SideAngles;

/// Each frame replaced by the mean of itself and its neighbours: three frames, two at the ends.
pub(super) fn moving_average(angles: &[SideAngles]) -> Vec<SideAngles> {
    (0..angles.len())
        .map(|frame| {
            let around = &angles[frame.saturating_sub(1)..(frame + 2).min(angles.len())];
            around.iter().sum::<SideAngles>() / around.len() as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impulse_is_spread_over_three_frames() {
        let mut angles = vec![SideAngles::zeros(); 5];
        angles[2] = SideAngles::repeat(3.0);
        let spread: Vec<f64> = moving_average(&angles).iter().map(|frame| frame[0]).collect();
        assert_eq!(spread, [0.0, 1.0, 1.0, 1.0, 0.0]);
    }
}
