// part.toml, read and checked.
#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <string_view>

#include "appliance/parts/part_model.h"

namespace deixis {
namespace {

void warn_unknown(const toml::table& table, std::initializer_list<std::string_view> known,
                  const std::string& file, const std::string& prefix, std::vector<std::string>& warnings) {
    const std::string unknown = file + ": unknown key `" + prefix;
    for (const auto& [key, value] : table)
        if (std::find(known.begin(), known.end(), key.str()) == known.end())
            warnings.push_back(one_line(unknown + std::string(key.str()) + "` is ignored."));
}

Result<std::string> text_of(const toml::table& table, const std::string& key, const std::string& file,
                            const std::string& prefix = "") {
    const auto* value = table[key].as_string();
    if (value == nullptr || value->get().empty())
        return fail(file + ": `" + prefix + key + "` must be a text that is not empty.");
    return value->get();
}

Result<Eigen::Vector3d> vector_of(const toml::table& table, const std::string& key, const std::string& file,
                                  const std::string& prefix) {
    const auto* values = table[key].as_array();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    bool good = values != nullptr && values->size() == 3;
    for (int i = 0; good && i < 3; ++i) {
        const auto number = (*values)[static_cast<size_t>(i)].value<double>();
        good = number && std::isfinite(*number) && std::abs(*number) <= 100;
        if (good) vector[i] = *number;
    }
    if (!good)
        return fail(file + ": `" + prefix + key + "` must be three numbers, metres between -100 and 100.");
    return vector;
}

Result<Zone> zone_from(const toml::table& table, const std::string& file, const std::string& prefix) {
    auto name = text_of(table, "name", file, prefix);
    if (!name) return tl::unexpected(name.error());
    auto min = vector_of(table, "min", file, prefix);
    if (!min) return tl::unexpected(min.error());
    auto max = vector_of(table, "max", file, prefix);
    if (!max) return tl::unexpected(max.error());
    if ((min->array() > max->array()).any())
        return fail(file + ": `" + prefix + "min` must not be above `" + prefix + "max`.");
    return Zone{*name, {*min, *max}};
}

Result<std::vector<Zone>> zones_from(const toml::table& table, const std::string& file,
                                     std::vector<std::string>& warnings) {
    std::vector<Zone> zones;
    const auto node = table["zones"];
    if (!node) return zones;
    const auto* array = node.as_array();
    if (array == nullptr ||
        !std::all_of(array->begin(), array->end(), [](const auto& n) { return n.is_table(); }))
        return fail(file + ": `zones` must be a list of tables, written [[zones]].");
    for (size_t i = 0; i < array->size(); ++i) {
        const std::string prefix = "zones[" + std::to_string(i) + "].";
        const toml::table& entry = *(*array)[i].as_table();
        auto zone = zone_from(entry, file, prefix);
        if (!zone) return tl::unexpected(zone.error());
        warn_unknown(entry, {"name", "min", "max"}, file, prefix, warnings);
        zones.push_back(*zone);
    }
    return zones;
}

}  // namespace

Result<PartFile> read_part_file(const std::filesystem::path& path) {
    const std::string file = path.string();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return fail(file + ": there is no such part file.");
    if (std::filesystem::file_size(path, error) > 1'000'000 || error)
        return fail(file + ": the part file is larger than 1 MB.");
    toml::table table;
    try {
        table = toml::parse_file(file);
    } catch (const toml::parse_error& problem) {
        std::ostringstream sentence;
        sentence << file << ": line " << problem.source().begin.line << " is not TOML ("
                 << problem.description() << ").";
        return fail(sentence.str());
    }
    PartFile part;
    for (const auto& [key, into] : {std::pair{"type", &part.type}, std::pair{"serial", &part.serial}}) {
        auto text = text_of(table, key, file);
        if (!text) return tl::unexpected(text.error());
        *into = *text;
    }
    auto model = text_of(table, "model", file);
    if (!model) return tl::unexpected(model.error());
    part.model = path.parent_path() / *model;
    auto units = text_of(table, "units", file);
    if (!units) return tl::unexpected(units.error());
    if (*units != "mm" && *units != "m")
        return fail(file + ": `units` is \"" + *units + "\", expected \"mm\" or \"m\".");
    part.metres_per_unit = *units == "mm" ? 1e-3 : 1;
    auto zones = zones_from(table, file, part.warnings);
    if (!zones) return tl::unexpected(zones.error());
    part.zones = std::move(*zones);
    warn_unknown(table, {"type", "serial", "model", "units", "zones"}, file, "", part.warnings);
    return part;
}

std::string zone_of(const std::vector<Zone>& zones, const Eigen::Vector3d& position_part) {
    for (const Zone& zone : zones)
        if (zone.box.contains(position_part)) return zone.name;
    return {};
}

}  // namespace deixis
