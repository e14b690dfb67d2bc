// The worker in time: tracks of feet, trunk, gaze and arms, and the posture that they make at any moment.
#pragma once

#include <array>
#include <vector>

#include "appliance/simulation/arm_goal.h"
#include "appliance/simulation/body_skeleton.h"
#include "appliance/simulation/floor_track.h"

namespace deixis {

/// From t0 to t1 (0.35 s of turning at either end) the head looks at a spot of the part.
struct Gaze {
    double t0, t1;
    Eigen::Vector3d spot;  ///< part frame [m]
};

struct WorkerTracks {
    explicit WorkerTracks(const FloorPose& start) : feet(start) {}
    FloorTrack feet;    ///< turn 0 = facing +y
    ScalarTrack lean;   ///< of the trunk, forwards [rad]
    ScalarTrack twist;  ///< of the chest against the feet, to the left [rad]
    std::vector<Gaze> gazes;
    std::array<ArmTrack, 2> arms;
};

/// Trunk, head and legs standing at `feet` (velocity and distance drive the gait): planted stance feet,
/// swinging free leg; sways a few millimetres. Arms are left at rest.
BodyPose stand(const BodyDimensions& dimensions, const FloorState& feet, double lean, double twist,
               double time);

/// Turns the head of `pose` towards `spot` (world) by `share`, at most 70 degrees off the chest.
void look_at(const BodyDimensions& dimensions, BodyPose& pose, const Eigen::Vector3d& spot, double share);

/// The whole posture at `time`. `around` gives part and trolley at that time; the rest of it is filled in
/// here.
BodyPose posture_at(const BodyDimensions& dimensions, const WorkerTracks& tracks, ArmSurroundings around,
                    double time);

}  // namespace deixis
