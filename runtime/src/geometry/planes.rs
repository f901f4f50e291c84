//! Planes side by side: a line, or a point, is held against eight of them at once.

use glam::DVec3;
use pulp::f64x8;

use super::convex_set::Plane;
use super::levels::Slide;
use crate::lanes::{EIGHT, Kernel, Wide, Wide3, lane_of};

/// Planes that stand still, or that slide.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Planes {
    // Invariant: as many as it takes. The last one is filled up with the last plane.
    eights: Vec<Eight>,
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eight {
    normal: [f64x8; 3],
    offset: f64x8,
    way: f64x8,
}

impl Planes {
    /// Planes that stand still.
    pub(super) fn new(planes: &[Plane]) -> Self {
        let still = |it: &Plane| Slide { normal: it.normal, offset: it.offset, way: 0.0 };
        Self::sliding(&planes.iter().map(still).collect::<Vec<Slide>>())
    }

    /// Planes on their way from one level of detail to another.
    pub(super) fn sliding(planes: &[Slide]) -> Self {
        Self { eights: planes.chunks(EIGHT).map(Eight::new).collect(), count: planes.len() }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The plane with a number, where it is on its way.
    pub(super) fn plane(&self, number: usize, part: f64) -> Option<Plane> {
        (number < self.count).then(|| self.eights[number / EIGHT].plane(number % EIGHT, part))
    }

    /// All of them, in the order of their numbers.
    pub(super) fn all(&self, part: f64) -> impl ExactSizeIterator<Item = Plane> {
        (0..self.count).map(move |it| self.eights[it / EIGHT].plane(it % EIGHT, part))
    }

    /// All of them, eight by eight; some at the end may be the last one once more.
    #[inline(always)]
    pub(super) fn eights(&self) -> &[Eight] {
        &self.eights
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.eights)
    }
}

impl Eight {
    /// As many planes, of which the last one stands for those that are missing.
    fn new(planes: &[Slide]) -> Self {
        let column = |part: fn(&Slide) -> f64| {
            pulp::cast(std::array::from_fn::<f64, EIGHT, _>(|lane| {
                planes.get(lane).or(planes.last()).map_or(0.0, part)
            }))
        };
        Self {
            normal: [column(|it| it.normal.x), column(|it| it.normal.y), column(|it| it.normal.z)],
            offset: column(|it| it.offset),
            way: column(|it| it.way),
        }
    }

    /// One of them, where it is on its way.
    #[inline(always)]
    pub(super) fn plane(&self, lane: usize, part: f64) -> Plane {
        let [x, y, z] = &self.normal;
        let slide = Slide {
            normal: DVec3::new(lane_of(x, lane), lane_of(y, lane), lane_of(z, lane)),
            offset: lane_of(&self.offset, lane),
            way: lane_of(&self.way, lane),
        };
        slide.at(part)
    }

    /// The normals and the offsets of all of them.
    #[inline(always)]
    pub(super) fn planes<K: Kernel>(&self, kernel: K, part: f64) -> (Wide3<K::Lanes>, Wide<K::Lanes>) {
        let lanes = kernel.lanes();
        let [x, y, z] = self.normal;
        let normal = Wide3 { x: Wide::new(lanes, x), y: Wide::new(lanes, y), z: Wide::new(lanes, z) };
        let offset = Wide::new(lanes, self.offset);
        // As for one of them.
        if part == 0.0 {
            return (normal, offset);
        }
        (normal, offset + Wide::new(lanes, self.way) * Wide::splat(lanes, part))
    }
}
