//! Reads the program and everything it uses into trees.
//!
//! Each file is read once, whatever leads to it. Files are numbered in the order in which they are first named.

use treegen_grammar::ast::{self, ItemKind};
use treegen_grammar::{FileId, Span, Unread, parse};

use crate::loader::{Loaded, Loader};
use crate::problem::Problem;
use crate::sources::Sources;
use crate::words;

/// How many files a program may use.
pub(crate) const MAX_FILES: usize = 256;

/// How many bytes all files may have together.
pub(crate) const MAX_BYTES: usize = 32 << 20;

/// A file that was read.
#[derive(Debug)]
pub(crate) struct Unit {
    /// Its tree.
    pub(crate) tree: ast::File,
    /// For each `use` in it, in order, what it leads to; `None` if that could not be read.
    pub(crate) uses: Vec<Option<FileId>>,
    /// What of it could not be read.
    pub(crate) unread: Unread,
}

/// Leaves out what is told of the pieces of each file that could not be read: of those their own mistakes are told. The first `own`
/// problems are those.
pub(crate) fn drop_consequences(unread: &[Unread], own: usize, problems: &mut Vec<Problem>) {
    let is_unread = |span: Span| unread.get(span.file.0 as usize).is_some_and(|it| it.holds(span));
    let mut number = 0;
    problems.retain(|it| {
        number += 1;
        number <= own || !it.labels.iter().any(|it| is_unread(it.span))
    });
}

/// Reads the program and what it uses. Unit n is file n.
pub(crate) fn load(main: Loaded, loader: &dyn Loader, sources: &mut Sources, problems: &mut Vec<Problem>) -> Vec<Unit> {
    let mut reader = Reader { loader, sources, problems, units: Vec::new(), broken: Vec::new(), bytes: 0, full: false };
    reader.read(main);
    let mut next = 0;
    while next < reader.units.len() {
        reader.follow(next);
        next += 1;
    }
    let units = reader.units;
    if let Some(problem) = cycle(&units, sources) {
        problems.push(problem);
    }
    units
}

struct Reader<'a> {
    loader: &'a dyn Loader,
    sources: &'a mut Sources,
    problems: &'a mut Vec<Problem>,
    units: Vec<Unit>,
    /// Where each unit could not be read.
    broken: Vec<Vec<Span>>,
    bytes: usize,
    /// Whether a limit was met: nothing more is read.
    full: bool,
}

impl Reader<'_> {
    fn read(&mut self, loaded: Loaded) -> FileId {
        self.bytes += loaded.text.len();
        let file = self.sources.add(loaded.name, loaded.text);
        let text = self.sources.get(file).map_or("", |it| it.text.as_str());
        let parsed = parse(file, text);
        self.problems.extend(parsed.errors.iter().map(words::syntax::problem));
        let broken: Vec<Span> = parsed.errors.iter().map(|it| it.span).collect();
        self.units.push(Unit { tree: parsed.file, uses: Vec::new(), unread: parsed.unread });
        self.broken.push(broken);
        file
    }

    /// Reads what a unit uses.
    fn follow(&mut self, number: usize) {
        let file = FileId(number as u32);
        let importer = self.sources.get(file).map_or(String::new(), |it| it.name.clone());
        let paths: Vec<(String, Span)> = self.units[number].tree.items.iter().filter_map(used_path).collect();
        for (path, span) in paths {
            // A path that could not be read whole names nothing.
            let is_whole = !self.broken[number].iter().any(|it| span.start <= it.start && it.start < span.end);
            let used = if is_whole { self.find(&importer, &path, span) } else { None };
            self.units[number].uses.push(used);
        }
    }

    fn find(&mut self, importer: &str, path: &str, span: Span) -> Option<FileId> {
        if self.full {
            return None;
        }
        match self.loader.load(importer, path) {
            Err(why) => {
                self.problems.push(words::files::not_loaded(path, span, &why));
                None
            }
            Ok(loaded) => {
                if let Some((file, _)) = self.sources.iter().find(|it| it.1.name == loaded.name) {
                    return Some(file);
                }
                self.full = self.units.len() >= MAX_FILES || self.bytes + loaded.text.len() > MAX_BYTES;
                if self.units.len() >= MAX_FILES {
                    self.problems.push(words::files::too_many("files", MAX_FILES, span));
                    return None;
                }
                if self.bytes + loaded.text.len() > MAX_BYTES {
                    self.problems.push(words::files::too_many("bytes of files", MAX_BYTES, span));
                    return None;
                }
                Some(self.read(loaded))
            }
        }
    }
}

fn used_path(item: &ast::Item) -> Option<(String, Span)> {
    match &item.kind {
        ItemKind::Use { path, path_span, .. } => Some((path.clone(), *path_span)),
        _ => None,
    }
}

/// The first circle of files that use one another, found by walking depth first with a stack of our own.
fn cycle(units: &[Unit], sources: &Sources) -> Option<Problem> {
    // 0: not seen, 1: on the way, 2: done.
    let mut state = vec![0_u8; units.len()];
    let mut way: Vec<(usize, usize)> = Vec::new();
    if !units.is_empty() {
        way.push((0, 0));
        state[0] = 1;
    }
    while let Some((unit, next)) = way.last_mut() {
        let here = *unit;
        let Some(used) = units[here].uses.get(*next) else {
            state[here] = 2;
            way.pop();
            continue;
        };
        let number = *next;
        *next += 1;
        let Some(used) = used.map(|it| it.0 as usize) else { continue };
        match state[used] {
            0 => {
                state[used] = 1;
                way.push((used, 0));
            }
            1 => {
                let span = units[here].tree.items.iter().filter_map(used_path).nth(number).map(|it| it.1)?;
                let from = way.iter().position(|it| it.0 == used).unwrap_or(0);
                let mut names: Vec<String> = way[from..].iter().map(|it| name(it.0, sources)).collect();
                names.push(name(used, sources));
                return Some(words::files::cycle(&names, span));
            }
            _ => {}
        }
    }
    None
}

fn name(unit: usize, sources: &Sources) -> String {
    sources.get(FileId(unit as u32)).map_or(String::new(), |it| it.name.clone())
}
