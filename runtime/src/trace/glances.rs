//! What the rays of a batch see, by columns: of most it is one bare surface, and many of those are lit and shaded at once.
//!
//! A surface is **bare** if it is opaque and its paint only scatters light and shines: it has no texture, mirrors nothing and lets no light
//! through. A ray that sees anything else has its fragments apart, as in [`Seen`]. Which of the two it is follows from what is seen alone.

use super::{Beam, Seen, Site};
use crate::form::MaterialId;
use crate::lanes::lanes_of;

/// How many rays stand side by side.
pub const ABREAST: usize = 16;

/// A number of each of some rays side by side.
pub type Column<T = f64> = [T; ABREAST];

/// What rays side by side see.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Row {
    /// Where on the ray, in lengths of the ray's direction.
    pub depth: Column,
    /// Where in the world: all x, all y, all z.
    pub position: [Column; 3],
    /// The surface's normal there, as that of a [`Fragment`](super::Fragment).
    pub normal: [Column; 3],
    /// A hash of the route to the solid, as that of a [`Fragment`](super::Fragment), where the look of the material depends on it.
    pub route: Column<u64>,
    /// The paint.
    pub material: Column<Option<MaterialId>>,
    /// The rays that see a bare surface, one bit each. In the columns of others stands anything.
    pub bare: u32,
    /// The rays that see something else. Those that are neither see nothing.
    pub other: u32,
}

/// What the rays of a batch see.
#[derive(Clone, Debug, Default)]
pub struct Glances {
    /// The first sixteen rays, the next sixteen, ...
    rows: Vec<Row>,
    /// How many of them are in use, and how many rays.
    used: usize,
    count: usize,
    /// Which primitive the bare surface of each ray is.
    sites: Vec<Site>,
    /// What the others see, one after another.
    pub others: Seen,
}

/// A shadow ray that starts on a bare surface, in the direction of a light.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// The ray.
    pub beam: Beam,
    /// The number of the ray that sees the surface that it starts on.
    pub from: u32,
    /// Whether it leaves the surface on the side of its normal.
    pub leaving: bool,
}

impl Row {
    const BLANK: Self = Self {
        depth: [0.0; ABREAST],
        position: [[0.0; ABREAST]; 3],
        normal: [[0.0; ABREAST]; 3],
        route: [0; ABREAST],
        material: [None; ABREAST],
        bare: 0,
        other: 0,
    };
}

impl Glances {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        (self.used, self.count) = (0, 0);
        self.others.clear();
    }

    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// What rays see, sixteen at a time.
    pub fn rows(&self) -> &[Row] {
        &self.rows[..self.used]
    }

    /// The numbers of the rays whose fragments are apart.
    pub fn others(&self) -> impl Iterator<Item = usize> {
        let other = |(number, row): (usize, &Row)| lanes_of(row.other).map(move |lane| number * ABREAST + lane);
        self.rows().iter().enumerate().flat_map(other)
    }

    /// Which primitive the bare surface is that the ray of this number sees.
    #[inline(always)]
    pub fn site(&self, ray: usize) -> &Site {
        &self.sites[ray]
    }

    /// Adds rays, all of them sixteen but those at the end, to be filled in, with their sites: they see nothing yet.
    #[inline(always)]
    pub(crate) fn add(&mut self, count: usize) -> (&mut Row, &mut [Site], &mut Seen) {
        let number = self.used;
        self.used += 1;
        self.count += count;
        if self.rows.len() < self.used {
            self.grow();
        }
        let row = &mut self.rows[number];
        (row.bare, row.other) = (0, 0);
        (row, &mut self.sites[number * ABREAST..][..ABREAST], &mut self.others)
    }

    /// Adds rays whose fragments are all apart, to be filled in.
    pub(crate) fn add_others(&mut self, count: usize) -> &mut Seen {
        for first in (0..count).step_by(ABREAST) {
            let count = (count - first).min(ABREAST);
            self.add(count).0.other = ((1_u64 << count) - 1) as u32;
        }
        &mut self.others
    }

    #[cold]
    fn grow(&mut self) {
        self.rows.push(Row::BLANK);
        self.sites.resize(self.rows.len() * ABREAST, Site::default());
    }
}

/// The materials whose surfaces are bare.
#[derive(Clone, Debug, Default)]
pub struct BareMaterials {
    of: Vec<Bareness>,
    /// Of what has no material.
    without: Bareness,
}

/// Whether the surfaces of a material are bare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bareness {
    /// Whether they are.
    pub bare: bool,
    /// Whether their look depends on the route to the solid.
    pub by_route: bool,
}

impl BareMaterials {
    /// Of the materials, in the order of their numbers, and of what has none.
    pub fn new(of: Vec<Bareness>, without: Bareness) -> Self {
        Self { of, without }
    }

    /// Of a material.
    #[inline(always)]
    pub fn of(&self, material: Option<MaterialId>) -> Bareness {
        match material {
            Some(MaterialId(number)) => self.of.get(number as usize).copied().unwrap_or(self.without),
            None => self.without,
        }
    }
}
