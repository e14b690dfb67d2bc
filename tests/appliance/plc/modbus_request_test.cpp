// The judge of requests: every kind of wrong one, every prefix, and noise.
#include "appliance/plc/modbus_request.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/appliance/plc/modbus_bytes.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using Kind = RequestVerdict::Kind;

RequestVerdict judge(const Bytes& bytes) {
    return judge_request(bytes.data(), bytes.size());
}

TEST(ModbusRequest, ServesItsFourFunctions) {
    for (const auto& [bytes, writes] :
         std::vector<std::pair<Bytes, bool>>{{request(pdu(3, {0, 36})), false},
                                             {request(pdu(3, {35, 1})), false},
                                             {request(pdu(4, {0, 34})), false},
                                             {request(pdu(6, {35, 65535})), true},
                                             {request(write_pdu(0, std::vector<uint16_t>(36, 7))), true}}) {
        const RequestVerdict verdict = judge(bytes);
        EXPECT_EQ(verdict.kind, Kind::serve) << verdict.sentence;
        EXPECT_EQ(verdict.length, bytes.size());
        EXPECT_EQ(verdict.writes, writes);
        for (size_t size = 0; size < bytes.size(); ++size)
            EXPECT_EQ(judge_request(bytes.data(), size).kind, Kind::incomplete) << size;
    }
}

TEST(ModbusRequest, RefusesEveryBadOneInASentence) {
    for (const BadRequest& bad : bad_requests()) {
        const RequestVerdict verdict = judge(bad.bytes);
        EXPECT_EQ(verdict.kind, bad.exception == 0 ? Kind::close : Kind::except) << bad.sentence;
        EXPECT_EQ(verdict.exception, bad.exception) << bad.sentence;
        EXPECT_THAT(verdict.sentence, HasSubstr(bad.sentence));
        if (verdict.kind == Kind::except) {
            EXPECT_EQ(verdict.length, bad.bytes.size());
        }
    }
    EXPECT_GE(bad_requests().size(), 20U);
}

TEST(ModbusRequest, JudgesNoiseWithoutReadingBeyondIt) {
    std::mt19937 random(17);
    int served = 0;
    for (int trial = 0; trial < 200'000; ++trial) {
        Bytes bytes(random() % (longest_request + 1));
        for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
        if (bytes.size() > 8 && trial % 2 == 0) {  // noise behind a header that fits
            bytes[2] = bytes[3] = bytes[4] = 0;
            bytes[5] = static_cast<uint8_t>(bytes.size() - 6);
            bytes[7] = static_cast<uint8_t>(std::array{3, 4, 6, 16}[random() % 4]);
        }
        // A copy of exactly this size, so that a sanitizer sees any read beyond it.
        const Bytes exact(bytes);
        const RequestVerdict verdict = judge(exact);
        ASSERT_LE(verdict.length, exact.size());
        ASSERT_EQ(verdict.sentence.empty(), verdict.kind == Kind::serve || verdict.kind == Kind::incomplete);
        served += verdict.kind == Kind::serve;
    }
    EXPECT_LT(served, 2'000);
}

}  // namespace
}  // namespace deixis
