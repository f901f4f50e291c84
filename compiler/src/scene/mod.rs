//! The scene's records, the materials and textures: constants with a type and a range.

mod fields;
mod surfaces;

use glam::DVec3;
use treegen_grammar::Span;
use treegen_runtime::form::{Background, Camera, ImageSettings, Lens, Material, Sky, Sun, Texture};

use crate::constant::Constants;
use crate::fields::{self as rules, FieldRule};
use crate::pictures::Pictures;
use crate::program::{Field, FieldValue, Record};
use crate::words;
use fields::Data;

pub(crate) use surfaces::surfaces;

/// How many suns a scene may have: each is looked for from every place that is seen.
pub(crate) const MAX_SUNS: usize = 256;

/// What a scene has besides its graph.
#[derive(Debug, Default)]
pub(crate) struct Setting {
    pub(crate) camera: Option<Camera>,
    pub(crate) suns: Vec<Sun>,
    pub(crate) sky: Option<Sky>,
    pub(crate) image: ImageSettings,
    /// For each material of the program what it looks like. Its textures are numbered as the program's.
    pub(crate) materials: Vec<Material>,
    /// For each texture of the program what it is; none if that has no effect yet.
    pub(crate) textures: Vec<Option<Texture>>,
}

/// Finds the fields of all records.
pub(crate) fn setting(constants: &mut Constants<'_>, pictures: &mut Pictures<'_>) -> Setting {
    let program = constants.program();
    let mut setting = Setting::default();
    for texture in &program.textures {
        let texture = surfaces::texture(constants, pictures, texture);
        setting.textures.push(texture);
    }
    for material in &program.materials {
        let material = surfaces::material(constants, material);
        setting.materials.push(material);
    }
    for record in program.scene.iter().flat_map(|it| &it.records) {
        let Some((_, rules, _)) = rules::SCENE.iter().find(|it| it.0 == record.name) else { continue };
        let fields = Fields::find(constants, record, rules);
        match record.name.as_str() {
            "image" => setting.image = image(&fields),
            "camera" => setting.camera = camera(constants, record, &fields),
            "sun" if setting.suns.len() >= MAX_SUNS => {
                constants.report(words::files::too_many("suns", MAX_SUNS, record.span));
                break;
            }
            "sun" => setting.suns.extend(sun(constants, record, &fields)),
            _ => setting.sky = Some(sky(&fields)),
        }
    }
    setting
}

/// The fields of a record that could be found.
struct Fields<'a> {
    found: Vec<(&'static str, &'a Field, Data)>,
    /// Whether a problem was reported about one of them.
    broken: bool,
}

impl<'a> Fields<'a> {
    fn find(constants: &mut Constants<'_>, record: &'a Record, rules: &[FieldRule]) -> Self {
        let mut fields = Self { found: Vec::new(), broken: constants.is_broken(record.def) };
        for field in &record.fields {
            let Some(rule) = rules.iter().find(|it| it.name == field.name) else { continue };
            match fields::data(constants, rule, field) {
                Some(data) => fields.found.push((rule.name, field, data)),
                None => fields.broken = true,
            }
        }
        fields
    }

    fn field(&self, name: &str) -> Option<&'a Field> {
        self.found.iter().find(|it| it.0 == name).map(|it| it.1)
    }

    fn value_span(&self, name: &str) -> Option<Span> {
        let field = self.field(name)?;
        Some(if let FieldValue::Expr(expr) = &field.value { expr.span } else { field.span })
    }

    fn data(&self, name: &str) -> Option<&Data> {
        self.found.iter().find(|it| it.0 == name).map(|it| &it.2)
    }

    fn number(&self, name: &str) -> Option<f64> {
        if let Some(Data::Number(number)) = self.data(name) { Some(*number) } else { None }
    }

    fn vector(&self, name: &str) -> Option<[f64; 3]> {
        let Some(Data::Parts(parts)) = self.data(name) else { return None };
        parts.as_slice().try_into().ok()
    }

    fn texture(&self, name: &str) -> Option<u32> {
        if let Some(Data::Texture(number)) = self.data(name) { Some(*number) } else { None }
    }

    fn text(&self, name: &str) -> Option<&str> {
        if let Some(Data::Text(text)) = self.data(name) { Some(text) } else { None }
    }

    fn word(&self, name: &str) -> Option<&'static str> {
        if let Some(Data::Word(word)) = self.data(name) { Some(word) } else { None }
    }
}

fn image(fields: &Fields<'_>) -> ImageSettings {
    let mut image = ImageSettings::default();
    if let Some(Data::Parts(size)) = fields.data("size")
        && let [width, height] = size.as_slice()
    {
        (image.width, image.height) = (*width as u32, *height as u32);
    }
    if let Some(samples) = fields.number("samples") {
        image.samples = samples as u32;
    }
    image.most = fields.number("most").map(|it| it as u32);
    if fields.word("background") == Some("none") {
        image.background = Background::Transparent;
    }
    image
}

fn camera(constants: &mut Constants<'_>, record: &Record, fields: &Fields<'_>) -> Option<Camera> {
    if fields.broken {
        return None;
    }
    for name in ["eye", "target"] {
        if fields.field(name).is_none() {
            constants.report(words::records::missing_field("a camera", name, record.span));
            return None;
        }
    }
    if let (Some(height), Some(fov)) = (fields.field("height"), fields.field("fov")) {
        constants.report(words::records::both_fields("fov", "height", height.span, fov.span));
        return None;
    }
    let eye = DVec3::from(fields.vector("eye")?);
    let target = DVec3::from(fields.vector("target")?);
    if eye == target {
        let span = fields.value_span("target").unwrap_or(record.span);
        constants.report(words::records::eye_on_target(span));
        return None;
    }
    let up = direction(constants, fields, "up", [0.0, 0.0, 1.0])?;
    let lens = match fields.number("height") {
        Some(height) => Lens::Orthographic(height),
        None => {
            let angle = fields.number("fov").unwrap_or(40.0);
            if angle >= 180.0 {
                let span = fields.value_span("fov").unwrap_or(record.span);
                let is = words::constants::number(angle);
                constants.report(words::records::bad_value("fov", "an angle above 0 and below 180", span, &is));
                return None;
            }
            Lens::Perspective(angle)
        }
    };
    Some(Camera { eye, target, up, lens })
}

fn sun(constants: &mut Constants<'_>, record: &Record, fields: &Fields<'_>) -> Option<Sun> {
    if fields.broken {
        return None;
    }
    if fields.field("direction").is_none() {
        constants.report(words::records::missing_field("a sun", "direction", record.span));
        return None;
    }
    Some(Sun {
        direction: direction(constants, fields, "direction", [0.0; 3])?,
        color: fields.vector("color").unwrap_or([1.0; 3]),
        strength: fields.number("strength").unwrap_or(1.0),
        size: fields.number("size").unwrap_or(0.0),
    })
}

fn sky(fields: &Fields<'_>) -> Sky {
    let default = Sky::default();
    Sky {
        color: fields.vector("color").unwrap_or(default.color),
        strength: fields.number("strength").unwrap_or(default.strength),
        haze: fields.number("haze").unwrap_or(default.haze),
    }
}

/// A vector that is not 0.
fn direction(constants: &mut Constants<'_>, fields: &Fields<'_>, name: &str, default: [f64; 3]) -> Option<DVec3> {
    let vector = DVec3::from(fields.vector(name).unwrap_or(default));
    if vector == DVec3::ZERO {
        let span = fields.value_span(name)?;
        constants.report(words::records::bad_value(name, "longer than 0", span, "(0, 0, 0)"));
        return None;
    }
    Some(vector)
}
