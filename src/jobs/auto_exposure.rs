//! Automatic exposure, as by an incident light meter.
//!
//! A meter of reflected light makes white models grey and dark ones pale, because it cannot know
//! what they reflect. Here the albedo is known: radiance without mirrors' reflections, divided by
//! the albedo, is the light on a surface. The exposure brings the upper quartile of that light to
//! [`KEY`], so that well-lit surfaces show their own colour, whatever the units of lamps. Neither
//! shadows on three quarters of the visible surfaces nor lamps on one quarter change it.

use phalanx_image::MAX_EXPOSURE;
use phalanx_render::Film;
use phalanx_render::frame::{
    AccelRef, Aov, Aovs, Control, FrameError, Integrator, Sampling, Settings, render_with,
};
use phalanx_scene::Scene;
use phalanx_scene::film::NO_HIT;
use phalanx_scene::lighting::luminance;
use phalanx_scene::sampling::log2;

/// Longest side of the picture that is measured, in pixels, whatever the size of the other.
const SIDE: u32 = 128;

/// Side of the squares that light is averaged over, in pixels, because one sample is noisy.
const SQUARE: usize = 4;

/// Light at the upper quartile: √¾, that of a matt sphere lit from the camera by a light of 1.
const KEY: f32 = 0.866;

/// Least albedo that is used. Mirrors, glass and lamps have less, and count as [`GREY`].
const LEAST_ALBEDO: f64 = 0.04;

/// Albedo of surfaces without one: in the light of [`KEY`], the brighter quarter of a picture whose
/// mean is middle grey.
const GREY: f64 = 0.4;

/// Number of steps per stop to which exposures are rounded, so that they are short in commands.
const STEPS: f64 = 64.0;

/// Exposure in stops that suits a picture. It depends on the whole frame, not on the region or
/// the samples of the settings, and is the same for every engine, kernel and number of threads.
///
/// The background does not count, nor do surfaces without any light. If nothing is left, or if the
/// picture is ambient occlusion, which is no light, the exposure is 0.
///
/// # Errors
/// Those of [`render_with`].
pub fn measure_exposure(
    scene: &Scene,
    tree: AccelRef,
    settings: &Settings,
    control: &Control,
) -> Result<f32, FrameError> {
    if matches!(settings.integrator, Integrator::Occlusion { .. }) {
        return Ok(0.0);
    }
    let longest = settings.width.max(settings.height).max(1);
    let shrunk = |side: u32| (side * SIDE).div_ceil(longest);
    let small = Settings {
        width: shrunk(settings.width),
        height: shrunk(settings.height),
        region: None,
        sampling: Sampling::CENTER,
        aovs: Aovs::default().with(Aov::Albedo).with(Aov::Direct),
        record_hits: true,
        ..settings.clone()
    };
    let film = render_with(scene, tree, &small, control)?.film;
    let mut lights = square_lights(&film);
    lights.sort_by(f32::total_cmp);
    let Some(&quartile) = lights.get(lights.len() * 3 / 4) else {
        return Ok(0.0);
    };
    let stops = f64::from(log2(KEY)) - f64::from(quartile);
    let most = f64::from(MAX_EXPOSURE);
    // −0 becomes 0, so that it is shown as 0.
    Ok(((stops * STEPS).round() / STEPS).clamp(-most, most) as f32 + 0.0)
}

/// Logarithms to base 2 of the light on the surfaces in each square of the film.
fn square_lights(film: &Film) -> Vec<f32> {
    let (width, rows) = (film.width as usize, film.height as usize);
    let columns = width.div_ceil(SQUARE);
    let mut sums = vec![[0.0, 0.0]; columns * rows.div_ceil(SQUARE)];
    let hits = film.hits.iter().flat_map(|hits| &hits.prim_id);
    for (k, _) in hits.enumerate().filter(|(_, prim)| **prim != NO_HIT) {
        let luminance_at = |planes: &[Vec<f32>]| luminance([0, 1, 2].map(|c| planes[c][k]).into());
        let albedo = luminance_at(film.layer(Aov::Albedo)).min(1.0);
        let (seen, albedo) = if albedo < LEAST_ALBEDO {
            (&film.planes[..], GREY)
        } else {
            (film.layer(Aov::Direct), albedo)
        };
        let radiance = luminance_at(seen);
        // Neither NaN nor infinite values say how much light there is.
        if radiance.is_finite() {
            let sum = &mut sums[k / width / SQUARE * columns + k % width / SQUARE];
            *sum = [sum[0] + radiance.max(0.0), sum[1] + albedo];
        }
    }
    let lit = sums.iter().filter(|[radiance, _]| *radiance > 0.0);
    let light = |[radiance, albedo]: &[f64; 2]| (radiance / albedo) as f32;
    lit.map(|sum| log2(light(sum).clamp(f32::MIN_POSITIVE, f32::MAX)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five squares in a row: what is no light, matt, a mirror, the background, and black.
    #[test]
    fn squares_have_the_light_on_what_is_hit() {
        let side = SQUARE as u32;
        let layers = Aovs::default().with(Aov::Albedo).with(Aov::Direct);
        let mut film = Film::new(5 * side, side, true).with_aovs(layers);
        let mut hits = film.hits.take().unwrap_or_default();
        for k in 0..film.planes[0].len() {
            let (square, odd) = (k % (5 * SQUARE) / SQUARE, k % 2 == 0);
            let light = match square {
                0 if odd => [f32::NAN, f32::INFINITY, -1.0][k % 3],
                0 | 1 => 0.25,
                2 => 0.1,
                3 => 1e30,
                _ => 0.0,
            };
            let albedo = [0.5, 0.125, 0.01, 0.0, 0.5][square];
            // Reflections count only where the albedo is too small.
            let reflected = [0.0, 4.0, 0.1, 0.0, 0.0][square];
            for channel in 0..3 {
                film.planes[channel][k] = light + reflected;
                film.aov_planes[channel][k] = albedo;
                film.aov_planes[3 + channel][k] = light;
            }
            hits.prim_id[k] = if square == 3 { NO_HIT } else { 7 };
        }
        film.hits = Some(hits);
        let lights: Vec<f32> = square_lights(&film).into_iter().map(f32::exp2).collect();
        assert_eq!(lights.len(), 3, "{lights:?}");
        assert!((0.3..0.5).contains(&lights[0]), "{lights:?}");
        for (light, want) in lights[1..].iter().zip([2.0, 0.5]) {
            assert!((light - want).abs() < 1e-5, "{lights:?}");
        }
    }
}
