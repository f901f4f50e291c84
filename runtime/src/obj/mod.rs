//! Meshes in Wavefront OBJ files: from bytes to [`Triangles`].
//!
//! What is read: points (`v`), normals (`vn`) and faces (`f`), of any number of corners, with numbers that count from the first or, if
//! they are negative, back from the last. All else is passed over, and no other file is opened, whatever the text names. Nothing
//! is reserved by a number in the text, so what is taken grows with the text and has a limit.

mod polygon;
mod text;

use glam::DVec3;

use self::text::{Line, Lines};
use crate::geometry::{Face, MeshPieces, Triangles};

/// How many bytes a line may have, with those that it is continued by.
pub const MAX_LINE_BYTES: usize = 1 << 16;
/// How many corners a face may have that is not convex.
pub const MAX_CORNERS: usize = polygon::MOST_CORNERS;
/// Coordinates are no larger than this.
pub const MAX_COORDINATE: f64 = 1e30;

/// Why bytes are no mesh. Lines count from 1.
#[derive(Clone, Debug, PartialEq)]
pub enum BadMesh {
    /// A byte that no text has.
    NotText {
        /// The line in which it is.
        line: u32,
    },
    /// A line is too long.
    LongLine {
        /// Which.
        line: u32,
    },
    /// Not so many numbers as there must be.
    Few {
        /// The line.
        line: u32,
        /// The word that it begins with.
        word: &'static str,
    },
    /// A coordinate that is no number, or too large.
    Number {
        /// The line.
        line: u32,
        /// What stands there, cut if it is long.
        text: String,
    },
    /// A corner that names no point or normal.
    Index {
        /// The line.
        line: u32,
        /// What stands there, cut if it is long.
        text: String,
        /// What it should name.
        what: &'static str,
        /// How many of these there are.
        count: usize,
    },
    /// A face of fewer than three corners, or of too many to be cut into triangles.
    Corners {
        /// The line.
        line: u32,
        /// How many.
        count: usize,
    },
    /// More triangles than there may be, or three times as many points or normals.
    TooMany {
        /// The line in which it becomes too many.
        line: u32,
    },
    /// No faces.
    NoFaces,
    /// Two corners of each triangle lie in one place.
    NoExtent,
}

/// The triangles of a text, of which there may be so many. A text that is given away is let go of once it has been read.
///
/// # Errors
/// Why there are none.
pub fn decode_obj(bytes: impl AsRef<[u8]>, most: u64) -> Result<Triangles, BadMesh> {
    let mut reader = Reader { most, ..Reader::default() };
    for line in Lines::new(bytes.as_ref()) {
        reader.read(&line?)?;
    }
    drop(bytes);
    if reader.polygons.is_empty() {
        return Err(BadMesh::NoFaces);
    }
    Triangles::new(reader.pieces()?).ok_or(BadMesh::NoExtent)
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    corners: Vec<Corner>,
    polygons: Vec<Polygon>,
    /// How many triangles they make.
    triangles: u64,
    most: u64,
}

/// A corner of a face: numbers from 0.
#[derive(Clone, Copy)]
struct Corner {
    point: u32,
    /// [`NONE`] for one without a normal.
    normal: u32,
}

const NONE: u32 = u32::MAX;

/// A face: where its corners end.
struct Polygon {
    end: u32,
    line: u32,
}

impl Reader {
    fn read(&mut self, line: &Line) -> Result<(), BadMesh> {
        let mut words = line.words();
        match words.next() {
            Some(b"v") => {
                let point = vector(line, &mut words, "v")?;
                push_one_of_few(&mut self.points, point, self.most, line)?;
            }
            Some(b"vn") => {
                let normal = vector(line, &mut words, "vn")?;
                push_one_of_few(&mut self.normals, normal, self.most, line)?;
            }
            Some(b"f" | b"fo") => self.face(line, words)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'w>(&mut self, line: &Line, words: impl Iterator<Item = &'w [u8]>) -> Result<(), BadMesh> {
        let begin = self.corners.len();
        for word in words {
            let corner = self.corner(line, word)?;
            self.corners.push(corner);
        }
        let count = self.corners.len() - begin;
        if count < 3 {
            return Err(BadMesh::Corners { line: line.number, count });
        }
        self.triangles += count as u64 - 2;
        if self.triangles > self.most {
            return Err(BadMesh::TooMany { line: line.number });
        }
        self.polygons.push(Polygon { end: self.corners.len() as u32, line: line.number });
        Ok(())
    }

    /// A corner: a point, and behind slashes perhaps a place in a texture, which is not read, and a normal.
    fn corner(&self, line: &Line, word: &[u8]) -> Result<Corner, BadMesh> {
        let mut parts = word.split(|it| *it == b'/');
        let number = |part: &[u8], what, count: usize| {
            index(part, count).ok_or_else(|| BadMesh::Index { line: line.number, text: text::shown(part), what, count })
        };
        let point = number(parts.next().unwrap_or_default(), "point", self.points.len())?;
        let texture = parts.next().unwrap_or_default();
        if !texture.is_empty() {
            // How many of them there are is not known.
            number(texture, "place in a texture", u32::MAX as usize)?;
        }
        let normal = match parts.next() {
            Some(part) if !part.is_empty() => number(part, "normal", self.normals.len())?,
            _ => NONE,
        };
        Ok(Corner { point, normal })
    }

    /// All faces, cut into triangles.
    fn pieces(self) -> Result<MeshPieces, BadMesh> {
        let mut faces = Vec::with_capacity(self.triangles as usize);
        let mut begin = 0;
        for Polygon { end, line } in self.polygons {
            let corners = &self.corners[begin..end as usize];
            begin = end as usize;
            let mut points = Vec::with_capacity(corners.len());
            for Corner { point, .. } in corners {
                points.push(
                    *self.points.get(*point as usize).ok_or_else(|| missing(line, *point, "point", &self.points))?,
                );
            }
            let mut is_shaded = true;
            for Corner { normal, .. } in corners.iter().filter(|it| it.normal != NONE) {
                let found = self
                    .normals
                    .get(*normal as usize)
                    .ok_or_else(|| missing(line, *normal, "normal", &self.normals))?;
                is_shaded &= *found != DVec3::ZERO;
            }
            is_shaded &= corners.iter().all(|it| it.normal != NONE);
            let Some(triangles) = polygon::triangles(&points) else {
                return Err(BadMesh::Corners { line, count: corners.len() });
            };
            faces.extend(triangles.into_iter().map(|it| Face {
                corners: it.map(|it| corners[it].point),
                normals: is_shaded.then(|| it.map(|it| corners[it].normal)),
                line,
            }));
        }
        Ok(MeshPieces { points: self.points, normals: self.normals, faces })
    }
}

/// Adds a point or a normal, of which there may be as many as corners of so many triangles.
fn push_one_of_few(all: &mut Vec<DVec3>, one: DVec3, triangles: u64, line: &Line) -> Result<(), BadMesh> {
    if all.len() as u64 >= triangles.saturating_mul(3) {
        return Err(BadMesh::TooMany { line: line.number });
    }
    all.push(one);
    Ok(())
}

/// A number of something that the whole text does not have.
fn missing(line: u32, number: u32, what: &'static str, all: &[DVec3]) -> BadMesh {
    BadMesh::Index { line, text: (u64::from(number) + 1).to_string(), what, count: all.len() }
}

/// Three numbers.
fn vector<'w>(line: &Line, words: &mut impl Iterator<Item = &'w [u8]>, word: &'static str) -> Result<DVec3, BadMesh> {
    let mut vector = DVec3::ZERO;
    for axis in 0..3 {
        let Some(text) = words.next() else {
            return Err(BadMesh::Few { line: line.number, word });
        };
        let number = std::str::from_utf8(text).ok().and_then(|it| it.parse::<f64>().ok());
        let fits = number.filter(|it| it.abs() <= MAX_COORDINATE);
        vector[axis] = fits.ok_or_else(|| BadMesh::Number { line: line.number, text: text::shown(text) })?;
    }
    Ok(vector)
}

/// What a number names, counted from 0: forward from the first, or back from the last of those there are so far. What it names may
/// come later in the text.
fn index(text: &[u8], count: usize) -> Option<u32> {
    let number: i64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    let named = if number < 0 { i64::try_from(count).ok()?.checked_add(number)? } else { number - 1 };
    u32::try_from(named).ok().filter(|it| *it != NONE)
}
