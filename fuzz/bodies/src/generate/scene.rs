//! Materials, textures and the scene.

use super::Maker;

/// What a material may have besides its colour; `T` is a texture.
const FIELDS: [&str; 12] = [
    "mirror: .5",
    "mirror: 1",
    "range: (.1, .1, .2)",
    "gloss: .5",
    "translucent: .4",
    "shade: T",
    "bump: T, depth: .1",
    "relief: T, depth: .05",
    "roughen: .3",
    "shade: T, amount: .3",
    "bump: T, depth: 1e300",
    "roughen: 1e-3",
];

const TEXTURES: [&str; 6] = [
    "kind: fbm",
    "kind: fourier",
    "kind: chunks, cube: 8, size: 1, count: 20, colors: [(.1, .5, .2), (.9, .1, .1)]",
    "kind: image, file: \"a.png\"",
    "kind: fbm, frequency: 1e9, octaves: 16, space: world",
    "kind: fbm, space: stem, dimension: 3, stretch: (1e-3, 1, 1e3)",
];

impl Maker<'_> {
    /// A material, after the texture that it needs.
    pub(super) fn material(&mut self) -> String {
        let name = self.name("Q");
        let field = FIELDS[self.bytes.below(FIELDS.len())];
        self.made.materials.push(name.clone());
        if !field.contains(": T") {
            return format!("material {name} {{ color: (.8, .4, .2), {field} }}\n");
        }
        let texture = self.name("X");
        let kind = TEXTURES[self.bytes.below(TEXTURES.len())];
        let field = field.replace(": T", &format!(": {texture}"));
        format!("texture {texture} {{ {kind} }}\nmaterial {name} {{ color: (.8, .4, .2), {field} }}\n")
    }

    pub(super) fn scene(&mut self) -> String {
        let mut text = String::new();
        if self.bytes.below(4) > 1 {
            let eye = match self.bytes.below(4) {
                0 => self.vector(1),
                1 => "(0, 0, 0)".to_owned(),
                2 => "(3, -5, 2)".to_owned(),
                _ => "(.5, -1.5, .5)".to_owned(),
            };
            let lens = ["fov: 40", "height: 3", "fov: 170", "height: 1e-6"][self.bytes.below(4)];
            text += &format!("  camera {{ eye: {eye}, target: (.01, .02, .03), {lens} }}\n");
        }
        match self.bytes.below(4) {
            0 => text += "  sun { direction: (-1, .5, -1), strength: 1, size: 3 }\n",
            1 => text += "  sky { color: (.5, .6, .9), haze: .1 }\n",
            _ => {}
        }
        let shown = self.several(3, "\n", |it| {
            let solid = it.system_call().unwrap_or_else(|| it.primitive());
            match it.bytes.below(4) {
                0 => format!("  show {solid};"),
                1 => format!("  show {} {solid};", it.prefix()),
                2 => format!("  show {} {solid};", it.paint()),
                _ => format!("  show {solid} \\ {};", it.solid(2)),
            }
        });
        format!("scene {{\n{text}{shown}\n}}\n")
    }
}
