//! One grasp a clip, and the hand that stands for the gripper.

/// The gripper's full opening, metres.
const OPENING: f64 = 0.085;
/// Share of the range of widths below which the gripper counts as closed.
const CLOSED_SHARE: f64 = 0.2;

/// Holds `widths` (metres) closed from the first to the last closed frame: closed is below
/// min + 0.2 (max − min), and no frame in between opens wider than that.
pub(super) fn hold_one_grasp(widths: &mut [f64]) {
    let low = widths.iter().copied().fold(f64::INFINITY, f64::min);
    let high = widths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let threshold = low + CLOSED_SHARE * (high - low);
    let closed = |width: &f64| *width < threshold;
    let (Some(first), Some(last)) = (widths.iter().position(closed), widths.iter().rposition(closed)) else {
        return;
    };
    for width in &mut widths[first..=last] {
        *width = width.min(threshold);
    }
}

/// How far the hand is closed, 0 to 1: 8.5 cm and 0 on the gripper's scale of 0 to 255.
pub(super) fn closing(width: f64) -> f64 {
    1.0 - width.clamp(0.0, OPENING) / OPENING
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grasp_holds_from_the_first_to_the_last_closed_frame() {
        let mut widths = [0.1, 0.01, 0.09, 0.0, 0.1];
        hold_one_grasp(&mut widths);
        let expected = [0.1, 0.01, 0.02, 0.0, 0.1];
        assert!(
            widths.iter().zip(expected).all(|(width, wanted)| (width - wanted).abs() < 1e-12),
            "{widths:?}"
        );
    }

    #[test]
    fn an_open_gripper_is_an_open_hand() {
        assert_eq!([closing(0.2), closing(0.085), closing(0.0)], [0.0, 0.0, 1.0]);
        assert!((closing(0.0425) - 0.5).abs() < 1e-12);
    }
}
