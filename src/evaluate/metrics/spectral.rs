//! Spectral arc length of a speed profile: how many sub-movements a movement is made of.
//!
//! The longer the outline of the speed's normalised amplitude spectrum, the less smooth the movement; values are
//! negative, and nearer to zero is smoother. Two forms are had side by side, because the adaptive one can be
//! fooled: white jitter raises the mean speed, by which the spectrum is normalised, and then looks smoother.

use realfft::RealFftPlanner;

/// Parameters of [`sparc`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralParams {
    /// Powers of two that the profile is padded by with zeros beyond the next power of two (4).
    pub padding: u32,
    /// Highest frequency that counts, Hz (10); at most half the sampling rate is used.
    pub cutoff_hz: f64,
    /// Share of the largest amplitude below which the spectrum's tail is cut off (0.05).
    pub threshold: f64,
}

impl Default for SpectralParams {
    /// The reference's: padding 4, 10 Hz, 0.05.
    fn default() -> Self {
        Self { padding: 4, cutoff_hz: 10.0, threshold: 0.05 }
    }
}

/// SPARC, the spectral arc length with an adaptive cut-off (Balasubramanian et al. 2015, "On the analysis of movement
/// smoothness"), of `speed` sampled at `fps`.
///
/// The amplitude spectrum M is normalised by its largest value; from the first to the last bin below `cutoff_hz` with
/// M ≥ `threshold` the lengths √((Δf / (f_b − f_a))² + ΔM²) are summed and negated. `None` for fewer than 4 samples,
/// values that are not finite, a standstill, or a spectrum of a single bin.
pub fn sparc(speed: &[f64], fps: f64, params: &SpectralParams) -> Option<f64> {
    let spectrum = Spectrum::new(speed, fps, params.padding, params.cutoff_hz)?;
    let last = spectrum.amplitudes.iter().rposition(|amplitude| *amplitude >= params.threshold)?;
    let first = spectrum.amplitudes.iter().position(|amplitude| *amplitude >= params.threshold)?;
    (last > first).then(|| spectrum.arc(first, last, (last - first) as f64 * spectrum.bin_hz))
}

/// The spectral arc length with a fixed cut-off (Balasubramanian et al. 2012) of `speed` sampled at `fps`: all bins up
/// to `cutoff_hz` count, whatever their amplitude. At 10 Hz it orders paths with and without jitter as they should be.
///
/// `None` as in [`sparc`].
pub fn sal_fixed(speed: &[f64], fps: f64, cutoff_hz: f64) -> Option<f64> {
    let spectrum = Spectrum::new(speed, fps, SpectralParams::default().padding, cutoff_hz)?;
    let last = spectrum.amplitudes.len() - 1;
    (last > 0).then(|| spectrum.arc(0, last, spectrum.cutoff_hz))
}

/// The normalised amplitude spectrum up to a cut-off.
struct Spectrum {
    amplitudes: Vec<f64>,
    bin_hz: f64,
    cutoff_hz: f64,
}

impl Spectrum {
    fn new(speed: &[f64], fps: f64, padding: u32, cutoff_hz: f64) -> Option<Self> {
        let usable = speed.len() >= 4 && speed.iter().all(|value| value.is_finite());
        if !(usable && fps.is_finite() && fps > 0.0 && cutoff_hz > 0.0) {
            return None;
        }
        let length = speed.len().next_power_of_two() << padding;
        let fft = RealFftPlanner::<f64>::new().plan_fft_forward(length);
        let mut input = fft.make_input_vec();
        input[..speed.len()].copy_from_slice(speed);
        let mut output = fft.make_output_vec();
        fft.process(&mut input, &mut output).ok()?;
        let mut amplitudes: Vec<f64> = output.iter().map(|value| value.norm()).collect();
        let largest = amplitudes.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let bin_hz = fps / length as f64;
        let cutoff_hz = cutoff_hz.min(0.5 * fps);
        let bins = (0..amplitudes.len()).take_while(|bin| *bin as f64 * bin_hz <= cutoff_hz).count();
        amplitudes.truncate(bins);
        for amplitude in &mut amplitudes {
            *amplitude /= largest;
        }
        Some(Self { amplitudes, bin_hz, cutoff_hz })
    }

    /// Minus the length of the outline from bin `first` to bin `last`, frequencies divided by `width_hz`.
    fn arc(&self, first: usize, last: usize, width_hz: f64) -> f64 {
        let along = self.bin_hz / width_hz;
        let pairs = self.amplitudes[first..=last].windows(2);
        -pairs.map(|pair| along.hypot(pair[1] - pair[0])).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::Vector3;
    use proptest::prelude::*;

    use super::*;
    use crate::evaluate::metrics::speed;

    /// Speed of a minimum-jerk movement of `seconds`.
    fn minimum_jerk(seconds: f64, fps: f64) -> Vec<f64> {
        let samples = (seconds * fps).round() as usize + 1;
        let at = |k: usize| k as f64 / fps / seconds;
        (0..samples).map(at).map(|x| 30.0 * x.powi(2) - 60.0 * x.powi(3) + 30.0 * x.powi(4)).collect()
    }

    fn together(length: usize, parts: &[(usize, f64)]) -> Vec<f64> {
        let mut speed = vec![0.0; length];
        for (start, scale) in parts {
            for (place, value) in speed[*start..].iter_mut().zip(minimum_jerk(1.0, 30.0)) {
                *place += scale * value;
            }
        }
        speed
    }

    fn helix() -> Vec<Vector3<f64>> {
        (0..61)
            .map(|k| {
                let x = f64::from(k) / 60.0;
                let s = 10.0 * x.powi(3) - 15.0 * x.powi(4) + 6.0 * x.powi(5);
                Vector3::new(0.1 * (2.0 * PI * s).cos(), 0.1 * (2.0 * PI * s).sin(), 0.2 * s)
            })
            .collect()
    }

    /// Central differences inside, one-sided ones at the ends.
    fn central(path: &[Vector3<f64>], fps: f64) -> Vec<f64> {
        let last = path.len() - 1;
        let at = |k: usize| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            (path[b] - path[a]).norm() * fps / (b - a) as f64
        };
        (0..=last).map(at).collect()
    }

    #[test]
    fn both_forms_meet_the_published_vectors() {
        let t30 = |k: i32| f64::from(k) / 30.0;
        let gaussian = (0..200).map(|k| (-5.0 * (-1.0 + 0.01 * f64::from(k)).powi(2)).exp()).collect();
        let impulse = (0..64).map(|k| if k == 0 { 1.0 } else { 0.0 }).collect();
        let table: [(&str, Vec<f64>, f64, f64, f64); 13] = [
            ("A", gaussian, 100.0, -1.414_031_261_710, -1.859_354_571_202),
            ("B", minimum_jerk(1.0, 30.0), 30.0, -1.400_412_748_759, -1.865_984_976_821),
            ("C", minimum_jerk(2.0, 30.0), 30.0, -1.400_407_742_538, -1.961_836_685_282),
            ("D", minimum_jerk(1.0, 100.0), 100.0, -1.405_829_324_421, -1.866_187_450_718),
            ("E", together(61, &[(0, 1.0), (30, 1.0)]), 30.0, -2.292_510_959_646, -2.952_662_153_925),
            ("F", together(61, &[(0, 1.0), (24, 0.5)]), 30.0, -1.649_349_351_960, -2.139_016_491_336),
            ("G", vec![1.0; 90], 30.0, -2.415_874_046_850, -3.485_185_147_103),
            (
                "H",
                (0..90).map(|k| 1.0 + 0.5 * (4.0 * PI * t30(k)).sin()).collect(),
                30.0,
                -2.922_759_048_484,
                -3.837_437_220_666,
            ),
            (
                "I",
                (0..=90).map(|k| (PI * f64::from(k) / 90.0).sin()).collect(),
                30.0,
                -1.566_135_412_830,
                -2.124_248_340_778,
            ),
            (
                "J",
                (0..300).map(|k| (PI * t30(k)).sin().abs()).collect(),
                30.0,
                -4.031_311_904_757,
                -4.662_087_379_457,
            ),
            ("L", impulse, 30.0, -1.0, -0.999_023_437_5),
            ("M", speed(&helix(), 30.0), 30.0, -1.400_677_871_276, -1.962_420_513_206),
            ("N", central(&helix(), 30.0), 30.0, -1.401_474_447_606, -1.964_066_946_905),
        ];
        for (name, speed, fps, adaptive, fixed) in table {
            let found = sparc(&speed, fps, &SpectralParams::default()).unwrap();
            assert!((found - adaptive).abs() < 1e-9, "{name}: SPARC {found} instead of {adaptive}");
            let found = sal_fixed(&speed, fps, 10.0).unwrap();
            assert!((found - fixed).abs() < 1e-9, "{name}: SAL {found} instead of {fixed}");
        }
    }

    #[test]
    fn more_movements_in_a_row_are_less_smooth() {
        for (count, expected) in [(1, -1.4004), (2, -2.2925), (3, -2.6896), (5, -3.3630), (8, -3.8004)] {
            let parts: Vec<(usize, f64)> = (0..count).map(|k| (30 * k, 1.0)).collect();
            let found = sparc(&together(30 * count + 1, &parts), 30.0, &SpectralParams::default()).unwrap();
            assert!((found - expected).abs() < 5e-5, "{count}: {found}");
        }
    }

    #[test]
    fn what_has_no_spectrum_has_no_smoothness() {
        let params = SpectralParams::default();
        for speed in [vec![], vec![1.0; 3], vec![0.0; 50], vec![f64::NAN; 50]] {
            assert_eq!((sparc(&speed, 30.0, &params), sal_fixed(&speed, 30.0, 10.0)), (None, None));
        }
        assert_eq!(sparc(&[1.0; 50], 0.0, &params), None);
    }

    #[test]
    fn a_cutoff_beyond_half_the_rate_means_half_the_rate() {
        let speed = minimum_jerk(2.0, 15.0);
        assert_eq!(sal_fixed(&speed, 15.0, 10.0), sal_fixed(&speed, 15.0, 7.5));
    }

    proptest! {
        #[test]
        fn size_does_not_matter(
            speed in prop::collection::vec(0.0_f64..2.0, 4..150),
            power in -12_i32..12,
        ) {
            prop_assume!(speed.iter().any(|value| *value > 0.0));
            // Powers of two scale without rounding, so that equal means equal.
            let scaled: Vec<f64> = speed.iter().map(|value| value * 2.0_f64.powi(power)).collect();
            let params = SpectralParams::default();
            prop_assert_eq!(sparc(&speed, 30.0, &params), sparc(&scaled, 30.0, &params));
            prop_assert_eq!(sal_fixed(&speed, 30.0, 10.0), sal_fixed(&scaled, 30.0, 10.0));
            let jerk = crate::evaluate::metrics::log_dimensionless_jerk;
            match (jerk(&speed, 30.0), jerk(&scaled, 30.0)) {
                (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b),
                (a, b) => prop_assert_eq!(a, b),
            }
        }
    }
}
