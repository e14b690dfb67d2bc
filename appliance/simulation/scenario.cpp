// Reading SCENARIO.toml, key by key, with one sentence for the first thing that is wrong.
#include "appliance/simulation/scenario.h"

#include <toml++/toml.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>

namespace deixis {

const char* name_of(AimMode mode) {
    switch (mode) {
        case AimMode::eye:
            return "eye";
        case AimMode::forearm:
            return "forearm";
        case AimMode::finger:
            return "finger";
    }
    return "";
}

namespace {

constexpr double degree = std::numbers::pi / 180;

/// The first complaint and all warnings of a file.
struct Findings {
    std::string file;
    std::string complaint;
    std::vector<std::string> warnings;

    void refuse(const std::string& key, const std::string& expected) {
        if (complaint.empty()) complaint = file + ": key \"" + key + "\" " + expected;
    }
};

std::string shown(double value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

/// One table of the file; what is never asked for becomes a warning at the end of its life.
class Section {
  public:
    Section(Findings& findings, const toml::table& table, std::string name)
        : findings_(findings), table_(table), name_(std::move(name)) {}
    ~Section() {
        for (const auto& [key, value] : table_)
            if (!asked_.contains(std::string(key.str())))
                findings_.warnings.push_back(one_line(findings_.file + ": key \"" +
                                                      path(std::string(key.str())) +
                                                      "\" is unknown and was ignored"));
    }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

    std::string path(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
    bool has(const std::string& key) const { return table_.contains(key); }
    void refuse(const std::string& key, const std::string& expected) {
        findings_.refuse(path(key), expected);
    }

    const toml::node* node(const std::string& key) {
        asked_.insert(key);
        return table_.get(key);
    }

    std::optional<double> number(const std::string& key, double low, double high) {
        const toml::node* n = node(key);
        if (n == nullptr) return std::nullopt;
        return checked(*n, key, low, high);
    }
    void number(const std::string& key, double low, double high, double& value) {
        value = number(key, low, high).value_or(value);
    }
    void integer(const std::string& key, int64_t low, int64_t high, int64_t& value) {
        const toml::node* n = node(key);
        if (n == nullptr) return;
        const auto given = n->value_exact<int64_t>();
        if (given && *given >= low && *given <= high)
            value = *given;
        else
            refuse(key, "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    void flag(const std::string& key, bool& value) {
        const toml::node* n = node(key);
        if (n == nullptr) return;
        if (const auto given = n->value_exact<bool>())
            value = *given;
        else
            refuse(key, "must be true or false");
    }
    std::optional<std::string> text(const std::string& key) {
        const toml::node* n = node(key);
        if (n == nullptr) return std::nullopt;
        const auto given = n->value_exact<std::string>();
        if (!given || given->empty()) refuse(key, "must be a text that is not empty");
        return given;
    }
    std::optional<std::string> word(const std::string& key, const std::vector<std::string>& allowed) {
        auto given = text(key);
        if (!given || std::find(allowed.begin(), allowed.end(), *given) != allowed.end()) return given;
        std::string list;
        for (const std::string& a : allowed) list += (list.empty() ? "\"" : ", \"") + a + "\"";
        refuse(key, "must be one of " + list + ", not \"" + *given + "\"");
        return std::nullopt;
    }
    template <int N>
    std::optional<Eigen::Matrix<double, N, 1>> vector(const std::string& key, double limit) {
        const toml::node* n = node(key);
        if (n == nullptr) return std::nullopt;
        const toml::array* a = n->as_array();
        if (a == nullptr || a->size() != N) {
            refuse(key, "must be a list of " + std::to_string(N) + " numbers");
            return std::nullopt;
        }
        Eigen::Matrix<double, N, 1> v;
        for (int i = 0; i < N; ++i) v[i] = checked(*a->get(static_cast<size_t>(i)), key, -limit, limit);
        return v;
    }

  private:
    double checked(const toml::node& n, const std::string& key, double low, double high) {
        const auto given = n.is_number() ? n.value<double>() : std::nullopt;
        if (given && *given >= low && *given <= high) return *given;
        refuse(key, "must be a number from " + shown(low) + " to " + shown(high) +
                        (given ? ", not " + shown(*given) : ""));
        return low;
    }

    Findings& findings_;
    const toml::table& table_;
    std::string name_;
    std::set<std::string> asked_;
};

constexpr double room = 50;  // no coordinate of a work cell lies farther out [m]

std::optional<FloorPose> read_floor_pose(Section& s, const std::string& position, const std::string& turn) {
    const auto p = s.vector<2>(position, room);
    const auto t = s.number(turn, -360, 360);
    if (!p && !t) return std::nullopt;
    if (!p) s.refuse(position, "is missing beside \"" + turn + "\"");
    return FloorPose{p.value_or(Eigen::Vector2d::Zero()), t.value_or(0) * degree};
}

/// The table `key` of `parent`, empty where it is absent; refuses what is no table.
const toml::table& table_of(Section& parent, const std::string& key) {
    static const toml::table empty;
    const toml::node* n = parent.node(key);
    if (n == nullptr) return empty;
    if (n->as_table() == nullptr) parent.refuse(key, "must be a table");
    return n->as_table() != nullptr ? *n->as_table() : empty;
}

/// Calls `each` for every table of the array of tables `key`.
template <class F>
void for_each_table(Findings& findings, Section& parent, const std::string& key, F each) {
    const toml::node* n = parent.node(key);
    if (n == nullptr) return;
    const toml::array* list = n->as_array();
    if (list == nullptr) return parent.refuse(key, "must be a list of tables");
    for (size_t i = 0; i < list->size(); ++i) {
        const std::string name = parent.path(key) + "[" + std::to_string(i + 1) + "]";
        const toml::table* t = list->get(i)->as_table();
        if (t == nullptr) return findings.refuse(name, "must be a table");
        Section section(findings, *t, name);
        each(section);
    }
}

Box read_box(Section& s, Box box) {
    box.min = s.vector<3>("min", room).value_or(box.min);
    box.max = s.vector<3>("max", room).value_or(box.max);
    if (!(box.min.array() < box.max.array()).all()) s.refuse("min", "must lie below \"max\" on every axis");
    return box;
}

void read_part(Findings& findings, Section& root, Scenario& scenario) {
    ScenarioPart& part = scenario.part;
    part.present = root.has("part");
    Section s(findings, table_of(root, "part"), "part");
    if (!part.present) return;
    if (const auto model = s.text("model")) part.model = scenario.file.parent_path() / *model;
    part.sample = s.word("sample", {"a", "b"}).value_or("");
    if (s.has("model") == s.has("sample")) s.refuse("model", "or \"sample\" must be given, one of the two");
    part.units = s.word("units", {"mm", "m"}).value_or("mm");
    part.type = s.text("type").value_or("part");
    part.serial = s.text("serial").value_or("0001");
    if (const auto turns = s.vector<3>("mounting_deg", 360)) {
        const auto about = [&](int i, const Eigen::Vector3d& axis) {
            return Eigen::AngleAxisd((*turns)[i] * degree, axis);
        };
        part.mounting = (about(2, Eigen::Vector3d::UnitZ()) * about(1, Eigen::Vector3d::UnitY()) *
                         about(0, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix();
    }
    part.mounting_position = s.vector<3>("mounting_position", 3);
    s.number("lower_edge", 0.3, 1.5, part.lower_edge);
    part.start = read_floor_pose(s, "start", "start_turn_deg").value_or(FloorPose{{0, 0.75}, 0});
    for_each_table(findings, s, "zones", [&](Section& zone) {
        const auto name = zone.text("name");
        if (!name) zone.refuse("name", "is missing");
        if (!zone.has("min") || !zone.has("max")) zone.refuse("min", "and \"max\" must both be given");
        part.zones.push_back(
            {name.value_or(""), read_box(zone, {Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()})});
    });
}

void read_worker(Findings& findings, Section& root, Scenario& scenario) {
    ScenarioWorker& worker = scenario.worker;
    worker.present = root.has("worker");
    Section s(findings, table_of(root, "worker"), "worker");
    worker.height = s.number("height", 1.4, 2.1);
    worker.build = s.number("build", 0.7, 1.5);
    if (const auto aim = s.word("aim", {"eye", "forearm", "finger"}))
        worker.aim = *aim == "eye" ? AimMode::eye : *aim == "forearm" ? AimMode::forearm : AimMode::finger;
    if (const auto scatter = s.number("scatter_deg", 0, 20)) worker.scatter = *scatter * degree;
    if (const auto gap = s.vector<2>("gap", 1)) {
        worker.gap_min = (*gap)[0];
        worker.gap_max = (*gap)[1];
        if (worker.gap_min < 0 || worker.gap_max < worker.gap_min)
            s.refuse("gap", "must hold the least and the greatest distance in metres, in this order");
    }
    worker.start = read_floor_pose(s, "start", "start_facing_deg");
    if (const auto clip = s.text("clip")) worker.clip = scenario.file.parent_path() / *clip;
    if (const auto skeleton = s.text("clip_skeleton"))
        worker.skeleton = scenario.file.parent_path() / *skeleton;
    s.number("clip_scale", 1e-5, 100, worker.clip_scale);
    if (s.has("clip_skeleton") && !s.has("clip"))
        s.refuse("clip_skeleton", "has no meaning without \"clip\"");
    if (worker.clip.extension() == ".amc" && worker.skeleton.empty())
        s.refuse("clip_skeleton", "is missing: an AMC clip needs the ASF file of its skeleton");
}

ScenarioAction read_action(Section& s, const Scenario& scenario) {
    static const std::vector<std::string> kinds{"wait", "walk", "push",    "point",
                                                "pass", "hip",  "scratch", "lean"};
    ScenarioAction action;
    const auto kind = s.word("do", kinds);
    if (!s.has("do")) s.refuse("do", "is missing");
    if (!kind) return action;
    action.kind = static_cast<ActionKind>(std::find(kinds.begin(), kinds.end(), *kind) - kinds.begin());
    action.seconds = s.number("seconds", 0.05, 600);
    const bool moves = action.kind == ActionKind::walk || action.kind == ActionKind::push;
    const bool aims = action.kind == ActionKind::point || action.kind == ActionKind::pass ||
                      action.kind == ActionKind::push;
    if (moves) {
        const auto to = read_floor_pose(s, "to", action.kind == ActionKind::walk ? "facing_deg" : "turn_deg");
        if (!to) s.refuse("to", "is missing");
        action.to = to.value_or(FloorPose{});
    }
    if (aims) action.target = s.vector<3>("target", 10);
    if (const auto arm = s.word("arm", {"left", "right"})) action.left_arm = *arm == "left";
    if (action.kind == ActionKind::point) {
        s.flag("meant", action.meant);
        s.flag("touch", action.touch);
    }
    if (action.kind == ActionKind::push) {
        if (const auto by = s.word("by", {"end", "corner"})) action.by_end = *by == "end";
        s.flag("pointing", action.pointing);
        if (action.pointing && action.by_end) s.refuse("pointing", "needs a free hand: push by = \"corner\"");
    }
    if (!scenario.part.present && action.kind != ActionKind::wait && action.kind != ActionKind::walk &&
        action.kind != ActionKind::scratch && action.kind != ActionKind::lean)
        s.refuse("do", "needs a part, but the scenario has no table \"part\"");
    return action;
}

void read_sensors(Findings& findings, Section& root, Scenario& scenario) {
    ScenarioOptics& optics = scenario.optics;
    Section s(findings, table_of(root, "optics"), "optics");
    int64_t width = optics.width, height = optics.height;
    s.integer("width", 64, 1280, width);
    s.integer("height", 48, 1024, height);
    optics.width = static_cast<int>(width);
    optics.height = static_cast<int>(height);
    s.number("focal", 200, 2000, optics.focal);
    optics.noise = s.number("noise", 0, 10);
    s.flag("distorted", optics.distorted);
    s.number("place_spread", 0, 1, optics.place_spread);

    std::set<std::string> names;
    for_each_table(findings, root, "sensor", [&](Section& sensor) {
        ScenarioSensor one;
        one.name = sensor.text("name").value_or("");
        if (!sensor.has("name")) sensor.refuse("name", "is missing");
        const bool plain = std::all_of(one.name.begin(), one.name.end(), [](unsigned char c) {
            return std::isalnum(c) != 0 || c == '_' || c == '-';
        });
        if (!plain || one.name.size() > 64)
            sensor.refuse("name", "must hold only letters, digits, \"_\" and \"-\"");
        if (!names.insert(one.name).second) sensor.refuse("name", "\"" + one.name + "\" is used twice");
        for (const char* key : {"position", "look_at"})
            if (!sensor.has(key)) sensor.refuse(key, "is missing");
        one.position = sensor.vector<3>("position", room).value_or(Eigen::Vector3d::Zero());
        one.look_at = sensor.vector<3>("look_at", room).value_or(Eigen::Vector3d::Zero());
        if ((one.look_at - one.position).head<2>().norm() < 0.1)
            sensor.refuse("look_at", "must lie at least 10 cm beside \"position\" on the floor plan");
        scenario.sensors.push_back(one);
    });
    if (scenario.sensors.empty()) findings.refuse("sensor", "is missing: at least one [[sensor]] is needed");
}

void read_all(Findings& findings, const toml::table& table, Scenario& scenario) {
    Section root(findings, table, "");
    const auto format = root.text("format");
    if (!format || *format != "deixis-scenario/1") root.refuse("format", "must be \"deixis-scenario/1\"");
    scenario.name = root.text("name").value_or(scenario.file.stem().string());
    int64_t seed = 1;
    root.integer("seed", 0, std::numeric_limits<int64_t>::max(), seed);
    scenario.seed = static_cast<uint64_t>(seed);
    root.number("fps", 1, 60, scenario.fps);
    root.number("tail", 0, 60, scenario.tail);
    root.flag("clutter", scenario.clutter);
    {
        Section cell(findings, table_of(root, "cell"), "cell");
        scenario.cell = read_box(cell, scenario.cell);
        const auto axis = cell.vector<3>("pointing_axis", 1e3);
        if (axis && axis->norm() < 1e-6) cell.refuse("pointing_axis", "must not be zero");
        if (axis) scenario.pointing_axis = axis->normalized();
    }
    read_part(findings, root, scenario);
    read_sensors(findings, root, scenario);
    read_worker(findings, root, scenario);
    for_each_table(findings, root, "action",
                   [&](Section& s) { scenario.actions.push_back(read_action(s, scenario)); });
    if (!scenario.actions.empty() && !scenario.worker.present)
        findings.refuse("action", "needs a worker, but the scenario has no table \"worker\"");
    if (!scenario.actions.empty() && !scenario.worker.clip.empty())
        findings.refuse("worker.clip", "and [[action]] exclude each other");
    if (scenario.actions.empty() && scenario.worker.clip.empty() && !root.has("seconds"))
        findings.refuse("seconds",
                        "is missing: without actions and clip it says how long the scenario lasts");
    if (const auto seconds = root.number("seconds", 0.1, 36000)) scenario.seconds = *seconds;
    Section expected(findings, table_of(root, "expected"), "expected");
    for (const char* key :
         {"marks_found_min", "false_marks_max", "position_mm_median_max", "position_mm_p95_max",
          "joint_error_mm_max", "pcp_min", "part_mm_max", "part_deg_max", "frame_ms_p99_max", "tolerance_mm"})
        if (const auto value = expected.number(key, 0, 1e6)) scenario.expected.emplace_back(key, *value);
}

}  // namespace

Result<Scenario> parse_scenario(const std::string& text, const std::filesystem::path& path) {
    toml::table table;
    try {
        table = toml::parse(text, path.string());
    } catch (const toml::parse_error& error) {
        return fail(path.string() + ": line " + std::to_string(error.source().begin.line) + ": " +
                    std::string(error.description()));
    }
    Scenario scenario;
    scenario.file = path;
    Findings findings{path.string(), "", {}};
    read_all(findings, table, scenario);
    if (!findings.complaint.empty()) return fail(findings.complaint);
    scenario.warnings = std::move(findings.warnings);
    return scenario;
}

Result<Scenario> read_scenario(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return fail(path.string() + ": cannot be opened");
    std::ostringstream text;
    text << file.rdbuf();
    if (!file.good() || std::filesystem::is_directory(path)) return fail(path.string() + ": cannot be read");
    return parse_scenario(text.str(), path);
}

}  // namespace deixis
