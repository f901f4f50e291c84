//! The parts on the way to a primitive.

use std::fmt;

/// Parts before the last one that are held in place.
const SHORT: usize = 12;

/// Instead of the number of a part: none.
const NONE: u32 = u32::MAX;

/// The numbers of the parts on the way to a primitive, from the outermost to its own: below `u32::MAX` each.
///
/// Each ray that hits has one, and so has each shadow ray. Most have few parts, and differ from the one before in the last alone: so
/// that is by itself, and the others are copied as a whole, without a look at how many there are.
#[derive(Clone)]
pub struct Path {
    /// All parts but the last, and then none; no part at all if there are more.
    short: [u32; SHORT],
    last: u32,
    long: Option<Box<Long>>,
}

/// Parts that are more, the last one with them.
#[derive(Clone)]
struct Long(Vec<u32>);

impl Path {
    /// A way of these parts that has no last one yet: see [`Path::to`].
    pub(crate) fn way(parts: &[u32]) -> Self {
        let mut short = [NONE; SHORT];
        match short.get_mut(..parts.len()) {
            Some(held) => {
                held.copy_from_slice(parts);
                Self { short, last: NONE, long: None }
            }
            None => Self { short, last: NONE, long: Some(Box::new(Long(parts.to_vec()))) },
        }
    }

    /// This way, and a last part.
    #[inline(always)]
    pub(crate) fn to(&self, part: u32) -> Self {
        if self.long.is_some() {
            return self.far_to(part);
        }
        Self { short: self.short, last: part, long: None }
    }

    #[cold]
    fn far_to(&self, part: u32) -> Self {
        self.parts().chain([part]).collect()
    }

    /// Makes this the way `way`, and a last part.
    #[inline(always)]
    pub(crate) fn lead(&mut self, way: &Self, part: u32) {
        (self.short, self.last) = (way.short, part);
        if way.long.is_some() || self.long.is_some() {
            *self = way.to(part);
        }
    }

    /// The part at a place.
    #[inline(always)]
    pub fn part(&self, place: usize) -> Option<u32> {
        let part = match &self.long {
            Some(long) => *long.0.get(place)?,
            None => match self.short.get(place).copied().unwrap_or(NONE) {
                NONE if place == 0 || *self.short.get(place - 1)? != NONE => self.last,
                part => part,
            },
        };
        (part != NONE).then_some(part)
    }

    /// The parts.
    pub fn parts(&self) -> impl Iterator<Item = u32> {
        (0..).map_while(|it| self.part(it))
    }

    /// Whether its first parts are these.
    pub(crate) fn starts_with(&self, parts: &[u32]) -> bool {
        parts.iter().enumerate().all(|(place, it)| self.part(place) == Some(*it))
    }

    /// Becomes another one, which is not to be used any more.
    #[inline(always)]
    pub(crate) fn take(&mut self, other: &mut Self) {
        (self.short, self.last) = (other.short, other.last);
        self.long = other.long.take();
    }
}

impl Default for Path {
    fn default() -> Self {
        Self { short: [NONE; SHORT], last: NONE, long: None }
    }
}

impl FromIterator<u32> for Path {
    fn from_iter<I: IntoIterator<Item = u32>>(parts: I) -> Self {
        let parts: Vec<u32> = parts.into_iter().collect();
        match parts.split_last() {
            Some((last, way)) if way.len() <= SHORT => Self { last: *last, ..Self::way(way) },
            _ => Self::way(&parts),
        }
    }
}

impl PartialEq for Path {
    fn eq(&self, other: &Self) -> bool {
        self.parts().eq(other.parts())
    }
}

impl Eq for Path {}

impl fmt::Debug for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.parts()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_of_any_length_are_what_they_were_made_of() {
        for length in 0..30 {
            let parts: Vec<u32> = (0..length).map(|it| it * 7).collect();
            let path: Path = parts.iter().copied().collect();
            assert_eq!(path.parts().collect::<Vec<_>>(), parts);
            assert_eq!(path.clone(), path);
            for place in 0..32 {
                assert_eq!(path.part(place), parts.get(place).copied(), "{length} {place}");
            }
            let longer = Path::way(&parts).to(5);
            assert_eq!(longer.parts().collect::<Vec<_>>(), [&*parts, &[5]].concat());
            assert!(longer.starts_with(&parts) && !longer.starts_with(&[&*parts, &[6]].concat()));
            assert!(!longer.starts_with(&[&*parts, &[5, 5]].concat()));
            assert_ne!(longer, path);
            let (mut other, mut third) = (path.clone(), Path::default());
            other.lead(&Path::way(&parts), 5);
            assert_eq!(other, longer);
            third.take(&mut other);
            assert_eq!(third, longer);
        }
    }
}
