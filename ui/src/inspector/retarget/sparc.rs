//! Spectral arc length: how smooth a movement is.

/// Above this frequency nothing is movement, Hz.
const CUTOFF: f64 = 10.0;
/// The spectrum ends where it stays below this share of its peak.
const THRESHOLD: f64 = 0.05;
/// Shorter movements have no spectrum to speak of.
const SHORTEST: usize = 8;
/// At most so many frequencies are looked at, so that a clip of minutes does not hold up a frame.
const MOST_FREQUENCIES: usize = 3000;

/// Spectral arc length (Balasubramanian et al. 2015) of a speed profile sampled at `rate` Hz: the negative length of
/// the normalised spectrum's curve. `None` where nothing moves or too little is seen.
pub fn sparc(speed: &[f64], rate: f64) -> Option<f64> {
    if speed.len() < SHORTEST {
        return None;
    }
    let highest = CUTOFF.min(0.5 * rate);
    // Eight points a lobe of the spectrum's finest detail draw its curve well.
    let count = ((8.0 * speed.len() as f64 * highest / rate).ceil() as usize).clamp(2, MOST_FREQUENCIES);
    let step = highest / count as f64;
    let spectrum: Vec<f64> = (0..=count).map(|k| magnitude(speed, step * k as f64 / rate)).collect();
    let peak = spectrum.iter().copied().fold(0.0, f64::max);
    if !(peak.is_finite() && peak > 1e-9) {
        return None;
    }
    let last = spectrum.iter().rposition(|value| *value >= THRESHOLD * peak)?.max(1);
    let run = 1.0 / last as f64;
    let length: f64 = spectrum[..=last].windows(2).map(|pair| run.hypot((pair[1] - pair[0]) / peak)).sum();
    Some(-length)
}

/// Magnitude of the spectrum at `frequency` cycles a sample; the phasor is turned on instead of computed anew.
fn magnitude(speed: &[f64], frequency: f64) -> f64 {
    let (turn_sin, turn_cos) = (std::f64::consts::TAU * frequency).sin_cos();
    let (mut cos, mut sin, mut real, mut imaginary) = (1.0, 0.0, 0.0, 0.0);
    for value in speed {
        real += value * cos;
        imaginary += value * sin;
        (cos, sin) = (cos * turn_cos - sin * turn_sin, sin * turn_cos + cos * turn_sin);
    }
    f64::hypot(real, imaginary)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach() -> Vec<f64> {
        (0..=60).map(|t| f64::from(t) / 60.0).map(|t| 30.0 * t * t * (1.0 - t) * (1.0 - t)).collect()
    }

    #[test]
    fn a_reach_of_least_jerk_scores_as_published_whatever_its_speed() {
        let smooth = sparc(&reach(), 30.0).unwrap();
        assert!((-1.7..-1.3).contains(&smooth), "{smooth}");
        let faster: Vec<f64> = reach().iter().map(|v| 5.0 * v).collect();
        assert!((sparc(&faster, 30.0).unwrap() - smooth).abs() < 1e-9);
    }

    #[test]
    fn trembling_costs() {
        let tremble = |t: usize| 0.3 * (1.0 + (t as f64 * 1.3).sin());
        let shaky: Vec<f64> = reach().iter().enumerate().map(|(t, v)| v + tremble(t)).collect();
        assert!(sparc(&shaky, 30.0).unwrap() < sparc(&reach(), 30.0).unwrap() - 0.3);
    }

    #[test]
    fn standing_still_has_no_smoothness() {
        assert_eq!(sparc(&[0.0; 30], 30.0), None);
        assert_eq!(sparc(&[1.0; 3], 30.0), None);
    }
}
