//! The primitives in POV-Ray's language.

use std::fmt::{self, Write};

use glam::{DAffine3, DMat3, DVec3};

use super::Placed;
use crate::form::PrimitiveKind;
use crate::geometry::Triangles;

/// The unit solids that POV-Ray does not have, and nothing at all.
pub(super) const DECLARATIONS: &str = "\
#declare Tetrahedron = intersection {
  plane { <-1, -1, -1>, 0.5773502691896257 }
  plane { < 1,  1, -1>, 0.5773502691896257 }
  plane { <-1,  1,  1>, 0.5773502691896257 }
  plane { < 1, -1,  1>, 0.5773502691896257 }
  bounded_by { box { -1, 1 } }
}
#declare Paraboloid = quadric { <1, 1, 0>, <0, 0, 0>, <0, 0, 1>, 0 }
#declare Hyperboloid = intersection { quadric { <1, 1, -1>, <0, 0, 0>, <0, 0, 2>, 0 } plane { z, 1 } }
#declare Nothing = intersection { plane { z, -1 } plane { -z, -1 } }
";

/// The texture of a solid.
#[derive(Clone, Copy, Debug)]
pub(super) enum Texture {
    /// The default one.
    None,
    /// That of a material.
    Declared(u32),
    /// That of a material, with a colour (sRGB) of its own.
    Varied(u32, DVec3),
}

impl fmt::Display for Texture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Declared(number) => write!(f, " texture {{ Material_{number} }}"),
            Self::Varied(number, color) => {
                write!(f, " texture {{ pigment {{ color srgb {} }} finish {{ Finish_{number} }} }}", Triple(*color))
            }
        }
    }
}

/// What is beyond all numbers, made larger for POV-Ray, is the greatest one; what came to no number on the way is 0.
fn within(vector: DVec3) -> DVec3 {
    let within = |it: f64| if it.is_nan() { 0.0 } else { it.clamp(-f64::MAX, f64::MAX) };
    DVec3::from_array(vector.to_array().map(within))
}

/// A vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triple(pub(super) DVec3);

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let v = within(self.0);
        write!(f, "<{:?}, {:?}, {:?}>", v.x, v.y, v.z)
    }
}

/// A map, with the images of the axes and of the origin after one another.
struct Matrix<'m>(&'m DAffine3);

impl fmt::Display for Matrix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = [self.0.matrix3.x_axis, self.0.matrix3.y_axis, self.0.matrix3.z_axis];
        let numbers = [x, y, z, self.0.translation].map(within);
        let numbers = numbers.map(|it| format!("{:?}, {:?}, {:?}", it.x, it.y, it.z));
        write!(f, "<{}>", numbers.join(", "))
    }
}

/// Writes a primitive.
pub(super) fn write(placed: &Placed, pov_from_world: &DAffine3, texture: &Texture, text: &mut String) {
    let (object, scale) = unit(placed.kind, &placed.parameters);
    let map = *pov_from_world * placed.world_from_primitive * DAffine3::from_scale(scale);
    let _ = match (placed.kind, factor(&map)) {
        // POV-Ray keeps and uses a matrix for every part of an object, unless it is told that there is no need to.
        (PrimitiveKind::Sphere, Some(radius)) => write!(text, "sphere {{ {}, {radius:?}", Triple(map.translation)),
        (_, Some(factor)) if map.matrix3 == DMat3::from_diagonal(DVec3::splat(factor)) => {
            write!(text, "{object} scale {factor:?} translate {}", Triple(map.translation))
        }
        _ => write!(text, "{object} matrix {}", Matrix(&map)),
    };
    let _ = writeln!(text, "{texture} }}");
}

/// By how much a map makes everything larger, if it keeps all shapes.
fn factor(map: &DAffine3) -> Option<f64> {
    /// Beyond the error of a product of many rotations.
    const ERROR: f64 = 1e-12;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = map.matrix3;
    let square = x.length_squared();
    let apart = [y.length_squared() - square, z.length_squared() - square, x.dot(y), y.dot(z), z.dot(x)];
    (square < f64::INFINITY && apart.iter().all(|it| it.abs() <= ERROR * square)).then(|| square.sqrt())
}

/// A plane with a normal of length 1. It is made smaller first where its square would be beyond all numbers, or nothing.
fn of_length_1(normal: DVec3, offset: f64) -> (Triple, f64) {
    let largest = normal.abs().max_element();
    let is_usual = (1e-150..1e150).contains(&largest);
    let (normal, offset) = if is_usual { (normal, offset) } else { (normal / largest, offset / largest) };
    let length = normal.length();
    (Triple(normal / length), (offset / length).clamp(-f64::MAX, f64::MAX))
}

/// Writes a triangle of a mesh.
pub(super) fn write_corners(map: &DAffine3, text: &mut String) {
    let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|it| Triple(map.transform_point3(it)));
    let _ = writeln!(text, "triangle {{ {a}, {b}, {c} }}");
}

/// The beginning of an object, and what to scale it by.
fn unit(kind: PrimitiveKind, parameters: &[f64]) -> (String, DVec3) {
    let plain = |text: &str| (text.to_owned(), DVec3::ONE);
    match (kind, parameters) {
        (PrimitiveKind::Ellipsoid, &[a, b, c]) => ("sphere { 0, 1".to_owned(), DVec3::new(a, b, c)),
        (PrimitiveKind::Cylinder, _) => plain("cylinder { 0, z, 1"),
        (PrimitiveKind::Cone, &[r0, r1]) => plain(&format!("cone {{ 0, {r0:?}, z, {r1:?}")),
        (PrimitiveKind::Box, _) => plain("box { -1, 1"),
        (PrimitiveKind::Tetrahedron, _) => plain("object { Tetrahedron"),
        (PrimitiveKind::Torus, &[r]) => plain(&format!("torus {{ 1, {r:?} sturm rotate 90*x")),
        (PrimitiveKind::Triangle, _) => plain("triangle { 0, x, y"),
        (PrimitiveKind::HalfSpace, &[x, y, z, d]) => {
            let (normal, offset) = of_length_1(DVec3::new(x, y, z), d);
            plain(&format!("plane {{ {normal}, {offset:?}"))
        }
        (PrimitiveKind::Paraboloid, &[a, b]) => ("object { Paraboloid".to_owned(), DVec3::new(a, b, 1.0)),
        (PrimitiveKind::Hyperboloid, &[a, b, c]) => ("object { Hyperboloid".to_owned(), DVec3::new(a, b, c)),
        (PrimitiveKind::Quadric, &[q1, q2, q3, q4, q5, q6, q7, q8, q9, q0]) => {
            // POV-Ray has the product of x and z before that of y and z.
            let [squares, products, linear] = [[q1, q2, q3], [q4, q6, q5], [q7, q8, q9]].map(|it| Triple(it.into()));
            plain(&format!("quadric {{ {squares}, {products}, {linear}, {q0:?}"))
        }
        (PrimitiveKind::Segment, &[radius, slope, lean, top, x, y]) => {
            plain(&segment(radius, slope, lean, top, [x, y]))
        }
        (PrimitiveKind::Hull, numbers) => plain(&hull(numbers)),
        (PrimitiveKind::Mesh { mesh, .. }, _) => plain(&format!("object {{ Mesh_{}", mesh.0)),
        // Only a sphere is left: a piece has the parameters of its kind.
        _ => plain("sphere { 0, 1"),
    }
}

/// Declares a mesh of a file, once for all places where it stands. What is inside of a closed one is found along an axis.
pub(super) fn declare(number: usize, mesh: &Triangles) -> String {
    let mut text = format!("#declare Mesh_{number} = mesh {{\n");
    for face in 0..mesh.count() as u32 {
        let ([a, b, c], [u, v, w]) = (mesh.corners(face).map(Triple), mesh.normals(face).map(Triple));
        let _ = if mesh.is_flat(face) {
            writeln!(text, "triangle {{ {a}, {b}, {c} }}")
        } else {
            writeln!(text, "smooth_triangle {{ {a}, {u}, {b}, {v}, {c}, {w} }}")
        };
    }
    text.push_str(if mesh.gap().is_none() { "inside_vector z\n}\n" } else { "}\n" });
    text
}

/// What lies behind planes, of which there may be one only.
fn hull(numbers: &[f64]) -> String {
    let (planes, _) = numbers.as_chunks::<4>();
    let planes = planes.iter().map(|[x, y, z, d]| {
        let (normal, offset) = of_length_1(DVec3::new(*x, *y, *z), *d);
        format!(" plane {{ {normal}, {offset:?} }}")
    });
    // POV-Ray wants two parts at least.
    let mut text = "intersection { plane { z, 1e30 }".to_owned();
    text.extend(planes);
    text
}

/// A cone that reaches beyond both cuts, and the cuts.
fn segment(radius: f64, slope: f64, lean: f64, top: f64, [x, y]: [f64; 2]) -> String {
    let steep = libm::hypot(x, y);
    // How high the nappe's lines cross a plane where it is lowest and where it is highest.
    let crossing = |height: f64, rise: f64| (height + radius * rise) / (1.0 - slope * rise);
    let (low, high) = (crossing(0.0, -lean.abs()), crossing(top, steep));
    let radius_at = |z: f64| (radius + slope * z).max(0.0);
    let plane = |normal: DVec3, offset: f64| {
        let (normal, offset) = of_length_1(normal, offset);
        format!("plane {{ {normal}, {offset:?} }}")
    };
    format!(
        "intersection {{ cone {{ {low:?}*z, {:?}, {high:?}*z, {:?} }} {} {}",
        radius_at(low),
        radius_at(high),
        plane(DVec3::new(lean, 0.0, -1.0), 0.0),
        plane(DVec3::new(-x, -y, 1.0), top)
    )
}
