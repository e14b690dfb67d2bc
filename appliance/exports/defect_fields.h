// What every export says of a defect: one list of named fields, so that CSV and JSON cannot disagree.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "appliance/records/defect_record.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// The plant's own codes for "paint defect" in its quality system (SAP QMIFE FEKAT, FEGRP, FECOD).
struct QualityCodes {
    std::string catalogue = "9";       ///< FEKAT, 1 character; 9 = defect types
    std::string code_group = "PAINT";  ///< FEGRP, 1 to 8 characters
    std::string code = "MARK";         ///< FECOD, 1 to 4 characters
    InvalidSettings validate() const;
};

/// A length [mm], written with three decimals; a plain number, with up to six.
struct Millimetres {
    double value = 0;
};
using FieldValue = std::variant<int64_t, double, Millimetres, bool, std::string>;
struct DefectField {
    std::string name;
    FieldValue value;
};

/// The fields of `record`, always the same names in the same order. `position_number` (POSNR) counts the
/// defects of one part from 1. A withdrawn defect has ANZFEHLER 0.
std::vector<DefectField> defect_fields(const DefectRecord& record, int64_t position_number,
                                       const QualityCodes& codes);

/// POSNR of each record: the how-manieth of its part (type and serial) it is in this list.
std::vector<int64_t> position_numbers(const std::vector<DefectRecord>& records);

/// `text` with every byte that is not part of valid UTF-8 replaced by U+FFFD.
std::string valid_utf8(const std::string& text);

}  // namespace deixis
