// Defect records as CSV (RFC 4180, UTF-8): one row a defect. Pure: records in, text out.
#pragma once

#include <string>
#include <vector>

#include "appliance/exports/defect_fields.h"

namespace deixis {

/// Header and one row a record, CRLF after each line. Field names, units and QM columns: defect_fields.h.
/// Texts are made safe: invalid UTF-8 and NUL become U+FFFD; cells with comma, quote or line break are
/// quoted; a text that a spreadsheet would take for a formula (it begins with = + - @ TAB or CR, or the
/// full-width forms) gets a leading apostrophe. Numbers are never changed.
std::string defect_csv(const std::vector<DefectRecord>& records, const QualityCodes& codes = {});

}  // namespace deixis
