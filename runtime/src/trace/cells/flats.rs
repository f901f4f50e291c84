//! The normals of flat faces that rays of a packet see, made several at once.

use glam::DVec3;
use pulp::Simd;

use crate::lanes::{EIGHT, Kernel, Mask, Wide3};
use crate::trace::Fragment;

/// Fragments on flat faces, whose normals point outwards and have any length.
#[derive(Default)]
pub(super) struct Flats(Vec<Flat>);

#[derive(Clone, Copy)]
struct Flat {
    /// The fragment's number.
    fragment: usize,
    /// Where the ray goes that sees it.
    direction: DVec3,
    /// Whether the normal is to be turned over; if that is not known, it is to point to where the ray comes from.
    turned: Option<bool>,
}

impl Flats {
    /// Adds a fragment that a ray of this direction sees, and whether its normal is to be turned over; if that is not known, it will point to
    /// where the ray comes from.
    #[inline(always)]
    pub(super) fn add(&mut self, fragment: usize, direction: DVec3, turned: Option<bool>) {
        self.0.push(Flat { fragment, direction, turned });
    }

    /// Gives the normals of all fragments added so far the length 1 and their side, and forgets these.
    #[inline]
    pub(super) fn straighten<K: Kernel>(&mut self, kernel: K, fragments: &mut [Fragment]) {
        if self.0.is_empty() {
            return;
        }
        kernel.vectorize(
            #[inline(always)]
            || straighten(kernel, &self.0, fragments),
        );
        self.0.clear();
    }
}

#[inline(always)]
fn straighten<K: Kernel>(kernel: K, flats: &[Flat], fragments: &mut [Fragment]) {
    let lanes = kernel.lanes();
    for flats in flats.chunks(EIGHT) {
        let (mut normals, mut directions) = ([[1.0; EIGHT]; 3], [[0.0; EIGHT]; 3]);
        for (lane, Flat { fragment, direction, .. }) in flats.iter().enumerate() {
            let normal = fragments[*fragment].normal;
            for axis in 0..3 {
                (normals[axis][lane], directions[axis][lane]) = (normal[axis], direction[axis]);
            }
        }
        let (normal, away) = upright(Wide3::of_arrays(lanes, normals), Wide3::of_arrays(lanes, directions));
        let away = kernel.bits(away.value);
        for (lane, Flat { fragment, turned, .. }) in flats.iter().enumerate() {
            let turned = turned.unwrap_or(away >> lane & 1 == 1);
            let normal = normal.lane(lane);
            fragments[*fragment].normal = if turned { -normal } else { normal };
        }
    }
}

/// Normals of length 1, and which of them point to where rays of these directions go.
#[inline(always)]
pub(super) fn upright<S: Simd>(normal: Wide3<S>, direction: Wide3<S>) -> (Wide3<S>, Mask<S>) {
    let normal = normal * (normal.x.all(1.0) / normal.dot(normal).sqrt());
    (normal, normal.dot(direction).gt(normal.x.all(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Origin;
    use crate::lanes::Plain;

    #[test]
    fn normals_have_length_one_and_are_turned_as_is_known_or_towards_the_ray() {
        let vector = |it: usize| {
            let angle = it as f64 + 0.5;
            DVec3::new(libm::sin(angle), libm::sin(1.7 * angle), libm::sin(2.9 * angle))
        };
        let (mut flats, mut fragments) = (Flats::default(), Vec::new());
        // More than are made at once, and one between them that is done already.
        for number in 0..21 {
            let normal = vector(number) * 3.0;
            fragments.push(Fragment::of_surface(1.0, DVec3::ZERO, normal, Origin::NONE));
            if number != 10 {
                flats.add(number, vector(number + 40), [None, Some(true), Some(false)][number % 3]);
            }
        }
        flats.straighten(Plain, &mut fragments);
        for (number, fragment) in fragments.iter().enumerate() {
            let (outwards, direction) = (vector(number) * 3.0, vector(number + 40));
            let turned = [outwards.dot(direction) > 0.0, true, false][number % 3];
            let unit = outwards.normalize();
            let expected = if number == 10 {
                outwards
            } else if turned {
                -unit
            } else {
                unit
            };
            assert_eq!(fragment.normal, expected, "{number}");
        }
        // They are forgotten.
        fragments.clear();
        flats.straighten(Plain, &mut fragments);
    }
}
