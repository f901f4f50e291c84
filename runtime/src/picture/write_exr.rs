//! OpenEXR files, for compositors and tests.

use std::io::{self, Seek, Write};

use exr::image::Blocks;
use exr::prelude::{
    AttributeValue, Compression, Encoding, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder,
    SpecificChannels, Text, Vec2, WritableImage,
};

use super::exr_header::SortedHeader;
use super::{Layers, Picture};

/// Writes a picture as OpenEXR: linear and premultiplied, in single precision, without loss. The display window is the whole
/// picture and the data window the part that is here.
///
/// The channels are `R`, `G`, `B`, `A`, and of the layers `Z`, `N.x`, `N.y`, `N.z`, `P.x`, `P.y`, `P.z` and `material`, a whole
/// number. The texts become attributes, and so do the names of the materials (`material.2` and so on).
///
/// # Errors
/// What the writer says, and of names that are empty or longer than 255 bytes or not of ASCII.
pub fn write_exr(picture: &Picture, text: &[(String, String)], out: &mut (impl Write + Seek)) -> io::Result<()> {
    match &picture.layers {
        None => write_channels(picture, text, out),
        Some(layers) => write_layers(picture, layers, text, out),
    }
}

fn write_channels(picture: &Picture, text: &[(String, String)], out: &mut (impl Write + Seek)) -> io::Result<()> {
    let width = picture.crop.width as usize;
    let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
        let [red, green, blue, alpha] = picture.color[at.y() * width + at.x()];
        (red, green, blue, alpha)
    });
    let image = image(picture, attributes(text, &[]), channels);
    // Compression in parallel would make threads of its own beside those of the caller.
    image.write().non_parallel().to_unbuffered(SortedHeader::new(out)).map_err(io_error)
}

fn write_layers(
    picture: &Picture,
    layers: &Layers,
    text: &[(String, String)],
    out: &mut (impl Write + Seek),
) -> io::Result<()> {
    let width = picture.crop.width as usize;
    let channels = SpecificChannels::build()
        .with_channel("R")
        .with_channel("G")
        .with_channel("B")
        .with_channel("A")
        .with_channel("Z")
        .with_channel("N.x")
        .with_channel("N.y")
        .with_channel("N.z")
        .with_channel("P.x")
        .with_channel("P.y")
        .with_channel("P.z")
        .with_channel("material")
        .with_pixel_fn(|at: Vec2<usize>| {
            let index = at.y() * width + at.x();
            let [red, green, blue, alpha] = picture.color[index];
            let [nx, ny, nz] = layers.normal[index];
            let [px, py, pz] = layers.position[index];
            (red, green, blue, alpha, layers.depth[index], nx, ny, nz, px, py, pz, layers.material[index])
        });
    let image = image(picture, attributes(text, &layers.materials), channels);
    image.write().non_parallel().to_unbuffered(SortedHeader::new(out)).map_err(io_error)
}

fn image<C>(picture: &Picture, attributes: LayerAttributes, channel_data: C) -> Image<Layer<C>> {
    let crop = picture.crop;
    let layer = Layer {
        channel_data,
        attributes: LayerAttributes { layer_position: Vec2(crop.x as i32, crop.y as i32), ..attributes },
        size: Vec2(crop.width as usize, crop.height as usize),
        // Lines in order: the bytes are the same each time.
        encoding: Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
    };
    let window = IntegerBounds::new((0, 0), (picture.width as usize, picture.height as usize));
    Image { attributes: ImageAttributes::new(window), layer_data: layer }
}

fn attributes(text: &[(String, String)], materials: &[String]) -> LayerAttributes {
    let mut attributes = LayerAttributes::default();
    let materials =
        materials.iter().enumerate().map(|(number, name)| (format!("material.{}", number + 2), name.clone()));
    for (name, value) in text.iter().cloned().chain(materials) {
        attributes.other.insert(utf8(&name), AttributeValue::Text(utf8(&value)));
    }
    attributes
}

fn utf8(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

fn io_error(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}
