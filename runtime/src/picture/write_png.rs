//! PNG files.

use std::io::{self, Write};

use png::{BitDepth, ColorType, DeflateCompression, Encoder, SrgbRenderingIntent};

use super::Picture;
use super::color::{plain_byte, srgb_byte};

/// How hard files are compressed, of 9: more would take as long as a small picture does, and save a few parts of a hundred.
const LEVEL: u8 = 2;

/// Writes a picture as PNG: 8 bits a channel in sRGB, with straight alpha unless it is opaque everywhere. The texts go into
/// chunks of their own, keyword and text.
///
/// # Errors
/// What the writer says, and of keywords that PNG does not take (1 to 79 characters of Latin-1).
pub fn write_png(picture: &Picture, text: &[(String, String)], out: &mut impl Write) -> io::Result<()> {
    let opaque = picture.color.iter().all(|color| color[3] >= 1.0);
    let mut encoder = Encoder::new(out, picture.crop.width, picture.crop.height);
    encoder.set_color(if opaque { ColorType::Rgb } else { ColorType::Rgba });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_deflate_compression(DeflateCompression::Level(LEVEL));
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    for (keyword, text) in text {
        if text.is_ascii() {
            encoder.add_text_chunk(keyword.clone(), text.clone())?;
        } else {
            encoder.add_itxt_chunk(keyword.clone(), text.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut row = Vec::new();
    for colors in picture.color.chunks(picture.crop.width.max(1) as usize) {
        row.clear();
        for color in colors {
            let bytes = bytes(*color);
            row.extend_from_slice(if opaque { &bytes[..3] } else { &bytes });
        }
        stream.write_all(&row)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(())
}

fn bytes([red, green, blue, alpha]: [f32; 4]) -> [u8; 4] {
    if alpha <= 0.0 {
        return [0; 4];
    }
    [srgb_byte(red / alpha), srgb_byte(green / alpha), srgb_byte(blue / alpha), plain_byte(alpha)]
}
