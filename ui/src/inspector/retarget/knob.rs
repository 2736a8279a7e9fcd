//! The parameters one can turn, each a number with a unit, a range and a default.

use agenticfocus::{
    geometry::Side,
    retarget::{Beta, CameraAngles, CameraRotation, RetargetParams, Smoothing},
    session::RetargetSettings,
};

use super::angles::angles_of;
use crate::inspector::parts::Parameter;

/// A parameter of retargeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knob {
    /// Scale β.
    Beta,
    /// Camera downwards, degrees.
    Pitch,
    /// Camera to the left, degrees.
    Yaw,
    /// Camera about its axis, degrees.
    Roll,
    /// Camera forward of the torso, centimetres.
    X,
    /// Camera left of the torso, centimetres.
    Y,
    /// Camera above the torso, centimetres.
    Z,
    /// Smoothing α.
    Alpha,
    /// A hand about its wrist, degrees.
    Wrist(Side, Turn),
}

/// About which axis a wrist is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// The forearm's.
    Roll,
    /// Fingers up or down.
    Pitch,
    /// Fingers to the side.
    Yaw,
}

impl Knob {
    /// The scale and the camera, in the order they are shown.
    pub const CAMERA: [Self; 7] = [Self::Beta, Self::Pitch, Self::Yaw, Self::Roll, Self::X, Self::Y, Self::Z];
    /// The wrists, in the order they are shown.
    pub const WRISTS: [Self; 6] = [
        Self::Wrist(Side::Left, Turn::Roll),
        Self::Wrist(Side::Left, Turn::Pitch),
        Self::Wrist(Side::Left, Turn::Yaw),
        Self::Wrist(Side::Right, Turn::Roll),
        Self::Wrist(Side::Right, Turn::Pitch),
        Self::Wrist(Side::Right, Turn::Yaw),
    ];

    /// All there are.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::CAMERA.into_iter().chain([Self::Alpha]).chain(Self::WRISTS)
    }

    /// How its row looks.
    pub(super) fn row(self) -> Parameter<'static> {
        let row = |name, hint, unit, range, limits, decimals| Parameter {
            name,
            hint,
            unit,
            range,
            limits,
            decimals,
        };
        match self {
            Self::Beta => {
                row("β", "How far the robot reaches where the hand reaches 1 m", "", 0.4..=1.6, 0.05..=5.0, 3)
            }
            Self::Pitch => row("Pitch", "Camera turned downwards", "°", 0.0..=90.0, -180.0..=180.0, 1),
            Self::Yaw => row("Yaw", "Camera turned to the left", "°", -45.0..=45.0, -180.0..=180.0, 1),
            Self::Roll => {
                row("Roll", "Camera turned clockwise about its axis", "°", -45.0..=45.0, -180.0..=180.0, 1)
            }
            Self::X => row("x", "Camera forward of the torso", " cm", -40.0..=40.0, -1000.0..=1000.0, 2),
            Self::Y => row("y", "Camera left of the torso", " cm", -40.0..=40.0, -1000.0..=1000.0, 2),
            Self::Z => row("z", "Camera above the torso", " cm", 0.0..=80.0, -1000.0..=1000.0, 2),
            Self::Alpha => row("α", "Smoothing of joint angles: 1 is none", "", 0.05..=1.0, 0.01..=1.0, 2),
            Self::Wrist(side, turn) => {
                let name = match (side, turn) {
                    (Side::Left, Turn::Roll) => "L roll",
                    (Side::Left, Turn::Pitch) => "L pitch",
                    (Side::Left, Turn::Yaw) => "L yaw",
                    (Side::Right, Turn::Roll) => "R roll",
                    (Side::Right, Turn::Pitch) => "R pitch",
                    (Side::Right, Turn::Yaw) => "R yaw",
                };
                let hint = match turn {
                    Turn::Roll => "Hand turned about the forearm, clockwise from the elbow",
                    Turn::Pitch => "Fingers turned down where the thumb is up",
                    Turn::Yaw => "Fingers turned to the left where the thumb is up",
                };
                row(name, hint, "°", -45.0..=45.0, -180.0..=180.0, 1)
            }
        }
    }

    /// Its value in `settings`, or its default; `fitted` stands for β where β is fitted.
    pub fn value(self, settings: &RetargetSettings, fitted: Option<f64>) -> f64 {
        let defaults = RetargetParams::default();
        let angles = angles_of(&settings.camera_rotation.unwrap_or(defaults.camera));
        let offset = settings.offset.unwrap_or_else(|| defaults.offset.into());
        match self {
            Self::Beta => match settings.beta {
                Some(Beta::Fixed(beta)) => beta,
                Some(Beta::Fit) | None => fitted.unwrap_or(1.0),
            },
            Self::Pitch => angles.pitch_deg,
            Self::Yaw => angles.yaw_deg,
            Self::Roll => angles.roll_deg,
            Self::X => 100.0 * offset[0],
            Self::Y => 100.0 * offset[1],
            Self::Z => 100.0 * offset[2],
            Self::Alpha => settings.alpha.unwrap_or(defaults.alpha),
            Self::Wrist(side, Turn::Roll) => settings.wrist[side].roll_deg,
            Self::Wrist(side, Turn::Pitch) => settings.wrist[side].pitch_deg,
            Self::Wrist(side, Turn::Yaw) => settings.wrist[side].yaw_deg,
        }
    }

    /// Whether it differs from its default.
    pub fn is_changed(self, settings: &RetargetSettings) -> bool {
        match self {
            Self::Beta => matches!(settings.beta, Some(Beta::Fixed(_))),
            _ => {
                let default = self.value(&RetargetSettings::default(), None);
                (self.value(settings, None) - default).abs() > 1e-9
            }
        }
    }

    /// `settings` with it set to `value`. A group of values that are all defaults is left out again.
    pub fn with(self, settings: &RetargetSettings, value: f64) -> RetargetSettings {
        let mut settings = *settings;
        match self {
            Self::Beta => settings.beta = Some(Beta::Fixed(value)),
            Self::Pitch | Self::Yaw | Self::Roll => {
                let mut angles = angles_of(&settings.camera_rotation.unwrap_or_default());
                match self {
                    Self::Pitch => angles.pitch_deg = value,
                    Self::Yaw => angles.yaw_deg = value,
                    _ => angles.roll_deg = value,
                }
                let changed = !same_angles(&angles, &CameraAngles::default());
                settings.camera_rotation = changed.then_some(CameraRotation::Angles(angles));
            }
            Self::X | Self::Y | Self::Z => {
                let default: [f64; 3] = RetargetParams::default().offset.into();
                let mut offset = settings.offset.unwrap_or(default);
                let axis = match self {
                    Self::X => 0,
                    Self::Y => 1,
                    _ => 2,
                };
                offset[axis] = value / 100.0;
                let changed = offset.iter().zip(default).any(|(now, default)| (now - default).abs() > 1e-9);
                settings.offset = changed.then_some(offset);
            }
            Self::Alpha => settings.alpha = Some(value),
            Self::Wrist(side, Turn::Roll) => settings.wrist[side].roll_deg = value,
            Self::Wrist(side, Turn::Pitch) => settings.wrist[side].pitch_deg = value,
            Self::Wrist(side, Turn::Yaw) => settings.wrist[side].yaw_deg = value,
        }
        settings
    }

    /// `settings` with it back at its default.
    pub fn reset(self, settings: &RetargetSettings) -> RetargetSettings {
        match self {
            Self::Beta => RetargetSettings { beta: None, ..*settings },
            Self::Alpha => RetargetSettings { alpha: None, ..*settings },
            _ => self.with(settings, self.value(&RetargetSettings::default(), None)),
        }
    }
}

/// How α is applied, with the default where nothing is set.
pub(super) fn smoothing_of(settings: &RetargetSettings) -> Smoothing {
    settings.smoothing.unwrap_or(RetargetParams::default().smoothing)
}

/// `settings` with another way of smoothing; the default is left out again.
pub(super) fn with_smoothing(settings: &RetargetSettings, smoothing: Smoothing) -> RetargetSettings {
    let changed = smoothing != RetargetParams::default().smoothing;
    RetargetSettings { smoothing: changed.then_some(smoothing), ..*settings }
}

fn same_angles(one: &CameraAngles, other: &CameraAngles) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
    same(one.pitch_deg, other.pitch_deg)
        && same(one.yaw_deg, other.yaw_deg)
        && same(one.roll_deg, other.roll_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_read_back_and_reset_leaves_nothing_behind() {
        let mut settings = RetargetSettings { hand_length: Some(0.19), ..RetargetSettings::default() };
        for (at, knob) in Knob::all().enumerate() {
            let value = 0.3 + 0.05 * at as f64;
            settings = knob.with(&settings, value);
            assert!((knob.value(&settings, None) - value).abs() < 1e-9, "{knob:?}");
            assert!(knob.is_changed(&settings), "{knob:?}");
        }
        for knob in Knob::all() {
            settings = knob.reset(&settings);
            assert!(!knob.is_changed(&settings), "{knob:?}");
        }
        assert_eq!(settings, RetargetSettings { hand_length: Some(0.19), ..RetargetSettings::default() });
    }

    #[test]
    fn a_fitted_beta_shows_what_was_fitted() {
        assert_eq!(Knob::Beta.value(&RetargetSettings::default(), Some(0.82)), 0.82);
        assert!(!Knob::Beta.is_changed(&RetargetSettings { beta: Some(Beta::Fit), ..Default::default() }));
    }

    #[test]
    fn sliders_cover_the_defaults_and_stay_inside_what_the_session_takes() {
        let mut document = agenticfocus::session::Document::default();
        for knob in Knob::all() {
            let row = knob.row();
            let default = knob.value(&RetargetSettings::default(), Some(0.9));
            assert!(row.range.contains(&default), "{knob:?}");
            for end in [row.range.start(), row.range.end(), row.limits.start(), row.limits.end()] {
                let settings = knob.with(&RetargetSettings::default(), *end);
                document.apply(agenticfocus::session::Command::SetRetarget(settings)).unwrap();
            }
        }
    }
}
