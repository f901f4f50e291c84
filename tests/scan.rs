//! Whole programs drawn by scan conversion: plants beside the ray tracer, and triangles beside brute force.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::scene;
use glam::DVec3;
use treegen_runtime::Limits;
use treegen_runtime::mesh::{Mapping, StemSurface, mesh};
use treegen_runtime::picture::{self, Layers, Picture, RenderOptions};
use treegen_runtime::scan::Scanner;
use treegen_runtime::trace::cells::{CellTracer, Culling};

const SIDE: u32 = 96;

fn options() -> RenderOptions {
    RenderOptions { size: Some((SIDE, SIDE)), samples: Some(1), layers: true, detail: 0.0, ..RenderOptions::default() }
}

fn drawn(text: &str, stems: StemSurface) -> Picture {
    let (scene, limits) = (scene(text), Limits::default());
    let scanner = Scanner::new(&scene, stems, &limits, &()).expect("the program has no faults");
    picture::scan(&scene, &scanner, &limits, &options(), &()).expect("the program has no faults")
}

fn traced(text: &str) -> Picture {
    let (scene, limits) = (scene(text), Limits::default());
    let tracer = CellTracer::new(&scene, &limits, Culling::State).expect("the program has no faults");
    picture::render(&scene, &tracer, &options(), &()).expect("the program has no faults")
}

fn layers(picture: &Picture) -> &Layers {
    picture.layers.as_ref().expect("layers are asked for")
}

/// A plant with bends, forks, paints that vary and a texture that stands where the plant does, laid down twice, one of them mirrored.
const PLANTS: &str = "
    texture Grain { kind: fbm, frequency: 3 }
    material Bark { color: (.4, .3, .2), range: (.2, .2, .1), shade: Grain, bump: Grain, depth: .1 }
    material Leaf { color: (.1, .4, .1), range: (.3, .3, .1) }
    shape Plant(order = 5) {
      start t(order);
      t(n) if n > 0 -> rotx(random(5, 25)) segment(.6, .05 * n, .05 * n - .04) segment(.3, .05 * n - .04, .05 * n - .05)
        [ rotx(50) t(n - 1) ] rotz(140) rotx(-30) t(n - 1);
      t(n) if n <= 0 -> paint(Leaf) segment(.3, .05, 0);
    }
    scene {
      camera { eye: (1, -9, 3), target: (0, 0, 1.3), fov: 30 }
      sky { color: (.6, .7, .9) }
      image { background: none }
      show paint(Bark) Plant();
      show paint(Bark) move(1.5, .5, 0) mirror(1, 0, 0) scale(.7, .7, 1.1) Plant();
      show halfspace(0, 0, 1, 0);
    }";

/// In how many pixels a program looks otherwise drawn than traced, and how many show one of its materials.
fn different(text: &str) -> (usize, usize) {
    let (traced, drawn) = (traced(text), drawn(text, StemSurface::Cones));
    let (seen, found) = (layers(&traced), layers(&drawn));
    let far = |a: f32, b: f32| (a - b).abs() > 1e-4 * (1.0 + a.abs());
    let is_other = |pixel: &usize| {
        let pixel = *pixel;
        seen.material[pixel] != found.material[pixel]
            || seen.depth[pixel] != found.depth[pixel] && far(seen.depth[pixel], found.depth[pixel])
            || traced.color[pixel].iter().zip(&drawn.color[pixel]).any(|(a, b)| far(*a, *b))
    };
    let painted = seen.material.iter().filter(|it| **it > 1).count();
    ((0..traced.color.len()).filter(is_other).count(), painted)
}

#[test]
fn plants_look_as_rays_see_them_but_for_a_few_edges() {
    let (different, painted) = different(PLANTS);
    assert!(painted > 500, "{painted} pixels of plants");
    // Rounding decides at an edge, and of two segments that touch there.
    assert!(different <= 4, "{different} pixels differ");
}

#[test]
fn textures_on_stems_lie_where_rays_see_them() {
    let plants = |space: &str| {
        let grain = format!("texture Grain {{ kind: fbm, space: {space}, frequency: 3 }}");
        let waves = format!("shade: Waves }} texture Waves {{ kind: fourier, space: {space}, frequency: 2 }}");
        let text = PLANTS.replace("texture Grain { kind: fbm, frequency: 3 }", &grain);
        text.replacen("range: (.3, .3, .1) }", &format!("range: (.3, .3, .1), {waves}"), 1)
    };
    let (different, painted) = different(&plants("stem"));
    assert!(painted > 500, "{painted} pixels of plants");
    assert!(different <= 4, "{different} pixels differ");
    // They do not lie where they would lie on a solid.
    let [on_stems, on_solids] = ["stem", "object"].map(|it| drawn(&plants(it), StemSurface::Cones).color);
    assert!(on_stems.iter().zip(&on_solids).filter(|(a, b)| a != b).count() > 500);
}

/// A bent and forked trunk with deep bark, in front of another one.
const BARK: &str = "
    texture Ridges { kind: fbm, frequency: 2, octaves: 3, stretch: (1, 1, 3) }
    material Bark { color: (.6, .5, .4), relief: Ridges, depth: .12 }
    material Smooth { color: (.3, .5, .4) }
    shape Trunk {
      start segment(1.2, .5, .45) rotx(20) segment(1, .45, .4) [ rotx(50) segment(1.2, .3, .1) ] rotx(-45) segment(1.5, .4, 0);
    }
    scene {
      camera { eye: (1, -7, 2), target: (0, 0, 1.5), fov: 32 }
      sky { color: (.6, .7, .9) }
      image { background: none }
      show paint(Bark) Trunk();
      show paint(Smooth) move(.5, 1.5, 0) Trunk();
      show paint(Bark) move(-.9, .8, 0) mirror(1, 0, 0) scale(.7, .7, 1.1) Trunk();
    }";

#[test]
fn relief_has_the_outline_the_depth_and_the_shades_that_rays_see() {
    let (different, painted) = different(BARK);
    assert!(painted > 1_500, "{painted} pixels of trunks");
    assert!(different <= 4, "{different} pixels differ");
    // Some of what the smooth stem would hide is seen.
    let smooth = BARK.replace("relief: Ridges, depth: .12", "relief: Ridges, depth: 0");
    let [carved, smooth] = [BARK, &smooth].map(|it| drawn(it, StemSurface::Cones));
    let seen = layers(&carved).material.iter().zip(&layers(&smooth).material).filter(|(a, b)| a != b).count();
    assert!(seen > 30, "{seen} pixels beside the relief");
}

/// Stems that are thick, bent and forked, in sight of a camera at this place.
fn thick(eye: &str) -> String {
    format!(
        "shape Stem {{ start a; a -> segment(2, 1, 1) rotx(40) segment(2, 1, .8) rotx(-70) segment(2, .8, .5)
           [ rotx(60) segment(2, .5, .3) ] segment(1, .5, .4); }}
         scene {{ camera {{ eye: {eye}, target: (0, -1, 3), fov: 60 }} image {{ background: none }} show Stem(); }}"
    )
}

/// What brute force meets along each pixel's ray: the nearest of all triangles of the program's mesh.
fn met(text: &str, stems: StemSurface) -> Vec<f64> {
    let (scene, limits) = (scene(text), Limits::default());
    let mesh = mesh(&scene, stems, &limits, &()).unwrap();
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for instance in mesh.instances() {
        let map = Mapping::new(&instance.world_from_component);
        for (_, surface) in mesh.components[instance.component].painted.surfaces() {
            let at = |it: u32| DVec3::from_array(map.vertex(&surface.vertices()[it as usize]).position.map(f64::from));
            triangles.extend(surface.triangles().iter().map(|it| it.map(at)));
        }
    }
    let camera = scene.camera.unwrap();
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let span = 2.0 * libm::tan(30_f64.to_radians());
    let along = |it: u32| ((f64::from(it) + 0.5) / f64::from(SIDE) - 0.5) * span;
    let rays = (0..SIDE * SIDE).map(|it| forward + right * along(it % SIDE) - up * along(it / SIDE));
    rays.map(|direction| {
        let hits = triangles.iter().filter_map(|[a, b, c]| {
            let normal = (*b - *a).cross(*c - *a);
            let t = normal.dot(*a - camera.eye) / normal.dot(direction);
            let hit = camera.eye + direction * t;
            let inside = |from: &DVec3, to: &DVec3| (*to - *from).cross(hit - *from).dot(normal) >= 0.0;
            (t > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)).then_some(t)
        });
        hits.fold(f64::INFINITY, f64::min)
    })
    .collect()
}

#[test]
fn triangles_are_seen_where_brute_force_meets_them() {
    for stems in [StemSurface::Smooth, StemSurface::Smoother] {
        for eye in ["(3, -9, 4)", "(-1, 6, 0)", "(0.5, 0.2, 12)"] {
            let text = thick(eye);
            let picture = drawn(&text, stems);
            let found = &layers(&picture).depth;
            let met = met(&text, stems);
            let wrong = met.iter().zip(found).filter(|(met, found)| {
                let found = f64::from(**found);
                met.is_finite() != found.is_finite() || met.is_finite() && (**met - found).abs() > 1e-5 * found
            });
            assert!(found.iter().filter(|it| it.is_finite()).count() > 200, "{eye}");
            // On an edge that is seen against what is further away, rounding decides.
            assert!(wrong.count() <= 3, "{stems:?} {eye}");
        }
    }
}

#[test]
fn a_closed_surface_has_no_crack_seen_from_inside() {
    for stems in [StemSurface::Smooth, StemSurface::Smoother] {
        // In the middle of the lowest segment, and in the bend above it, with walls behind and beside the eye.
        for eye in ["(0.1, 0.05, 1)", "(0.2, -0.9, 2.8)", "(0, 0, 0.001)"] {
            let picture = drawn(&thick(eye), stems);
            let open = picture.color.iter().filter(|it| it[3] < 1.0).count();
            assert_eq!(open, 0, "{stems:?} {eye}");
        }
    }
}

#[test]
fn smooth_stems_have_smooth_normals() {
    let text = "shape Stem { start segment(3, 1, 1) segment(3, 1, 1) segment(3, 1, 1); }
         scene { camera { eye: (0, -9, 4.5), target: (0, 0, 4.5), height: 3 } show Stem(); }";
    let picture = drawn(text, StemSurface::Smoother);
    let layers = layers(&picture);
    let row = (SIDE / 2 * SIDE) as usize;
    let turned = (row + 1..row + SIDE as usize).filter_map(|pixel| {
        let normal = |it: usize| DVec3::from_array(layers.normal[it].map(f64::from));
        let both = layers.depth[pixel - 1].is_finite() && layers.depth[pixel].is_finite();
        both.then(|| normal(pixel - 1).dot(normal(pixel)))
    });
    assert!(turned.clone().count() > 20);
    assert!(turned.clone().all(|it| it > 0.9), "{:?}", turned.collect::<Vec<_>>());
}
