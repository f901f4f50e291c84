//! Colours for amounts of work: from black for none over red and yellow to white for the most.

use glam::DVec3;

use super::Picture;
use super::color::linear;

/// The colours of evenly spaced amounts, sRGB. Their lightness grows evenly too, so that more always looks brighter.
const SCALE: [[f64; 3]; 7] = [
    [0.00, 0.00, 0.02],
    [0.16, 0.04, 0.33],
    [0.45, 0.09, 0.43],
    [0.73, 0.21, 0.33],
    [0.93, 0.41, 0.14],
    [0.98, 0.70, 0.12],
    [0.99, 1.00, 0.80],
];

/// Turns a picture whose red is an amount of work into one that shows it, and notes the most. Amounts are shown by their roots:
/// a few pixels far above all others would leave the rest black.
pub(super) fn color(picture: &mut Picture) {
    let most = picture.color.iter().fold(0.0, |most: f32, it| most.max(it[0]));
    for color in &mut picture.color {
        let part = if most > 0.0 { f64::from(color[0] / most).sqrt() } else { 0.0 };
        let [red, green, blue] = linear(shade(part)).as_vec3().to_array();
        *color = [red, green, blue, 1.0];
    }
    picture.most_work = Some(most as u32);
}

/// The colour of a part of the most.
fn shade(part: f64) -> DVec3 {
    let place = part.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let below = (place as usize).min(SCALE.len() - 2);
    DVec3::from_array(SCALE[below]).lerp(DVec3::from_array(SCALE[below + 1]), place - below as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_work_is_always_brighter() {
        let brightness = |part: f64| linear(shade(part)).dot(DVec3::new(0.2126, 0.7152, 0.0722));
        for step in 0..100 {
            let part = f64::from(step) / 100.0;
            assert!(brightness(part) < brightness(part + 0.01), "{part}");
        }
    }
}
