//! A method and its parameters, under a name.

use crate::retarget::{Beta, Method, RetargetParams, Smoothing};

/// What is compared with what.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Its name in reports.
    pub name: String,
    /// Method and parameters.
    pub params: RetargetParams,
}

impl Setting {
    /// A method as it ships.
    pub fn of_method(method: Method) -> Self {
        let params = RetargetParams { method, ..RetargetParams::default() };
        Self { name: method.name().to_owned(), params }
    }

    /// Our method with other smoothing.
    pub fn smoothed(alpha: f64, smoothing: Smoothing, beta: Beta) -> Self {
        let word = match smoothing {
            Smoothing::None => "none",
            Smoothing::Ema => "ema",
            Smoothing::ZeroPhase => "zero_phase",
        };
        let scale = match beta {
            Beta::Fit => String::new(),
            Beta::Fixed(beta) => format!(" beta={beta}"),
        };
        let name = match smoothing {
            Smoothing::None => format!("none{scale}"),
            _ => format!("{word} alpha={alpha}{scale}"),
        };
        Self { name, params: RetargetParams { alpha, smoothing, beta, ..RetargetParams::default() } }
    }
}
