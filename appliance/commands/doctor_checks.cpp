// Files, ports and space, looked at the way the station will use them.
#include "appliance/commands/doctor_checks.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <vector>

#include "appliance/calibration/calibration_file.h"
#include "appliance/parts/part_model.h"
#include "appliance/sessions/session.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    return line;
}

/// True for files "lib*.so.0", the only names that Debian's OpenNI2 loads.
bool is_driver_name(const std::string& name) {
    return name.starts_with("lib") && name.ends_with(".so.0");
}

std::string usb_name(const char* maker, const std::string& vendor, const std::string& product) {
    return std::string(maker) + " (" + vendor + ":" + product + ")";
}

/// Where libOpenNI2.so.0 lies; empty when nowhere.
fs::path openni_folder(const fs::path& driver_folder) {
    std::vector<fs::path> folders{driver_folder};
    if (driver_folder.empty())
        folders = {"/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib", "/usr/local/lib"};
    std::error_code trouble;
    for (const fs::path& folder : folders)
        if (fs::exists(folder / "libOpenNI2.so.0", trouble)) return folder;
    return {};
}

void check_part(DoctorReport& report, const fs::path& file, const ModelReader& reader) {
    const auto part = read_part_file(file);
    if (!part) return report.fail("part", part.error().sentence, "mend the file that the sentence names");
    const auto mesh = load_mesh(part->model, part->metres_per_unit, reader);
    if (!mesh) return report.fail("part", mesh.error().sentence, "compare with `deixis part info`");
    report.ok("part", part->type + ", serial " + part->serial + ", " +
                          std::to_string(mesh->triangles.size()) + " triangles, " +
                          std::to_string(part->zones.size()) + " zones");
    for (const std::string& warning : part->warnings)
        report.warn("part", warning, "check the spelling of the key");
}

std::string gigabytes(uint64_t bytes) {
    const uint64_t tenths = bytes / 100'000'000;
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " GB";
}

/// Free bytes for this user; nullopt when `folder` cannot be asked.
std::optional<uint64_t> free_bytes(const fs::path& folder) {
    struct statvfs status {};
    if (::statvfs(folder.empty() ? "." : folder.c_str(), &status) != 0) return std::nullopt;
    return static_cast<uint64_t>(status.f_bavail) * status.f_frsize;
}

}  // namespace

void check_drivers(DoctorReport& report, const fs::path& driver_folder) {
    const fs::path folder = openni_folder(driver_folder);
    if (folder.empty())
        return report.fail(
            "sensor drivers",
            "libOpenNI2.so.0 is not in " + (driver_folder.empty()
                                                ? std::string("the system's library folders")
                                                : driver_folder.string()),
            driver_folder.empty() ? "apt-get install libopenni2-0" : "check station.driver_folder");
    std::error_code trouble;
    std::string drivers;
    for (const auto& entry : fs::directory_iterator(folder / "OpenNI2" / "Drivers", trouble)) {
        const std::string name = entry.path().filename().string();
        if (is_driver_name(name))
            drivers += (drivers.empty() ? "" : ", ") + name;
        else if (name.ends_with(".so") && !fs::exists(entry.path().string() + ".0", trouble))
            report.warn("sensor drivers",
                        entry.path().string() + " will be ignored: OpenNI2 loads lib*.so.0 only",
                        "rename or link it to " + name + ".0");
    }
    if (drivers.empty())
        return report.fail("sensor drivers",
                           "no driver plug-in in " + (folder / "OpenNI2" / "Drivers").string(),
                           "apt-get install --reinstall libopenni2-0, or check station.driver_folder");
    report.ok("sensor drivers", drivers + " in " + (folder / "OpenNI2" / "Drivers").string());
    if (drivers.find("libOniFile.so.0") == std::string::npos)
        report.fail("sensor drivers", "libOniFile.so.0 is missing, recordings cannot be played",
                    "link it into " + (folder / "OpenNI2" / "Drivers").string());
}

void check_usb(DoctorReport& report, const fs::path& sysfs, const fs::path& devices) {
    struct Maker {
        const char *id, *name;
    };
    constexpr std::array<Maker, 3> makers{
        {{"1d27", "PrimeSense or ASUS Xtion"}, {"2bc5", "Orbbec"}, {"045e", "Microsoft Kinect"}}};
    int found = 0;
    std::error_code trouble;
    for (const auto& entry : fs::directory_iterator(sysfs / "bus" / "usb" / "devices", trouble)) {
        const std::string vendor = first_line(entry.path() / "idVendor"),
                          product = first_line(entry.path() / "idProduct");
        for (const Maker& maker : makers) {
            if (vendor != maker.id) continue;
            if (vendor == "045e" && product != "02ae" && product != "02bf")
                continue;  // a mouse of that maker
            ++found;
            const auto padded = [](const std::string& number) {
                return std::string(3 - std::min<size_t>(3, number.size()), '0') + number;
            };
            const fs::path device = devices / "bus" / "usb" / padded(first_line(entry.path() / "busnum")) /
                                    padded(first_line(entry.path() / "devnum"));
            const std::string what = usb_name(maker.name, vendor, product);
            if (::access(device.c_str(), R_OK | W_OK) == 0)
                report.ok("usb", what + " at " + device.string());
            else
                report.fail(
                    "usb", what + " at " + device.string() + " may not be opened by this user",
                    "install the rules of libopenni2-0 (udevadm control --reload), join the group video or "
                    "plugdev, unplug and plug in");
        }
    }
    if (found == 0)
        report.warn("usb", "no depth sensor is plugged in",
                    "for live operation: check cables and power, and that `lsusb` lists it; for recordings: "
                    "none needed");
}

void check_session(DoctorReport& report, const fs::path& folder, const ModelReader& reader) {
    const auto session = open_session(folder);
    if (!session)
        return report.fail("session", session.error().sentence,
                           "record, simulate or import it again, or mend it");
    std::string streams;
    for (const SessionStream& stream : session->streams)
        streams +=
            (streams.empty() ? "" : ", ") + stream.sensor + " " + std::to_string(stream.frames) + " frames";
    report.ok("session", session->name + ": " + streams + ", checksums right");
    for (const std::string& warning : session->warnings)
        report.warn("session", warning, "mend session.toml; what it names is used as it stands");
    if (session->part) check_part(report, *session->part, reader);
    if (session->settings)
        if (const auto settings = read_settings(*session->settings); !settings)
            report.fail("session", settings.error().sentence, "mend the settings.toml of the session");
}

void check_station_files(DoctorReport& report, const StationFiles& files, const ModelReader& reader) {
    if (files.calibration.empty())
        report.warn("calibration", "station.calibration is not set", "needed for live operation only");
    else if (const auto calibration = read_calibration(files.calibration); !calibration)
        report.fail("calibration", calibration.error().sentence, "calibrate the cell or mend the file");
    else
        report.ok("calibration", files.calibration);
    if (!files.part.empty()) check_part(report, files.part, reader);
    std::error_code trouble;
    if (!files.background.empty() && !fs::is_directory(files.background, trouble))
        report.fail("background", files.background + " is not a folder", "check station.background");
}

void check_record(DoctorReport& report, const fs::path& file) {
    std::error_code trouble;
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    const bool folder_writable = ::access(folder.c_str(), W_OK | X_OK) == 0;
    if (!fs::exists(file, trouble)) {
        if (!folder_writable)
            return report.fail(
                "record", "there is none at " + file.string() + " and its folder may not be written",
                "make the folder " + folder.string() + " and give this user the right to write");
        return report.ok("record", "there is none at " + file.string() + " yet; the station will make it");
    }
    const auto facts = DefectLedger::inspect(file);
    if (!facts)
        return report.fail("record", facts.error().sentence, "do what the sentence says; never delete it");
    if (!facts->complaints.empty())
        return report.fail(
            "record", file.string() + " is damaged: " + facts->complaints.front(),
            "stop the station, move the file aside with its -wal and -shm, keep it for repair");
    report.ok("record", file.string() + ": " + std::to_string(facts->defects) + " defects, version " +
                            std::to_string(facts->tables_version) + " of the tables, whole");
    if (facts->tables_version < DefectLedger::schema_version)
        report.warn("record", "its tables are of an older version",
                    "the station brings them up to date when it starts");
    if (!facts->write_ahead_log)
        report.warn("record", "it has no write-ahead log", "the station switches it on when it starts");
    if (::access(file.c_str(), W_OK) != 0 || !folder_writable)
        report.fail("record", file.string() + " or its folder may not be written",
                    "give this user the right to write both");
}

void check_port(DoctorReport& report, const std::string& subject, const std::string& host, int port,
                const std::string& key) {
    if (port == 0) return report.ok(subject, "any free port");
    const std::string where = host + ":" + std::to_string(port);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    if (::inet_pton(AF_INET, host == "localhost" ? "127.0.0.1" : host.c_str(), &address.sin_addr) != 1)
        return report.warn(subject, "cannot try the address " + where, "give an IPv4 address");
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const bool is_free = ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                         ::listen(socket, 1) == 0;
    const int code = errno;
    ::close(socket);
    if (is_free) return report.ok(subject, where + " is free");
    report.fail(subject, where + " cannot be had: " + std::strerror(code),
                "end the program that holds it (a running station?), or set " + key);
}

void check_disk(DoctorReport& report, const fs::path& folder) {
    const std::string where = fs::absolute(folder.empty() ? "." : folder).string();
    const auto bytes = free_bytes(folder);
    if (!bytes)
        return report.fail("disk", "cannot look at " + where + ": " + std::strerror(errno),
                           "make the folder");
    const std::string finding = gigabytes(*bytes) + " free at " + where;
    if (*bytes < 100'000'000)
        return report.fail("disk", finding, "free at least 1 GB: marks could not be recorded");
    if (*bytes < 1'000'000'000) return report.warn("disk", finding, "free at least 1 GB");
    report.ok("disk", finding);
}

void check_shared_memory(DoctorReport& report) {
    const auto bytes = free_bytes("/dev/shm");
    if (!bytes) return report.fail("shared memory", "there is no /dev/shm", "mount a tmpfs there");
    const std::string finding = gigabytes(*bytes) + " free at /dev/shm";
    if (*bytes < 64'000'000)
        return report.fail("shared memory", finding,
                           "the frames of two sensors need 64 MB: enlarge the tmpfs");
    report.ok("shared memory", finding);
}

void check_web(DoctorReport& report, const fs::path& web_root) {
    std::error_code trouble;
    if (fs::is_regular_file(web_root / "index.html", trouble))
        return report.ok("screen page", web_root.string());
    report.fail("screen page", "there is no " + (web_root / "index.html").string(),
                "build it (cmake --build build --target deixis_web), or set screen.web_root");
}

void check_plc(DoctorReport& report, const PlcParams& params) {
    if (params.mode == "off") return report.ok("plc", "no PLC is configured (plc.mode is off)");
    if (params.mode == "server") return check_port(report, "plc", params.address, params.port, "plc.port");
    report.ok("plc", "the station will ask the PLC at " + params.address + ":" + std::to_string(params.port));
}

}  // namespace deixis
