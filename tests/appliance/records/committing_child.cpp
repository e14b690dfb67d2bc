// Commits marks until it is killed; prints each id only after the commit has returned, as the station
// acknowledges.
#include <unistd.h>

#include <cstdio>
#include <string>

#include "appliance/records/defect_ledger.h"

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    auto ledger = deixis::DefectLedger::open(argv[1]);
    if (!ledger) {
        std::fprintf(stderr, "%s\n", ledger.error().sentence.c_str());
        return 1;
    }
    deixis::DefectRecord record;
    record.part_type = "bumper";
    for (int n = 1;; ++n) {
        record.part_serial = std::to_string(n % 7);
        record.mark.timestamp_us = n;
        record.zone = std::string(n % 500, 'z');
        const auto id = ledger->commit(record);
        if (!id) {
            std::fprintf(stderr, "%s\n", id.error().sentence.c_str());
            return 1;
        }
        const std::string line = std::to_string(*id) + "\n";
        if (::write(STDOUT_FILENO, line.data(), line.size()) != static_cast<ssize_t>(line.size())) return 1;
    }
}
