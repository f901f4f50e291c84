//! Successors of csg systems.

use super::{Kind, Maker};

impl Maker<'_> {
    /// An expression over solids.
    pub(super) fn solid(&mut self, depth: usize) -> String {
        let way = if depth == 0 { self.bytes.below(3) } else { self.way(3, 16) };
        match way {
            0 => self.primitive(),
            1 | 2 => self.module().unwrap_or_else(|| self.primitive()),
            3..=5 => format!("{} {}", self.prefix(), self.operand_solid(depth - 1)),
            6 | 7 => format!("({})", self.several(4, " | ", |it| it.solid(depth - 1))),
            8 => format!("({} \\ {})", self.operand_solid(depth - 1), self.operand_solid(depth - 1)),
            9 => format!("({} & {})", self.operand_solid(depth - 1), self.operand_solid(depth - 1)),
            10 => self.repeat(|it| it.solid(depth - 1)),
            11 => self.choice(|it| it.solid(depth - 1)),
            12 => self.system_call().unwrap_or_else(|| self.primitive()),
            13 => format!("{} {}", self.calc_node(), self.operand_solid(depth - 1)),
            14 => format!("{} {}", self.paint(), self.operand_solid(depth - 1)),
            _ => format!("variant({}) {}", self.literal(), self.operand_solid(depth - 1)),
        }
    }

    /// One that may stand after a prefix or an operator.
    fn operand_solid(&mut self, depth: usize) -> String {
        format!("({})", self.solid(depth))
    }

    pub(super) fn primitive(&mut self) -> String {
        let (name, count) = [
            ("sphere", 0),
            ("box", 0),
            ("cylinder", 0),
            ("tetrahedron", 0),
            ("triangle", 0),
            ("nothing", 0),
            ("cone", 2),
            ("torus", 1),
            ("ellipsoid", 3),
            ("halfspace", 4),
            ("paraboloid", 2),
            ("hyperboloid", 3),
            ("quadric", 10),
        ][self.way(6, 13)];
        self.term(name, count)
    }

    /// A transformation.
    pub(super) fn prefix(&mut self) -> String {
        let (name, count) = [
            ("uscale", 1),
            ("move", 3),
            ("rotz", 1),
            ("rotx", 1),
            ("roty", 1),
            ("scale", 3),
            ("rotate", 4),
            ("mirror", 3),
            ("zshear", 2),
            ("matrix", 12),
        ][self.way(4, 10)];
        match (name, self.bytes.below(4)) {
            ("move", 0) => format!("move({})", self.vector(1)),
            // Mostly something that shrinks, or few recursions would have an end.
            ("uscale", 1..) => format!("uscale({})", ["0.5", "0.7", "0.9"][self.bytes.below(3)]),
            _ => self.term(name, count),
        }
    }

    pub(super) fn term(&mut self, name: &str, count: usize) -> String {
        if count == 0 {
            return name.to_owned();
        }
        let depth = if count > 4 { 0 } else { 1 };
        let args: Vec<String> = (0..count).map(|_| self.number(depth)).collect();
        format!("{name}({})", args.join(", "))
    }

    /// A call of a module of the same system, mostly with a smaller number than its own.
    pub(super) fn module(&mut self) -> Option<String> {
        let callee = self.one(&self.names.modules.clone())?;
        if callee.params == 0 {
            return Some(callee.name);
        }
        let args: Vec<String> = (0..callee.params)
            .map(|_| match self.names.numbers.last().cloned().filter(|_| self.bytes.below(3) > 0) {
                Some(name) => format!("{name} - 1"),
                None => self.number(1),
            })
            .collect();
        Some(format!("{}({})", callee.name, args.join(", ")))
    }

    /// A call of a system that was written before.
    pub(super) fn system_call(&mut self) -> Option<String> {
        let callee = self.one(&self.made.systems.clone())?;
        let mut args: Vec<String> = Vec::new();
        if callee.params > 0 && self.bytes.below(2) == 0 {
            args.extend((0..callee.params).map(|_| self.number(1)));
        }
        if self.bytes.below(4) == 0 {
            args.push(format!("seed: {}", self.number(0)));
        }
        Some(format!("{}({})", callee.name, args.join(", ")))
    }

    pub(super) fn repeat(&mut self, body: impl FnOnce(&mut Self) -> String) -> String {
        let count = match self.bytes.below(4) {
            0 => self.number(1),
            more => (2 * more).to_string(),
        };
        let index = self.name("i");
        self.names.numbers.push(index.clone());
        let body = body(self);
        self.names.numbers.retain(|it| *it != index);
        format!("repeat {count} as {index} {{ {body} }}")
    }

    pub(super) fn choice(&mut self, body: impl Fn(&mut Self) -> String) -> String {
        let (condition, one) = (self.truth(1), body(self));
        match self.bytes.below(2) {
            0 => format!("if {condition} {{ {one} }}"),
            _ => format!("if {condition} {{ {one} }} else {{ {} }}", body(self)),
        }
    }

    /// A C-node.
    pub(super) fn calc_node(&mut self) -> String {
        let steps = self.several(3, "; ", |it| {
            let state = it.names.state.clone();
            match (it.bytes.below(4), it.one(&state)) {
                (0..=1, Some(name)) => format!("{name} = {name} - 1"),
                (2, Some(name)) => format!("{name} = {}", it.number(1)),
                _ => match it.one(&it.names.calcs.clone()) {
                    Some(calc) => calc,
                    None => {
                        let name = it.name("_t");
                        format!("let {name} = {}", it.number(1))
                    }
                },
            }
        });
        format!("{{ {steps} }}")
    }

    pub(super) fn paint(&mut self) -> String {
        self.one(&self.made.materials.clone()).map_or_else(|| self.prefix(), |it| format!("paint({it})"))
    }

    /// What a rule of a system of this kind leads to.
    pub(super) fn successor(&mut self, kind: Kind, depth: usize) -> String {
        match kind {
            Kind::Csg => self.several(3, " | ", |it| it.solid(depth)),
            Kind::Shape | Kind::Hull => self.walk(kind, depth),
        }
    }
}
