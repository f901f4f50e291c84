//! Mirrors and textured surfaces in pictures, against closed forms.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;
mod spheres;

use common::Builder;
use glam::DVec3;
use spheres::{Spheres, from_above, scene, sphere, sun};
use treegen_runtime::form::{
    Camera, Fbm, Fourier, Lens, Material, MaterialId, NodeId, Pattern, PrimitiveKind, Scene, Sky, Space, Texture,
    TextureId, TransformKind,
};
use treegen_runtime::picture::{EXPOSURE, MAX_BOUNCES, Picture, RenderOptions, render};
use treegen_runtime::texture::{Field, Footprint};
use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{FaultKind, Limits};

/// No light but what suns give.
const DARK: Sky = Sky { color: [0.0; 3], strength: 0.0, haze: 0.0 };

fn picture(scene: &Scene, tracer: &dyn Tracer) -> Picture {
    render(scene, tracer, &RenderOptions::default(), &()).unwrap()
}

fn ground() -> Spheres {
    Spheres { ground: true, ..Spheres::default() }
}

/// How far two pictures are apart at most.
fn apart(a: &Picture, b: &Picture) -> f32 {
    let both = a.color.iter().flatten().zip(b.color.iter().flatten());
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Things to be seen: a Sierpinski tetrahedron, a block and a ball, between the heights 2 and 6.
fn things(b: &mut Builder) -> NodeId {
    let fractal = {
        let scene = common::sierpinski(3.0);
        *b = Builder { nodes: scene.graph.nodes().to_vec(), selects: scene.graph.selects().to_vec() };
        scene.graph.system(scene.graph.root()).start
    };
    let fractal = b.paint(1, fractal);
    let block = b.primitive(PrimitiveKind::Box, &[]);
    let block = b.paint(2, block);
    let ball = b.primitive(PrimitiveKind::Sphere, &[]);
    let places = [(fractal, [-1.4, 0.3, 4.0], 30.0), (block, [1.6, -0.4, 4.2], 70.0), (ball, [0.2, 1.6, 3.5], 0.0)];
    let placed = places.map(|(body, place, angle)| {
        let turned = b.transform(TransformKind::Rotate, &[1.0, 0.4, 0.2, angle], body);
        b.transform(TransformKind::Move, &place, turned)
    });
    b.union(&placed)
}

fn materials() -> Vec<Material> {
    let mirror = Material { mirror: 1.0, color: [0.0; 3], ..Material::default() };
    let red = Material { color: [0.8, 0.2, 0.1], gloss: 0.7, ..Material::default() };
    let green = Material { color: [0.2, 0.5, 0.3], ..Material::default() };
    vec![mirror, green, red]
}

/// A look down at the mirror image of all [`things`], which are lit from one side; no thing itself is in view.
fn looked_down(start: impl FnOnce(&mut Builder) -> NodeId, light: [f64; 3], haze: f64) -> Scene {
    let mut b = Builder::default();
    let start = start(&mut b);
    let mut scene = b.scene(start);
    scene.materials = materials();
    scene.suns = vec![sun(light)];
    scene.sky = Some(Sky { haze, ..DARK });
    let (eye, target) = (DVec3::new(0.3, -7.0, 1.5), DVec3::new(0.0, 0.0, -3.8));
    scene.camera = Some(Camera { eye, target, up: DVec3::Z, lens: Lens::Perspective(44.0) });
    (scene.image.width, scene.image.height, scene.image.samples) = (60, 45, 1);
    scene
}

#[test]
fn a_mirror_shows_what_a_mirrored_scene_shows() {
    let (light, haze) = ([0.3, 0.8, -0.05], 0.02);
    let in_mirror = looked_down(
        |b| {
            let things = things(b);
            let plane = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 0.0, 1.0, 0.0]);
            let plane = b.paint(0, plane);
            b.union(&[plane, things])
        },
        light,
        haze,
    );
    let mirrored = looked_down(
        |b| {
            let things = things(b);
            b.transform(TransformKind::Mirror, &[0.0, 0.0, 1.0], things)
        },
        [light[0], light[1], -light[2]],
        haze,
    );
    let limits = Limits::default();
    let by_cells = |scene: &Scene| picture(scene, &CellTracer::new(scene, &limits, Culling::State).unwrap());
    let by_the_book = |scene: &Scene| picture(scene, &Reference::new(scene, &limits));
    for (image, things) in [
        (by_cells(&in_mirror), by_cells(&mirrored)),
        (by_the_book(&in_mirror), by_the_book(&mirrored)),
        (by_cells(&in_mirror), by_the_book(&mirrored)),
    ] {
        let differs = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-5);
        let different = image.color.iter().zip(&things.color).filter(differs).count();
        // Rays along an edge may fall on its other side.
        assert!(different <= 2, "{different} pixels differ");
        let lit = things.color.iter().filter(|it| it[0] > 0.02).count();
        assert!(lit > 200, "{lit}");
        assert_eq!(image.rays.reflected, image.rays.camera);
    }
}

#[test]
fn a_mirror_takes_its_share_from_the_surface_and_gives_it_to_the_sky() {
    let sky = Sky { color: [1.0, 0.0, 0.0], strength: 0.6, haze: 0.0 };
    let with = |mirror: f64| {
        let mut scene = scene(from_above(1.0), vec![sun([0.3, 0.0, -1.0])], (2, 2), 1);
        scene.sky = Some(sky.clone());
        scene.materials[0].mirror = mirror;
        picture(&scene, &ground()).color[0]
    };
    let bare = with(0.0);
    for mirror in [0.1, 0.5, 1.0] {
        let found = with(mirror);
        // Straight up the sky has the colour that the program names.
        for (channel, above) in [0.6, 0.0, 0.0].into_iter().enumerate() {
            let expected = (1.0 - mirror as f32) * bare[channel] + mirror as f32 * above;
            assert!((found[channel] - expected).abs() < 1e-6, "{mirror} {channel}: {} {expected}", found[channel]);
        }
        assert_eq!(found[3], 1.0);
    }
}

#[test]
fn the_image_of_a_mirror_grows_towards_grazing_angles_and_its_highlight_stays() {
    let toward = |height: f64| {
        let eye = DVec3::new(0.0, -libm::cos(height), libm::sin(height)) * 5.0;
        let camera = Camera { eye, target: DVec3::ZERO, up: DVec3::Z, lens: Lens::Orthographic(0.01) };
        let mut scene = scene(camera, Vec::new(), (1, 1), 1);
        scene.sky = Some(Sky { color: [1.0; 3], strength: 1.0, haze: 0.0 });
        scene.materials[0].color = [0.0; 3];
        scene.materials[0].mirror = 0.04;
        f64::from(picture(&scene, &ground()).color[0][0])
    };
    for height in [0.05, 0.3, 0.8, 1.5] {
        let rest = libm::pow(1.0 - libm::sin(height), 5.0);
        // A white sky is white in all directions above the horizon.
        assert!((toward(height) - (0.04 + 0.96 * rest)).abs() < 1e-6, "{height}");
    }
}

/// A room of two mirrors that face each other, seen from between them: what is left after the last bounce.
fn between_mirrors(mirror: f64) -> Picture {
    let mut b = Builder::default();
    let near = b.primitive(PrimitiveKind::HalfSpace, &[0.0, -1.0, 0.0, -3.0]);
    let far = b.primitive(PrimitiveKind::HalfSpace, &[0.0, 1.0, 0.0, -3.0]);
    let both = b.union(&[near, far]);
    let start = b.paint(0, both);
    let mut scene = b.scene(start);
    scene.materials = vec![Material { mirror, color: [0.0; 3], ..Material::default() }];
    scene.suns = vec![sun([0.2, 0.1, -1.0])];
    scene.sky = Some(Sky { color: [1.0; 3], strength: 0.5, haze: 0.0 });
    scene.camera = Some(Camera { eye: DVec3::ZERO, target: DVec3::Y, up: DVec3::Z, lens: Lens::Orthographic(1.0) });
    (scene.image.width, scene.image.height, scene.image.samples) = (4, 3, 1);
    picture(&scene, &CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap())
}

#[test]
fn mirrors_that_face_each_other_end_in_the_sky_after_the_last_bounce() {
    let bounces = u64::from(MAX_BOUNCES);
    for (mirror, followed) in [(1.0, bounces), (0.9, bounces), (0.5, 9), (0.04, 1), (0.001, 0)] {
        let made = between_mirrors(mirror);
        // Each mirror leaves so much; the level sky is half way from its colour, half as bright as white, to itself.
        let expected = libm::pow(mirror, followed as f64 + 1.0) * 0.5;
        assert_eq!(made.rays.reflected, followed * made.rays.camera, "{mirror}");
        for color in &made.color {
            assert!((f64::from(color[0]) - expected).abs() < 1e-6, "{mirror}: {} for {expected}", color[0]);
        }
    }
}

/// Spheres and ground that mirror, are shaded and bumped, seen from the side.
fn still_life() -> (Scene, Spheres) {
    let camera =
        Camera { eye: DVec3::new(3.0, -6.0, 2.5), target: DVec3::Z * 0.7, up: DVec3::Z, lens: Lens::Perspective(35.0) };
    let mut scene = scene(camera, vec![sun([-1.0, 0.6, -1.2])], (47, 33), 4);
    let world = |pattern| Texture { space: Space::World, ..Texture::new(pattern) };
    scene.textures = vec![
        world(Pattern::Fbm(Fbm::default())),
        world(Pattern::Fourier(Fourier { frequency: 2.0, ..Fourier::default() })),
    ];
    scene.materials[0] = Material {
        mirror: 0.3,
        gloss: 0.5,
        shade: Some(TextureId(1)),
        amount: 0.7,
        bump: Some(TextureId(0)),
        depth: 0.1,
        ..scene.materials[0].clone()
    };
    let mut spheres: Vec<_> =
        (0..5).map(|i| sphere([f64::from(i) * 0.9 - 1.8, f64::from(i % 2) - 0.5, 0.5], 0.45)).collect();
    spheres.iter_mut().step_by(2).for_each(|sphere| sphere.material = Some(MaterialId(0)));
    (scene, Spheres { spheres, ..ground() })
}

#[test]
fn tiles_threads_and_crops_change_no_mirror_and_no_texture() {
    let (scene, tracer) = still_life();
    let made = |tile: u32, count: usize| {
        let options = RenderOptions { tile, ..RenderOptions::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        pool.install(|| render(&scene, &tracer, &options, &()).unwrap())
    };
    let first = made(16, 1);
    assert!(first.rays.reflected > first.rays.camera / 4);
    for (tile, count) in [(16, 2), (1, 3), (7, 1), (64, 2)] {
        assert_eq!(made(tile, count), first, "tiles of {tile}, {count} threads");
    }
    let crop = treegen_runtime::picture::Rect { x: 11, y: 9, width: 20, height: 13 };
    let options = RenderOptions { crop: Some(crop), ..RenderOptions::default() };
    let part = render(&scene, &tracer, &options, &()).unwrap();
    for row in 0..13 {
        let from = (9 + row) * 47 + 11;
        assert_eq!(first.color[from..from + 20], part.color[row * 20..(row + 1) * 20]);
    }
}

#[test]
fn a_fault_in_a_mirror_is_that_of_the_lowest_pixel_that_shows_it() {
    let mut scene = scene(from_above(32.0), Vec::new(), (32, 32), 1);
    scene.materials[0].mirror = 1.0;
    let faulty: fn(DVec3) -> bool = |p| p.y < 4.0 && p.x > 3.0;
    let tracer = Spheres { faulty_image: Some(faulty), ..ground() };
    let made = |tile: u32| {
        let options = RenderOptions { tile, ..RenderOptions::default() };
        render(&scene, &tracer, &options, &()).unwrap_err()
    };
    let FaultKind::Range { value, low, .. } = made(16).kind else { panic!() };
    // The first pixel from above, and of those the leftmost.
    assert_eq!((value, low), (3.0, 3.0));
    for tile in [1, 5, 64] {
        assert_eq!(made(tile), made(16));
    }
}

/// The ground from above, one sample a pixel, with a texture of the world: its picture, and what the texture is at each pixel.
fn textured(texture: Texture, material: Material, span: f64) -> (Vec<f64>, Vec<treegen_runtime::texture::Tone>) {
    let mut scene = scene(from_above(span), vec![sun([0.0, 0.0, -1.0])], (16, 16), 1);
    scene.sky = Some(DARK);
    let field = Field::new(&texture, scene.seed);
    scene.textures = vec![texture];
    scene.materials[0] = Material { color: [1.0; 3], ..material };
    let light = picture(&scene, &ground()).color.iter().map(|it| f64::from(it[0]) / EXPOSURE).collect();
    let pixel = span / 16.0;
    let footprint = Footprint::new(DVec3::NEG_Z, pixel, DVec3::Z);
    let place = |it: u32| (f64::from(it) - 7.5) * pixel;
    let tones = (0..256).map(|it| field.at(DVec3::new(place(it % 16), -place(it / 16), 0.0), &footprint)).collect();
    (light, tones)
}

fn world_textures() -> [Texture; 2] {
    let fourier = Fourier { frequency: 0.4, ..Fourier::default() };
    [Pattern::Fourier(fourier), Pattern::Fbm(Fbm::default())]
        .map(|it| Texture { space: Space::World, ..Texture::new(it) })
}

#[test]
fn a_shaded_surface_has_the_tone_of_its_texture() {
    for texture in world_textures() {
        for amount in [0.4, 1.0] {
            let shaded = Material { shade: Some(TextureId(0)), amount, ..Material::default() };
            let (light, tones) = textured(texture.clone(), shaded, 6.0);
            for (light, tone) in light.iter().zip(&tones) {
                let expected = 1.0 - amount * (1.0 - tone.value.clamp(0.0, 1.0));
                assert!((light - expected).abs() < 1e-6, "{light} {expected}");
            }
            assert!(tones.iter().any(|it| (it.value - tones[0].value).abs() > 0.1));
        }
    }
}

#[test]
fn a_bumped_plane_is_lit_like_the_hills_it_stands_for() {
    for texture in world_textures() {
        for depth in [0.1, 1.0] {
            let bumped = Material { bump: Some(TextureId(0)), depth, ..Material::default() };
            let (light, tones) = textured(texture.clone(), bumped, 6.0);
            for (light, tone) in light.iter().zip(&tones) {
                // The cosine of the slope of z = depth * value, under a sun that stands straight above.
                let (dx, dy) = (tone.slope.x * depth, tone.slope.y * depth);
                let expected = 1.0 / (1.0 + dx * dx + dy * dy).sqrt();
                assert!((light - expected).abs() < 1e-6, "{light} {expected}");
            }
            assert!(light.iter().any(|it| (it - light[0]).abs() > 0.01 * depth));
        }
    }
}

#[test]
fn from_far_away_a_texture_is_one_tone() {
    for texture in world_textures() {
        let mean = Field::new(&texture, 0).mean();
        let material =
            Material { shade: Some(TextureId(0)), bump: Some(TextureId(0)), depth: 5.0, ..Material::default() };
        let (light, _) = textured(texture, material, 1e4);
        assert!(light.iter().all(|it| (it - mean).abs() < 1e-6 && *it == light[0]));
    }
}

#[test]
fn the_same_place_looks_the_same_from_two_cameras() {
    for texture in world_textures() {
        let seen_at = |shift: f64| {
            let mut camera = from_above(4.0);
            let by = DVec3::new(shift, -2.0 * shift, 0.0);
            (camera.eye, camera.target) = (camera.eye + by, camera.target + by);
            let mut scene = scene(camera, vec![sun([0.4, 0.0, -1.0])], (32, 32), 1);
            scene.textures = vec![texture.clone()];
            scene.materials[0] = Material {
                shade: Some(TextureId(0)),
                bump: Some(TextureId(0)),
                depth: 0.2,
                ..scene.materials[0].clone()
            };
            picture(&scene, &ground()).color
        };
        // Four pixels to the right and eight down, in steps that are exact.
        let (here, there) = (seen_at(0.0), seen_at(0.5));
        for row in 8..32 {
            assert_eq!(here[row * 32 + 4..(row + 1) * 32], there[(row - 8) * 32..(row - 8) * 32 + 28]);
        }
    }
}

/// A ball with a texture that goes with it, and the camera, both moved and turned.
fn ball(by: f64, space: Space) -> Picture {
    let mut b = Builder::default();
    let body = b.primitive(PrimitiveKind::Sphere, &[]);
    let painted = b.paint(0, body);
    let start = b.transform(TransformKind::Move, &[by, 2.0 * by, -by], painted);
    let mut scene = b.scene(start);
    scene.textures = vec![Texture { space, ..Texture::new(Pattern::Fbm(Fbm { frequency: 1.3, ..Fbm::default() })) }];
    let texture = Some(TextureId(0));
    scene.materials = vec![Material { shade: texture, bump: texture, depth: 0.3, ..Material::default() }];
    scene.suns = vec![sun([0.5, 0.3, -1.0])];
    let place = DVec3::new(by, 2.0 * by, -by);
    let (eye, target) = (place + DVec3::new(1.0, -4.0, 2.0), place);
    scene.camera = Some(Camera { eye, target, up: DVec3::Z, lens: Lens::Perspective(35.0) });
    (scene.image.width, scene.image.height, scene.image.samples) = (40, 40, 1);
    let tracer = CellTracer::new(&scene, &Limits::default(), Culling::State).unwrap();
    let made = picture(&scene, &tracer);
    assert!(apart(&made, &picture(&scene, &Reference::new(&scene, &Limits::default()))) < 1e-4);
    made
}

#[test]
fn a_texture_goes_with_its_thing_or_stays_in_the_world() {
    assert!(apart(&ball(0.0, Space::Object), &ball(8.0, Space::Object)) < 1e-5);
    assert!(apart(&ball(0.0, Space::World), &ball(8.0, Space::World)) > 0.1);
    assert!(apart(&ball(0.0, Space::Object), &ball(0.0, Space::World)) < 1e-5);
}
