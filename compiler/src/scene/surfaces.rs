//! Materials and textures.

use std::collections::HashMap;

use glam::DVec3;
use treegen_runtime::form::{Chunks, Fbm, Fourier, Image, Material, Pattern, Space, Texture, TextureId};

use super::fields::Data;
use super::{Fields, Setting};
use crate::constant::Constants;
use crate::fields as rules;
use crate::lower::origin;
use crate::pictures::Pictures;
use crate::program::{FieldValue, MaterialId, Record};
use crate::words;

/// The materials that a graph names, in its order, and the textures that these name.
pub(crate) fn surfaces(setting: &Setting, used: &[MaterialId]) -> (Vec<Material>, Vec<Texture>) {
    let mut materials: Vec<Material> =
        used.iter().filter_map(|it| setting.materials.get(it.index()).cloned()).collect();
    let mut textures = Vec::new();
    let mut numbers: HashMap<TextureId, TextureId> = HashMap::new();
    // What is shown has only textures that have an effect.
    let mut number = |texture: TextureId| {
        if let Some(number) = numbers.get(&texture) {
            return Some(*number);
        }
        textures.push(setting.textures.get(texture.0 as usize)?.clone()?);
        let number = TextureId(textures.len() as u32 - 1);
        numbers.insert(texture, number);
        Some(number)
    };
    for Material { shade, bump, relief, .. } in &mut materials {
        *shade = shade.and_then(&mut number);
        *bump = bump.and_then(&mut number);
        *relief = relief.and_then(&mut number);
    }
    (materials, textures)
}

pub(super) fn material(constants: &mut Constants<'_>, record: &Record) -> Material {
    let fields = Fields::find(constants, record, rules::MATERIAL);
    let default = Material::default();
    Material {
        name: record.name.clone(),
        color: fields.vector("color").unwrap_or(default.color),
        range: fields.vector("range").unwrap_or(default.range),
        shade: fields.texture("shade").map(TextureId),
        amount: fields.number("amount").unwrap_or(default.amount),
        bump: fields.texture("bump").map(TextureId),
        relief: fields.texture("relief").map(TextureId),
        depth: fields.number("depth").unwrap_or(default.depth),
        roughen: fields.number("roughen").unwrap_or(default.roughen),
        gloss: fields.number("gloss").unwrap_or(default.gloss),
        mirror: fields.number("mirror").unwrap_or(default.mirror),
        translucent: fields.number("translucent").unwrap_or(default.translucent),
        origin: origin(record.span),
    }
}

/// A texture; none if its kind has no effect yet.
pub(super) fn texture(constants: &mut Constants<'_>, pictures: &mut Pictures<'_>, record: &Record) -> Option<Texture> {
    let kind = record.fields.iter().find_map(|it| match (it.name, &it.value) {
        ("kind", FieldValue::Word(word)) => Some(*word),
        _ => None,
    })?;
    let fields = Fields::find(constants, record, rules::texture(kind));
    let pattern = match kind {
        "fourier" => Pattern::Fourier(fourier(&fields)),
        "fbm" => Pattern::Fbm(fbm(&fields)),
        "image" => Pattern::Image(image(constants, pictures, record, &fields)?),
        "chunks" => Pattern::Chunks(chunks(constants, record, &fields)?),
        _ => return None,
    };
    let default = Texture::new(pattern);
    Some(Texture {
        name: record.name.clone(),
        space: match fields.word("space") {
            Some("object") => Space::Object,
            Some("stem") => Space::Stem,
            Some(_) => Space::World,
            None => default.space,
        },
        seed: fields.number("seed").unwrap_or(default.seed),
        stretch: fields.vector("stretch").map_or(default.stretch, DVec3::from),
        offset: fields.vector("offset").map_or(default.offset, DVec3::from),
        origin: origin(record.span),
        ..default
    })
}

/// What an image shows; none if there is a problem with it, which is then reported.
fn image(
    constants: &mut Constants<'_>,
    pictures: &mut Pictures<'_>,
    record: &Record,
    fields: &Fields<'_>,
) -> Option<Image> {
    if fields.broken {
        return None;
    }
    let (Some(file), Some(span)) = (fields.text("file"), fields.value_span("file")) else {
        constants.report(words::records::missing_field("an `image` texture", "file", record.span));
        return None;
    };
    match pictures.find(file, span) {
        Ok(raster) => Some(Image { raster, size: fields.number("size").unwrap_or(1.0) }),
        Err(problem) => {
            constants.report(problem);
            None
        }
    }
}

fn fourier(fields: &Fields<'_>) -> Fourier {
    let default = Fourier::default();
    Fourier {
        terms: fields.number("terms").map_or(default.terms, |it| it as u32),
        frequency: fields.number("frequency").unwrap_or(default.frequency),
        phase: fields.number("phase").unwrap_or(default.phase),
        ratio: fields.number("ratio").unwrap_or(default.ratio),
        gain: fields.number("gain").unwrap_or(default.gain),
    }
}

/// Chunks of colour; none if there is a problem with them, which is then reported.
fn chunks(constants: &mut Constants<'_>, record: &Record, fields: &Fields<'_>) -> Option<Chunks> {
    if fields.broken {
        return None;
    }
    let span = |name: &str| fields.value_span(name).unwrap_or(record.span);
    let Some(Data::Colors(colors)) = fields.data("colors") else {
        constants.report(words::records::missing_field("a texture of `chunks`", "colors", record.span));
        return None;
    };
    if colors.is_empty() || colors.len() > Chunks::MOST_COLORS {
        let needs = format!("a list of 1 to {} colors", Chunks::MOST_COLORS);
        let is = words::count(colors.len(), "color");
        constants.report(words::records::bad_value("colors", &needs, span("colors"), &is));
        return None;
    }
    let share = match fields.data("share") {
        Some(Data::Numbers(share)) => share.clone(),
        _ => vec![1.0; colors.len()],
    };
    let sum: f64 = share.iter().sum();
    if share.len() != colors.len() || share.iter().any(|it| *it < 0.0) || !(sum > 0.0 && sum.is_finite()) {
        let needs = format!("{}, one a color, 0 or more and not all 0", words::count(colors.len(), "part"));
        let is = words::count(share.len(), "part");
        constants.report(words::records::bad_value("share", &needs, span("share"), &is));
        return None;
    }
    let chunk = match fields.data("chunk") {
        Some(Data::Parts(parts)) if let [least, most] = parts.as_slice() => [*least as u32, *most as u32],
        _ => [1, 4],
    };
    if chunk[0] > chunk[1] {
        let is = format!("({}, {})", chunk[0], chunk[1]);
        constants.report(words::records::bad_value(
            "chunk",
            "the least and the most, in this order",
            span("chunk"),
            &is,
        ));
        return None;
    }
    Some(Chunks {
        cube: fields.number("cube").map_or(64, |it| it as u32),
        size: fields.number("size").unwrap_or(1.0),
        count: fields.number("count").map_or(4000, |it| it as u32),
        chunk,
        colors: colors.clone(),
        share,
    })
}

fn fbm(fields: &Fields<'_>) -> Fbm {
    let default = Fbm::default();
    Fbm {
        dimension: fields.number("dimension").unwrap_or(default.dimension),
        octaves: fields.number("octaves").map_or(default.octaves, |it| it as u32),
        frequency: fields.number("frequency").unwrap_or(default.frequency),
        lacunarity: fields.number("lacunarity").unwrap_or(default.lacunarity),
    }
}
