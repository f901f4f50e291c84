//! `treegen measure FILE`: what a program comes to, without expanding it.

use std::fmt::Write as _;
use std::path::Path;

use clap::ValueEnum;
use serde_json::{Value, json};
use treegen_runtime::census::{self, Census, Number, Spread};
use treegen_runtime::geometry::Aabb;
use treegen_runtime::picture::Watch;
use treegen_runtime::trace::cells;
use treegen_runtime::{Fault, Limits};

use crate::arguments::Measure;
use crate::compile::{Understood, compile};
use crate::console::{Console, shown_text};
use crate::exit::Failure;
use crate::output::Place;
use crate::progress::Bar;
use crate::supervise::{Progress, supervise};

/// States that are counted one by one.
const MOST_STATES: usize = 1 << 16;

/// How the answers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MeasureFormat {
    /// A line each, for people
    Text,
    /// One JSON object; what has no end, or cannot be said, is null
    Json,
}

/// What there is to say of a scene.
struct Measured {
    seed: u64,
    /// None: there are too many branches that draw.
    census: Option<Census>,
    /// Over so many seeds, if chance decides anything and they can all be counted.
    spread: Option<(u32, Spread)>,
    /// None: there are more than [`MOST_STATES`].
    states: Option<usize>,
    bounds: Aabb,
}

/// Measures a program.
///
/// # Errors
/// What is wrong with the program.
pub fn measure(arguments: Measure, console: Console) -> Result<(), Failure> {
    let progress = Progress::listen()?;
    let place = Place::find(Path::new("-"))?;
    // The bar would stand between the lines.
    let quiet = Bar::new(Console { quiet: true, ..console });
    let format = arguments.format;
    let measured = supervise(&progress, quiet, move |progress| {
        // Nobody waits for the bounds of a scene as for a large picture of it.
        let limits = arguments.program.with_work(arguments.program.limits(), 0, 1);
        let understood = compile(&arguments.file, &arguments.program, limits, console)?;
        look(&understood, arguments.seeds, &limits, progress).map_err(|fault| understood.failure(&fault, console))
    })?;
    let written = match format {
        MeasureFormat::Text => text(&measured),
        MeasureFormat::Json => format!("{:#}\n", object(&measured)),
    };
    place.stream(&progress, |out| out.write_all(written.as_bytes()))
}

fn look(understood: &Understood, seeds: u32, limits: &Limits, watch: &dyn Watch) -> Result<Measured, Fault> {
    let scene = &understood.scene;
    let census = census::census(scene, limits, watch)?;
    let spread = match &census {
        Some(Census { chance: true, .. }) => census::over_seeds(scene, seeds, limits, watch)?,
        _ => None,
    };
    Ok(Measured {
        seed: scene.seed,
        census,
        spread: spread.map(|it| (seeds, it)),
        states: census::count_states(scene, MOST_STATES, limits, watch)?,
        bounds: cells::finite_bounds(scene, limits)?,
    })
}

/// The answers in lines.
fn text(measured: &Measured) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "{name:<14}{value}");
    };
    match &measured.census {
        Some(census) => {
            let seed = if census.chance { format!(" with seed {}", measured.seed) } else { String::new() };
            line("primitives", &format!("{}{seed}", census.primitives));
            if let Some((seeds, spread)) = &measured.spread {
                let last = measured.seed.wrapping_add(u64::from(*seeds) - 1);
                let Spread { mean, least, most } = spread;
                line("", &format!("{} on average over the seeds {} to {last}", Number::near(*mean), measured.seed));
                line("", &format!("from {} with seed {} to {} with seed {}", least.0, least.1, most.0, most.1));
            }
            line("modules", &census.modules.to_string());
            line("depth", &census.depth.map_or_else(|| "endless".to_owned(), |it| it.to_string()));
            line("largest step", &format!("{} parts: {}", census.largest.0, shown_text(&census.largest.1)));
        }
        None => line("primitives", "cannot be counted: too many parts, or branches that draw how many they are"),
    }
    match measured.states {
        Some(states) => line("states", &Number::Exact(states as u128).to_string()),
        None => line("states", &format!("more than {}, or too much in them", Number::Exact(MOST_STATES as u128))),
    }
    let Aabb { min, max } = measured.bounds;
    if measured.bounds.is_empty() {
        line("bounds", "none: nothing in it is finite");
    } else {
        let corner = |[x, y, z]: [f64; 3]| format!("({}, {}, {})", short(x), short(y), short(z));
        line("bounds", &format!("{} to {}", corner(min.to_array()), corner(max.to_array())));
    }
    text
}

/// A length in as few digits as show its first seven.
fn short(length: f64) -> f64 {
    let written = format!("{length:.6e}");
    written.parse().unwrap_or(length) + 0.0
}

/// The answers as data.
fn object(measured: &Measured) -> Value {
    let census = measured.census.as_ref();
    let number = |it: Number| if it == Number::Endless { Value::Null } else { json!(it.to_f64()) };
    let exact = |it: Number| if let Number::Exact(it) = it { json!(it.to_string()) } else { Value::Null };
    let spread = measured.spread.map(|(seeds, it)| {
        json!({
            "seeds": seeds,
            "mean": it.mean,
            "least": { "primitives": number(it.least.0), "seed": it.least.1 },
            "most": { "primitives": number(it.most.0), "seed": it.most.1 },
        })
    });
    let bounds = (!measured.bounds.is_empty())
        .then(|| json!({ "min": measured.bounds.min.to_array(), "max": measured.bounds.max.to_array() }));
    json!({
        "seed": measured.seed,
        "chance": census.map(|it| it.chance),
        "primitives": census.map(|it| number(it.primitives)),
        "primitives_exact": census.map(|it| exact(it.primitives)),
        "over_seeds": spread,
        "modules": census.map(|it| number(it.modules)),
        "depth": census.and_then(|it| it.depth),
        "largest_step": census.map(|it| json!({ "parts": it.largest.0, "rule_of": it.largest.1 })),
        "states": measured.states,
        "bounds": bounds,
    })
}
