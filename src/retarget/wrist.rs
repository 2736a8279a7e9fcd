//! A person's correction of a wrist, on top of the one that follows from the model.

use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

/// A turn of the robot's whole hand about its wrist, in the axes of `{side}_wrist_yaw_link`: x to the fingers, z to
/// the index finger's side. First roll, then pitch, then yaw, each about the wrist's own resting axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WristTurn {
    /// About x, degrees, clockwise as seen from the elbow (default: 0).
    pub roll_deg: f64,
    /// About y, degrees, fingers down where the thumb is up (default: 0).
    pub pitch_deg: f64,
    /// About z, degrees, fingers to the left where the thumb is up (default: 0).
    pub yaw_deg: f64,
}

impl WristTurn {
    /// The rotation that the wrist's own is multiplied with from the right.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        let [roll, pitch, yaw] = self.degrees().map(f64::to_radians);
        UnitQuaternion::from_euler_angles(roll, pitch, yaw)
    }

    /// Roll, pitch and yaw.
    pub fn degrees(&self) -> [f64; 3] {
        [self.roll_deg, self.pitch_deg, self.yaw_deg]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn fingers_go_where_the_words_say() {
        let turned = |turn: WristTurn| turn.rotation() * Vector3::x();
        let pitched = turned(WristTurn { pitch_deg: 90.0, ..WristTurn::default() });
        assert!((pitched + Vector3::z()).norm() < 1e-12, "down");
        let yawed = turned(WristTurn { yaw_deg: 90.0, ..WristTurn::default() });
        assert!((yawed - Vector3::y()).norm() < 1e-12, "left");
        let rolled = WristTurn { roll_deg: 90.0, ..WristTurn::default() }.rotation() * Vector3::z();
        assert!((rolled + Vector3::y()).norm() < 1e-12, "up goes right, clockwise from behind");
    }
}
