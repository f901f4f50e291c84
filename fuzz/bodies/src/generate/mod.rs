//! Programs from bytes: right in their syntax, and mostly in all else.
//!
//! Whatever the bytes are, a program comes out. It is small, but has what is hard: recursion with and without an end, state, draws,
//! Booleans in Booleans, plants, hulls, textures, and numbers that no one would write.

mod scene;
mod solid;
mod system;
mod value;
mod walk;

use crate::bytes::Bytes;

/// So many pieces a program has at most.
const MOST_PIECES: usize = 160;

/// The program that these bytes stand for.
pub fn program(data: &[u8]) -> String {
    let mut maker = Maker { bytes: Bytes::new(data), pieces: 0, names: Names::default(), made: Made::default() };
    maker.file()
}

/// What a system is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Csg,
    Shape,
    Hull,
}

/// A module or a system: its name, and how many numbers it takes.
#[derive(Clone, Debug)]
struct Callee {
    name: String,
    params: usize,
}

/// The names that may be used where something is being written.
#[derive(Clone, Debug, Default)]
struct Names {
    numbers: Vec<String>,
    vectors: Vec<String>,
    lists: Vec<String>,
    /// Functions of one number.
    functions: Vec<String>,
    /// Numbers that may be changed.
    state: Vec<String>,
    calcs: Vec<String>,
    modules: Vec<Callee>,
    /// Whether draws may stand here.
    draws: bool,
}

/// What has been written so far.
#[derive(Clone, Debug, Default)]
struct Made {
    materials: Vec<String>,
    systems: Vec<Callee>,
    count: usize,
}

/// Writes a program piece by piece.
struct Maker<'a> {
    bytes: Bytes<'a>,
    pieces: usize,
    names: Names,
    made: Made,
}

impl Maker<'_> {
    /// One of so many ways to go on; the first ones are the short ones, and when there is enough only they are left.
    fn way(&mut self, short: usize, all: usize) -> usize {
        self.pieces += 1;
        let way = self.bytes.below(all);
        if self.pieces > MOST_PIECES || self.bytes.is_empty() { way % short } else { way }
    }

    fn one<T: Clone>(&mut self, of: &[T]) -> Option<T> {
        if of.is_empty() { None } else { Some(of[self.bytes.below(of.len())].clone()) }
    }

    /// A name that there is no other of.
    fn name(&mut self, stem: &str) -> String {
        self.made.count += 1;
        format!("{stem}{}", self.made.count)
    }

    fn several(&mut self, most: usize, between: &str, mut one: impl FnMut(&mut Self) -> String) -> String {
        let count = 1 + self.bytes.below(most);
        (0..count).map(|_| one(self)).collect::<Vec<_>>().join(between)
    }

    fn file(&mut self) -> String {
        let mut text = String::new();
        for _ in 0..self.bytes.below(4) {
            text += &self.item();
        }
        for _ in 0..self.bytes.below(3) {
            text += &self.material();
        }
        for _ in 0..1 + self.bytes.below(3) {
            text += &self.system();
        }
        if self.bytes.below(3) > 0 {
            text += &self.scene();
        }
        text
    }

    /// A definition that all of the file sees.
    fn item(&mut self) -> String {
        match self.bytes.below(4) {
            0 => {
                let (name, value) = (self.name("k"), self.number(2));
                self.names.numbers.push(name.clone());
                format!("let {name} = {value};\n")
            }
            1 => {
                let (name, value) = (self.name("u"), self.vector(1));
                self.names.vectors.push(name.clone());
                format!("let {name} = {value};\n")
            }
            2 => {
                let name = self.name("l");
                let list = self.several(4, ", ", |it| it.number(1));
                self.names.lists.push(name.clone());
                format!("let {name} = [{list}];\n")
            }
            _ => self.function(),
        }
    }

    /// A function of one number, that may well call itself.
    fn function(&mut self) -> String {
        let (name, param) = (self.name("f"), self.name("x"));
        let calls_itself = self.bytes.below(4) == 3;
        let outer = self.names.clone();
        self.names.numbers.push(param.clone());
        let body = if calls_itself {
            self.names.functions.push(name.clone());
            format!("if {param} < 1 then {} else {}", self.number(1), self.number(2))
        } else {
            self.number(2)
        };
        self.names = outer;
        self.names.functions.push(name.clone());
        format!("fn {name}({param}) = {body};\n")
    }
}
