//! What other languages call what there is here, and how they write it: for those who come from there.

/// What is written here for a name of another language: in whole, if that may take its place, and in words. `what` says what would fit.
pub(super) fn name(name: &str, what: &str) -> Option<(Option<&'static str>, &'static str)> {
    let name = name.to_lowercase();
    if what == "value" {
        return COLORS.contains(&name.as_str()).then_some((
            None,
            "a color is three numbers from 0 to 1, for red, green and blue: `(1, .5, 0)` is orange",
        ));
    }
    let of_solids = what.contains("solid").then_some(SOLIDS)?;
    of_solids.iter().find(|it| it.0.contains(&name.as_str())).map(|it| (it.1, it.2))
}

const COLORS: &[&str] = &[
    "black", "white", "gray", "grey", "red", "green", "blue", "yellow", "orange", "brown", "cyan", "magenta", "purple",
    "pink",
];

/// Names, what may take their place, and what to say.
type Row = (&'static [&'static str], Option<&'static str>, &'static str);

const SOLIDS: &[Row] = &[
    (&["translate", "translation", "translated"], Some("move"), "`move(x, y, z)` moves what follows"),
    (
        &["cube", "block", "cuboid"],
        Some("box"),
        "`box` is the cube from -1 to 1; `scale(x, y, z) box` makes others of it",
    ),
    (&["ball"], Some("sphere"), "`sphere` has radius 1; `uscale(2) sphere` makes another of it"),
    (&["union", "merge", "group"], None, "`A | B` unites solids"),
    (&["difference", "subtract"], None, "`A \\ B` takes the second solid away from the first"),
    (&["intersection", "intersect"], None, "`A & B` leaves what is in both solids"),
    (
        &["color", "colour", "pigment"],
        None,
        "`paint(Bark) A` gives a solid a material: `material Bark { color: (.5, .4, .3) }`",
    ),
    (&["plane", "ground"], None, "`halfspace(0, 0, 1, 0)` is all that lies below z = 0"),
    (&["for", "while", "loop", "foreach"], None, "`repeat 10 as i { ... }` unites ten copies, with `i` from 0 to 9"),
];

/// What a solid or transformation is, for those who give it what it takes in other languages.
pub(super) fn arguments(callee: &str) -> Option<&'static str> {
    Some(match callee {
        "sphere" => "`sphere` has radius 1; `uscale(2) sphere` has radius 2",
        "box" => "`box` is the cube from -1 to 1; `scale(1, 2, 3) box` is 2 wide, 4 deep and 6 high",
        "cylinder" => "`cylinder` has radius 1, from z = 0 to 1; `scale(.2, .2, 3) cylinder` is thin and long",
        "cone" => {
            "`cone(r0, r1)` has radius r0 at z = 0 and r1 at z = 1; `scale(1, 1, 3) cone(1, 0)` is three times as high"
        }
        "torus" => {
            "`torus(.2)` is a ring of radius 1, .2 thick from its middle; `uscale(2) torus(.2)` is twice as large"
        }
        "tetrahedron" => "`tetrahedron` has one size; `uscale(2) tetrahedron` is twice as large",
        "triangle" => "`triangle` has corners (0, 0, 0), (1, 0, 0) and (0, 1, 0); `matrix` puts them anywhere",
        "move" => "`move(x, y, z)` moves along the three axes: `move(0, 0, 1)` moves up",
        "rotate" => "`rotx(a)`, `roty(a)` and `rotz(a)` turn about the axes: `rotx(90) rotz(30)` turns about z first",
        "scale" => "`uscale(f)` scales all directions alike",
        _ => return None,
    })
}

/// What is written here where `found` has no place, and something of this list would have.
pub(super) fn sign(found: &str, expected: &[String]) -> Option<&'static str> {
    let expects = |it: &str| expected.iter().any(|word| word == it);
    match found {
        "+" | "-" | "*" | "/" if expects("`|`") => {
            Some("`A | B` unites solids, `A \\ B` takes the second away from the first, `A & B` leaves what is in both")
        }
        "+" | "-" | "/" | "^" if expects("a solid") => {
            Some("turns and moves are words: `rotz(30)`, `rotx(-30)`, `move(0, 0, 1)`")
        }
        "=" if expects("`|`") => {
            Some("values are changed in braces before what they are changed for: `{ n = n + 1 } sphere`")
        }
        "{" if expected == ["`=`"] => Some("a function is one value: `fn area(r) = pi * r * r;`"),
        "then" if expects("`{`") => Some("solids are chosen in braces: `if n > 1 { sphere } else { box }`"),
        _ if expected == ["an item"] => Some(
            "a file has `use`, `param`, `let`, `fn`, `enum`, `texture`, `material`, `csg`, `shape`, `hull` and `scene`",
        ),
        _ if expected == ["`)`", "a name"] && found.starts_with(|it: char| it.is_ascii_digit()) => {
            Some("names stand here; which values a rule is for is asked behind `if`: `S(n) if n == 0 -> ...`")
        }
        _ => None,
    }
}
