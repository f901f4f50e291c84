//! Every field of scenes, materials and textures, with every number that one would not want there (rows 31 and 60 to 63).

use crate::common::compiled;
use crate::ways::{astray, framed_and_traced, on_deep_stacks};

/// A program with `@` for one number.
const FIELDS: &[&str] = &[
    "scene { camera { eye: (@, -5, 1), target: (0, 0, 0) } show sphere; }",
    "scene { camera { eye: (0, -5, @), target: (0, 0, 0) } show sphere; }",
    "scene { camera { eye: (0, -5, 1), target: (@, 0, 0) } show sphere; }",
    "scene { camera { eye: (0, -5, 1), target: (0, 0, @) } show sphere | halfspace(0, 0, 1, 0); }",
    "scene { camera { eye: (0, -5, 1), target: (0, 0, 0), up: (0, 0, @) } show sphere; }",
    "scene { camera { eye: (0, -5, 1), target: (0, 0, 0), up: (@, 1, 0) } show sphere; }",
    "scene { camera { eye: (0, -5, 1), target: (0, 0, 0), fov: @ } show sphere; }",
    "scene { camera { eye: (0, -5, 1), target: (0, 0, 0), height: @ } show sphere; }",
    "scene { sun { direction: (1, 1, @) } show sphere; }",
    "scene { sun { direction: (@, 0, 0) } show sphere | halfspace(0, 0, 1, -1); }",
    "scene { sun { direction: (1, 1, -1), strength: @ } show sphere; }",
    "scene { sun { direction: (1, 1, -1), size: @ } show sphere | halfspace(0, 0, 1, -1); }",
    "scene { sun { direction: (1, 1, -1), color: (1, @, 1) } show sphere; }",
    "scene { sky { strength: @ } show sphere; }",
    "scene { sky { color: (@, 1, 1) } show sphere; }",
    "scene { sky { haze: @ } show sphere | halfspace(0, 0, 1, 0); }",
    "material M { color: (.5, @, .5) } scene { show paint(M) sphere; }",
    "material M { range: (.5, @, .5) } scene { show paint(M) sphere; }",
    "material M { gloss: @ } scene { show paint(M) sphere; }",
    "material M { mirror: @ } scene { show paint(M) sphere; }",
    "material M { translucent: @ } scene { show paint(M) sphere; }",
    "material M { roughen: @ } hull H { prune none; start [ rotx(180) normal(1) ] [ normal(1) ]
        repeat 4 as i { [ rotz(90 * i) rotx(90) normal(1) ] }; } scene { show paint(M) H(); }",
    "texture T { kind: fbm } material M { shade: T, amount: @ } scene { show paint(M) sphere; }",
    "texture T { kind: fbm } material M { bump: T, depth: @ } scene { show paint(M) sphere; }",
    "texture T { kind: fbm } material M { relief: T, depth: @ } shape S { start segment(1, .3, .2); } scene { show paint(M) S(); }",
    "texture T { kind: fbm, seed: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, stretch: (1, @, 1) } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, offset: (1, @, 1) } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, dimension: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, octaves: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, frequency: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fbm, lacunarity: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, terms: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, frequency: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, phase: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, ratio: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, gain: @ } material M { shade: T, bump: T } scene { show paint(M) sphere; }",
    "texture T { kind: fourier, space: stem, frequency: @ } material M { shade: T, bump: T }
        shape S { start segment(1, .3, .2); } scene { show paint(M) S(); }",
    "texture T { kind: chunks, cube: 8, colors: [(1, 0, 0)], size: @ } material M { shade: T } scene { show paint(M) sphere; }",
    "texture T { kind: chunks, cube: 8, colors: [(1, @, 0)] } material M { shade: T } scene { show paint(M) sphere; }",
    "texture T { kind: chunks, cube: @, colors: [(1, 0, 0)] } material M { shade: T } scene { show paint(M) sphere; }",
    "texture T { kind: chunks, cube: 8, colors: [(1, 0, 0)], count: @ } material M { shade: T } scene { show paint(M) sphere; }",
    "texture T { kind: chunks, cube: 8, colors: [(1, 0, 0)], chunk: (@, 2) } material M { shade: T } scene { show paint(M) sphere; }",
    "texture T { kind: chunks, cube: 8, colors: [(1, 0, 0), (0, 1, 0)], share: [@, 1] } material M { shade: T } scene { show paint(M) sphere; }",
    "scene { image { size: (@, 3) } show sphere; }",
    "scene { image { samples: @ } show sphere; }",
    "scene { image { most: @ } show sphere; }",
];

const NUMBERS: [&str; 17] = [
    "0/0", "1/0", "inf", "-inf", "-1", "0", ".5", "1", "180", "360", "1e-300", "5e-324", "1e300", "-1e300", "1.7e308",
    "1e150", "1e-16",
];

#[test]
fn no_number_in_a_field_makes_a_picture_of_no_numbers() {
    let wrong: Vec<String> = on_deep_stacks(|| {
        let mut wrong = Vec::new();
        for (field, value) in FIELDS.iter().flat_map(|it| NUMBERS.iter().map(move |value| (it, *value))) {
            let program = field.replace('@', value);
            let mut compiled = compiled(&program);
            let found = framed_and_traced(&mut compiled);
            let is_none = value.contains("/0");
            let may_be = if is_none { &["E1005"][..] } else { &["fine", "E0608", "E0610", "E0920"] };
            // Nothing infinite is part of a picture.
            if !may_be.contains(&found.as_str()) || value.contains("inf") && found == "fine" {
                wrong.push(format!("{found}: {program}"));
            }
            // What is wrong is named.
            let name = field.split('@').next().and_then(|it| it.rsplit(['{', ',']).find(|it| it.contains(':')));
            let name = name.and_then(|it| it.split(':').next()).unwrap().trim();
            let said = |it: &str| compiled.problems.iter().any(|problem| problem.message.contains(it));
            if found == "E0608" && !said(&format!("`{name}`")) {
                wrong.push(format!("`{name}` is not named: {program}: {:?}", compiled.problems));
            }
            wrong.extend(astray(&compiled, &found).iter().map(|it| format!("{it}, not {found}: {program}")));
        }
        wrong
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
