//! All limits with their names: what can grow, how far, how it can be changed, and what is said when it is met.

use treegen_grammar::{MAX_ERRORS, MAX_NAME_BYTES, MAX_NESTING, MAX_SOURCE_BYTES, MAX_TEXT_BYTES};
use treegen_runtime::picture::{MAX_CELLS, MAX_PIXELS, MAX_SAMPLES};
use treegen_runtime::{Limit, Limits};

use crate::check::MAX_LISTS;
use crate::load::{MAX_BYTES, MAX_FILES};
use crate::lower::MAX_NODES;
use crate::resolve::MAX_SLOTS;
use crate::scene::MAX_SUNS;
use crate::show::MOST_SHOWN;
use crate::words::fault::limit_code;
use crate::{meshes, pictures};

/// A limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitRow {
    /// Its name.
    pub name: &'static str,
    /// What is counted.
    pub what: &'static str,
    /// How far it goes unless somebody says otherwise.
    pub default: u64,
    /// How it can be changed.
    pub change: Change,
    /// The code of the message when it is met; none for what is passed over, such as messages beyond the hundredth.
    pub code: Option<&'static str>,
}

/// How a limit can be changed. A program can never do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Not at all.
    Fixed,
    /// By an option of its own.
    Option(&'static str),
    /// By its name, up to this number.
    Allow(u64),
}

/// All limits, in the order in which a program meets them.
pub fn limits() -> Vec<LimitRow> {
    let mut rows: Vec<LimitRow> = OF_TEXT.iter().map(|it| fixed(it.0, it.1, it.2, Some(it.3))).collect();
    let defaults = Limits::default();
    rows.extend(RAISED.iter().map(|it| LimitRow {
        name: it.name,
        what: it.what,
        default: (it.of)(&defaults),
        change: it.change,
        code: it.limit.map(limit_code),
    }));
    let picture = |name, what, default, option, limit| LimitRow {
        name,
        what,
        default,
        change: Change::Option(option),
        code: Some(limit_code(limit)),
    };
    rows.push(picture("pixels", "pixels of a picture", MAX_PIXELS, "--size, up to this", Limit::Pixels));
    rows.push(picture("samples", "rays of a pixel", u64::from(MAX_SAMPLES), "--samples, up to this", Limit::Samples));
    let cells = "cells of all textures of blocks";
    rows.push(fixed("texture-cells", cells, MAX_CELLS, Some(limit_code(Limit::Cells))));
    rows.push(fixed("messages", "messages that are shown; then how many are left", MOST_SHOWN as u64, None));
    rows
}

fn fixed(name: &'static str, what: &'static str, default: u64, code: Option<&'static str>) -> LimitRow {
    LimitRow { name, what, default, change: Change::Fixed, code }
}

/// Limits of what is read: name, what, how far, code.
const OF_TEXT: &[(&str, &str, u64, &str)] = &[
    ("file-bytes", "bytes of a file", MAX_SOURCE_BYTES as u64, "E0901"),
    ("program-bytes", "bytes of all files of a program", MAX_BYTES as u64, "E0902"),
    ("files", "files of a program", MAX_FILES as u64, "E0902"),
    ("nesting", "brackets, ifs and signs of exponents in one another", MAX_NESTING as u64, "E0903"),
    ("mistakes", "mistakes of a file's text before the rest is not read", MAX_ERRORS as u64, "E0904"),
    ("name-bytes", "bytes of a name", MAX_NAME_BYTES as u64, "E0906"),
    ("text-bytes", "bytes of a quoted text", MAX_TEXT_BYTES as u64, "E0907"),
    ("list-nesting", "lists in one another", MAX_LISTS as u64, "E0908"),
    ("values", "names of values in one system", MAX_SLOTS as u64, "E0902"),
    ("picture-bytes", "bytes of a picture's file", pictures::MAX_BYTES, "E0901"),
    ("picture-pixels", "pixels of all pictures of a program", pictures::MAX_PIXELS, "E0909"),
    ("mesh-bytes", "bytes of a mesh's file", meshes::MAX_BYTES, "E0901"),
    ("suns", "suns of a scene", MAX_SUNS as u64, "E0902"),
    ("nodes", "nodes of the graph that a program is lowered to", MAX_NODES as u64, "E0905"),
];

/// A limit of the runtime.
struct Raised {
    name: &'static str,
    what: &'static str,
    change: Change,
    limit: Option<Limit>,
    of: fn(&Limits) -> u64,
    set: fn(&mut Limits, u64),
}

macro_rules! raised {
    ($($name:literal, $what:literal, $field:ident: $kind:ty, $limit:expr, $change:expr;)*) => {
        &[$(Raised {
            name: $name,
            what: $what,
            change: $change,
            limit: $limit,
            of: |it| it.$field as u64,
            set: |it, value| it.$field = <$kind>::try_from(value).unwrap_or(<$kind>::MAX),
        }),*]
    };
}

const MANY: Change = Change::Allow(u32::MAX as u64);

/// Stacks are made for this depth, so it can only be lowered.
const DEEP: Change = Change::Allow(10_000);

const RAISED: &[Raised] = raised![
    "depth", "modules and systems in one another", depth: u32, Some(Limit::Depth), DEEP;
    "calls", "functions in one another", calls: u32, Some(Limit::Calls), Change::Allow(128);
    "operations", "operations for one list of arguments, guard or C-node", operations: u64, Some(Limit::Operations), Change::Allow(1 << 48);
    "repeat", "copies of the repeats in one part", repeat: u32, Some(Limit::Repeat), MANY;
    "list", "values of one list", list: u32, Some(Limit::List), MANY;
    "parts", "parts of one module; a call of another counts as four", items: u32, Some(Limit::Nodes), MANY;
    "rules", "rules applied in one derivation of a shape", rules: u32, Some(Limit::Rules), MANY;
    "modules", "modules of one derivation that wait to be replaced", modules: u32, Some(Limit::Modules), MANY;
    "segments", "segments of one derivation", segments: u32, Some(Limit::Segments), MANY;
    "strides", "steps of one derivation's walks, and operations of their expressions", strides: u64, Some(Limit::Strides), Change::Allow(1 << 48);
    "planes", "planes of one hull, with the modules that stand for planes", planes: u32, Some(Limit::Planes), Change::Allow(16_384);
    "steps", "boxes and primitives that one ray may meet", steps: u64, Some(Limit::Steps), Change::Allow(1 << 48);
    "work", "steps of all rays of a picture, with what is made for them", work: u64, Some(Limit::Work), Change::Allow(1 << 60);
    "booleans", "intersections and differences in one another, on one ray", booleans: u32, Some(Limit::Booleans), MANY;
    "intervals", "pieces of one ray inside solids", intervals: u32, Some(Limit::Intervals), MANY;
    "primitives", "primitives that treegen inspect --expand writes", primitives: u64, Some(Limit::Primitives), Change::Option("--limit N");
    "triangles", "triangles of a mesh that is written", triangles: u64, Some(Limit::Triangles), Change::Option("--triangles N");
    "mesh-triangles", "triangles of all meshes that a program reads", mesh_triangles: u64, Some(Limit::MeshTriangles), Change::Allow(u32::MAX as u64 / 4);
    "mesh-nodes", "places in a mesh; where there are more, parts are larger", mesh_nodes: u64, None, Change::Allow(1 << 32);
    "cell-bytes", "bytes kept between rays; it changes the time, never the picture", cell_bytes: u64, None, Change::Option("--cell-memory MB");
];

/// Sets a limit by its name.
///
/// # Errors
/// Why not, in words.
pub fn allow(limits: &mut Limits, name: &str, value: u64) -> Result<(), String> {
    let Some(row) = RAISED.iter().find(|it| it.name == name) else {
        return Err(match crate::similar::nearest(name, RAISED.iter().map(|it| it.name)) {
            Some(near) => format!("there is no limit of this name that can be changed; did you mean `{near}`?"),
            None => "`treegen limits` lists the limits that can be changed so".to_owned(),
        });
    };
    match row.change {
        Change::Allow(most) if (1..=most).contains(&value) => {
            (row.set)(limits, value);
            Ok(())
        }
        Change::Allow(most) => Err(format!("`{name}` is from 1 to {most}")),
        Change::Option(option) => Err(format!("`{option}` sets this limit")),
        Change::Fixed => Err("this limit is fixed".to_owned()),
    }
}

/// How a limit that was met can be raised, in words.
pub fn way_to_raise(limit: Limit) -> Option<String> {
    let row = RAISED.iter().find(|it| it.limit == Some(limit))?;
    match row.change {
        Change::Option(option) => Some(format!("`{option}` allows so many")),
        Change::Allow(most) if (row.of)(&Limits::default()) < most => {
            Some(format!("`--allow {}=N` allows so many", row.name))
        }
        Change::Allow(_) | Change::Fixed => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_of_the_runtime_has_its_row() {
        let mut limits = Limits::default();
        for row in RAISED {
            (row.set)(&mut limits, (row.of)(&Limits::default()) + 7);
        }
        // A limit that is added is named here, so that it gets a row.
        let Limits {
            depth,
            calls,
            operations,
            repeat,
            list,
            items,
            rules,
            modules,
            segments,
            planes,
            strides,
            steps,
            work,
            booleans,
            intervals,
            primitives,
            triangles,
            mesh_triangles,
            mesh_nodes,
            cell_bytes,
            // How pictures look is no limit.
            lod: _,
        } = limits;
        let small =
            [depth, calls, repeat, list, items, rules, modules, segments, planes, booleans, intervals].map(u64::from);
        let large = [operations, strides, steps, work, primitives, triangles, mesh_triangles, mesh_nodes, cell_bytes];
        let mut changed: Vec<u64> = small.iter().chain(&large).map(|it| it - 7).collect();
        let mut defaults: Vec<u64> = RAISED.iter().map(|it| (it.of)(&Limits::default())).collect();
        changed.sort_unstable();
        defaults.sort_unstable();
        assert_eq!(changed, defaults);
    }

    #[test]
    fn a_limit_is_set_by_its_name_within_what_is_possible() {
        let mut limits = Limits::default();
        assert_eq!(allow(&mut limits, "rules", 5), Ok(()));
        assert_eq!(limits, Limits { rules: 5, ..Limits::default() });
        for (name, value, words) in [
            ("rule", 5, "did you mean `rules`?"),
            ("files", 5, "lists the limits"),
            ("rules", 0, "from 1 to"),
            ("depth", 10_001, "from 1 to 10000"),
            ("triangles", 5, "--triangles N"),
        ] {
            let said = allow(&mut limits, name, value).unwrap_err();
            assert!(said.contains(words), "{said}");
        }
    }

    #[test]
    fn names_are_there_once() {
        let rows = limits();
        let mut names: Vec<&str> = rows.iter().map(|it| it.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), rows.len());
    }
}
