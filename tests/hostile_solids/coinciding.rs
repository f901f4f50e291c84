//! Solids that stand where others of the same shape stand already (row 55): seen, lit and mirrored they are one.

use crate::ways::{on_deep_stacks, picture_in};

/// What is tried, from -1 to 1 about.
const SYSTEMS: &str = "\
material Silver { mirror: .9, color: (.2,.2,.2) }
hull Gem { start [ normal(.8) ] [ rotx(180) normal(.8) ] repeat 7 as i { [ rotz(51 * i) rotx(70 + 9 * i) normal(.9) ] }; }
shape Stem { start move(0,0,-1) segment(.9, .5, .4) rotx(70) segment(.8, .4, .2); }
csg Chain(n) { start C(n); C(k) if k > 0 -> sphere | move(.7,0,0) rotz(25) uscale(.7) C(k - 1); C(k) -> sphere; }
";

/// Solids, and surfaces without an inside.
const SHAPES: [&str; 18] = [
    "sphere",
    "ellipsoid(.6, .9, 1)",
    "box",
    "cylinder",
    "cone(.9, .3)",
    "torus(.4)",
    "quadric(1, 1, 1, .3, 0, 0, 0, 0, 0, -.8)",
    "paraboloid(.8, 1)",
    "(hyperboloid(.5, .5, .5) & box)",
    "triangle",
    "(sphere \\ move(.6, -.5, .3) sphere)",
    "(box & move(.2, .1, 0) sphere)",
    "Gem()",
    "Stem()",
    "Chain(4)",
    "variant(3) Chain(4)",
    "paint(Silver) sphere",
    "paint(Silver) torus(.4)",
];

/// Ways to the same place, by which numbers are rounded differently.
const WAYS: [&str; 3] = [
    "",
    "rotx(77) uscale(3) rotz(41) rotz(-41) uscale(1/3) rotx(-77)",
    "move(71, -33, 12) rotz(130) move(5, 0, 0) move(-5, 0, 0) rotz(-130) move(-71, 33, -12)",
];

#[test]
fn what_stands_twice_in_one_place_looks_as_if_it_stood_there_once() {
    let view = |show: &str| {
        SYSTEMS.to_owned()
            + "scene { camera { eye: (4,-5,3), target: (0,0,0), fov: 26 } sun { direction: (.5,.4,-1) } sun { direction: (-.6,.3,-.2) } "
            + &format!("show halfspace(0,0,1,-1.4); show {show}; }}")
    };
    let mut wrong = Vec::new();
    on_deep_stacks(|| {
        for shape in SHAPES {
            for by_the_book in [false, true] {
                let size = if by_the_book { (40, 30) } else { (120, 90) };
                let once = picture_in(size, &view(shape), by_the_book).unwrap();
                for way in WAYS {
                    let text = view(&format!("({shape} | {way} {shape})"));
                    let twice = picture_in(size, &text, by_the_book).unwrap();
                    let both = once.color.as_flattened().chunks(4).zip(twice.color.as_flattened().chunks(4));
                    let is_alike = |(a, b): &(&[f32], &[f32])| a.iter().zip(*b).all(|(a, b)| (a - b).abs() < 2e-3);
                    let others = both.filter(|it| !is_alike(it)).count();
                    if others > 0 {
                        wrong.push(format!("{others} pixels (by the book: {by_the_book}) of {text}"));
                    }
                }
            }
        }
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
