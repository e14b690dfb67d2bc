// Defect records as JSON lines: the fields of defect_fields.h, one object a line. Pure: records in, text out.
#pragma once

#include <string>
#include <vector>

#include "appliance/exports/defect_fields.h"

namespace deixis {

/// One object and one LF a record; each obeys defect.schema.json beside this file. Invalid UTF-8 becomes
/// U+FFFD, NUL is escaped.
std::string defect_json_lines(const std::vector<DefectRecord>& records, const QualityCodes& codes = {});

}  // namespace deixis
