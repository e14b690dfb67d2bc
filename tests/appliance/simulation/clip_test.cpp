// Captured motion: parsing, refusals, retargeting.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "appliance/simulation/clip_motion.h"
#include "appliance/simulation/motion_clip.h"
#include "tests/appliance/simulation/small_cell.h"

namespace deixis {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// A body of 10 units, y up, that lifts its left arm sideways by 90 degrees in the second frame and walks 3
/// units on.
const std::string small_bvh = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Neck
  {
    OFFSET 0 3 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Head
    {
      OFFSET 0 0.5 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 1 0
      }
    }
    JOINT LeftArm
    {
      OFFSET 1 0 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT LeftForeArm
      {
        OFFSET 0 -1.5 0
        CHANNELS 3 Zrotation Xrotation Yrotation
        JOINT LeftHand
        {
          OFFSET 0 -1.2 0
          CHANNELS 0
          End Site
          {
            OFFSET 0 -0.5 0
          }
        }
      }
    }
    JOINT RightArm
    {
      OFFSET -1 0 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT RightForeArm
      {
        OFFSET 0 -1.5 0
        CHANNELS 3 Zrotation Xrotation Yrotation
        JOINT RightHand
        {
          OFFSET 0 -1.2 0
          CHANNELS 0
        }
      }
    }
  }
  JOINT LeftUpLeg
  {
    OFFSET 0.5 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftLeg
    {
      OFFSET 0 -2 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT LeftFoot
      {
        OFFSET 0 -2 0
        CHANNELS 0
        End Site
        {
          OFFSET 0 -0.1 0.8
        }
      }
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -0.5 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightLeg
    {
      OFFSET 0 -2 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT RightFoot
      {
        OFFSET 0 -2 0
        CHANNELS 0
        End Site
        {
          OFFSET 0 -0.1 0.8
        }
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.5
7 4.3 1 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0
7 4.3 4 0 0 0  0 0 0 0 0 0  90 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0  0 0 0 0 0 0
)";

const std::string small_asf = R"(:version 1.10
:root
  order TX TY TZ RX RY RZ
:bonedata
begin
 name lfemur
 direction 0.2 -1 0
 length 2
 axis 0 0 20 XYZ
 dof rx ry rz
end
begin
 name ltibia
 direction 0 -1 0
 length 2
 axis 0 0 0 XYZ
 dof rx
end
begin
 name lfoot
 direction 0 0 1
 length 0.8
end
begin
 name rfemur
 direction -0.2 -1 0
 length 2
end
begin
 name rtibia
 direction 0 -1 0
 length 2
end
begin
 name rfoot
 direction 0 0 1
 length 0.8
end
begin
 name thorax
 direction 0 1 0
 length 3
end
begin
 name lowerneck
 direction 0 1 0
 length 0.3
end
begin
 name head
 direction 0 1 0
 length 1
end
begin
 name lclavicle
 direction 1 0 0
 length 1
end
begin
 name lhumerus
 direction 0 -1 0
 length 1.5
end
begin
 name lradius
 direction 0 -1 0
 length 1.2
end
begin
 name lwrist
 direction 0 -1 0
 length 0.4
end
begin
 name rclavicle
 direction -1 0 0
 length 1
end
begin
 name rhumerus
 direction 0 -1 0
 length 1.5
end
begin
 name rradius
 direction 0 -1 0
 length 1.2
end
begin
 name rwrist
 direction 0 -1 0
 length 0.4
end
:hierarchy
begin
 root lfemur rfemur thorax
 lfemur ltibia
 ltibia lfoot
 rfemur rtibia
 rtibia rfoot
 thorax lowerneck lclavicle rclavicle
 lowerneck head
 lclavicle lhumerus
 lhumerus lradius
 lradius lwrist
 rclavicle rhumerus
 rhumerus rradius
 rradius rwrist
end
)";

const std::string small_amc = R"(:FULLY-SPECIFIED
:DEGREES
1
root 1 4 2 0 0 0
lfemur 0 0 0
ltibia 0
2
root 1 4 2 0 90 0
lfemur 0 0 0
ltibia 90
)";

TEST(Bvh, PlacesTheJointsWithZUp) {
    const auto clip = parse_bvh(small_bvh, "a.bvh");
    ASSERT_TRUE(clip.has_value()) << clip.error().sentence;
    ASSERT_EQ(clip->frames.size(), 2U);
    EXPECT_EQ(clip->seconds_per_frame, 0.5);
    const ClipFrame& f = clip->frames[0];
    EXPECT_LT((f.joints[0] - Vector3d(7, -1, 8.8)).norm(), 1e-12) << "end of the head";
    EXPECT_LT((f.joints[2] - Vector3d(8, -1, 7.3)).norm(), 1e-12) << "left shoulder";
    EXPECT_LT((f.joints[6] - Vector3d(8, -1, 4.6)).norm(), 1e-12) << "left wrist";
    EXPECT_LT((f.toes[1] - Vector3d(6.5, -1.8, 0.2)).norm(), 1e-12);
    EXPECT_LT((clip->frames[1].joints[6] - Vector3d(10.7, -4, 7.3)).norm(), 1e-12)
        << "arm lifted to the side";
}

TEST(Amc, PlacesTheJointsWithZUp) {
    const auto clip = parse_asf_amc(small_asf, "a.asf", small_amc, "a.amc");
    ASSERT_TRUE(clip.has_value()) << clip.error().sentence;
    ASSERT_EQ(clip->frames.size(), 2U);
    const ClipFrame &a = clip->frames[0], &b = clip->frames[1];
    EXPECT_LT((a.joints[11] - Vector3d(1.4, -2, 2)).norm(), 1e-12) << "left knee";
    EXPECT_LT((a.joints[13] - Vector3d(1.4, -2, 0)).norm(), 1e-12) << "left ankle";
    EXPECT_LT((a.joints[0] - Vector3d(1, -2, 8.3)).norm(), 1e-12);
    // Turned by 90 degrees about the up axis, the shank lifted about its own x axis.
    EXPECT_LT((b.joints[11] - Vector3d(1, -1.6, 2)).norm(), 1e-12);
    EXPECT_LT((b.joints[13] - Vector3d(-1, -1.6, 2)).norm(), 1e-12);
}

TEST(ClipMotion, KeepsDirectionsAndOwnLengths) {
    const auto clip = parse_bvh(small_bvh, "a.bvh");
    ASSERT_TRUE(clip.has_value());
    const BodyDimensions d{.height = 1.8, .girth = 1};
    // The clip faces +z, which is our -y; the worker shall start at (1, 2) facing -x.
    const ClipMotion motion(d, *clip, {{1, 2}, std::numbers::pi / 2}, 0);
    EXPECT_EQ(motion.duration_s(), 0.5);
    const BodyPlaces first = place_body(d, motion.at(0)), last = place_body(d, motion.at(9));
    EXPECT_LT((first.joints[8].head<2>() - Eigen::Vector2d(1, 2)).norm(), 1e-9);
    EXPECT_NEAR(std::min(first.joints[13].z(), first.joints[14].z()), d.ankle_height(), 1e-9);
    EXPECT_NEAR(first.joints[0].z(), 1.8, 0.03);
    EXPECT_LT(first.joints[9].y(), first.joints[10].y()) << "facing -x the left hip is at -y";
    const double scale = (d.thigh() + d.shank()) / 4;
    EXPECT_LT(((last.joints[8] - first.joints[8]).head<2>() - Eigen::Vector2d(-3 * scale, 0)).norm(), 1e-9)
        << "walks ahead";
    EXPECT_NEAR((last.joints[6] - last.joints[2]).normalized().dot(-Vector3d::UnitY()), 1, 1e-9)
        << "left arm out to the left";
    EXPECT_NEAR((last.joints[4] - last.joints[2]).norm(), d.upper_arm(), 1e-9);
    const Vector3d half = place_body(d, motion.at(0.25)).joints[8];
    EXPECT_NEAR(half.x(), 1 - 1.5 * scale, 1e-9);
}

struct BadClip {
    const char* from;
    const char* to;
    const char* sentence;
};

class BadBvh : public testing::TestWithParam<BadClip> {};

TEST_P(BadBvh, IsRefusedInOneSentence) {
    const auto clip = parse_bvh(replaced(small_bvh, GetParam().from, GetParam().to), "a.bvh");
    ASSERT_FALSE(clip.has_value());
    EXPECT_THAT(clip.error().sentence, HasSubstr(GetParam().sentence));
    EXPECT_THAT(clip.error().sentence, testing::StartsWith("a.bvh: "));
}

INSTANTIATE_TEST_SUITE_P(
    Each, BadBvh,
    testing::Values(
        BadClip{"HIERARCHY", "HIERARCHI", "line 1: expected \"HIERARCHY\", not \"HIERARCHI\""},
        BadClip{"OFFSET 0 0 0", "OFFSET 0 zero 0", "line 4: expected a number, not \"zero\""},
        BadClip{"OFFSET 0 3 0", "OFFSET 0 nan 0", "line 8: expected a number, not \"nan\""},
        BadClip{"CHANNELS 6", "CHANNELS 7", "line 5: CHANNELS must be 0 to 6"},
        BadClip{"Xposition", "Wposition", "line 5: unknown channel \"Wposition\""},
        BadClip{"JOINT Neck", "JOIN Neck", "line 6: expected JOINT, End Site or }, not \"JOIN\""},
        BadClip{"JOINT LeftForeArm", "JOINT Wing", "the skeleton has no left elbow that we know the name of"},
        BadClip{"JOINT Neck", "JOINT Nick", "the skeleton has no neck that we know the name of"},
        BadClip{"MOTION", "MOTOIN", "expected \"MOTION\", not \"MOTOIN\""},
        BadClip{"Frames: 2", "Frames: 0", "Frames must be 1 to"},
        BadClip{"Frames: 2", "Frames: 3", "the file ends too early"},
        BadClip{"Frames: 2", "Frames: 1", "numbers after the last frame"},
        BadClip{"Time: 0.5", "Time: 0", "Frame Time must be above 0.0001"},
        BadClip{"7 4.3 1", "7 4.3 inf", "expected a number, not \"inf\""},
        BadClip{"7 4.3 1 0 0 0", "7 4.3 1 90 0 0", "nobody stands upright along y or z in the first frame"}));

struct BadAmc {
    bool in_skeleton;
    BadClip change;
};

class BadAcclaim : public testing::TestWithParam<BadAmc> {};

TEST_P(BadAcclaim, IsRefusedInOneSentence) {
    const auto& [in_skeleton, change] = GetParam();
    const auto clip =
        parse_asf_amc(in_skeleton ? replaced(small_asf, change.from, change.to) : small_asf, "a.asf",
                      in_skeleton ? small_amc : replaced(small_amc, change.from, change.to), "a.amc");
    ASSERT_FALSE(clip.has_value());
    EXPECT_THAT(clip.error().sentence, HasSubstr(change.sentence));
    EXPECT_THAT(clip.error().sentence, testing::StartsWith(in_skeleton ? "a.asf: " : "a.amc: "));
}

INSTANTIATE_TEST_SUITE_P(
    Each, BadAcclaim,
    testing::Values(
        BadAmc{true, {"length 2", "length two", "line 8: \"length\" needs a number"}},
        BadAmc{true, {"direction 0.2 -1 0", "direction 0.2", "line 7: \"direction\" needs three numbers"}},
        BadAmc{true, {"dof rx ry rz", "dof tx", "only rx, ry and rz are read as \"dof\", not \"tx\""}},
        BadAmc{true, {"name lfemur", "title lfemur", "a bone without a name"}},
        BadAmc{true, {"name ltibia", "name lfemur", "bone \"lfemur\" is given twice"}},
        BadAmc{true, {"root lfemur rfemur", "root lfemur rwing", "unknown bone \"rwing\""}},
        BadAmc{true, {" lfemur ltibia\n", " ltibia lfemur\n", "bone \"lfemur\" stands before its parent"}},
        BadAmc{true, {"name head", "name hat", "unknown bone \"head\""}},
        BadAmc{false, {"1\nroot", "root", "a bone before the first frame's number"}},
        BadAmc{false, {"lfemur 0 0 0", "lfemur 0 0", "bone \"lfemur\" needs 3 numbers"}},
        BadAmc{false, {"lfemur 0 0 0", "wing 0 0 0", "unknown bone \"wing\""}},
        BadAmc{false, {"root 1 4 2 0 0 0", "root 1 4 2 0 0 x", "expected a number, not \"x\""}}));

TEST(Amc, AnEmptyClipIsRefused) {
    const auto clip = parse_asf_amc(small_asf, "a.asf", ":DEGREES\n", "a.amc");
    ASSERT_FALSE(clip.has_value());
    EXPECT_EQ(clip.error().sentence, "a.amc: holds no frame");
    EXPECT_EQ(read_bvh("no-such.bvh").error().sentence, "no-such.bvh: cannot be read");
}

TEST(Bvh, EveryCutAndFlipIsReadOrRefusedButNeverWorse) {
    for (size_t cut = 0; cut < small_bvh.size(); cut += 7) {
        const auto clip = parse_bvh(small_bvh.substr(0, cut), "a.bvh");
        EXPECT_FALSE(clip.has_value()) << cut;
        std::string flipped = small_bvh;
        flipped[cut] = static_cast<char>(flipped[cut] ^ 0x15);
        const auto other = parse_bvh(flipped, "a.bvh");
        if (!other.has_value()) {
            EXPECT_THAT(other.error().sentence, testing::StartsWith("a.bvh: "));
            continue;
        }
        for (const ClipFrame& f : other->frames) ASSERT_TRUE(f.joints[0].allFinite());
    }
}

}  // namespace
}  // namespace deixis
