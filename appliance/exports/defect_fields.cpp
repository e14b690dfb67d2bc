// Metres become millimetres here and nowhere else.
#include "appliance/exports/defect_fields.h"

#include <map>
#include <string_view>

#include "appliance/records/utc_time.h"

namespace deixis {
namespace {

void require_length(InvalidSettings& complaints, const char* key, const std::string& value, size_t longest) {
    if (!value.empty() && value.size() <= longest) return;
    complaints.push_back({key, value, "1 to " + std::to_string(longest) + " characters"});
}

/// Length of the valid UTF-8 sequence that begins `text`; 0 when none does (RFC 3629, table of section 4).
size_t sequence_length(std::string_view text) {
    const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const auto continues = [&](size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
    const unsigned first = byte(0), second = byte(1);
    if (first < 0x80) return 1;
    if (first >= 0xC2 && first <= 0xDF) return continues(1) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) {
        const bool overlong = first == 0xE0 && second < 0xA0, surrogate = first == 0xED && second > 0x9F;
        return continues(1) && continues(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (first >= 0xF0 && first <= 0xF4) {
        const bool overlong = first == 0xF0 && second < 0x90, beyond = first == 0xF4 && second > 0x8F;
        return continues(1) && continues(2) && continues(3) && !overlong && !beyond ? 4 : 0;
    }
    return 0;
}

}  // namespace

InvalidSettings QualityCodes::validate() const {
    InvalidSettings complaints;
    require_length(complaints, "catalogue", catalogue, 1);
    require_length(complaints, "code_group", code_group, 8);
    require_length(complaints, "code", code, 4);
    return complaints;
}

std::vector<DefectField> defect_fields(const DefectRecord& record, int64_t position_number,
                                       const QualityCodes& codes) {
    const Eigen::Vector3d position_mm = 1000.0 * record.mark.spot.position;
    const Eigen::Vector3d& normal = record.mark.spot.normal;
    const int64_t count = record.state == DefectState::withdrawn ? 0 : 1;
    return {
        {"id", record.id},
        {"time", utc_text(record.time_us)},
        {"part_type", record.part_type},
        {"part_serial", record.part_serial},
        {"x_mm", Millimetres{position_mm.x()}},
        {"y_mm", Millimetres{position_mm.y()}},
        {"z_mm", Millimetres{position_mm.z()}},
        {"normal_x", normal.x()},
        {"normal_y", normal.y()},
        {"normal_z", normal.z()},
        {"zone", record.zone},
        {"arm", std::string(record.mark.arm == ArmSide::left ? "left" : "right")},
        {"confidence", record.mark.confidence},
        {"touch", record.mark.touch},
        {"state", std::string(name_of(record.state))},
        {"source", record.source},
        {"session_us", record.mark.timestamp_us},
        {"plc_time", record.delivered_us ? utc_text(*record.delivered_us) : std::string()},
        {"POSNR", position_number},
        {"FEKAT", codes.catalogue},
        {"FEGRP", codes.code_group},
        {"FECOD", codes.code},
        {"ANZFEHLER", count},
    };
}

std::vector<int64_t> position_numbers(const std::vector<DefectRecord>& records) {
    std::map<std::pair<std::string, std::string>, int64_t> counted;
    std::vector<int64_t> numbers;
    numbers.reserve(records.size());
    for (const DefectRecord& record : records)
        numbers.push_back(++counted[{record.part_type, record.part_serial}]);
    return numbers;
}

std::string valid_utf8(const std::string& text) {
    std::string valid;
    for (size_t i = 0; i < text.size();) {
        const size_t length = sequence_length(std::string_view(text).substr(i));
        if (length == 0) {
            valid += "\xEF\xBF\xBD";
            ++i;
        } else {
            valid.append(text, i, length);
            i += length;
        }
    }
    return valid;
}

}  // namespace deixis
