// A close box around a Boolean. Embree is no faster than the boxes it is given, and those of the primitives are far too
// large for what is left when they are cut.
//
// The box of the first primitive is halved again and again in the primitive's frame; what surely lies outside of the
// solid is left out, and the rest gives the box in the world.
#pragma once
#include "solid.hpp"

struct Box {
    std::array<double, 3> low, high;
};

class Bounds {
public:
    explicit Bounds(const Solid &solid) : solid(solid), world_from_own(solid.primitives[0].world_from_own) {
        for (const Primitive &it : solid.primitives)
            other_from_own.push_back(product(inverse(it.world_from_own), world_from_own));
        double infinity = std::numeric_limits<double>::infinity();
        box.low.fill(infinity);
        box.high.fill(-infinity);
        int node = int(solid.nodes.size()) - 1;
        for (; solid.nodes[node].kind != Solid::Kind::Primitive; node = solid.nodes[node].first) {
            // Then the solid does not lie in its first primitive.
            if (solid.nodes[node].kind == Solid::Kind::Union)
                fail("a union at the head of a Boolean is more than this program knows");
        }
        halve({{-1, -1, -1}, {1, 1, 1}}, 0);
    }

    Box box;

private:
    static constexpr int DEPTH = 15;  // five halvings a direction
    enum class Place { Outside, Inside, Across };

    const Solid &solid;
    Map world_from_own;
    std::vector<Map> other_from_own;

    void halve(const Box &cell, int depth) {
        if (place(int(solid.nodes.size()) - 1, cell) == Place::Outside) return;
        if (depth == DEPTH) {
            cover(cell);
            return;
        }
        Box lower = cell, upper = cell;
        int axis = depth % 3;
        lower.high[axis] = upper.low[axis] = (cell.low[axis] + cell.high[axis]) / 2;
        halve(lower, depth + 1);
        halve(upper, depth + 1);
    }

    void cover(const Box &cell) {
        Box image = mapped(world_from_own, cell);
        for (int k = 0; k < 3; k++) {
            box.low[k] = std::min(box.low[k], image.low[k]);
            box.high[k] = std::max(box.high[k], image.high[k]);
        }
    }

    static Box mapped(const Map &map, const Box &box) {
        Box image;
        for (int row = 0; row < 3; row++) {
            image.low[row] = image.high[row] = map[4 * row + 3];
            for (int k = 0; k < 3; k++) {
                double a = map[4 * row + k] * box.low[k], b = map[4 * row + k] * box.high[k];
                image.low[row] += std::min(a, b);
                image.high[row] += std::max(a, b);
            }
        }
        return image;
    }

    Place place(int number, const Box &cell) const {
        const Solid::Node &node = solid.nodes[number];
        if (node.kind == Solid::Kind::Primitive) {
            return place(*solid.primitives[node.first].shape, mapped(other_from_own[node.first], cell));
        }
        Place first = place(node.first, cell), second = place(node.second, cell);
        if (node.kind == Solid::Kind::Difference) {
            second = second == Place::Inside ? Place::Outside : second == Place::Outside ? Place::Inside : second;
        }
        Place decides = node.kind == Solid::Kind::Union ? Place::Inside : Place::Outside;
        if (first == decides || second == decides) return decides;
        return first == second ? first : Place::Across;
    }

    static Place place(const Shape &shape, const Box &box) {
        bool inside = true;
        if (shape.round) {
            double least = 0, most = 0;
            for (int k = 0; k < 3; k++) {
                double factor = k == 2 ? shape.square_z : 1, low = box.low[k], high = box.high[k];
                double near = low > 0 ? low : high < 0 ? high : 0, far = std::max(-low, high);
                least += factor * near * near;
                most += factor * far * far;
            }
            if (least > 1.0001) return Place::Outside;
            inside = most < 0.9999;
        }
        for (int plane = 0; plane < shape.planes; plane++) {
            Vec n = shape.normals[plane];
            double least = 0, most = 0;
            const float parts[3] = {n.x, n.y, n.z};
            for (int k = 0; k < 3; k++) {
                least += parts[k] * (parts[k] > 0 ? box.low[k] : box.high[k]);
                most += parts[k] * (parts[k] > 0 ? box.high[k] : box.low[k]);
            }
            if (least > shape.distances[plane] + 0.0001) return Place::Outside;
            inside = inside && most < shape.distances[plane] - 0.0001;
        }
        return inside ? Place::Inside : Place::Across;
    }
};
