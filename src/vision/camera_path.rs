//! The background's motion over a whole clip, chained from neighbouring frames.

use nalgebra::Matrix3;

/// Homographies between any two frames of a clip, composed from those of neighbours.
///
/// Drift grows with the distance in time: refine a long composition on the pictures themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// Takes pixels of each frame to the first frame of its unbroken stretch.
    to_anchor: Vec<Matrix3<f64>>,
    /// The unbroken stretch each frame belongs to.
    stretch: Vec<u32>,
}

impl CameraPath {
    /// From `steps[t]`, which takes pixels of frame `t` to frame `t + 1`; `None` breaks the chain.
    /// The path has one frame more than there are steps.
    pub fn from_steps(steps: &[Option<Matrix3<f64>>]) -> Self {
        let (mut to_anchor, mut stretch) = (vec![Matrix3::identity()], vec![0]);
        let (mut current, mut number) = (Matrix3::identity(), 0);
        for step in steps {
            match step.and_then(|step| step.try_inverse()) {
                Some(back) => current = normalised(current * back),
                None => (current, number) = (Matrix3::identity(), number + 1),
            }
            to_anchor.push(current);
            stretch.push(number);
        }
        Self { to_anchor, stretch }
    }

    /// Number of frames.
    pub fn frame_count(&self) -> usize {
        self.to_anchor.len()
    }

    /// Takes pixels of frame `from` to frame `to`; `None` across a break or beyond the end.
    pub fn between(&self, from: usize, to: usize) -> Option<Matrix3<f64>> {
        if self.stretch.get(from)? != self.stretch.get(to)? {
            return None;
        }
        if from == to {
            return Some(Matrix3::identity());
        }
        Some(normalised(self.to_anchor[to].try_inverse()? * self.to_anchor[from]))
    }
}

/// Scales a homography so that its last element is 1, where that is possible.
fn normalised(h: Matrix3<f64>) -> Matrix3<f64> {
    if h[(2, 2)].abs() > 1e-12 { h / h[(2, 2)] } else { h }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shift(x: f64) -> Option<Matrix3<f64>> {
        Some(Matrix3::new(1.0, 0.0, x, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    }

    #[test]
    fn steps_add_up_forwards_and_backwards() {
        let path = CameraPath::from_steps(&[shift(1.0), shift(2.0), shift(4.0)]);
        assert_eq!(path.between(0, 3).unwrap()[(0, 2)], 7.0);
        assert_eq!(path.between(3, 1).unwrap()[(0, 2)], -6.0);
    }

    #[test]
    fn a_break_separates_what_lies_on_either_side() {
        let path = CameraPath::from_steps(&[shift(1.0), None, shift(4.0)]);
        assert!(path.between(1, 2).is_none());
        assert_eq!(path.between(2, 3).unwrap()[(0, 2)], 4.0);
        assert!(path.between(0, 9).is_none());
    }
}
