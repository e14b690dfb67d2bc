// SQLite's complaints as one sentence for a person, with the cause that decides whether waiting helps.
#pragma once

#include <filesystem>
#include <string>

#include "appliance/records/defect_ledger.h"

namespace SQLite {
class Exception;
}

namespace deixis {

/// `doing` completes "cannot ...": "write a mark to", "open", "read".
LedgerFailure explain(const SQLite::Exception& complaint, const std::string& doing,
                      const std::filesystem::path& file);

LedgerFailure damaged_ledger(const std::filesystem::path& file, const std::string& detail);

inline tl::unexpected<LedgerFailure> ledger_fail(LedgerTrouble trouble, std::string sentence) {
    return tl::unexpected<LedgerFailure>(LedgerFailure{{one_line(std::move(sentence))}, trouble});
}

}  // namespace deixis
