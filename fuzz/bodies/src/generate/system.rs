//! Systems with their members.

use super::{Callee, Kind, Maker};

impl Maker<'_> {
    pub(super) fn system(&mut self) -> String {
        let kind = [Kind::Csg, Kind::Csg, Kind::Shape, Kind::Csg, Kind::Hull][self.bytes.below(5)];
        let name = self.name(["S", "P", "H"][kind as usize]);
        let outer = self.names.clone();
        let formals: Vec<String> = (0..self.bytes.below(3)).map(|_| self.name("a")).collect();
        let written: Vec<String> = formals.iter().map(|it| format!("{it} = {}", self.literal())).collect();
        self.names.numbers.extend(formals.iter().cloned());
        self.names.draws = true;
        let head = if written.is_empty() { String::new() } else { format!("({})", written.join(", ")) };
        let members = self.members(kind);
        self.names = outer;
        self.made.systems.push(Callee { name: name.clone(), params: formals.len() });
        let word = ["csg", "shape", "hull"][kind as usize];
        format!("{word} {name}{head} {{\n{members}}}\n")
    }

    fn members(&mut self, kind: Kind) -> String {
        let mut text = String::new();
        for _ in 0..self.bytes.below(3) {
            text += "  ";
            text += &match self.bytes.below(4) {
                0 => {
                    let (name, value) = (self.name("v"), self.number(1));
                    self.names.numbers.push(name.clone());
                    self.names.state.push(name.clone());
                    format!("var {name} = {value};\n")
                }
                1 if !self.names.state.is_empty() => {
                    let name = self.name("c");
                    let calc = self.calc_node();
                    self.names.calcs.push(name.clone());
                    format!("calc {name} {calc}\n")
                }
                _ => self.item(),
            };
        }
        let count = 1 + self.bytes.below(4);
        let modules: Vec<Callee> =
            (0..count).map(|_| Callee { name: self.name("M"), params: self.bytes.below(3) }).collect();
        self.names.modules = modules.clone();
        text += &format!("  start {};\n", self.successor(kind, 3));
        match (kind, self.bytes.below(4)) {
            (Kind::Hull, 1) => text += &format!("  derive parallel {};\n", 1 + self.bytes.below(5)),
            (Kind::Hull, 2) => {
                let order = ["oldest", "random", "lifetime"][self.bytes.below(3)];
                text += &format!("  derive {order} {};\n", self.number(0));
            }
            (Kind::Hull, 3) => text += "  prune none;\n",
            _ => {}
        }
        for module in &modules {
            text += &self.rules(kind, module);
        }
        text
    }

    /// All rules of a module.
    fn rules(&mut self, kind: Kind, module: &Callee) -> String {
        let mut text = String::new();
        let has_weights = self.bytes.below(4) == 3;
        let count = 1 + self.bytes.below(3);
        for number in 0..count {
            let outer = self.names.clone();
            let params: Vec<String> = (0..module.params).map(|_| self.name("n")).collect();
            self.names.numbers.extend(params.iter().cloned());
            let head =
                if params.is_empty() { module.name.clone() } else { format!("{}({})", module.name, params.join(", ")) };
            let guard = match params.last() {
                // All but the last rule have one, as people write it.
                Some(name) if number + 1 < count => match self.bytes.below(3) {
                    0 => format!(" if {name} <= 0"),
                    1 => format!(" if {name} == 0"),
                    _ => format!(" if {}", self.truth(1)),
                },
                None if number + 1 < count => format!(" if {}", self.truth(1)),
                _ => String::new(),
            };
            let weight = if has_weights { format!(" @ {}", self.operand_of_weight()) } else { String::new() };
            let arrow = if kind == Kind::Shape && self.bytes.below(8) == 7 { "+>" } else { "->" };
            text += &format!("  {head}{guard}{weight} {arrow} {};\n", self.successor(kind, 3));
            self.names = outer;
        }
        if self.bytes.below(8) == 7 && kind == Kind::Csg {
            text += &format!("  proxy {} -> {};\n", module.name, self.primitive());
        }
        text
    }

    fn operand_of_weight(&mut self) -> String {
        match self.bytes.below(4) {
            0 => self.number(1),
            more => more.to_string(),
        }
    }
}
