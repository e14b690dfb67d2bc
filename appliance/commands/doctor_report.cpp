// The report as text and as JSON.
#include "appliance/commands/doctor_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace deixis {
namespace {

const char* name_of(DoctorVerdict verdict) {
    switch (verdict) {
        case DoctorVerdict::ok:
            return "OK";
        case DoctorVerdict::warn:
            return "WARN";
        case DoctorVerdict::fail:
            return "FAIL";
    }
    return "FAIL";
}

}  // namespace

void DoctorReport::ok(const std::string& subject, const std::string& finding) {
    lines_.push_back({DoctorVerdict::ok, subject, finding, ""});
}

void DoctorReport::warn(const std::string& subject, const std::string& finding, const std::string& advice) {
    lines_.push_back({DoctorVerdict::warn, subject, finding, advice});
}

void DoctorReport::fail(const std::string& subject, const std::string& finding, const std::string& advice) {
    lines_.push_back({DoctorVerdict::fail, subject, finding, advice});
}

bool DoctorReport::failed() const {
    return std::any_of(lines_.begin(), lines_.end(),
                       [](const DoctorLine& line) { return line.verdict == DoctorVerdict::fail; });
}

std::string DoctorReport::text() const {
    std::string text;
    for (const DoctorLine& line : lines_) {
        std::string verdict = name_of(line.verdict);
        verdict.resize(6, ' ');
        text += verdict + line.subject + ": " + line.finding + "\n";
        if (!line.advice.empty()) text += "      -> " + line.advice + "\n";
    }
    return text;
}

std::string DoctorReport::json() const {
    nlohmann::ordered_json report;
    report["ok"] = !failed();
    report["checks"] = nlohmann::ordered_json::array();
    for (const DoctorLine& line : lines_)
        report["checks"].push_back({{"verdict", name_of(line.verdict)},
                                    {"subject", line.subject},
                                    {"finding", line.finding},
                                    {"advice", line.advice}});
    return report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace deixis
