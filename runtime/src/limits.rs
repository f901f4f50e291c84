//! How far things may grow. Everything that a program can make grow has a limit here, with a name in [`Limit`](crate::Limit).

/// The limits of a run. No program can raise them; the command line can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Modules and systems inside one another, on one ray.
    pub depth: u32,
    /// Functions inside one another.
    pub calls: u32,
    /// Operations of one evaluation: of an argument list, a guard, a C-node.
    pub operations: u64,
    /// Copies of one `repeat`.
    pub repeat: u32,
    /// Elements of one list.
    pub list: u32,
    /// Parts of one state: primitives, copies, modules up to the next ones. A module counts as four.
    pub items: u32,
    /// Rules applied in one derivation of a shape.
    pub rules: u32,
    /// Modules laid down in one derivation and not replaced yet.
    pub modules: u32,
    /// Segments of one derivation.
    pub segments: u32,
    /// Planes of one hull, and at the same time modules that stand for planes.
    pub planes: u32,
    /// Strides of one derivation's walks, and the operations of their expressions.
    pub strides: u64,
    /// Boxes and primitives that one ray may meet.
    pub steps: u64,
    /// Steps of all rays of a picture, and what is made for them: each state that is expanded counts as some, and so do its parts and the
    /// operations of its expressions.
    pub work: u64,
    /// Booleans inside one another, on one ray.
    pub booleans: u32,
    /// Intervals on one ray.
    pub intervals: u32,
    /// Primitives of an exported scene; places where there is nothing count, too.
    pub primitives: u64,
    /// Triangles of a mesh that is written.
    pub triangles: u64,
    /// Triangles of all meshes that a program reads.
    pub mesh_triangles: u64,
    /// Places where parts of a mesh are laid down; where there would be more, they are larger.
    pub mesh_nodes: u64,
    /// How far hulls that were split may be seen beside where they are, in widths of beams: they have so much less detail from afar. 0 shows
    /// all their planes from everywhere.
    pub lod: f64,
    /// Bytes for states and cells that are kept. It affects the time, never the picture.
    pub cell_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            depth: 10_000,
            calls: 128,
            operations: 10_000_000,
            repeat: 1_000_000,
            list: 1_000_000,
            items: 1_000_000,
            rules: 4_000_000,
            modules: 1_000_000,
            segments: 500_000,
            planes: 16_384,
            strides: 100_000_000,
            steps: 10_000_000,
            work: 1_000_000_000_000,
            booleans: 32_768,
            intervals: 4096,
            primitives: 10_000_000,
            triangles: 4_000_000,
            mesh_triangles: 2_000_000,
            mesh_nodes: 65_536,
            lod: 1.0,
            cell_bytes: 256 << 20,
        }
    }
}

impl Limits {
    /// Work that a picture of so many pixels, each begun with so many samples, may take at most: what is small shall not take long.
    #[must_use]
    pub fn work_for(pixels: u64, samples: u32) -> u64 {
        /// Whatever the picture's size: what is expanded for one pixel is much of what is expanded for all.
        const LEAST: u64 = 1_000_000_000;
        /// For each pixel, and for each sample of it beyond the first four.
        const FOR_EACH: u64 = 1_000_000;
        const FOR_EACH_SAMPLE: u64 = FOR_EACH / 4;
        let pixel = FOR_EACH + FOR_EACH_SAMPLE * u64::from(samples.saturating_sub(4));
        Self::default().work.min(LEAST.saturating_add(pixels.saturating_mul(pixel)))
    }
}
