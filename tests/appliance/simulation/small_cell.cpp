// A small cell for the tests of the simulation.
#include "tests/appliance/simulation/small_cell.h"

#include <gtest/gtest.h>

#include <cmath>

namespace deixis {

SurfaceMesh curved_panel() {
    constexpr int columns = 48, rows = 12;
    constexpr double radius = 1.6, wall = 0.003;
    SurfaceMesh mesh;
    for (const double r : {radius, radius - wall})
        for (int row = 0; row <= rows; ++row)
            for (int column = 0; column <= columns; ++column) {
                const double turn = (static_cast<double>(column) / columns - 0.5) * 1.05;
                mesh.vertices.emplace_back(static_cast<float>(r * std::sin(turn)),
                                           static_cast<float>(radius - r * std::cos(turn)),
                                           0.4F * static_cast<float>(row) / rows);
            }
    const auto at = [](int layer, int row, int column) {
        return static_cast<uint32_t>((layer * (rows + 1) + row) * (columns + 1) + column);
    };
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            quad(at(0, row, column), at(0, row, column + 1), at(0, row + 1, column + 1),
                 at(0, row + 1, column));
            quad(at(1, row, column), at(1, row + 1, column), at(1, row + 1, column + 1),
                 at(1, row, column + 1));
        }
    return mesh;
}

std::string small_scenario(const std::string& actions) {
    return R"(format = "deixis-scenario/1"
name = "small"
seed = 5
[part]
model = "panel.stl"
units = "m"
lower_edge = 0.65
start = [0.0, 0.75]
[optics]
width = 160
height = 120
[[sensor]]
name = "left"
position = [-2.05, -1.35, 2.5]
look_at = [0.1, 0.45, 0.95]
[[sensor]]
name = "right"
position = [2.1, -1.2, 2.4]
look_at = [-0.1, 0.45, 0.95]
[worker]
)" + actions;
}

Scenario parsed(const std::string& text) {
    auto scenario = parse_scenario(text, "cell.toml");
    EXPECT_TRUE(scenario.has_value()) << scenario.error().sentence;
    return scenario.has_value() ? *scenario : Scenario{};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

double distance_off_line(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d along = (b - a).normalized();
    return ((p - a) - along * along.dot(p - a)).norm();
}

}  // namespace deixis
