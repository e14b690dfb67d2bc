// Records for the exports, plain ones and ones with ugly texts.
#pragma once

#include <string>
#include <vector>

#include "appliance/records/defect_record.h"

namespace deixis {

inline DefectRecord plain_record(DefectId id = 1) {
    DefectRecord record;
    record.id = id;
    record.part_type = "bumper-front-a";
    record.part_serial = "0001";
    record.mark.timestamp_us = 33'333;
    record.mark.spot.position = {0.31, -0.0204999, 0.12};
    record.mark.spot.normal = {0, -1, 0};
    record.mark.arm = ArmSide::left;
    record.mark.confidence = 0.875;
    record.mark.touch = true;
    record.zone = "upper left";
    record.time_us = 951'827'696'000'001;
    return record;
}

inline std::vector<std::string> ugly_texts() {
    return {"=1+1",
            "+1",
            "-1",
            "@SUM(A1)",
            "\tx",
            "\rx",
            "=cmd|' /C calc'!A0",
            "\xEF\xBC\x9D"
            "1",
            "a,b",
            "say \"hi\"",
            "two\r\nlines",
            "line\nfeed",
            "\"",
            ",",
            "'",
            "",
            " ",
            std::string("a\0b", 3),
            "\xff\xfe",
            "caf\xc3\xa9",
            "\xc3",
            "\xed\xa0\x80",
            "\xf0\x9f\x94\xb4",
            "\xf5\x80\x80\x80",
            "\xe0\x80\xaf",
            "\xc0\xaf",
            "trailing,",
            std::string(4096, '"'),
            "\xE2\x80\xAE"
            "rtl",
            "a;b\tc"};
}

}  // namespace deixis
