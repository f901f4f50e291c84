//! The fields of textures, materials and scene records, and the arguments of `scatter` and `terrain`.

/// What may stand in a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FieldType {
    /// A number within a range, ends included.
    Number(f64, f64),
    /// A number that is more than 0.
    Positive,
    /// A whole number within a range.
    Whole(f64, f64),
    /// A power of two up to this one.
    PowerOfTwo(f64),
    /// A vector of so many finite numbers.
    Vector(u8),
    /// Three numbers that are more than 0.
    Factors,
    /// Three parts from 0 to 1.
    Color,
    /// Two whole numbers from 1 to [`MOST_SIDE`].
    Size,
    /// A list of numbers.
    Numbers,
    /// A list of colours.
    Colors,
    /// A list of two vectors of two numbers: the corners of a region.
    Region,
    /// How far a thing is jittered: a number, or two.
    Spread,
    /// A truth value.
    Truth,
    /// Text.
    Text,
    /// One of these words.
    Words(&'static [&'static str]),
    /// A texture's name.
    Texture,
    /// A number or a texture's name.
    Density,
    /// A call of a system.
    Surface,
}

/// How many pixels a side of a picture may have: with any more, a picture one pixel high would be beyond the limit on them all.
pub(crate) const MOST_SIDE: f64 = (1u64 << 26) as f64;

/// A field of a record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FieldRule {
    pub(crate) name: &'static str,
    pub(crate) kind: FieldType,
    /// Whether it has an effect today.
    pub(crate) supported: bool,
}

const fn field(name: &'static str, kind: FieldType) -> FieldRule {
    FieldRule { name, kind, supported: true }
}

const fn later(name: &'static str, kind: FieldType) -> FieldRule {
    FieldRule { name, kind, supported: false }
}

use FieldType::{
    Color, Colors, Density, Factors, Number, Numbers, Positive, PowerOfTwo, Region, Size, Spread, Surface, Text,
    Texture, Truth, Vector, Whole, Words,
};

const ANY: FieldType = Number(f64::NEG_INFINITY, f64::INFINITY);
const SHARE: FieldType = Number(0.0, 1.0);
const NOT_NEGATIVE: FieldType = Number(0.0, f64::INFINITY);

pub(crate) const MATERIAL: &[FieldRule] = &[
    field("color", Color),
    field("range", Color),
    field("shade", Texture),
    field("amount", SHARE),
    later("holes", Texture),
    field("threshold", SHARE),
    field("softness", SHARE),
    later("limb", SHARE),
    field("bump", Texture),
    field("relief", Texture),
    field("depth", NOT_NEGATIVE),
    field("roughen", NOT_NEGATIVE),
    field("gloss", SHARE),
    field("mirror", SHARE),
    field("translucent", SHARE),
];

/// The kinds of texture.
pub(crate) const TEXTURE_KINDS: &[&str] = &["fourier", "fbm", "chunks", "elevation", "image"];

/// Those that have no effect yet.
pub(crate) const LATER_TEXTURE_KINDS: &[&str] = &["elevation"];

const TEXTURE: [FieldRule; 5] = [
    field("kind", Words(TEXTURE_KINDS)),
    field("space", Words(&["object", "stem", "world"])),
    field("seed", ANY),
    field("stretch", Factors),
    field("offset", Vector(3)),
];

const FOURIER: &[FieldRule] = &[
    TEXTURE[0],
    TEXTURE[1],
    TEXTURE[2],
    TEXTURE[3],
    TEXTURE[4],
    field("terms", Whole(1.0, 12.0)),
    field("frequency", Positive),
    field("phase", Number(0.0, 4.0)),
    field("ratio", Positive),
    field("gain", SHARE),
];

const FBM: &[FieldRule] = &[
    TEXTURE[0],
    TEXTURE[1],
    TEXTURE[2],
    TEXTURE[3],
    TEXTURE[4],
    field("dimension", Number(2.0, 3.0)),
    field("octaves", Whole(1.0, 16.0)),
    field("frequency", Positive),
    field("lacunarity", Positive),
];

const CHUNKS: &[FieldRule] = &[
    TEXTURE[0],
    TEXTURE[1],
    TEXTURE[2],
    TEXTURE[3],
    TEXTURE[4],
    field("cube", PowerOfTwo(256.0)),
    field("size", Positive),
    field("count", Whole(0.0, 1e6)),
    field("chunk", Size),
    field("colors", Colors),
    field("share", Numbers),
];

const ELEVATION: &[FieldRule] = &[
    TEXTURE[0],
    TEXTURE[1],
    TEXTURE[2],
    TEXTURE[3],
    TEXTURE[4],
    field("levels", Numbers),
    field("colors", Colors),
    field("slope", SHARE),
    field("noise", Texture),
];

const IMAGE_TEXTURE: &[FieldRule] =
    &[TEXTURE[0], TEXTURE[1], TEXTURE[2], TEXTURE[3], TEXTURE[4], field("file", Text), field("size", Positive)];

/// The fields of a texture of this kind.
pub(crate) fn texture(kind: &str) -> &'static [FieldRule] {
    match kind {
        "fourier" => FOURIER,
        "fbm" => FBM,
        "chunks" => CHUNKS,
        "elevation" => ELEVATION,
        _ => IMAGE_TEXTURE,
    }
}

/// How many rays a pixel may have.
const MOST_SAMPLES: f64 = 4096.0;

/// The records of a scene: name, fields, whether it may repeat.
pub(crate) const SCENE: &[(&str, &[FieldRule], bool)] = &[
    (
        "image",
        &[
            field("size", Size),
            field("samples", Whole(1.0, MOST_SAMPLES)),
            field("most", Whole(1.0, MOST_SAMPLES)),
            field("background", Words(&["sky", "none"])),
        ],
        false,
    ),
    (
        "camera",
        &[
            field("eye", Vector(3)),
            field("target", Vector(3)),
            field("up", Vector(3)),
            field("fov", Positive),
            field("height", Positive),
            later("on", Surface),
        ],
        false,
    ),
    (
        "sun",
        &[
            field("direction", Vector(3)),
            field("color", Color),
            field("strength", NOT_NEGATIVE),
            field("size", Number(0.0, 180.0)),
        ],
        true,
    ),
    ("sky", &[field("color", Color), field("strength", NOT_NEGATIVE), field("haze", NOT_NEGATIVE)], false),
];

/// The arguments of `terrain`.
pub(crate) const TERRAIN: &[FieldRule] = &[
    field("size", Positive),
    field("relief", NOT_NEGATIVE),
    field("dimension", Number(2.0, 3.0)),
    field("levels", Whole(1.0, 24.0)),
    field("corners", Numbers),
    field("sea", ANY),
    field("seed", ANY),
];

/// The arguments of `scatter`; those without a default come first.
pub(crate) const SCATTER: &[FieldRule] = &[
    field("region", Region),
    field("spacing", Positive),
    field("jitter", Spread),
    field("on", Surface),
    field("abut", Truth),
    field("density", Density),
];

/// The argument of `mesh`.
pub(crate) const MESH: &[FieldRule] = &[field("file", Text)];
