//! What may be the background in shadow, and what the clip's own shadows look like.
//!
//! A dark sleeve on light ground of the same hue looks like shadow, but is darker than any. How dark they are is
//! learned from places where the background's texture shows through.

use super::texture::Texture;

/// Share of the light from which a place is lit.
const LIT: f32 = 0.95;
/// Share of the light from which a shadow is too faint to tell of others.
const FAINT: f32 = 0.85;
/// Width of a bin of shares of light.
const STEP: f32 = 0.05;
/// Bins from [`Shadows::default`]'s deepest up to [`FAINT`].
const BINS: usize = 10;
/// Textured places, of the commonest depth, that say something about the clip's shadows.
const ENOUGH: u32 = 200;
/// One in how many places, against the commonest depth, that still prove a depth.
const RARE: u32 = 5;
/// Whether a pixel may be the background in shadow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shade {
    No,
    /// Darker and of a similar hue: shadow if the background's texture shows through.
    Perhaps,
    /// Darker and of the very same hue.
    Surely,
}

/// What is known of the clip's shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shadows {
    /// Share of the lightness that the deepest leaves.
    deepest: f32,
}

impl Default for Shadows {
    fn default() -> Self {
        Self { deepest: 0.35 }
    }
}

/// Share of the background's lightness that is left.
fn share_of_light(pixel: [u8; 3], background: [u8; 3]) -> f32 {
    f32::from(pixel[0]) / f32::from(background[0]).max(1.0)
}

impl Shadows {
    /// Whether a shadow may leave as little as this share of the lightness.
    pub fn reach(&self, light: f32) -> bool {
        light >= self.deepest
    }

    /// Whether `pixel` may be `background` in shadow, which scales lightness and with it chroma (both in OpenCV's
    /// 8-bit Lab).
    pub fn shade(&self, pixel: [u8; 3], background: [u8; 3]) -> Shade {
        let light = share_of_light(pixel, background);
        if !(self.deepest..LIT).contains(&light) || background[0] < 40 {
            return Shade::No;
        }
        let chroma = |lab: [u8; 3]| [f32::from(lab[1]) - 128.0, f32::from(lab[2]) - 128.0];
        let (now, before) = (chroma(pixel), chroma(background));
        match (now[0] - light * before[0]).hypot(now[1] - light * before[1]) {
            error if error < 2.5 => Shade::Surely,
            error if error < 7.0 => Shade::Perhaps,
            _ => Shade::No,
        }
    }
}

/// How deep the shadows are through which the background's texture shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ProvenShadows {
    depths: [u32; BINS],
}

impl ProvenShadows {
    /// Counts `pixel`, which may be `background` in shadow, if `texture` proves it.
    pub fn add(&mut self, pixel: [u8; 3], background: [u8; 3], texture: Texture) {
        let light = share_of_light(pixel, background);
        let above = light - Shadows::default().deepest;
        if texture == Texture::Same && above >= 0.0 && light < FAINT {
            self.depths[((above / STEP) as usize).min(BINS - 1)] += 1;
        }
    }

    /// Counts what `other` has counted.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.depths.iter_mut().zip(other.depths) {
            *mine += theirs;
        }
    }

    /// What they have in common; `None` where they are too few.
    pub fn learned(&self) -> Option<Shadows> {
        let most = self.depths.iter().copied().max().filter(|most| *most >= ENOUGH)?;
        let deepest = self.depths.iter().position(|count| RARE * count >= most)?;
        // One bin more: noise, and the border of the bin.
        Some(Shadows { deepest: Shadows::default().deepest + STEP * deepest.saturating_sub(1) as f32 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUND: [u8; 3] = [180, 133, 146];

    #[test]
    fn shadow_scales_lightness_and_chroma_and_skin_does_not_pass_for_it() {
        let shadows = Shadows::default();
        assert_eq!(shadows.shade([120, 131, 140], GROUND), Shade::Surely);
        assert_eq!(shadows.shade([150, 148, 148], [200, 130, 135]), Shade::No);
        assert_eq!(shadows.shade([190, 133, 146], GROUND), Shade::No);
    }

    #[test]
    fn what_is_darker_than_any_shadow_with_texture_in_it_is_no_shadow() {
        let (shadow, sleeve) = ([148, 132, 143], [90, 130, 137]);
        let mut proven = ProvenShadows::default();
        assert_eq!(proven.learned(), None);
        for _ in 0..300 {
            proven.add(shadow, GROUND, Texture::Same);
            proven.add(sleeve, GROUND, Texture::Flat);
        }
        let learned = proven.learned().unwrap();
        assert_eq!(Shadows::default().shade(sleeve, GROUND), Shade::Surely);
        assert_eq!(learned.shade(sleeve, GROUND), Shade::No);
        assert_eq!(learned.shade(shadow, GROUND), Shade::Surely);
    }
}
