//! Principal axes.

use glam::{DMat3, DVec3};

/// The eigenvalues of a symmetric matrix and its eigenvectors, of length 1 and at right angles, in the same order.
///
/// By Jacobi's rotations (Golub and Van Loan, Matrix Computations, section 8.5): each makes one element off the diagonal 0. A
/// diagonal matrix comes back as it is, to the bit.
pub(crate) fn eigen(matrix: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let mut m = matrix;
    let mut vectors = DMat3::IDENTITY;
    // It converges quadratically: six sweeps are more than f64 needs, and the rest do nothing.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = m.col(p)[q];
            if off != 0.0 {
                let rotation = annihilating(m.col(p)[p], m.col(q)[q], off, p, q);
                m = rotation.transpose() * m * rotation;
                m.col_mut(p)[q] = 0.0;
                m.col_mut(q)[p] = 0.0;
                vectors *= rotation;
            }
        }
    }
    ([m.x_axis.x, m.y_axis.y, m.z_axis.z], [vectors.x_axis, vectors.y_axis, vectors.z_axis])
}

/// The rotation in the plane of axes `p` and `q` that takes `off` to 0.
fn annihilating(pp: f64, qq: f64, off: f64, p: usize, q: usize) -> DMat3 {
    let theta = (qq - pp) / (2.0 * off);
    let tangent = 1_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    let mut rotation = DMat3::IDENTITY;
    rotation.col_mut(p)[p] = cosine;
    rotation.col_mut(q)[q] = cosine;
    rotation.col_mut(q)[p] = sine;
    rotation.col_mut(p)[q] = -sine;
    rotation
}
