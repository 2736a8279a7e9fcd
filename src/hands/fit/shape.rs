//! Lengths of a hand's bones and the places of its finger bases.
//!
//! Means are those of Buryanov & Kotiuk 2010 (Int. J. Morphol. 28(3):755, X-rays of 66 adults), with
//! a carpal height of 0.54 of the middle metacarpal (Youm's ratio) between wrist and metacarpals.

use nalgebra::{SVector, Vector3};

/// Shape parameters: base points of five fingers (3 each, metres), then the logarithms of three
/// bone lengths a finger (metres).
pub(super) const SHAPE_DOF: usize = 30;
/// A change of all shape parameters.
pub(super) type ShapeVector = SVector<f64, SHAPE_DOF>;

/// A hand's proportions, in the hand frame: origin in the wrist, x to the middle MCP, y out of the
/// back, z to the thumb. Right-handed for a left hand; right hands are fitted in the mirror.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HandShape {
    /// Thumb CMC and the MCPs, metres.
    pub bases: [Vector3<f64>; 5],
    /// Three bones a finger, base to tip, metres.
    pub bones: [[f64; 3]; 5],
}

/// Wrist to middle tip, straight, at the table's size, millimetres.
const TABLE_LENGTH_MM: f64 = 191.8;
const BASES_MM: [[f64; 3]; 5] =
    [[23.0, -11.0, 25.0], [94.5, -0.5, 23.5], [99.5, 0.0, 0.0], [90.7, -1.5, -20.5], [79.5, -4.3, -38.8]];
/// Distal bones end at the fingertip, pulp included.
const BONES_MM: [[f64; 3]; 5] =
    [[46.2, 31.6, 27.4], [39.8, 22.4, 19.6], [44.6, 26.3, 21.4], [41.4, 25.7, 21.3], [32.7, 18.1, 19.7]];

impl HandShape {
    /// The average hand at `length` metres, wrist to middle tip, straight.
    pub fn average(length: f64) -> Self {
        let unit = length / TABLE_LENGTH_MM;
        Self {
            bases: BASES_MM.map(|p| Vector3::from(p) * unit),
            bones: BONES_MM.map(|finger| finger.map(|l| l * unit)),
        }
    }

    /// Wrist to middle tip, straight, metres.
    pub fn length(&self) -> f64 {
        self.bases[2].norm() + self.bones[2].iter().sum::<f64>()
    }

    /// The shape after a step.
    pub fn stepped(&self, step: &ShapeVector) -> Self {
        let mut shape = self.clone();
        for finger in 0..5 {
            shape.bases[finger] += step.fixed_rows::<3>(3 * finger);
            for bone in 0..3 {
                shape.bones[finger][bone] *= step[15 + 3 * finger + bone].exp();
            }
        }
        shape
    }

    /// The step that leads from `other` to this shape.
    pub fn difference(&self, other: &Self) -> ShapeVector {
        let mut step = ShapeVector::zeros();
        for finger in 0..5 {
            step.fixed_rows_mut::<3>(3 * finger).copy_from(&(self.bases[finger] - other.bases[finger]));
            for bone in 0..3 {
                step[15 + 3 * finger + bone] = (self.bones[finger][bone] / other.bones[finger][bone]).ln();
            }
        }
        step
    }

    /// d length / d shape parameters.
    pub fn length_gradient(&self) -> ShapeVector {
        let mut gradient = ShapeVector::zeros();
        gradient.fixed_rows_mut::<3>(6).copy_from(&self.bases[2].normalize());
        for bone in 0..3 {
            gradient[15 + 6 + bone] = self.bones[2][bone];
        }
        gradient
    }
}
