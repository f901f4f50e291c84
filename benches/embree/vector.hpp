// Vectors of three floats, and affine maps.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

struct Vec {
    float x, y, z;
};

inline Vec operator+(Vec a, Vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(Vec a, Vec b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(Vec a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline float dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec unit(Vec a) {
    return a * (1 / std::sqrt(dot(a, a)));
}

// Three rows of an affine map, row by row: the fourth column is the translation.
using Map = std::array<double, 12>;

inline std::array<double, 3> apply(const Map &m, double x, double y, double z) {
    std::array<double, 3> image;
    for (int row = 0; row < 3; row++)
        image[row] = m[4 * row] * x + m[4 * row + 1] * y + m[4 * row + 2] * z + m[4 * row + 3];
    return image;
}

// The inverse of a map, by cofactors.
inline Map inverse(const Map &m) {
    auto at = [&](int row, int column) { return m[4 * (row % 3) + column % 3]; };
    Map inverse{};
    double determinant = 0;
    for (int k = 0; k < 3; k++) determinant += at(0, k) * (at(1, k + 1) * at(2, k + 2) - at(1, k + 2) * at(2, k + 1));
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++) {
            double minor =
                at(column + 1, row + 1) * at(column + 2, row + 2) - at(column + 1, row + 2) * at(column + 2, row + 1);
            inverse[4 * row + column] = minor / determinant;
        }
    }
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++) inverse[4 * row + 3] -= inverse[4 * row + k] * m[4 * k + 3];
    }
    return inverse;
}

// The map that does `inner` first.
inline Map product(const Map &outer, const Map &inner) {
    Map result{};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++) {
            for (int k = 0; k < 3; k++) result[4 * row + column] += outer[4 * row + k] * inner[4 * k + column];
        }
        result[4 * row + 3] += outer[4 * row + 3];
    }
    return result;
}
