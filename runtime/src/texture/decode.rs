//! Decoding the files of rasters.

use std::io::Cursor;

use glam::DVec3;
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, Limits};

use crate::form::{Raster, Texel};
use crate::picture::color::linear;

/// Why a file is no picture to be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BadPicture {
    /// It does not begin as a PNG file does.
    NotPng,
    /// It has more pixels than there may be.
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// It cannot be read to its end.
    Broken(String),
}

/// The picture in a PNG file, with so many pixels at most. Its size is looked at before memory is taken for it. What is transparent
/// shows the colour that it has in the file.
///
/// # Errors
/// Why it cannot be used.
pub fn decode_png(bytes: &[u8], most: u64) -> Result<Raster, BadPicture> {
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err(BadPicture::NotPng);
    }
    let broken = |error: ImageError| BadPicture::Broken(error.to_string());
    let mut limits = Limits::default();
    // Lines are unpacked to 8 bytes a pixel at most, twice.
    limits.max_alloc = Some(most.saturating_mul(16).max(1 << 20));
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > most {
        return Err(BadPicture::TooLarge { width, height });
    }
    let pixels = DynamicImage::from_decoder(decoder).map_err(broken)?.into_rgb16();
    let light = Light::new();
    let texels = pixels.pixels().map(|it| light.texel(it.0)).collect();
    Raster::new(width, height, texels).ok_or_else(|| BadPicture::Broken("it has no pixels".to_owned()))
}

/// How much light each number of an sRGB channel stands for.
struct Light(Vec<u16>);

impl Light {
    fn new() -> Self {
        let light = |it: u16| (linear(DVec3::splat(f64::from(it) / 65535.0)).x * 65535.0 + 0.5) as u16;
        Self((0..=u16::MAX).map(light).collect())
    }

    fn texel(&self, [red, green, blue]: [u16; 3]) -> Texel {
        let sum = u32::from(red) + u32::from(green) + u32::from(blue);
        let [r, g, b] = [red, green, blue].map(|it| self.0[usize::from(it)]);
        [r, g, b, ((sum + 1) / 3) as u16]
    }
}
