// Microseconds since 1970 to RFC 3339 UTC text and back.
#pragma once

#include <cstdint>
#include <string>

#include "tracking/geometry/result.h"

namespace deixis {

/// First and last instant that has an RFC 3339 form: 0001-01-01T00:00:00Z to 9999-12-31T23:59:59.999999Z.
constexpr int64_t earliest_utc_us = -62'135'596'800'000'000;
constexpr int64_t latest_utc_us = 253'402'300'799'999'999;

/// "2026-11-22T10:12:13.123456Z"; always six decimals, so that texts sort as times do. Clamped to the range
/// above.
std::string utc_text(int64_t time_us);

/// Reads a date ("2026-11-22": its first instant, UTC) or an RFC 3339 time with any offset and up to nine
/// decimals (those beyond six are cut). Refuses anything else, naming the text.
Result<int64_t> parse_utc(const std::string& text);

/// The wall clock. For the edges only: nothing that a replay computes may depend on it.
int64_t utc_now_us();

}  // namespace deixis
