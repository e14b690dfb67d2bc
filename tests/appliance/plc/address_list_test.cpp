// Addresses and networks that may connect, and texts that are neither.
#include "appliance/plc/address_list.h"

#include <gmock/gmock.h>

#include <random>

namespace deixis {
namespace {

uint32_t ip(const char* text) {
    return ipv4_of(text).value();
}

TEST(AddressList, AllowsWhatItNamesAndNothingElse) {
    const auto list = AddressList::read("127.0.0.1, 192.168.3.0/24,10.1.2.3/32").value();
    for (const char* yes : {"127.0.0.1", "192.168.3.0", "192.168.3.255", "10.1.2.3"})
        EXPECT_TRUE(list.allows(ip(yes)));
    for (const char* no :
         {"127.0.0.2", "192.168.2.255", "192.168.4.0", "10.1.2.2", "0.0.0.0", "255.255.255.255"})
        EXPECT_FALSE(list.allows(ip(no))) << no;
}

TEST(AddressList, AnEmptyListAllowsNobodyAndSlashZeroEverybody) {
    EXPECT_FALSE(AddressList::read("").value().allows(ip("127.0.0.1")));
    EXPECT_FALSE(AddressList::read("  ").value().allows(0));
    EXPECT_TRUE(AddressList::read("0.0.0.0/0").value().allows(ip("203.0.113.9")));
}

TEST(AddressList, TextAndNumberAgree) {
    std::mt19937 random(5);
    for (int i = 0; i < 1'000; ++i) {
        const auto address = static_cast<uint32_t>(random());
        EXPECT_EQ(ipv4_of(ipv4_text(address)), address);
    }
}

TEST(AddressList, RefusesEntriesThatAreNoAddressByName) {
    for (const char* entry :
         {"plc.local",    "1.2.3",      "1.2.3.4.5", "1.2.3.256",       "1.2.3.-1",
          "1.2.3.04",     "1.2.3.4/33", "1.2.3.4/",  "1.2.3.4/a",       "/24",
          "1.2.3.4/24/8", "::1",        "1,2",       "1.2.3.4;5.6.7.8", "0x7f.0.0.1",
          "1.2.3.4 5",    "*",          "1..3.4",    ".1.2.3",          "999999999999.1.1.1"}) {
        const auto list = AddressList::read(entry);
        ASSERT_FALSE(list) << entry;
        const std::string named = std::string(entry).substr(0, std::string(entry).find(','));
        EXPECT_EQ(list.error().sentence,
                  "\"" + named +
                      "\" is not an IPv4 address or network; expected as 192.168.3.7 or "
                      "192.168.3.0/24");
    }
}

}  // namespace
}  // namespace deixis
