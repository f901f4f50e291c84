//! What stands before the primitives in a file for POV-Ray: how to run it, camera, lights, sky, materials.

use std::fmt::Write;

use glam::DVec3;

use super::pov_solid::{DECLARATIONS, Triple};
use crate::form::{Background, Camera, Lens, Material, Scene};
use crate::picture::camera::{half_span, unit, upright};
use crate::picture::light::{Lights, SkyLight};
use crate::picture::paint::{self, Gloss};

/// How far away the lights are, in units of POV-Ray: beyond everything, and nearer than where POV-Ray stops to look.
const FAR: f64 = 1e6;

/// So many colours of the sky are given between straight down and straight up.
const SKY_STEPS: u32 = 32;

/// The colour, sRGB, of a material on the solid that has this route.
pub(super) fn varied(material: &Material, route: u64) -> DVec3 {
    paint::varied(DVec3::from_array(material.color), DVec3::from_array(material.range), route)
}

/// All that stands before the primitives. A scene has `scale` times its size there.
pub(super) fn header(scene: &Scene, scale: f64) -> String {
    let image = &scene.image;
    let mut text = String::new();
    let _ = writeln!(text, "// povray +W{} +H{} +A FILE", image.width, image.height);
    text.push_str("#version 3.7;\nglobal_settings { assumed_gamma 1 }\nbackground { color rgbt <0, 0, 0, 1> }\n");
    let lights = Lights::of(&scene.suns, &scene.sky.clone().unwrap_or_default(), image.background);
    if let Some(camera) = &scene.camera {
        write_camera(camera, (image.width, image.height), scale, &mut text);
    }
    write_lights(&lights, scale, &mut text);
    if image.background == Background::Sky {
        write_sky(&lights.sky, &mut text);
    }
    write_materials(&scene.materials, lights.sky.mean, &mut text);
    text.push_str(DECLARATIONS);
    text
}

fn write_camera(camera: &Camera, (width, height): (u32, u32), scale: f64, text: &mut String) {
    let forward = unit(camera.target - camera.eye).unwrap_or(DVec3::Y);
    let (_, up) = upright(forward, camera.up);
    let (kind, span) = match camera.lens {
        Lens::Perspective(fov) => ("perspective", 2.0 * half_span(fov)),
        Lens::Orthographic(length) => ("orthographic", length * scale),
    };
    let pixel = span / f64::from(width.min(height));
    let [across, down] = [width, height].map(|it| (pixel * f64::from(it)).min(f64::MAX));
    // To the right is -x where space is right-handed.
    let _ = writeln!(
        text,
        "camera {{\n  {kind} location {} direction z right {:?}*x up {down:?}*y\n  sky {} look_at {}\n}}",
        Triple(camera.eye * scale),
        -across,
        Triple(up),
        Triple(camera.target * scale),
    );
}

fn write_lights(lights: &Lights, scale: f64, text: &mut String) {
    for sun in &lights.suns {
        write_light(sun.toward, sun.color, "", text);
    }
    // The light of the sky is linear in the normal. POV-Ray's ambient light is the constant part; each slope is a light without
    // shadow, and one that takes as much away on the other side.
    let sky = &lights.sky;
    for (toward, slope) in [(DVec3::Z, sky.upward), (sky.side, sky.sunward)] {
        let color = slope * (2.0 / 3.0);
        if color != DVec3::ZERO && toward != DVec3::ZERO {
            write_light(toward, color, " shadowless", text);
            write_light(-toward, -color, " shadowless", text);
        }
    }
    let distance = scale / lights.haze;
    if distance > 0.0 && distance.is_finite() {
        let color = Triple(sky.seen(DVec3::X));
        let _ = writeln!(text, "fog {{ fog_type 1 distance {distance:?} color rgb {color} }}");
    }
}

fn write_light(toward: DVec3, color: DVec3, more: &str, text: &mut String) {
    let (at, color) = (Triple(toward * FAR), Triple(color));
    let _ = writeln!(text, "light_source {{ {at}, color rgb {color} parallel point_at 0{more} }}");
}

fn write_sky(sky: &SkyLight, text: &mut String) {
    text.push_str("sky_sphere { pigment { gradient z color_map {\n");
    for step in 0..=SKY_STEPS {
        let part = f64::from(step) / f64::from(SKY_STEPS);
        let height = 2.0 * part - 1.0;
        let direction = DVec3::new((1.0 - height * height).sqrt(), 0.0, height);
        let _ = writeln!(text, "  [{part:?} color rgb {}]", Triple(sky.seen(direction)));
    }
    text.push_str("} scale 2 translate -z } }\n");
}

fn write_materials(materials: &[Material], ambient: DVec3, text: &mut String) {
    let finish = |material: &Material| {
        let gloss = Gloss::new(material.gloss)
            .map_or(String::new(), |it| format!(" specular {:?} roughness {:?}", it.strength, 1.0 / it.exponent()));
        format!("ambient rgb {} diffuse 1{gloss}", Triple(ambient))
    };
    let color = |material: &Material| Triple(DVec3::from_array(material.color));
    let plain = Material::default();
    let _ = writeln!(text, "#default {{ pigment {{ color srgb {} }} finish {{ {} }} }}", color(&plain), finish(&plain));
    for (number, material) in materials.iter().enumerate() {
        let _ = writeln!(text, "#declare Finish_{number} = finish {{ {} }}", finish(material));
        let _ = writeln!(
            text,
            "#declare Material_{number} = texture {{ pigment {{ color srgb {} }} finish {{ Finish_{number} }} }} // {}",
            color(material),
            material.name.replace(char::is_control, " "),
        );
    }
}
