//! Routes: the choices and copies that lead to a solid.

use crate::eval::spread;

/// The choices and copies on a stretch of the way to a solid.
///
/// Stretches join ([`Route::then`]) in any grouping to the same whole, so the route to a solid does not depend on how the states
/// on the way were merged: each is a map x -> factor * x + offset modulo 2^64, and joining composes the maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Route {
    factor: u64,
    offset: u64,
}

impl Route {
    /// No step at all.
    pub const START: Self = Self { factor: 1, offset: 0 };

    /// One step, told apart from others by a number.
    pub fn step(number: u64) -> Self {
        // Odd factors have inverses, so nothing that went before is lost.
        Self { factor: spread(number) | 1, offset: spread(!number) }
    }

    /// This stretch, and then another.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self {
            factor: self.factor.wrapping_mul(next.factor),
            offset: next.factor.wrapping_mul(self.offset).wrapping_add(next.offset),
        }
    }

    /// A hash of the whole.
    pub fn hash(self) -> u64 {
        spread(self.factor ^ spread(self.offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_route_is_the_same_however_it_is_grouped() {
        let [a, b, c] = [Route::step(1), Route::step(2), Route::step(3)];
        assert_eq!(a.then(b).then(c), a.then(b.then(c)));
        assert_ne!(a.then(b).hash(), b.then(a).hash());
        assert_eq!(Route::START.then(a), a);
    }
}
