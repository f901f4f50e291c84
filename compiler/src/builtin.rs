//! The names that every program knows.

use treegen_runtime::form::{Builtin, Draw, PrimitiveKind, TransformKind};

/// The built-in functions, with how many arguments they take at least and at most.
pub(crate) const FUNCTIONS: &[(&str, Builtin, usize, usize)] = &[
    ("sin", Builtin::Sin, 1, 1),
    ("cos", Builtin::Cos, 1, 1),
    ("tan", Builtin::Tan, 1, 1),
    ("asin", Builtin::Asin, 1, 1),
    ("acos", Builtin::Acos, 1, 1),
    ("atan", Builtin::Atan, 1, 1),
    ("atan2", Builtin::Atan2, 2, 2),
    ("sqrt", Builtin::Sqrt, 1, 1),
    ("exp", Builtin::Exp, 1, 1),
    ("ln", Builtin::Ln, 1, 1),
    ("abs", Builtin::Abs, 1, 1),
    ("floor", Builtin::Floor, 1, 1),
    ("ceil", Builtin::Ceil, 1, 1),
    ("round", Builtin::Round, 1, 1),
    ("min", Builtin::Min, 1, 255),
    ("max", Builtin::Max, 1, 255),
    ("clamp", Builtin::Clamp, 3, 3),
    ("mix", Builtin::Mix, 3, 3),
    ("dot", Builtin::Dot, 2, 2),
    ("cross", Builtin::Cross, 2, 2),
    ("norm", Builtin::Norm, 1, 1),
    ("unit", Builtin::Unit, 1, 1),
    ("count", Builtin::Count, 1, 1),
    ("rand", Builtin::Rand, 1, 1),
    ("noise", Builtin::Noise, 1, 1),
];

/// The random draws, with how many arguments they take.
pub(crate) const DRAWS: &[(&str, Draw, usize)] =
    &[("random", Draw::Uniform, 2), ("gauss", Draw::Gauss, 2), ("chance", Draw::Chance, 1)];

/// The names of values that every program knows.
pub(crate) const CONSTANTS: &[&str] = &["inf", "pi", "time"];

/// A group of parameters: so many numbers, or one vector of that size.
pub(crate) struct Group {
    /// The name of the vector.
    pub(crate) name: &'static str,
    /// The names of the numbers.
    pub(crate) parts: &'static [&'static str],
}

const fn one(parts: &'static [&'static str]) -> Group {
    Group { name: parts[0], parts }
}

const POINT: Group = Group { name: "v", parts: &["x", "y", "z"] };

/// A transformation, with what it needs and does in words: "`move` needs something to move".
pub(crate) struct Transform {
    pub(crate) name: &'static str,
    pub(crate) kind: TransformKind,
    pub(crate) groups: &'static [Group],
    pub(crate) verb: &'static str,
}

/// The transformations.
pub(crate) const TRANSFORMS: &[Transform] = &[
    transform("move", TransformKind::Move, &[POINT], "move"),
    transform("rotx", TransformKind::RotX, &[one(&["a"])], "turn"),
    transform("roty", TransformKind::RotY, &[one(&["a"])], "turn"),
    transform("rotz", TransformKind::RotZ, &[one(&["a"])], "turn"),
    transform("rotate", TransformKind::Rotate, &[Group { name: "axis", parts: &["x", "y", "z"] }, one(&["a"])], "turn"),
    transform("scale", TransformKind::Scale, &[POINT], "scale"),
    transform("uscale", TransformKind::UScale, &[one(&["f"])], "scale"),
    transform("mirror", TransformKind::Mirror, &[POINT], "mirror"),
    transform("zshear", TransformKind::ZShear, &[one(&["dzdx"]), one(&["dzdy"])], "shear"),
    transform("matrix", TransformKind::Matrix, &[one(&MATRIX)], "map"),
];

const MATRIX: [&str; 12] = ["xx", "xy", "xz", "x0", "yx", "yy", "yz", "y0", "zx", "zy", "zz", "z0"];

const fn transform(name: &'static str, kind: TransformKind, groups: &'static [Group], verb: &'static str) -> Transform {
    Transform { name, kind, groups, verb }
}

/// A primitive solid and its parameters.
pub(crate) struct Primitive {
    pub(crate) name: &'static str,
    pub(crate) kind: PrimitiveKind,
    pub(crate) groups: &'static [Group],
}

/// The primitives that are numbers only.
pub(crate) const PRIMITIVES: &[Primitive] = &[
    primitive("sphere", PrimitiveKind::Sphere, &[]),
    primitive("cylinder", PrimitiveKind::Cylinder, &[]),
    primitive("cone", PrimitiveKind::Cone, &[one(&["r0"]), one(&["r1"])]),
    primitive("box", PrimitiveKind::Box, &[]),
    primitive("tetrahedron", PrimitiveKind::Tetrahedron, &[]),
    primitive("torus", PrimitiveKind::Torus, &[one(&["r"])]),
    primitive("triangle", PrimitiveKind::Triangle, &[]),
    primitive("halfspace", PrimitiveKind::HalfSpace, &[Group { name: "n", parts: &["nx", "ny", "nz"] }, one(&["d"])]),
    primitive("ellipsoid", PrimitiveKind::Ellipsoid, &[Group { name: "v", parts: &["a", "b", "c"] }]),
    primitive("hyperboloid", PrimitiveKind::Hyperboloid, &[Group { name: "v", parts: &["a", "b", "c"] }]),
    primitive("paraboloid", PrimitiveKind::Paraboloid, &[one(&["a"]), one(&["b"])]),
    primitive("quadric", PrimitiveKind::Quadric, &[one(&QUADRIC)]),
];

/// The name of a primitive's parameter.
pub(crate) fn parameter(kind: PrimitiveKind, place: usize) -> Option<&'static str> {
    let primitive = PRIMITIVES.iter().find(|it| it.kind == kind)?;
    primitive.groups.iter().flat_map(|it| it.parts).nth(place).copied()
}

const QUADRIC: [&str; 10] = ["q1", "q2", "q3", "q4", "q5", "q6", "q7", "q8", "q9", "q0"];

const fn primitive(name: &'static str, kind: PrimitiveKind, groups: &'static [Group]) -> Primitive {
    Primitive { name, kind, groups }
}

/// What a walk's own words do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WalkWord {
    /// `toward(direction, angle)`
    Toward,
    /// `segment(length, r0, r1)`
    Segment,
    /// `normal(length)`
    Normal,
}

/// The words that only walks have, with their parameters.
pub(crate) const WALK_WORDS: &[(&str, WalkWord, &[&str])] = &[
    ("toward", WalkWord::Toward, &["direction", "angle"]),
    ("segment", WalkWord::Segment, &["length", "r0", "r1"]),
    ("normal", WalkWord::Normal, &["length"]),
];

/// The words for solids with arguments of their own: `terrain(...)`, `mesh(...)`, `scatter(...)`.
pub(crate) const SPECIAL: &[&str] = &["nothing", "paint", "variant", "scatter", "terrain", "mesh"];

/// Every name that may stand in a chain.
pub(crate) fn chain_names() -> impl Iterator<Item = &'static str> {
    let transforms = TRANSFORMS.iter().map(|it| it.name);
    transforms.chain(PRIMITIVES.iter().map(|it| it.name)).chain(SPECIAL.iter().copied())
}

/// Every name that a value may be called by or made with.
pub(crate) fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|it| it.0).chain(DRAWS.iter().map(|it| it.0))
}

/// What kind of thing a built-in name is, if it is one.
pub(crate) fn describe(name: &str) -> Option<&'static str> {
    if FUNCTIONS.iter().any(|it| it.0 == name) || DRAWS.iter().any(|it| it.0 == name) {
        return Some("function");
    }
    if CONSTANTS.contains(&name) {
        return Some("number");
    }
    if TRANSFORMS.iter().any(|it| it.name == name) {
        return Some("transformation");
    }
    if PRIMITIVES.iter().any(|it| it.name == name) {
        return Some("solid");
    }
    match name {
        "nothing" | "terrain" | "mesh" => Some("solid"),
        "paint" | "variant" | "scatter" => Some("operator"),
        _ => None,
    }
}

/// What a name stands for where no program defines it: as [`describe`] says, or a word of walks.
pub(crate) fn word_for(name: &str) -> Option<&'static str> {
    describe(name).or_else(|| is_walk_word(name).then_some("word of walks"))
}

/// Whether walks know this name, besides what [`describe`] knows.
pub(crate) fn is_walk_word(name: &str) -> bool {
    WALK_WORDS.iter().any(|it| it.0 == name)
}
