// Which IPv4 addresses may connect: a list of addresses and networks, read from a setting.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// "192.168.0.7" as a number, the first octet highest; nullopt unless it is exactly four decimal octets.
std::optional<uint32_t> ipv4_of(const std::string& text);
std::string ipv4_text(uint32_t address);

class AddressList {
  public:
    /// Reads "127.0.0.1, 192.168.3.0/24"; refuses an entry that is neither, naming it. The empty text allows
    /// nobody.
    static Result<AddressList> read(const std::string& text);

    bool allows(uint32_t address) const;

  private:
    struct Network {
        uint32_t address, mask;
    };
    std::vector<Network> networks_;
};

}  // namespace deixis
