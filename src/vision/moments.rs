//! Moments of a one-channel picture: where its mass lies, how far it spreads and along which axis.

use super::Plane;

/// Moments of first and second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The sum of all values.
    pub weight: f64,
    /// The mean position, pixels of the plane.
    pub centre: (f64, f64),
    /// Variances along x and y and their covariance, pixels².
    covariance: (f64, f64, f64),
}

impl Moments {
    /// The mean variance, pixels²: proportional to the area of one shape at different sizes.
    pub fn spread(&self) -> f64 {
        0.5 * (self.covariance.0 + self.covariance.1)
    }

    /// The angle of the main axis, rad, within ±π/2.
    pub fn axis(&self) -> f64 {
        let (xx, yy, xy) = self.covariance;
        0.5 * (2.0 * xy).atan2(xx - yy)
    }

    /// Length over width: the square root of the variances' ratio, 1 for a disc.
    pub fn elongation(&self) -> f64 {
        let (xx, yy, xy) = self.covariance;
        let (mean, off) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        ((mean + off) / (mean - off).max(1e-6)).sqrt()
    }
}

impl Plane {
    /// Moments of the values taken as masses; `None` where they sum to nothing.
    pub fn moments(&self) -> Option<Moments> {
        let (mut weight, mut x1, mut y1) = (0.0, 0.0, 0.0);
        let place = |at: usize| ((at % self.width) as f64, (at / self.width) as f64);
        for (at, value) in self.data.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            let ((x, y), value) = (place(at), f64::from(*value));
            (weight, x1, y1) = (weight + value, x1 + value * x, y1 + value * y);
        }
        if weight <= 1e-6 {
            return None;
        }
        let centre = (x1 / weight, y1 / weight);
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for (at, value) in self.data.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            let ((x, y), value) = (place(at), f64::from(*value));
            let (dx, dy) = (x - centre.0, y - centre.1);
            (xx, yy, xy) = (xx + value * dx * dx, yy + value * dy * dy, xy + value * dx * dy);
        }
        Some(Moments { weight, centre, covariance: (xx / weight, yy / weight, xy / weight) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slanted_bar_gives_its_centre_axis_and_length() {
        let (sin, cos) = 0.5_f64.sin_cos();
        let bar = Plane::from_fn(120, 100, |x, y| {
            let (dx, dy) = (x as f64 - 60.0, y as f64 - 40.0);
            let (along, across) = (cos * dx + sin * dy, cos * dy - sin * dx);
            f32::from(u8::from(along.abs() < 30.0 && across.abs() < 6.0))
        });
        let moments = bar.moments().unwrap();
        assert!((moments.axis() - 0.5).abs() < 0.01, "{moments:?}");
        assert!((moments.centre.0 - 60.0).hypot(moments.centre.1 - 40.0) < 0.3, "{moments:?}");
        assert!((moments.elongation() - 5.0).abs() < 0.2, "{}", moments.elongation());
        assert_eq!(Plane::zeros(4, 4).moments(), None);
    }
}
