//! Gradient noise (K. Perlin, "Improving noise", 2002), on the hash of this crate.

use super::path::mix;

/// Smooth noise at a point, between -1 and 1, 0 at every point of the whole-number lattice. The seed decides the gradients.
pub(crate) fn gradient_noise(seed: u64, point: [f64; 3]) -> f64 {
    let cell = point.map(f64::floor);
    let inside = [point[0] - cell[0], point[1] - cell[1], point[2] - cell[2]];
    let fade = inside.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |x: usize, y: usize, z: usize| {
        let offset = [x as f64, y as f64, z as f64];
        let hash = (0..3).fold(seed, |hash, axis| mix(hash, (cell[axis] + offset[axis] + 0.0).to_bits()));
        let [dx, dy, dz] = [inside[0] - offset[0], inside[1] - offset[1], inside[2] - offset[2]];
        // The twelve directions to the middles of a cube's edges, four of them twice.
        match hash >> 60 {
            0 => dx + dy,
            1 => dy - dx,
            2 => dx - dy,
            3 => -dx - dy,
            4 => dx + dz,
            5 => dz - dx,
            6 => dx - dz,
            7 => -dx - dz,
            8 => dy + dz,
            9 => dz - dy,
            10 => dy - dz,
            11 => -dy - dz,
            12 => dx + dy,
            13 => dy - dx,
            14 => dz - dy,
            _ => -dy - dz,
        }
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |y, z| mix(corner(0, y, z), corner(1, y, z), fade[0]);
    let along_y = |z| mix(along_x(0, z), along_x(1, z), fade[1]);
    mix(along_y(0), along_y(1), fade[2])
}

#[cfg(test)]
mod tests {
    use super::gradient_noise;

    #[test]
    fn noise_is_zero_on_the_lattice_and_bounded_between() {
        let mut largest: f64 = 0.0;
        for step in 0..20_000u32 {
            let it = f64::from(step);
            assert_eq!(gradient_noise(5, [it, -it, 3.0]), 0.0);
            largest = largest.max(gradient_noise(5, [it * 0.377, it * 0.511, it * 0.123]).abs());
        }
        assert!((0.5..=1.0).contains(&largest), "{largest}");
    }

    #[test]
    fn noise_does_not_jump_where_cells_meet() {
        for step in 0..1000u32 {
            let (y, z) = (f64::from(step) * 0.37, f64::from(step) * 0.11);
            let (before, after) = (gradient_noise(1, [4.0 - 1e-10, y, z]), gradient_noise(1, [4.0 + 1e-10, y, z]));
            assert!((before - after).abs() < 1e-9);
        }
    }
}
