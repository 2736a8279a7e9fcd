//! What is measured of a method on an episode.

/// A figure of one method on one episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Metric {
    /// Mean distance of the robot's wrist, taken back to the human scene, to the human's.
    PositionError,
    /// SPARC of the wrist's path, mean over the sides.
    Sparc,
    /// Spectral arc length at a fixed cut-off, mean over the sides.
    Sal,
    /// Log dimensionless jerk, mean over the sides.
    Ldlj,
    /// Mean distance of wrist → fingertip vectors, the human's scaled to the robot's hand length.
    FingertipError,
    /// Root mean square angle between the lines of sight to the robot's wrist and to the track's: how far the overlay is
    /// off in the picture.
    SightError,
    /// Gap between the robot's thumb and index tips where the human pinches.
    PinchGap,
    /// Mean of the smallest distance of an arm joint to a limit, as a share of its range.
    LimitMargin,
    /// Largest joint speed as a share of its limit.
    VelocityPeak,
    /// Joints beyond a position or velocity limit, counted over all frames.
    LimitViolations,
    /// Share of the driven frames on which the method's own wrist target is reached.
    Reachable,
    /// Share of the scored frames on which a hand drives its arm.
    Driven,
}

impl Metric {
    /// All, in the order of tables.
    pub const ALL: [Self; 12] = [
        Self::PositionError,
        Self::Sparc,
        Self::Sal,
        Self::Ldlj,
        Self::FingertipError,
        Self::SightError,
        Self::PinchGap,
        Self::LimitMargin,
        Self::VelocityPeak,
        Self::LimitViolations,
        Self::Reachable,
        Self::Driven,
    ];

    /// Key in reports.
    pub const fn key(self) -> &'static str {
        match self {
            Self::PositionError => "position_error_cm",
            Self::Sparc => "sparc",
            Self::Sal => "sal",
            Self::Ldlj => "ldlj",
            Self::FingertipError => "fingertip_error_cm",
            Self::SightError => "sight_error_mrad",
            Self::PinchGap => "pinch_gap_cm",
            Self::LimitMargin => "limit_margin",
            Self::VelocityPeak => "velocity_peak",
            Self::LimitViolations => "limit_violations",
            Self::Reachable => "reachable",
            Self::Driven => "driven",
        }
    }

    /// What a reader sees, with the unit.
    pub const fn label(self) -> &'static str {
        match self {
            Self::PositionError => "wrist position error, cm",
            Self::Sparc => "SPARC, adaptive cut-off",
            Self::Sal => "spectral arc length, 10 Hz",
            Self::Ldlj => "log dimensionless jerk",
            Self::FingertipError => "fingertip vector error, cm",
            Self::SightError => "wrist off its line of sight, mrad",
            Self::PinchGap => "gap in pinches, cm",
            Self::LimitMargin => "joint-limit margin, share of range",
            Self::VelocityPeak => "peak joint speed, share of limit",
            Self::LimitViolations => "limit violations, joints × frames",
            Self::Reachable => "own target reached, share of frames",
            Self::Driven => "frames with a driven arm, share",
        }
    }

    /// Which direction is better.
    pub const fn better(self) -> &'static str {
        match self {
            Self::Sparc | Self::Sal | Self::Ldlj => "nearer 0",
            Self::LimitMargin | Self::Reachable | Self::Driven => "higher",
            _ => "lower",
        }
    }

    const fn index(self) -> usize {
        self as usize
    }
}

/// The figures of one method on one episode; what could not be measured is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scores([Option<f64>; Metric::ALL.len()]);

impl Scores {
    /// The figure of `metric`.
    pub const fn get(&self, metric: Metric) -> Option<f64> {
        self.0[metric.index()]
    }

    /// Sets a figure; what is not finite counts as not measured.
    pub fn set(&mut self, metric: Metric, value: Option<f64>) {
        self.0[metric.index()] = value.filter(|value| value.is_finite());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_metric_has_its_own_place_and_key() {
        let mut scores = Scores::default();
        for (number, metric) in Metric::ALL.into_iter().enumerate() {
            scores.set(metric, Some(number as f64));
        }
        for (number, metric) in Metric::ALL.into_iter().enumerate() {
            assert_eq!(scores.get(metric), Some(number as f64));
            assert_eq!(Metric::ALL.iter().filter(|other| other.key() == metric.key()).count(), 1);
        }
        scores.set(Metric::Sparc, Some(f64::NAN));
        assert_eq!(scores.get(Metric::Sparc), None);
    }
}
