// RFC 3339 by plain calendar arithmetic: no time zone data base, no locale.
#include "appliance/records/utc_time.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>

namespace deixis {
namespace {

using std::chrono::day;
using std::chrono::microseconds;
using std::chrono::month;
using std::chrono::sys_days;
using std::chrono::year;
using std::chrono::year_month_day;

/// Reads texts from the left; every take_ says whether it found what it was asked for.
class Cursor {
  public:
    explicit Cursor(const std::string& text) : text_(text) {}

    bool take(char expected) {
        if (at_end() || text_[position_] != expected) return false;
        ++position_;
        return true;
    }
    bool take_digit(int& digit) {
        if (at_end() || text_[position_] < '0' || text_[position_] > '9') return false;
        digit = text_[position_++] - '0';
        return true;
    }
    bool take_number(int digits, int& number) {
        number = 0;
        for (int i = 0, digit = 0; i < digits; ++i) {
            if (!take_digit(digit)) return false;
            number = 10 * number + digit;
        }
        return true;
    }
    bool at_end() const { return position_ == text_.size(); }

  private:
    const std::string& text_;
    size_t position_ = 0;
};

bool take_date(Cursor& cursor, year_month_day& date) {
    int y = 0, m = 0, d = 0;
    if (!cursor.take_number(4, y) || !cursor.take('-') || !cursor.take_number(2, m) || !cursor.take('-') ||
        !cursor.take_number(2, d))
        return false;
    date = year_month_day{year{y}, month{static_cast<unsigned>(m)}, day{static_cast<unsigned>(d)}};
    return date.ok() && y >= 1;
}

bool take_time_of_day(Cursor& cursor, int64_t& time_us) {
    int hour = 0, minute = 0, second = 0;
    if (!cursor.take_number(2, hour) || !cursor.take(':') || !cursor.take_number(2, minute) ||
        !cursor.take(':') || !cursor.take_number(2, second))
        return false;
    if (hour > 23 || minute > 59 || second > 59) return false;
    time_us = ((hour * 60LL + minute) * 60 + second) * 1'000'000;
    if (!cursor.take('.')) return true;
    int64_t weight = 100'000;
    int digits = 0;
    for (int digit = 0; cursor.take_digit(digit); ++digits, weight /= 10) time_us += digit * weight;
    return digits >= 1 && digits <= 9;
}

bool take_offset(Cursor& cursor, int64_t& offset_us) {
    offset_us = 0;
    if (cursor.take('Z') || cursor.take('z')) return true;
    int64_t sign = 1;
    if (cursor.take('-'))
        sign = -1;
    else if (!cursor.take('+'))
        return false;
    int hour = 0, minute = 0;
    if (!cursor.take_number(2, hour) || !cursor.take(':') || !cursor.take_number(2, minute)) return false;
    if (hour > 23 || minute > 59) return false;
    offset_us = sign * (hour * 60LL + minute) * 60 * 1'000'000;
    return true;
}

}  // namespace

std::string utc_text(int64_t time_us) {
    const microseconds since_epoch{std::clamp(time_us, earliest_utc_us, latest_utc_us)};
    const auto days = std::chrono::floor<std::chrono::days>(since_epoch);
    const year_month_day date{sys_days{days}};
    const int64_t rest = (since_epoch - days).count();
    std::array<char, 64> text{};
    const int length = std::snprintf(
        text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%06dZ", static_cast<int>(date.year()),
        static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
        static_cast<int>(rest / 3'600'000'000), static_cast<int>(rest / 60'000'000 % 60),
        static_cast<int>(rest / 1'000'000 % 60), static_cast<int>(rest % 1'000'000));
    return {text.data(), static_cast<size_t>(length)};
}

Result<int64_t> parse_utc(const std::string& text) {
    const auto refused = [&] {
        return fail("\"" + text +
                    "\" is not a time: expected a date as 2026-11-22 or an RFC 3339 time as "
                    "2026-11-22T10:12:13Z");
    };
    Cursor cursor(text);
    year_month_day date;
    if (!take_date(cursor, date)) return refused();
    int64_t time_us = std::chrono::duration_cast<microseconds>(sys_days{date}.time_since_epoch()).count();
    if (cursor.at_end()) return time_us;
    int64_t time_of_day_us = 0, offset_us = 0;
    if (!cursor.take('T') && !cursor.take('t') && !cursor.take(' ')) return refused();
    if (!take_time_of_day(cursor, time_of_day_us) || !take_offset(cursor, offset_us)) return refused();
    if (!cursor.at_end()) return refused();
    time_us += time_of_day_us - offset_us;
    if (time_us < earliest_utc_us || time_us > latest_utc_us) return refused();
    return time_us;
}

int64_t utc_now_us() {
    return std::chrono::duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

}  // namespace deixis
