// RFC 3339: known instants, round trips over ten thousand years, and texts that are no time.
#include "appliance/records/utc_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>
#include <random>

namespace deixis {
namespace {

TEST(UtcTime, WritesKnownInstants) {
    EXPECT_EQ(utc_text(0), "1970-01-01T00:00:00.000000Z");
    EXPECT_EQ(utc_text(-1), "1969-12-31T23:59:59.999999Z");
    EXPECT_EQ(utc_text(951'827'696'000'001), "2000-02-29T12:34:56.000001Z");
    EXPECT_EQ(utc_text(earliest_utc_us), "0001-01-01T00:00:00.000000Z");
    EXPECT_EQ(utc_text(latest_utc_us), "9999-12-31T23:59:59.999999Z");
    EXPECT_EQ(utc_text(INT64_MAX), utc_text(latest_utc_us));
    EXPECT_EQ(utc_text(INT64_MIN), utc_text(earliest_utc_us));
}

TEST(UtcTime, ReadsWhatItWritesAndAgreesWithTheSystemsCalendar) {
    std::mt19937_64 random(7);
    std::uniform_int_distribution<int64_t> anywhen(earliest_utc_us, latest_utc_us);
    for (int i = 0; i < 10'000; ++i) {
        const int64_t time_us = anywhen(random);
        const std::string text = utc_text(time_us);
        ASSERT_EQ(parse_utc(text).value_or(0), time_us) << text;
        const std::time_t seconds = (time_us >= 0 ? time_us : time_us - 999'999) / 1'000'000;
        std::tm calendar{};
        gmtime_r(&seconds, &calendar);
        char peer[32];
        std::strftime(peer, sizeof peer, "-%m-%dT%H:%M:%S", &calendar);
        ASSERT_EQ(text.substr(4, 15), peer);
    }
}

TEST(UtcTime, ReadsOffsetsDatesAndDecimals) {
    const int64_t noon = parse_utc("2026-11-22T12:00:00Z").value();
    EXPECT_EQ(parse_utc("2026-11-22T14:00:00+02:00").value(), noon);
    EXPECT_EQ(parse_utc("2026-11-22T06:30:00-05:30").value(), noon);
    EXPECT_EQ(parse_utc("2026-11-22t12:00:00z").value(), noon);
    EXPECT_EQ(parse_utc("2026-11-22 12:00:00.5Z").value(), noon + 500'000);
    EXPECT_EQ(parse_utc("2026-11-22T12:00:00.123456999Z").value(), noon + 123'456);
    EXPECT_EQ(parse_utc("2026-11-22").value(), noon - 12 * 3'600'000'000);
}

TEST(UtcTime, RefusesWhatIsNoTimeByName) {
    for (const char* text : {"",
                             "now",
                             "2026",
                             "2026-11",
                             "2026-11-31",
                             "2026-02-29",
                             "2026-13-01",
                             "2026-00-10",
                             "0000-01-01",
                             "26-11-22",
                             "2026-11-22T",
                             "2026-11-22T12",
                             "2026-11-22T12:00",
                             "2026-11-22T12:00:00",
                             "2026-11-22T24:00:00Z",
                             "2026-11-22T12:60:00Z",
                             "2026-11-22T12:00:60Z",
                             "2026-11-22T12:00:00.Z",
                             "2026-11-22T12:00:00.1234567890Z",
                             "2026-11-22T12:00:00+2",
                             "2026-11-22T12:00:00+25:00",
                             "2026-11-22T12:00:00Z ",
                             " 2026-11-22",
                             "2026/11/22",
                             "+2026-11-22",
                             "9999-12-31T23:59:59-01:00"}) {
        const auto time = parse_utc(text);
        ASSERT_FALSE(time.has_value()) << text;
        EXPECT_EQ(time.error().sentence, std::string("\"") + text +
                                             "\" is not a time: expected a date as 2026-11-22 or an RFC 3339 "
                                             "time as 2026-11-22T10:12:13Z");
    }
}

}  // namespace
}  // namespace deixis
