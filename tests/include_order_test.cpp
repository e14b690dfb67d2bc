// Reads the `#include` lines of every source and holds the order of the house.
#include "tests/include_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/source_files.h"

namespace deixis {
namespace {

TEST(IncludeOrder, HoldsInEverySource) {
    size_t includes = 0;
    for (const std::string& file : source_files()) {
        if (!ends_in(file, {".h", ".cpp"})) continue;
        for (const std::string& line : lines_of(file)) {
            const auto header = included_by(line);
            if (!header) continue;
            ++includes;
            const auto wrong = objection(file, *header);
            EXPECT_FALSE(wrong) << *wrong;
        }
    }
    EXPECT_GT(includes, 100U) << "no sources were read";
}

TEST(IncludeOrder, HeavyLibrariesDoNotLeaveTheirRoomThroughAHeader) {
    std::map<std::string, std::string> shows;  // header of ours: the library that its includes show
    std::vector<std::pair<std::string, std::string>> includes;
    for (const std::string& file : source_files()) {
        if (!ends_in(file, {".h", ".cpp"}) || file.starts_with("tests/")) continue;
        for (const std::string& line : lines_of(file)) {
            const auto header = included_by(line);
            if (!header) continue;
            includes.emplace_back(file, *header);
            if (file.ends_with(".h") && !hidden_library_of(*header).empty())
                shows[file] = hidden_library_of(*header);
        }
    }
    for (const auto& [file, header] : includes) {
        const auto shown = shows.find(header);
        EXPECT_TRUE(shown == shows.end() || room_of(file) == room_of(header))
            << file << " sees " << shown->second << " through " << header;
    }
}

TEST(IncludeOrder, HasNoCircleAmongTheRooms) {
    // A room's allowance may name a group ("tracking"): every room below it counts.
    std::set<std::string> settled;
    for (size_t round = 0; round < rooms().size(); ++round) {
        for (const Room& room : rooms()) {
            const auto open = [&](const Room& other) {
                if (&other == &room || settled.contains(other.path)) return false;
                return std::any_of(room.may_include.begin(), room.may_include.end(),
                                   [&](const std::string& allowed) {
                                       return other.path == allowed || other.path.starts_with(allowed + "/");
                                   });
            };
            if (std::none_of(rooms().begin(), rooms().end(), open)) settled.insert(room.path);
        }
    }
    EXPECT_EQ(settled.size(), rooms().size());
}

TEST(IncludeOrder, CatchesAnIncludeUpwards) {
    EXPECT_EQ(objection("tracking/geometry/ray_caster.cpp", "tracking/part/part_estimate.h"),
              "tracking/geometry/ray_caster.cpp includes tracking/part/part_estimate.h: "
              "tracking/geometry may not know tracking/part");
    EXPECT_TRUE(objection("tracking/part/part_tracker.cpp", "tracking/body/body_model.h"));
    EXPECT_TRUE(objection("tracking/body/body_tracker.cpp", "tracking/part/part_estimate.h"));
    EXPECT_TRUE(objection("gestures/mark.h", "appliance/records/defect_record.h"));
    EXPECT_TRUE(objection("gestures/mark.h", "tracking/part/part_estimate.h"));
    EXPECT_TRUE(objection("appliance/records/defect_ledger.cpp", "appliance/station/frame_result.h"));
    EXPECT_TRUE(objection("appliance/station/frame_loop.cpp", "appliance/acceptance/mark_matching.h"));
    EXPECT_TRUE(objection("hmi/server/screen_server.cpp", "appliance/records/defect_ledger.h"));
    EXPECT_TRUE(objection("appliance/plc/plc_link.cpp", "tests/fakes/plc.h"));
    EXPECT_TRUE(objection("cellar/box.h", "string")) << "a room that the house does not have";
}

TEST(IncludeOrder, CatchesALibraryAwayFromItsHome) {
    EXPECT_EQ(objection("appliance/station/frame_loop.cpp", "OpenNI.h"),
              "appliance/station/frame_loop.cpp includes OpenNI.h: OpenNI2 has its home elsewhere");
    EXPECT_TRUE(objection("tracking/geometry/surface_mesh.cpp", "pcl/point_types.h"));
    EXPECT_TRUE(objection("appliance/simulation/bumper.cpp", "BRepPrimAPI_MakeBox.hxx"));
    EXPECT_TRUE(objection("appliance/station/frame_loop.cpp", "SQLiteCpp/Database.h"));
    EXPECT_TRUE(objection("hmi/server/screen_server.cpp", "modbus/modbus.h"));
    EXPECT_TRUE(objection("gestures/dwell.cpp", "chrono"));
    EXPECT_TRUE(objection("tracking/volume/carving.cpp", "fstream"));
    EXPECT_TRUE(objection("tracking/part/part_tracker.cpp", "thread"));
}

TEST(IncludeOrder, LetsPassWhatTheDesignAllows) {
    EXPECT_FALSE(objection("tracking/part/descriptors.cpp", "pcl/features/fpfh.h"));
    EXPECT_FALSE(objection("tracking/part/descriptors.cpp", "tracking/volume/surface_points.h"));
    EXPECT_FALSE(objection("appliance/acceptance/mark_matching.h", "gestures/mark.h"));
    EXPECT_FALSE(objection("appliance/commands/station_command.cpp", "hmi/server/screen_server.h"));
    EXPECT_FALSE(objection("tests/appliance/plc/plc_test.cpp", "modbus/modbus.h"));
    EXPECT_FALSE(objection("tracking/geometry/ray_caster.cpp", "vector"));
}

TEST(IncludeOrder, ReadsIncludeLinesOfEveryShape) {
    EXPECT_EQ(included_by("#include <vector>"), "vector");
    EXPECT_EQ(included_by("#include \"gestures/mark.h\"  // why"), "gestures/mark.h");
    EXPECT_EQ(included_by("  #  include<a.h>"), "a.h");
    EXPECT_FALSE(included_by("// #include <vector>"));
    EXPECT_FALSE(included_by("#define include"));
}

}  // namespace
}  // namespace deixis
