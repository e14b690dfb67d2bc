// calibration.toml, read and written.
#include "appliance/calibration/calibration_file.h"

#include <Eigen/LU>
#include <cmath>
#include <set>

#include "appliance/calibration/toml_section.h"
#include "appliance/calibration/whole_file.h"

namespace deixis {
namespace {

constexpr const char* calibration_format = "deixis-calibration/1";
constexpr size_t largest_file = size_t{1} << 20;
constexpr size_t most_sensors = 64;
constexpr double orthonormal_to = 1e-4;

constexpr const char* three_numbers = "three finite numbers";

const char* word_for(SensorKind kind) {
    switch (kind) {
        case SensorKind::depth:
            return "depth";
        case SensorKind::infrared:
            return "infrared";
        case SensorKind::video:
            return "video";
    }
    return "";
}

/// Why `name` cannot be the stem of a stream's file; empty when it can.
std::string name_fault(const std::string& name) {
    if (name.empty() || name.size() > 64) return "1 to 64 bytes";
    if (name.front() == '.') return "a name that does not begin with a dot";
    if (name == "background") return "another name than that of the folder 'background'";
    for (const char c : name)
        if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            return "a name without slash, backslash and control characters";
    return "";
}

Eigen::Vector3d vector_of(const std::vector<double>& v) {
    return {v[0], v[1], v[2]};
}

void read_lens(TomlSection& section, CameraModel& camera) {
    constexpr const char* focal = "a focal length in pixels, above 0 and at most 1e6";
    constexpr const char* centre = "a number of pixels between -1e6 and 1e6";
    camera.width = static_cast<int>(section.whole_number("width", 1, 16384));
    camera.height = static_cast<int>(section.whole_number("height", 1, 16384));
    camera.fx = section.number("fx", 1e-6, 1e6, focal);
    camera.fy = section.number("fy", 1e-6, 1e6, focal);
    camera.cx = section.number("cx", -1e6, 1e6, centre);
    camera.cy = section.number("cy", -1e6, 1e6, centre);
    if (!section.has("distortion")) return;
    const std::vector<double> k =
        section.numbers("distortion", 5, "five finite numbers [k1, k2, p1, p2, k3]");
    for (size_t i = 0; i < 5; ++i) camera.distortion[i] = k[i];
}

void read_place(TomlSection& section, RigidTransform& camera_from_world) {
    const std::vector<double> r = section.matrix3("rotation", "3 rows of 3 finite numbers");
    camera_from_world.translation = vector_of(section.numbers("translation", 3, three_numbers));
    for (int i = 0; i < 9; ++i) camera_from_world.rotation(i / 3, i % 3) = r[static_cast<size_t>(i)];
    const Eigen::Matrix3d& m = camera_from_world.rotation;
    const double off = (m * m.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(off <= orthonormal_to)) {
        section.refuse("rotation", "orthonormal rows to 1e-4", "rows that are off by " + std::to_string(off));
    } else if (m.determinant() < 0) {
        section.refuse("rotation", "a rotation", "a reflection (determinant -1)");
    }
    if (camera_from_world.translation.cwiseAbs().maxCoeff() > 1e4)
        section.refuse("translation", "metres, at most 10000 each");
}

CalibratedSensor read_sensor(TomlSection& section, std::set<std::string>& names) {
    CalibratedSensor sensor;
    sensor.name = section.text("name", "the sensor's name");
    if (const std::string fault = name_fault(sensor.name); !fault.empty())
        section.refuse("name", fault, toml_quoted(sensor.name));
    if (!names.insert(sensor.name).second)
        section.refuse("name", "a name that no other sensor has", toml_quoted(sensor.name));
    constexpr const char* kinds = "\"depth\", \"infrared\" or \"video\"";
    const std::string kind = section.text("kind", kinds);
    bool known = false;
    for (const SensorKind k : {SensorKind::depth, SensorKind::infrared, SensorKind::video}) {
        if (kind != word_for(k)) continue;
        sensor.kind = k;
        known = true;
    }
    if (!known) section.refuse("kind", kinds, toml_quoted(kind));
    read_lens(section, sensor.camera);
    read_place(section, sensor.camera_from_world);
    sensor.uri = section.optional_text("uri", "the device's URI").value_or("");
    section.warn_of_unknown_keys();
    return sensor;
}

void read_cell(TomlSection& section, SensorRig& rig) {
    if (section.has("min") || section.has("max")) {
        Box box;
        box.min = vector_of(section.numbers("min", 3, three_numbers));
        box.max = vector_of(section.numbers("max", 3, three_numbers));
        if (!(box.min.array() < box.max.array()).all())
            section.refuse("max", "each number above that of cell.min (an empty cell holds nothing)");
        if (box.min.cwiseAbs().maxCoeff() > 1e3 || box.max.cwiseAbs().maxCoeff() > 1e3)
            section.refuse("max", "a cell within 1000 m of the origin");
        rig.cell = box;
    }
    if (section.has("pointing_axis")) {
        Eigen::Vector3d axis = vector_of(section.numbers("pointing_axis", 3, three_numbers));
        const double norm = axis.stableNorm();
        if (!(norm > 1e-9 && norm < 1e9)) section.refuse("pointing_axis", "a direction, not the zero vector");
        // An axis that is a unit vector already stays as it is, so that values survive writing and reading to
        // the bit.
        if (std::abs(norm - 1.0) > 1e-12) axis /= norm;
        rig.pointing_axis = axis;
    }
    section.warn_of_unknown_keys();
}

std::string vector_text(const Eigen::Vector3d& v) {
    std::string out = "[";
    out += toml_float(v.x()) + ", " + toml_float(v.y()) + ", " + toml_float(v.z()) + "]";
    return out;
}

std::string sensor_text(const CalibratedSensor& sensor) {
    const CameraModel& camera = sensor.camera;
    std::string out = "\n[[sensor]]\n";
    out += "name = " + toml_quoted(sensor.name) + "\n";
    out += std::string("kind = \"") + word_for(sensor.kind) + "\"\n";
    out += "width = " + std::to_string(camera.width) + "\nheight = " + std::to_string(camera.height) + "\n";
    out += "fx = " + toml_float(camera.fx) + "\nfy = " + toml_float(camera.fy) + "\n";
    out += "cx = " + toml_float(camera.cx) + "\ncy = " + toml_float(camera.cy) + "\n";
    out += "distortion = [";
    for (size_t i = 0; i < 5; ++i) {
        if (i > 0) out += ", ";
        out += toml_float(camera.distortion[i]);
    }
    const Eigen::Matrix3d& r = sensor.camera_from_world.rotation;
    out += "]\nrotation = [" + vector_text(r.row(0)) + ", " + vector_text(r.row(1)) + ", " +
           vector_text(r.row(2));
    out += "]\ntranslation = " + vector_text(sensor.camera_from_world.translation) + "\n";
    out += "uri = " + toml_quoted(sensor.uri) + "\n";
    return out;
}

}  // namespace

Result<CalibrationFile> parse_calibration(std::string_view text, const std::string& name) {
    const Result<toml::table> table = parse_toml(text, name);
    if (!table) return tl::unexpected(table.error());
    TomlComplaints complaints{name, {}, {}};
    TomlSection top(*table, "", complaints);
    CalibrationFile file;
    const std::string format = top.text("format", "\"deixis-calibration/1\"");
    if (format != calibration_format) top.refuse("format", "\"deixis-calibration/1\"", toml_quoted(format));
    if (std::optional<TomlSection> cell = top.table("cell")) read_cell(*cell, file.rig);
    std::set<std::string> names;
    std::vector<TomlSection> sensors = top.tables("sensor");
    if (sensors.empty() || sensors.size() > most_sensors)
        top.refuse("sensor", "1 to 64 tables headed [[sensor]]");
    for (TomlSection& section : sensors) {
        if (complaints.first) break;
        file.rig.sensors.push_back(read_sensor(section, names));
    }
    top.warn_of_unknown_keys();
    if (complaints.first) return tl::unexpected(*complaints.first);
    file.warnings = std::move(complaints.warnings);
    return file;
}

Result<CalibrationFile> read_calibration(const std::filesystem::path& path) {
    const Result<std::string> text = read_whole_file(path, largest_file);
    if (!text) return tl::unexpected(text.error());
    return parse_calibration(*text, path.string());
}

std::string calibration_text(const SensorRig& rig) {
    std::string out = "format = \"" + std::string(calibration_format) + "\"\n";
    if (rig.cell || rig.pointing_axis) out += "\n[cell]\n";
    if (rig.cell)
        out += "min = " + vector_text(rig.cell->min) + "\nmax = " + vector_text(rig.cell->max) + "\n";
    if (rig.pointing_axis) out += "pointing_axis = " + vector_text(*rig.pointing_axis) + "\n";
    for (const CalibratedSensor& sensor : rig.sensors) out += sensor_text(sensor);
    return out;
}

Result<void> write_calibration(const SensorRig& rig, const std::filesystem::path& path) {
    const std::string text = calibration_text(rig);
    // A rig that could not be read back must not be written; the reader knows all that there is to check.
    if (const Result<CalibrationFile> back = parse_calibration(text, path.string()); !back)
        return tl::unexpected(back.error());
    return write_whole_file(path, text);
}

}  // namespace deixis
