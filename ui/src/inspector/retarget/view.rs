//! From the torso frame to the screen, through the camera that drew the picture of the robot.

use agenticfocus::{
    engine::OrbitCamera,
    geometry::{Pinhole, Position, Size, Torso},
};
use egui::{Pos2, Rect, pos2};
use nalgebra::{Isometry3, Point3, Vector3};

/// Nothing nearer than this is drawn, metres.
const NEAR: f64 = 0.02;

/// A picture of the robot on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    to_camera: Isometry3<f64>,
    lens: Pinhole,
    place: Rect,
}

impl View {
    /// The view of `camera` whose picture of `size` fills `place` on the screen.
    pub fn new(camera: &OrbitCamera, size: Size, place: Rect) -> Self {
        Self { to_camera: camera.pose().inverse(), lens: camera.pinhole(size), place }
    }

    /// Where a point is on the screen; `None` behind the camera.
    pub fn point(&self, point: &Position<Torso>) -> Option<Pos2> {
        let seen = self.to_camera * Point3::from(point.xyz);
        (seen.z >= NEAR).then(|| self.on_screen(seen))
    }

    /// Where a line is on the screen, cut off where it passes behind the camera; `None` when all of it is there.
    pub fn line(&self, from: &Position<Torso>, to: &Position<Torso>) -> Option<[Pos2; 2]> {
        let (start, end) = (self.to_camera * Point3::from(from.xyz), self.to_camera * Point3::from(to.xyz));
        if start.z < NEAR && end.z < NEAR {
            return None;
        }
        let cut = |point: Point3<f64>, other: Point3<f64>| {
            if point.z >= NEAR {
                point
            } else {
                point + (other - point) * ((NEAR - point.z) / (other.z - point.z))
            }
        };
        Some([self.on_screen(cut(start, end)), self.on_screen(cut(end, start))])
    }

    fn on_screen(&self, seen: Point3<f64>) -> Pos2 {
        let x = self.lens.fx * seen.x / seen.z + self.lens.cx;
        let y = self.lens.fy * seen.y / seen.z + self.lens.cy;
        // A pixel's centre has integer coordinates, so the picture begins half a pixel before 0.
        let across = (x + 0.5) / f64::from(self.lens.size.width);
        let down = (y + 0.5) / f64::from(self.lens.size.height);
        pos2(
            self.place.left() + across as f32 * self.place.width(),
            self.place.top() + down as f32 * self.place.height(),
        )
    }
}

/// The camera turned by a drag of `across` and `down` points.
pub(super) fn turned(camera: &OrbitCamera, across: f32, down: f32) -> OrbitCamera {
    let azimuth = camera.azimuth - 0.01 * f64::from(across);
    let elevation = (camera.elevation + 0.01 * f64::from(down)).clamp(-1.5, 1.5);
    let azimuth = (azimuth + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    OrbitCamera { azimuth, elevation, ..*camera }
}

/// The camera nearer (`scroll` above 0) or farther.
pub(super) fn zoomed(camera: &OrbitCamera, scroll: f32) -> OrbitCamera {
    let distance = (camera.distance * (-0.002 * f64::from(scroll)).exp()).clamp(0.3, 5.0);
    OrbitCamera { distance, ..*camera }
}

/// The camera moved sideways so that what is under the pointer goes along with it; `height` of the picture in points.
pub(super) fn shifted(camera: &OrbitCamera, across: f32, down: f32, height: f32) -> OrbitCamera {
    let metres = 2.0 * camera.distance * (0.5 * camera.field_of_view).tan() / f64::from(height.max(1.0));
    let by =
        camera.pose().rotation * Vector3::new(-f64::from(across) * metres, -f64::from(down) * metres, 0.0);
    OrbitCamera { target: camera.target + by, ..*camera }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> Position<Torso> {
        Position::new(Vector3::new(x, y, z))
    }

    fn view_from_behind() -> View {
        let camera = OrbitCamera {
            target: Point3::new(0.0, 0.0, 0.0),
            distance: 2.0,
            azimuth: 0.0,
            elevation: 0.0,
            field_of_view: std::f64::consts::FRAC_PI_2,
        };
        View::new(&camera, Size::new(200, 100), Rect::from_min_max(pos2(10.0, 20.0), pos2(410.0, 220.0)))
    }

    fn near(seen: Option<Pos2>, expected: Pos2) {
        assert!(seen.is_some_and(|seen| (seen - expected).length() < 1e-2), "{seen:?} {expected:?}");
    }

    #[test]
    fn the_target_is_in_the_middle_left_is_left_and_up_is_up() {
        let view = view_from_behind();
        near(view.point(&at(0.0, 0.0, 0.0)), pos2(210.0, 120.0));
        // At the target's distance the picture is 4 m high, so 1 m is a quarter of it.
        near(view.point(&at(0.0, 0.0, 1.0)), pos2(210.0, 70.0));
        near(view.point(&at(0.0, 1.0, 0.0)), pos2(160.0, 120.0));
    }

    #[test]
    fn a_line_that_passes_the_camera_is_cut_and_one_behind_it_is_gone() {
        let view = view_from_behind();
        let [from, to] = view.line(&at(0.0, 0.0, 0.0), &at(-5.0, 0.1, 0.0)).unwrap();
        near(Some(from), pos2(210.0, 120.0));
        assert!(to.x < 210.0 && to.x.is_finite() && (to.y - 120.0).abs() < 1e-3, "{to:?}");
        assert!(view.line(&at(-3.0, 0.0, 0.0), &at(-4.0, 0.0, 0.0)).is_none());
        assert!(view.point(&at(-3.0, 0.0, 0.0)).is_none());
    }

    #[test]
    fn shifting_moves_what_is_at_the_target_with_the_pointer() {
        let camera = OrbitCamera::default();
        let place = Rect::from_min_max(pos2(0.0, 0.0), pos2(300.0, 200.0));
        let view = View::new(&shifted(&camera, 30.0, -12.0, 200.0), Size::new(300, 200), place);
        near(view.point(&Position::new(camera.target.coords)), pos2(180.0, 88.0));
    }
}
