//! Pictures against closed forms, and against themselves made in other ways.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod spheres;

use std::f64::consts::PI;
use std::io::Cursor;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::DVec3;
use proptest::prelude::*;
use spheres::{Spheres, from_above, scene, sphere, sun};
use treegen_runtime::form::{Background, Camera, Lens, MaterialId, Scene, Sky, Sun};
use treegen_runtime::picture::{
    EXPOSURE, MAX_PIXELS, MAX_SAMPLES, Picture, Rect, RenderOptions, Watch, frame, render, write_exr, write_png,
};
use treegen_runtime::{FaultKind, Limit};

/// No light but what suns give.
const DARK: Sky = Sky { color: [0.0; 3], strength: 0.0, haze: 0.0 };

fn picture(scene: &Scene, tracer: &Spheres) -> Picture {
    render(scene, tracer, &RenderOptions::default(), &()).unwrap()
}

fn ground() -> Spheres {
    Spheres { ground: true, ..Spheres::default() }
}

/// Spheres on the ground seen from the side, with edges, shadows and sky.
fn still_life() -> (Scene, Spheres) {
    let camera =
        Camera { eye: DVec3::new(3.0, -6.0, 2.5), target: DVec3::Z * 0.7, up: DVec3::Z, lens: Lens::Perspective(35.0) };
    let mut scene =
        scene(camera, vec![sun([-1.0, 0.6, -1.2]), Sun { size: 3.0, ..sun([1.0, 0.4, -1.0]) }], (61, 43), 4);
    scene.materials[0].range = [-0.5, -0.3, -0.2];
    scene.materials[0].gloss = 0.6;
    let mut spheres: Vec<_> =
        (0..9).map(|i| sphere([f64::from(i) * 0.6 - 2.4, f64::from(i % 3) - 1.0, 0.5], 0.4)).collect();
    spheres.iter_mut().step_by(2).for_each(|sphere| sphere.material = Some(MaterialId(0)));
    (scene, Spheres { spheres, ground: true, ..Spheres::default() })
}

fn threads(count: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap()
}

#[test]
fn a_lit_plane_reflects_by_the_cosine() {
    for angle in [0.0, 0.3, 0.8, 1.3] {
        let mut scene = scene(from_above(1.0), vec![sun([libm::sin(angle), 0.0, -libm::cos(angle)])], (8, 8), 4);
        scene.sky = Some(DARK);
        for color in picture(&scene, &ground()).color {
            let expected = EXPOSURE * libm::cos(angle);
            assert!((f64::from(color[1]) - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn suns_add_up() {
    let lit = |suns: Vec<Sun>| {
        let mut scene = scene(from_above(1.0), suns, (1, 1), 1);
        scene.sky = Some(DARK);
        picture(&scene, &ground()).color[0][0]
    };
    let (a, b) = (sun([0.3, 0.0, -1.0]), Sun { strength: 0.4, ..sun([0.0, 0.8, -1.0]) });
    assert!((lit(vec![a.clone(), b.clone()]) - lit(vec![a]) - lit(vec![b])).abs() < 1e-6);
}

#[test]
fn a_spheres_shadow_has_its_area_by_the_suns_height() {
    for (height, samples) in [(0.5, 1), (1.0, 4), (1.4, 16)] {
        let radius = 0.7;
        // Light from the right throws the shadow clear of the sphere, which is far above the eye of the camera.
        let offset = 200.0 / libm::tan(height);
        let direction = [-libm::cos(height), 0.0, -libm::sin(height)];
        let mut scene = scene(from_above(4.0), vec![sun(direction)], (400, 400), samples);
        scene.sky = Some(DARK);
        let tracer =
            Spheres { spheres: vec![sphere([offset, 0.0, 200.0], radius)], ground: true, ..Spheres::default() };
        let picture = picture(&scene, &tracer);
        let lit = EXPOSURE * libm::sin(height);
        let dark: f64 = picture.color.iter().map(|color| 1.0 - f64::from(color[0]) / lit).sum();
        let area = dark * (4.0 / 400.0) * (4.0 / 400.0);
        let expected = PI * radius * radius / libm::sin(height);
        assert!((area / expected - 1.0).abs() < 0.01, "{height}: {area} for {expected}");
    }
}

#[test]
fn a_soft_shadow_takes_as_much_light_as_a_hard_one_and_has_a_penumbra() {
    let shadow = |size: f64| {
        let mut scene = scene(from_above(4.0), vec![Sun { size, ..sun([-1.0, 0.0, -1.0]) }], (100, 100), 16);
        scene.sky = Some(DARK);
        let tracer = Spheres { spheres: vec![sphere([200.0, 0.0, 200.0], 0.8)], ground: true, ..Spheres::default() };
        picture(&scene, &tracer).color.iter().map(|color| f64::from(color[0])).collect::<Vec<_>>()
    };
    let (hard, soft) = (shadow(0.0), shadow(0.1));
    let between = |picture: &[f64]| picture.iter().filter(|light| (0.1..0.38).contains(*light)).count();
    // Seen from the ground a disc of 0.1 degrees has a radius of 0.25 m at the sphere.
    assert!(between(&soft) > 4 * between(&hard));
    let missing = |picture: &[f64]| picture.iter().map(|light| EXPOSURE / 2.0_f64.sqrt() - light).sum::<f64>();
    assert!((missing(&soft) / missing(&hard) - 1.0).abs() < 0.02);
}

#[test]
fn a_sphere_covers_its_disc() {
    let mut scene = scene(from_above(3.0), Vec::new(), (200, 150), 4);
    scene.image.background = Background::Transparent;
    let tracer = Spheres { spheres: vec![sphere([0.1, -0.2, 0.0], 0.9)], ..Spheres::default() };
    let picture = picture(&scene, &tracer);
    let area = picture.color.iter().map(|color| f64::from(color[3])).sum::<f64>() * (3.0 / 150.0) * (3.0 / 150.0);
    assert!((area / (PI * 0.81) - 1.0).abs() < 2e-3, "{area}");
    // Premultiplied: where nothing is seen there is no colour either.
    assert!(picture.color.iter().all(|color| color[3] > 0.0 || *color == [0.0; 4]));
}

#[test]
fn a_sphere_in_perspective_has_the_radius_of_its_limb() {
    // Of radius 1 at distance 5: its limb lies at 1 / sqrt(5² - 1²) of the focal length.
    let camera =
        Camera { eye: DVec3::new(0.0, -5.0, 0.0), target: DVec3::ZERO, up: DVec3::Z, lens: Lens::Perspective(60.0) };
    let mut scene = scene(camera, Vec::new(), (300, 200), 4);
    scene.image.background = Background::Transparent;
    let picture = picture(&scene, &Spheres { spheres: vec![sphere([0.0; 3], 1.0)], ..Spheres::default() });
    let pixel = 2.0 * libm::tan(PI / 6.0) / 200.0;
    let area = picture.color.iter().map(|color| f64::from(color[3])).sum::<f64>() * pixel * pixel;
    assert!((area / (PI / 24.0) - 1.0).abs() < 2e-3, "{area}");
}

#[test]
fn the_first_pixel_is_the_upper_left_one_and_layers_tell_of_its_centre() {
    let scene = scene(from_above(2.0), Vec::new(), (4, 2), 4);
    let options = RenderOptions { layers: true, ..RenderOptions::default() };
    let picture = render(&scene, &ground(), &options, &()).unwrap();
    let layers = picture.layers.unwrap();
    assert_eq!(layers.position[0], [-1.5, 0.5, 0.0]);
    assert_eq!(layers.position[7], [1.5, -0.5, 0.0]);
    assert_eq!((layers.depth[0], layers.normal[0], layers.material[0]), (100.0, [0.0, 0.0, 1.0], 2));
    assert_eq!(layers.materials, ["White"]);
}

#[test]
fn depth_is_measured_along_the_axis_and_infinite_where_nothing_is() {
    let camera = Camera { eye: DVec3::Z * 3.0, target: DVec3::ZERO, up: DVec3::Y, lens: Lens::Perspective(90.0) };
    let options = RenderOptions { layers: true, samples: Some(1), ..RenderOptions::default() };
    let scene = scene(camera, Vec::new(), (9, 9), 1);
    let layers = render(&scene, &ground(), &options, &()).unwrap().layers.unwrap();
    assert!(layers.depth.iter().all(|depth| (depth - 3.0).abs() < 1e-6));
    let layers = render(&scene, &Spheres::default(), &options, &()).unwrap().layers.unwrap();
    assert!(
        layers.depth.iter().all(|depth| depth.is_infinite()) && layers.material.iter().all(|material| *material == 0)
    );
}

#[test]
fn up_along_the_view_gives_way_to_y_and_then_to_z() {
    for (eye, up, right) in
        [(DVec3::Z, DVec3::Z, DVec3::X), (DVec3::Y, DVec3::Y, DVec3::NEG_X), (DVec3::Z, DVec3::ZERO, DVec3::X)]
    {
        let camera = Camera { eye: eye * 9.0, target: DVec3::ZERO, up, lens: Lens::Orthographic(2.0) };
        let mut scene = scene(camera, Vec::new(), (2, 2), 1);
        scene.image.background = Background::Transparent;
        let on_the_right = Spheres { spheres: vec![sphere((right * 0.5).to_array(), 0.6)], ..Spheres::default() };
        let alpha: Vec<f32> = picture(&scene, &on_the_right).color.iter().map(|color| color[3]).collect();
        assert_eq!(alpha, [0.0, 1.0, 0.0, 1.0]);
    }
}

#[test]
fn tiles_threads_and_repetition_change_nothing() {
    let (scene, tracer) = still_life();
    let made = |tile: u32, count: usize| {
        let options = RenderOptions { tile, layers: true, ..RenderOptions::default() };
        threads(count).install(|| render(&scene, &tracer, &options, &()).unwrap())
    };
    let first = made(16, 1);
    for (tile, count) in [(16, 1), (16, 2), (1, 8), (7, 3), (64, 2), (0, 2)] {
        assert_eq!(made(tile, count), first, "tiles of {tile}, {count} threads");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn a_crop_is_the_whole_picture_there(x in 0u32..61, y in 0u32..43, width in 1u32..61, height in 1u32..43, samples in 1u32..6) {
        let (scene, tracer) = still_life();
        let crop = Rect { x, y, width: width.min(61 - x), height: height.min(43 - y) };
        let options = RenderOptions { samples: Some(samples), layers: true, ..RenderOptions::default() };
        let whole = render(&scene, &tracer, &options, &()).unwrap();
        let part = render(&scene, &tracer, &RenderOptions { crop: Some(crop), ..options }, &()).unwrap();
        let (whole_layers, part_layers) = (whole.layers.unwrap(), part.layers.unwrap());
        for row in 0..crop.height as usize {
            let from = (crop.y as usize + row) * 61 + crop.x as usize;
            let (wide, narrow) = (from..from + crop.width as usize, row * crop.width as usize..(row + 1) * crop.width as usize);
            prop_assert_eq!(&whole.color[wide.clone()], &part.color[narrow.clone()]);
            prop_assert_eq!(&whole_layers.depth[wide], &part_layers.depth[narrow]);
        }
    }
}

#[test]
fn more_samples_go_where_samples_differ_and_never_change_a_flat_region() {
    let camera = from_above(2.0);
    let mut scene = scene(camera, vec![sun([0.2, 0.1, -1.0])], (64, 64), 4);
    scene.image.most = Some(64);
    let flat = picture(&scene, &ground());
    assert_eq!(flat.rays.camera, 64 * 64 * 4);
    let one = render(&scene, &ground(), &RenderOptions { samples: Some(1), ..RenderOptions::default() }, &()).unwrap();
    assert_eq!(flat.color, one.color);

    let tracer = Spheres { spheres: vec![sphere([0.0, 0.0, 50.0], 0.5)], ground: true, ..Spheres::default() };
    let edges = picture(&scene, &tracer);
    assert!(edges.rays.camera > 64 * 64 * 4 && edges.rays.camera < 64 * 64 * 12, "{}", edges.rays.camera);
    assert_eq!(edges.color[0], flat.color[0]);
}

#[test]
fn adaptive_sampling_comes_near_to_many_samples_everywhere() {
    let (scene, tracer) = still_life();
    let with = |samples: u32| {
        render(&scene, &tracer, &RenderOptions { samples: Some(samples), ..RenderOptions::default() }, &()).unwrap()
    };
    let exact = with(256);
    let error = |picture: &Picture| {
        let pairs = picture.color.iter().flatten().zip(exact.color.iter().flatten());
        (pairs.map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>() / (4.0 * picture.color.len() as f64)).sqrt()
    };
    assert!(error(&with(4)) < 0.015, "{}", error(&with(4)));
    assert!(error(&with(4)) < error(&with(1)) / 3.0);
}

#[test]
fn a_heatmap_is_white_where_most_work_is_and_black_where_there_is_none() {
    let (scene, _) = still_life();
    let tracer = Spheres { spheres: vec![sphere([0.0, 0.0, 0.7], 0.5)], ..Spheres::default() };
    let options = RenderOptions { heatmap: true, ..RenderOptions::default() };
    let heat = render(&scene, &tracer, &options, &()).unwrap();
    assert_eq!(heat.most_work, Some(1));
    let white = heat.color.iter().filter(|it| it[0] > 0.9 && it[1] > 0.9).count();
    let black = heat.color.iter().filter(|it| it[..3].iter().all(|it| *it < 0.01)).count();
    assert_eq!(white + black, heat.color.len());
    let hits = picture(&scene, &tracer);
    assert_eq!(hits.most_work, None);
    assert!(white > 20 && black > white, "{white} white, {black} black");
}

#[test]
fn the_same_solid_has_one_color_and_others_have_others() {
    let (mut scene, _) = still_life();
    scene.suns.clear();
    scene.camera = Some(from_above(2.0));
    scene.sky = Some(Sky::default());
    let balls = (0..6)
        .map(|i| spheres::Sphere { material: Some(MaterialId(0)), ..sphere([f64::from(i) - 2.5, 0.0, 0.0], 0.4) });
    let tracer = Spheres { spheres: balls.collect(), ..Spheres::default() };
    let options = RenderOptions { size: Some((60, 20)), samples: Some(1), ..RenderOptions::default() };
    let picture = render(&scene, &tracer, &options, &()).unwrap();
    // The pixels on the equator's top see the sky alike, whatever the ball.
    let tops: Vec<[f32; 4]> = (0..6).map(|i| picture.color[10 * 60 + i * 10 + 5]).collect();
    for (i, a) in tops.iter().enumerate() {
        for b in &tops[..i] {
            // No two balls have channels in one proportion: the three draws are apart.
            assert!((a[0] / b[0] - a[1] / b[1]).abs() > 1e-4);
        }
    }
}

#[test]
fn the_fault_of_the_lowest_pixel_wins_on_any_number_of_threads() {
    let scene = scene(from_above(64.0), Vec::new(), (64, 64), 4);
    // Rays may land beside their pixel: the places are wide.
    let faulty: fn(DVec3) -> bool = |p| (p.y < 20.0 && p.x > 10.0) || (p.y < 12.0 && p.x < -5.0);
    let tracer = Spheres { faulty: Some(faulty), ..ground() };
    let made = |tile: u32, count: usize| {
        let options = RenderOptions { tile, ..RenderOptions::default() };
        threads(count).install(|| render(&scene, &tracer, &options, &())).unwrap_err()
    };
    let first = made(1, 1);
    for (tile, count) in [(16, 1), (16, 4), (64, 2), (5, 8)] {
        assert_eq!(made(tile, count), first);
    }
}

#[test]
fn a_watch_sees_all_pixels_and_can_stop() {
    struct Counter(AtomicU64, AtomicBool);
    impl Watch for Counter {
        fn progress(&self, done: u64, total: u64) {
            assert_eq!(total, 61 * 43);
            self.0.fetch_max(done, Ordering::Relaxed);
        }
        fn interrupted(&self) -> bool {
            self.1.load(Ordering::Relaxed)
        }
    }
    let (scene, tracer) = still_life();
    let counter = Counter(AtomicU64::new(0), AtomicBool::new(false));
    assert!(render(&scene, &tracer, &RenderOptions::default(), &counter).is_ok());
    assert_eq!(counter.0.load(Ordering::Relaxed), 61 * 43);
    counter.1.store(true, Ordering::Relaxed);
    let stopped = render(&scene, &tracer, &RenderOptions::default(), &counter).unwrap_err();
    assert_eq!(stopped.kind, FaultKind::Interrupted);
}

#[test]
fn sizes_beyond_the_limits_are_refused() {
    let (scene, tracer) = still_life();
    let refused = |options: RenderOptions| render(&scene, &tracer, &options, &()).unwrap_err().kind;
    let default = RenderOptions::default;
    let too_large = refused(RenderOptions { size: Some((u32::MAX, u32::MAX)), ..default() });
    assert_eq!(too_large, FaultKind::Limit { limit: Limit::Pixels, most: MAX_PIXELS });
    let too_many = refused(RenderOptions { samples: Some(MAX_SAMPLES + 1), ..default() });
    assert_eq!(too_many, FaultKind::Limit { limit: Limit::Samples, most: u64::from(MAX_SAMPLES) });
    assert!(matches!(refused(RenderOptions { size: Some((0, 5)), ..default() }), FaultKind::Whole { .. }));
    assert!(matches!(refused(RenderOptions { samples: Some(0), ..default() }), FaultKind::Whole { .. }));
    let outside = Rect { x: 60, y: 0, width: 2, height: 1 };
    assert!(matches!(refused(RenderOptions { crop: Some(outside), ..default() }), FaultKind::Range { .. }));
}

#[test]
fn a_scene_without_a_camera_is_framed_with_a_margin() {
    for (size, spheres) in [
        ((80, 60), vec![sphere([0.0, 0.0, 1.0], 1.0)]),
        ((30, 90), vec![sphere([1e6, 5.0, 3.0], 0.2), sphere([1e6, 9.0, 3.0], 0.3)]),
        ((90, 30), vec![sphere([0.0, 0.0, 1e-7], 1e-7), sphere([0.0, 0.0, 1e-6], 1e-7)]),
    ] {
        let tracer = Spheres { spheres: spheres.clone(), ground: true, ..Spheres::default() };
        let camera = frame(&tracer, size.0, size.1).unwrap();
        let mut scene = scene(camera, Vec::new(), size, 1);
        scene.image.background = Background::Transparent;
        let picture = picture(&scene, &Spheres { spheres, ..Spheres::default() });
        let seen = |x: u32, y: u32| picture.color[(y * size.0 + x) as usize][3] > 0.0;
        let (columns, rows): (Vec<u32>, Vec<u32>) =
            (0..size.0 * size.1).map(|i| (i % size.0, i / size.0)).filter(|(x, y)| seen(*x, *y)).unzip();
        let span = |list: &[u32], size: u32| {
            let (low, high) = (*list.iter().min().unwrap(), *list.iter().max().unwrap());
            assert!(low > 0 && high + 1 < size, "no margin: {low}..{high} of {size}");
            f64::from(high - low) / f64::from(size)
        };
        let filled = span(&columns, size.0).max(span(&rows, size.1));
        assert!((0.7..0.95).contains(&filled), "{filled}");
    }
}

#[test]
fn nothing_at_all_gives_a_picture_of_the_sky() {
    let (mut scene, _) = still_life();
    scene.camera = None;
    let picture = picture(&scene, &Spheres::default());
    assert!(picture.color.iter().all(|color| color[3] == 1.0 && color[2] >= color[0] && color[0] > 0.1));
}

#[test]
fn haze_takes_what_is_far_into_the_air() {
    let contrast = |haze: f64| {
        let mut scene = scene(from_above(2.0), Vec::new(), (2, 1), 1);
        scene.sky = Some(Sky { haze, ..Sky::default() });
        scene.materials[0].color = [0.0; 3];
        let colors = picture(&scene, &Spheres { spheres: vec![sphere([-0.5, 0.0, 0.0], 0.6)], ..ground() }).color;
        f64::from(colors[0][1] - colors[1][1])
    };
    // The sphere's top is 0.6 nearer to the eye, which changes what is lost by less than a hundredth.
    let kept = contrast(0.01) / contrast(0.0);
    assert!((kept - libm::exp(-1.0)).abs() < 0.02, "{kept}");
}

#[test]
fn a_png_reads_back_with_straight_alpha_and_its_texts() {
    let (mut scene, tracer) = still_life();
    scene.image.background = Background::Transparent;
    let tracer = Spheres { ground: false, ..tracer };
    let clear = picture(&scene, &tracer);
    let text = [("Software".to_owned(), "treegen".to_owned()), ("Title".to_owned(), "Kätzchen".to_owned())];
    let mut file = Vec::new();
    write_png(&clear, &text, &mut file).unwrap();
    let read = image::load_from_memory(&file).unwrap().into_rgba8();
    assert_eq!(read.dimensions(), (61, 43));
    for (pixel, color) in read.pixels().zip(&clear.color) {
        assert!((f32::from(pixel[3]) / 255.0 - color[3]).abs() < 0.5 / 255.0 + 1e-6);
        // Back to linear light, within half a step of the curve, which is at most 0.009 high.
        if color[3] > 0.1 {
            let srgb = f64::from(pixel[0]) / 255.0;
            let linear = if srgb <= 0.04045 { srgb / 12.92 } else { libm::pow((srgb + 0.055) / 1.055, 2.4) };
            assert!((linear - f64::from(color[0] / color[3]).min(1.0)).abs() < 0.005);
        }
    }
    let info = png::Decoder::new(Cursor::new(&file)).read_info().unwrap().info().clone();
    assert_eq!(info.uncompressed_latin1_text[0].text, "treegen");
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "Kätzchen");

    let opaque = Picture { color: vec![[0.5, 0.5, 0.5, 1.0]; 61 * 43], ..clear };
    let mut file = Vec::new();
    write_png(&opaque, &[], &mut file).unwrap();
    assert_eq!(image::load_from_memory(&file).unwrap().color(), image::ColorType::Rgb8);
}

#[test]
fn an_exr_reads_back_with_windows_layers_and_texts() {
    use exr::prelude::{AttributeValue, FlatSamples, IntegerBounds, Text, Vec2, read_all_flat_layers_from_file};
    let (scene, tracer) = still_life();
    let crop = Rect { x: 20, y: 7, width: 33, height: 21 };
    let options = RenderOptions { crop: Some(crop), layers: true, ..RenderOptions::default() };
    let picture = render(&scene, &tracer, &options, &()).unwrap();
    let text = [("seed".to_owned(), "7".to_owned()), ("program".to_owned(), "still life".to_owned())];
    let write = || {
        let mut file = Cursor::new(Vec::new());
        write_exr(&picture, &text, &mut file).unwrap();
        file.into_inner()
    };
    let bytes = write();
    // The library keeps attributes in hash maps, which come in another order each time.
    assert!((0..8).all(|_| write() == bytes));

    let path = std::env::temp_dir().join(format!("treegen-picture-test-{}.exr", std::process::id()));
    std::fs::write(&path, &bytes).unwrap();
    let read = read_all_flat_layers_from_file(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read.attributes.display_window, IntegerBounds::new((0, 0), (61, 43)));
    let layer = &read.layer_data[0];
    assert_eq!((layer.attributes.layer_position, layer.size), (Vec2(20, 7), Vec2(33, 21)));
    assert_eq!(layer.attributes.other[&Text::from("seed")], AttributeValue::Text("7".into()));
    assert_eq!(layer.attributes.other[&Text::from("material.2")], AttributeValue::Text("White".into()));

    let channel = |name: &str| {
        let list = &layer.channel_data.list;
        &list.iter().find(|channel| channel.name.to_string() == name).unwrap().sample_data
    };
    let floats = |name: &str| match channel(name) {
        FlatSamples::F32(values) => values.clone(),
        other => panic!("{name}: {other:?}"),
    };
    let layers = picture.layers.as_ref().unwrap();
    assert_eq!(floats("G"), picture.color.iter().map(|color| color[1]).collect::<Vec<f32>>());
    assert_eq!(floats("A"), picture.color.iter().map(|color| color[3]).collect::<Vec<f32>>());
    assert_eq!(floats("Z"), layers.depth);
    assert_eq!(floats("N.y"), layers.normal.iter().map(|normal| normal[1]).collect::<Vec<f32>>());
    assert_eq!(floats("P.z"), layers.position.iter().map(|position| position[2]).collect::<Vec<f32>>());
    assert!(matches!(channel("material"), FlatSamples::U32(values) if *values == layers.material));
}
