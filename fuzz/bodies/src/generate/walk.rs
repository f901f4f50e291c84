//! Successors of shape and hull systems.

use super::{Kind, Maker};

impl Maker<'_> {
    /// A walk.
    pub(super) fn walk(&mut self, kind: Kind, depth: usize) -> String {
        self.several(5, " ", |it| it.stride(kind, depth))
    }

    fn stride(&mut self, kind: Kind, depth: usize) -> String {
        let way = if depth == 0 { self.bytes.below(4) } else { self.way(4, 16) };
        match way {
            0 | 4 | 5 if kind == Kind::Shape => self.segment(),
            0 | 4 | 5 => format!("normal({})", self.number(1)),
            1 | 6 => self.module().unwrap_or_else(|| self.prefix()),
            2 | 7 => self.prefix(),
            3 => format!("rotx({})", self.number(0)),
            8 | 9 => format!("[ {} ]", self.walk(kind, depth - 1)),
            10 => self.repeat(|it| it.walk(kind, depth - 1)),
            11 => self.choice(|it| it.walk(kind, depth - 1)),
            12 => self.calc_node(),
            13 => self.paint(),
            14 => format!("toward({}, {})", self.vector(1), self.number(1)),
            _ => match self.bytes.below(3) {
                0 => self.primitive(),
                1 => self.system_call().unwrap_or_else(|| self.primitive()),
                _ => {
                    // Modules do not stand among what is placed; without the bracket a name before it would be called.
                    let modules = std::mem::take(&mut self.names.modules);
                    let placed = format!("[ ({} \\ {}) ]", self.primitive(), self.solid(depth - 1));
                    self.names.modules = modules;
                    placed
                }
            },
        }
    }

    fn segment(&mut self) -> String {
        match self.bytes.below(4) {
            0 => format!("segment({}, {}, {})", self.number(1), self.number(1), self.number(1)),
            1 => "segment(1, .1, .1)".to_owned(),
            2 => "segment(1, .2, .1)".to_owned(),
            _ => format!("segment({}, .1, .05)", self.literal()),
        }
    }
}
