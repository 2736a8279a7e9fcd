//! What the samples of one place say about its background: its usual colour, and the same without a shadow.

use super::moved::differs;

/// One frame's colour of a place.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    pub colour: [u8; 3],
    /// Which of the frames that were read, as an index into their times.
    pub source: u8,
}

/// What the samples of one pixel say.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Settled {
    /// What is usual around the key frame's time.
    pub usual: [u8; 3],
    /// The brighter state that others show in the same hue, where there is one: no shadow lies on it.
    pub lit: Option<[u8; 3]>,
    /// A single brighter sample of the same hue, where there are not more: too little to tell a shadow by, enough where the
    /// clip's shadows darken as much.
    pub once: Option<[u8; 3]>,
    /// By which factors the lit state is brighter than the shadowed one, where both were seen.
    pub shadow: Option<[f32; 3]>,
}

/// The median of factors that are at least `enough` and agree among themselves.
pub(super) fn common_factor(mut ratios: [Vec<f32>; 3], enough: usize) -> Option<[f32; 3]> {
    let mut factor = [0.0; 3];
    for (factor, ratios) in factor.iter_mut().zip(&mut ratios) {
        if ratios.len() < enough {
            return None;
        }
        ratios.sort_unstable_by(f32::total_cmp);
        let at = |share: usize| ratios[(ratios.len() - 1) * share / 4];
        if at(3) > 1.3 * at(1) {
            return None;
        }
        *factor = at(2);
    }
    Some(factor)
}

/// Samples that say what is usual near the key frame's time.
const USUAL: usize = 7;
/// By how much a shadow may be deeper than the clip's shadows.
const SAME_FACTOR: f32 = 0.12;
/// Largest brightening that a shadow explains.
const DARKEST_SHADOW: f32 = 3.0;

/// Samples of one place at most.
pub(super) const MOST_SAMPLES: usize = 15;
/// A sample that looks like another within this many levels shows the same.
const SAME: u8 = 12;

/// `samples` nearest in time first, `times` of their sources in frames after the key frame; colours that differ
/// beyond light by more than `limit` levels show different states of the scene.
pub(super) fn settled(samples: &[Sample], times: &[i32], limit: f32) -> Settled {
    let mut colours = [[0_u8; 3]; MOST_SAMPLES];
    let mut count = 0;
    let side = side_of_change(samples, times, limit);
    for sample in samples.iter().filter(|sample| side.is_none_or(|side| side.holds(times, sample))) {
        colours[count] = sample.colour;
        count += 1;
    }
    settled_colours(&colours[..count])
}

/// Before or after the key frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Before,
    After,
}

impl Side {
    fn holds(self, times: &[i32], sample: &Sample) -> bool {
        let time = times[usize::from(sample.source)];
        if self == Self::Before { time <= 0 } else { time >= 0 }
    }
}

/// The nearer side, where all earlier samples show one thing and all later ones another: something was put there or
/// taken away behind the hand, and what was usual over the clip says nothing about the key frame's time.
fn side_of_change(samples: &[Sample], times: &[i32], limit: f32) -> Option<Side> {
    let (before, since) = state(samples, times, Side::Before)?;
    let (after, until) = state(samples, times, Side::After)?;
    differs(before, after, limit).then_some(if since <= until { Side::Before } else { Side::After })
}

/// What most samples of one side show, and how many frames away the nearest of them is; `None` where they are few or
/// disagree.
fn state(samples: &[Sample], times: &[i32], side: Side) -> Option<([u8; 3], i32)> {
    let on_side = || samples.iter().filter(|sample| side.holds(times, sample)).take(USUAL);
    let mut colours = [[0_u8; 3]; USUAL];
    let mut count = 0;
    for sample in on_side() {
        colours[count] = sample.colour;
        count += 1;
    }
    let colours = &mut colours[..count];
    colours.sort_unstable_by_key(luma);
    let pivot = *colours.get(count / 2)?;
    let agrees = |colour: [u8; 3]| {
        alike(colour, pivot) || is_lit_version(colour, pivot) || is_lit_version(pivot, colour)
    };
    let agreeing = colours.iter().filter(|colour| agrees(**colour)).count();
    if agreeing < 2 || 3 * agreeing < 2 * count {
        return None;
    }
    let away = on_side().filter(|sample| agrees(sample.colour));
    let nearest = away.map(|sample| times[usize::from(sample.source)].abs()).min()?;
    Some((mean_near(colours, pivot), nearest))
}

fn alike(a: [u8; 3], b: [u8; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= SAME)
}

/// `samples` nearest in time first.
fn settled_colours(samples: &[[u8; 3]]) -> Settled {
    if samples.is_empty() {
        return Settled::default();
    }
    let mut near = [[0_u8; 3]; USUAL];
    let near = &mut near[..samples.len().min(USUAL)];
    near.copy_from_slice(&samples[..near.len()]);
    near.sort_unstable_by_key(luma);
    // Of two, the brighter: shadows are commoner than highlights.
    let usual = mean_near(near, near[near.len() / 2]);
    let lit = lit_state(samples, usual);
    let bright = lit.unwrap_or(usual);
    let brighter = || samples.iter().copied().filter(|sample| is_lit_version(*sample, usual));
    let once = if lit.is_some() { None } else { brighter().max_by_key(luma) };
    Settled { usual, lit, once, shadow: shadow_factor(samples, bright) }
}

fn luma(c: &[u8; 3]) -> u32 {
    2 * u32::from(c[0]) + 5 * u32::from(c[1]) + u32::from(c[2])
}

/// The mean of those samples that resemble `pivot`.
fn mean_near(samples: &[[u8; 3]], pivot: [u8; 3]) -> [u8; 3] {
    let near = samples.iter().filter(|colour| alike(**colour, pivot));
    let (mut sum, mut count) = ([0_u32; 3], 0_u32);
    for colour in near {
        count += 1;
        for (sum, value) in sum.iter_mut().zip(colour) {
            *sum += u32::from(*value);
        }
    }
    sum.map(|sum| ((sum + count / 2) / count.max(1)) as u8)
}

/// A tight group of samples clearly brighter than `usual` and of its hue.
fn lit_state(samples: &[[u8; 3]], usual: [u8; 3]) -> Option<[u8; 3]> {
    let mut brighter = [[0_u8; 3]; 16];
    let mut count = 0;
    for sample in samples.iter().take(brighter.len()) {
        if is_lit_version(*sample, usual) {
            brighter[count] = *sample;
            count += 1;
        }
    }
    if count < 2 {
        return None;
    }
    let brighter = &mut brighter[..count];
    brighter.sort_unstable_by_key(luma);
    let pivot = brighter[(count * 3 / 4).min(count - 1 - usize::from(count > 2))];
    let similar = brighter.iter().filter(|colour| alike(**colour, pivot)).count();
    (similar >= 2 && 2 * similar >= count).then(|| mean_near(brighter, pivot))
}

/// By how much `bright` exceeds a tight group of samples that are the same in shadow.
fn shadow_factor(samples: &[[u8; 3]], bright: [u8; 3]) -> Option<[f32; 3]> {
    let mut darker = [[0_u8; 3]; 16];
    let mut count = 0;
    for sample in samples.iter().take(darker.len()).filter(|sample| is_lit_version(bright, **sample)) {
        darker[count] = *sample;
        count += 1;
    }
    let darker = &mut darker[..count];
    darker.sort_unstable_by_key(luma);
    let pivot = *darker.get(count / 2)?;
    let alike = darker.iter().filter(|c| c.iter().zip(pivot).all(|(a, b)| a.abs_diff(b) <= 8)).count();
    (alike >= 2 && 3 * alike >= 2 * count)
        .then(|| std::array::from_fn(|c| f32::from(bright[c]) / f32::from(pivot[c]).max(1.0)))
}

/// Whether `bright` is `dark` with a shadow taken off: all channels brighter by about one factor.
fn is_lit_version(bright: [u8; 3], dark: [u8; 3]) -> bool {
    let sum = |c: [u8; 3]| c.iter().map(|v| f32::from(*v)).sum::<f32>();
    let scale = sum(bright) / sum(dark).max(1.0);
    if !(1.09..=DARKEST_SHADOW).contains(&scale) || sum(bright) - sum(dark) < 24.0 {
        return false;
    }
    let tolerance = 5.0 + 0.25 * (sum(bright) - sum(dark)) / 3.0;
    bright.iter().zip(dark).all(|(b, d)| (f32::from(*b) - scale * f32::from(d)).abs() <= tolerance)
}

/// Whether `bright` is `dark` brightened by about `factor` or, as along the edges of shadows, by less.
pub(super) fn is_brighter_within(bright: [u8; 3], dark: [u8; 3], factor: [f32; 3]) -> bool {
    let ratio = |c: usize| f32::from(bright[c]) / f32::from(dark[c]).max(1.0);
    (0..3).all(|c| ratio(c) < factor[c] * (1.0 + SAME_FACTOR))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_frame_with_skin_on_it_does_not_tint_the_plate() {
        let samples = [[100, 90, 80], [102, 91, 79], [210, 160, 140], [101, 92, 81]];
        let mean = settled_colours(&samples).usual;
        assert!(mean[0].abs_diff(101) <= 1 && mean[1].abs_diff(91) <= 1 && mean[2].abs_diff(80) <= 1);
    }

    #[test]
    fn a_lit_state_of_the_same_hue_wins_over_a_shadow_that_lasts() {
        let shadow = [[62, 54, 46]; 6];
        let lit = [[100, 88, 75], [101, 88, 76]];
        let samples: Vec<[u8; 3]> = shadow.into_iter().chain(lit).collect();
        assert_eq!(settled_colours(&samples).lit.map(|c| c[0] / 10), Some(10));
        let other_hue = [[150, 60, 40], [151, 61, 40]];
        let samples: Vec<[u8; 3]> = shadow.into_iter().chain(other_hue).collect();
        assert_eq!(settled_colours(&samples).lit, None);
    }

    #[test]
    fn a_single_lit_sample_counts_where_it_is_brighter_by_no_more_than_the_shadows_of_the_clip() {
        let shadow = [62, 54, 46];
        let samples: Vec<[u8; 3]> = std::iter::repeat_n(shadow, 6).chain([[100, 88, 75]]).collect();
        let settled = settled_colours(&samples);
        assert_eq!((settled.lit, settled.once), (None, Some([100, 88, 75])));
        assert!(is_brighter_within([100, 88, 75], shadow, [1.6; 3]), "the shadow itself");
        assert!(is_brighter_within([80, 70, 60], shadow, [1.6; 3]), "its soft edge");
        assert!(!is_brighter_within([130, 114, 97], shadow, [1.6; 3]), "a highlight");
    }

    fn at(times: &[i32], colours: &[[u8; 3]]) -> Settled {
        let samples: Vec<Sample> =
            colours.iter().zip(0..).map(|(colour, source)| Sample { colour: *colour, source }).collect();
        settled(&samples, times, 24.0)
    }

    const GROUND: [u8; 3] = [120, 90, 40];
    const LID: [u8; 3] = [210, 180, 150];

    #[test]
    fn what_was_put_there_later_is_not_shown_before_it_even_if_most_samples_show_it() {
        let (times, colours) = ([-10, -14, 20, 24, 28, 32], [GROUND, GROUND, LID, LID, LID, LID]);
        assert_eq!(at(&times, &colours).usual, GROUND);
        let later = times.map(|time| time - 22);
        assert_eq!(at(&later, &colours).usual, LID, "nearer to the later state");
    }

    #[test]
    fn a_single_sample_or_a_shadow_is_no_change_of_the_scene() {
        let skin = at(&[-3, 10, 12, 14], &[LID, GROUND, GROUND, GROUND]);
        assert_eq!(skin.usual, GROUND);
        let shade = GROUND.map(|value| value / 2);
        let shadowed = at(&[-3, -5, 10, 12, 14], &[shade, shade, GROUND, GROUND, GROUND]);
        assert_eq!((shadowed.usual, shadowed.shadow.is_some()), (GROUND, true));
    }
}
